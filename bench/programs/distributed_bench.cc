// Cost of a solve in parallel, measured on P processes and modelled for more.
//
//   mpirun -n P distributed_bench --side=183 --iterations=200
//       one row: a cold step of a triangular packing of about side² disks (3 contacts each), tilted
//       by --tilt degrees, apgd. It has the seconds of an iteration of the slowest process, bytes
//       sent, imbalance, iterations to the tolerances, and memory. Without mpirun, it also measures
//       the solver of one process.
//   mpirun -n P distributed_bench --state --side=317 --iterations=300 --steps=1 --tols=1e-4
//       steps of such a packing with a distributed state: memory, bytes sent in a step, and seconds
//       of a step of the slowest process. The first step is cold.
//   distributed_bench --model
//       halos, partners and bytes of one packing cut for many processes, and the cost of an
//       iteration of larger ones at a given latency and bandwidth
//       (data/manual/explanation/parallel.md).

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "bench/command/blas_kernels.h"
#include "bench/measure/peak_memory.h"
#include "core/base/release.h"
#include "core/base/stopwatch.h"
#include "core/motion/midpoint.h"
#include "core/scene/scene_family.h"
#include "solvers/parallel/cell_tree.h"
#include "solvers/parallel/contact_owners.h"
#include "solvers/parallel/distributed_solve.h"
#include "solvers/parallel/launch.h"
#include "solvers/parallel/problem_piece.h"
#include "solvers/simulation/domain.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

/// The first step of a packing and the positions of its contacts.
struct CutPacking {
  ContactProblem problem;
  std::vector<Vec3> places;

  CutPacking(int side, double tilt) {
    const Scene<2> scene = make_family_scene("triangular", side, {.tilt_degrees = tilt});
    const State<2> state = initial_state(scene);
    const Midpoint<2> mid = make_midpoint(scene, state);
    problem = assemble_step(scene, mid, false).problem;
    for (const Contact<2>& c : mid.contacts) {
      const Disk& disk = mid.bodies[to_size(c.i)];
      const Vec2 at = disk.x - disk.radius * c.n;
      places.push_back(Vec3(at[0], at[1], 0));
    }
  }
};

struct Timed {
  SolveResult result;
  DistributedCounts counts;
  double seconds = 0;
};

/// The best of `repeat` solves.
template <class Solve>
Timed fastest(int repeat, Solve solve) {
  Timed best;
  best.seconds = kInfinity;
  for (int k = 0; k < repeat; ++k) {
    Timed one = solve();
    if (one.result.solve_seconds < best.seconds) {
      best = std::move(one);
      best.seconds = best.result.solve_seconds;
    }
  }
  return best;
}

void measure(int side, double tilt, int iterations, int repeat, bool reproducible,
             const std::vector<double>& tols) {
  const auto group = launched_group();
  const CutPacking packing(side, tilt);
  const int contacts = packing.problem.num_contacts();
  SolverOptions options{.tol = 1e-300, .max_iterations = iterations};
  const DistributedOptions extra{.reproducible = reproducible, .contact_places = packing.places};
  Timed t = fastest(repeat, [&] {
    DistributedResult r = distributed_solve("apgd", packing.problem, options, *group, extra);
    // The time of the slowest process.
    group->largest({&r.result.solve_seconds, 1});
    return Timed{std::move(r.result), r.counts, 0};
  });
  double memory[1] = {peak_memory()};
  group->largest(memory);
  const bool speaks = group->rank() == 0;
  const Traffic& traffic = t.counts.traffic;
  const double n = iterations;
  if (speaks) {
    fmt::print(
        "P {}: {} contacts, {} iterations: {:.3e} s an iteration, {:.2f} ns a contact; sent by one "
        "{:.2f} messages and {:.0f} bytes, {:.2f} reductions with {:.0f} bytes an iteration; "
        "imbalance {:.3f}, halo {} of {}; peak {:.2f} kB a disk{}\n",
        group->size(), contacts, iterations, t.seconds / n, 1e9 * t.seconds / n / contacts,
        static_cast<double>(traffic.messages) / n, static_cast<double>(traffic.bytes) / n,
        static_cast<double>(traffic.reductions) / n, static_cast<double>(traffic.reduced_bytes) / n,
        t.counts.imbalance, t.counts.most_halo, t.counts.most_contacts,
        memory[0] / 1000 * 3 / contacts, reproducible ? "; exact sums" : "");
  }
  if (group->size() == 1) {
    const Timed one = fastest(repeat, [&] {
      return Timed{solve("apgd", packing.problem, options), {}, 0};
    });
    fmt::print("one process's own solver: {:.3e} s an iteration, {:.2f} ns a contact\n",
               one.seconds / n, 1e9 * one.seconds / n / contacts);
  }
  for (const double tol : tols) {
    options.tol = tol;
    options.max_iterations = 1000000;
    DistributedResult r = distributed_solve("apgd", packing.problem, options, *group, extra);
    group->largest({&r.result.solve_seconds, 1});
    const auto say = [&](const char* whose, const SolveResult& s) {
      if (!speaks) return;
      fmt::print("  to {:.0e}{}: {}, {} iterations, {:.2f} s, ε {:.2e}, η {:.2e}\n", tol, whose,
                 to_string(s.status), s.iterations, s.solve_seconds, s.error.epsilon, s.error.eta);
    };
    say("", r.result);
    if (group->size() == 1) say(" by its own solver", solve("apgd", packing.problem, options));
  }
}

void measure_state(int side, double tilt, int iterations, int steps, double tol) {
  const auto group = launched_group();
  Scene<2> scene = make_family_scene("triangular", side, {.tilt_degrees = tilt});
  SolverOptions options{.tol = tol, .max_iterations = iterations};
  Domain<2> domain(scene, initial_state(scene), *group,
                   [&](const ProblemPiece& piece, const Vector& s0) {
                     options.s0 = s0;
                     return distributed_solve("apgd", piece, options, *group);
                   });
  TimeStepper<2> stepper(scene, domain);
  release(scene.bodies);
  double memory[2] = {peak_memory(), 0};
  StepReport<2> sum;
  for (int k = 0; k < steps; ++k) {
    const StepReport<2> r = stepper.advance(domain.state());
    sum.contacts = r.contacts;
    sum.iterations += r.iterations;
    sum.converged = r.converged;
    sum.error = r.error;
    sum.detection_seconds += r.detection_seconds;
    sum.assembly_seconds += r.assembly_seconds;
    sum.solve_seconds += r.solve_seconds;
  }
  memory[1] = peak_memory();
  group->largest(memory);
  double seconds[3] = {sum.detection_seconds, sum.assembly_seconds, sum.solve_seconds};
  group->largest(seconds);
  const DomainCounts c = largest_counts(domain.counts(), *group);
  if (group->rank() != 0) return;
  const double n = steps;
  fmt::print(
      "P {}: {} disks, {} contacts; one has at most {} disks and {} ghosts, {} contacts and {} of "
      "others; imbalance {:.3f}\n",
      group->size(), domain.own().bodies, sum.contacts, c.most_bodies, c.most_ghosts,
      c.most_contacts, c.most_halo, c.imbalance);
  for (const auto& [name, t] :
       {std::pair{"detection", &c.detection}, {"solve", &c.solve}, {"migration", &c.migration}}) {
    fmt::print(
        "  {}: sent by one {:.1f} messages and {:.0f} bytes, {:.1f} reductions with {:.0f} "
        "bytes a step\n",
        name, static_cast<double>(t->messages) / n, static_cast<double>(t->bytes) / n,
        static_cast<double>(t->reductions) / n, static_cast<double>(t->reduced_bytes) / n);
  }
  fmt::print(
      "  a step takes {:.3f} s for detection, {:.3f} s for assembly, {:.3f} s for {:.0f} "
      "iterations; the last one {}, ε {:.2e}, η {:.2e}\n  peak of one {:.1f} MB, of which {:.1f} MB "
      "before the first step; {:.2f} kB a disk with all processes\n",
      seconds[0] / n, seconds[1] / n, seconds[2] / n, sum.iterations / n,
      sum.converged ? "converged" : "did not converge", sum.error.epsilon, sum.error.eta,
      memory[1] / 1e6, memory[0] / 1e6, memory[1] * group->size() / 1000 / domain.own().bodies);
}

/// Values of the process with the most of each.
struct CutCount {
  int contacts = 0, halo = 0, sent = 0, partners = 0;
  double imbalance = 1;
};

/// Counts the bytes of one exchange of a cut for P processes, without running it.
CutCount count_cut(const CutPacking& packing, const BodyNodes& nodes, int processes) {
  const ContactOwners owners = contact_owners(packing.problem, nodes, packing.places, processes);
  CutCount count{.imbalance = imbalance(owners.contacts)};
  std::vector<int> sent(to_size(processes), 0);
  std::vector<std::set<int>> to(to_size(processes));
  for (int rank = 0; rank < processes; ++rank) {
    const ProblemPiece piece = cut_piece(packing.problem, nodes, owners, rank);
    count.contacts = std::max(count.contacts, piece.own.num_contacts());
    count.halo = std::max(count.halo, static_cast<int>(piece.halo.size()));
    for (const RemoteItem& item : piece.copies) {
      ++sent[to_size(item.owner)];
      to[to_size(item.owner)].insert(rank);
    }
  }
  for (int rank = 0; rank < processes; ++rank) {
    count.sent = std::max(count.sent, sent[to_size(rank)]);
    count.partners = std::max(count.partners, static_cast<int>(to[to_size(rank)].size()));
  }
  return count;
}

struct ModelMachine {
  double latency = 2e-6;    ///< of a message, s
  double bandwidth = 5e9;   ///< of one process, bytes/s
  double contact = 1.4e-8;  ///< work on a contact in an iteration, s
};

void model(int side, double tilt, const ModelMachine& machine) {
  const CutPacking packing(side, tilt);
  const BodyNodes nodes = body_nodes(packing.problem);
  fmt::print(
      "Counted on one packing of {} contacts, one exchange of apgd (2 doubles a contact):\n\n",
      packing.problem.num_contacts());
  fmt::print(
      "| P | contacts of one | imbalance | halo of one | sent by one | bytes | partners | "
      "sent / root of contacts |\n| --- | --- | --- | --- | --- | --- | --- | --- |\n");
  double per_root = 0;
  int partners = 0;
  for (const int processes : {2, 4, 8, 16, 32, 64}) {
    const CutCount c = count_cut(packing, nodes, processes);
    const double root = c.sent / std::sqrt(static_cast<double>(c.contacts));
    per_root = std::max(per_root, root);
    partners = std::max(partners, c.partners);
    fmt::print("| {} | {} | {:.3f} | {} | {} | {} | {} | {:.2f} |\n", processes, c.contacts,
               c.imbalance, c.halo, c.sent, 16 * c.sent, c.partners, root);
  }
  fmt::print(
      "\nModel of an iteration: work {:.1f} ns a contact of one, {} messages at {:.1f} µs each and "
      "16 · {:.1f} · root(contacts of one) bytes at {:.0f} GB/s, a reduction of 24 bytes by "
      "recursive doubling: log2 P steps at the latency and 24 P bytes.\n\n",
      1e9 * machine.contact, partners, 1e6 * machine.latency, per_root, 1e-9 * machine.bandwidth);
  fmt::print(
      "| disks | P | contacts of one | kB sent by one | work [µs] | exchange [µs] | "
      "reduction [µs] | s an iteration | speed-up | efficiency |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  for (const double disks : {1e5, 1e6, 1e7, 1e8}) {
    for (const int processes : {1, 16, 128, 1000}) {
      const double contacts = 3 * disks / processes;
      if (contacts < 1000) continue;
      const double work = machine.contact * contacts;
      double exchange = 0, reduction = 0, bytes = 0;
      if (processes > 1) {
        bytes = 16 * per_root * std::sqrt(contacts);
        exchange = partners * machine.latency + bytes / machine.bandwidth;
        reduction = std::ceil(std::log2(processes)) * machine.latency +
                    24.0 * processes / machine.bandwidth;
      }
      const double total = work + exchange + reduction;
      const double alone = machine.contact * 3 * disks;
      fmt::print(
          "| {:.0e} | {} | {:.3g} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.2e} | {:.1f} | "
          "{:.0f} % |\n",
          disks, processes, contacts, bytes / 1000, 1e6 * work, 1e6 * exchange, 1e6 * reduction,
          total, alone / total, 100 * alone / total / processes);
    }
  }
}

}  // namespace
}  // namespace bipot

int main(int argc, char** argv) {
  bipot::take_kernels_of_this_processor(argv);
  CLI::App app("Costs of solves on several processes");
  int side = 183, iterations = 200, repeat = 3, steps = 1;
  double tilt = 0;
  bool use_model = false, reproducible = false, state = false;
  std::vector<double> tols;
  bipot::ModelMachine machine;
  app.add_option("--side", side, "Rows of the packing, about side² disks")
      ->check(CLI::Range(3, 2000));
  app.add_option("--iterations", iterations, "Measured")->check(CLI::Range(1, 1000000));
  app.add_option("--repeat", repeat, "Solves, of which the fastest counts")
      ->check(CLI::Range(1, 100));
  app.add_option("--tilt", tilt, "Angle of gravity [degrees]");
  app.add_option("--tols", tols,
                 "Solve to these as well; with --state to the first, within --iterations")
      ->delimiter(',');
  app.add_flag("--reproducible", reproducible, "Exact sums");
  app.add_flag("--state", state, "Steps of a state that lies on the processes");
  app.add_option("--steps", steps, "With --state")->check(CLI::Range(1, 1000000));
  app.add_flag("--model", use_model, "Count and extrapolate");
  app.add_option("--latency", machine.latency, "Of the model [s]");
  app.add_option("--bandwidth", machine.bandwidth, "Of the model [bytes/s]");
  app.add_option("--contact", machine.contact, "Of the model: work on a contact [s]");
  CLI11_PARSE(app, argc, argv);
  try {
    if (use_model) {
      bipot::model(side, tilt, machine);
    } else if (state) {
      bipot::measure_state(side, tilt, iterations, steps, tols.empty() ? 1e-300 : tols[0]);
    } else {
      bipot::measure(side, tilt, iterations, repeat, reproducible, tols);
    }
  } catch (const std::exception& e) {
    fmt::print(stderr, "distributed_bench: {}\n", e.what());
    bipot::end_all_processes(1);
  }
  return 0;
}
