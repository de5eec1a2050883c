// Savings by doing only the work that a scene requires. Each row is measured once without and once
// with the saving, in one run, in CPU seconds of one thread (median of --repeat alternating pairs).
// It states how the answers were compared. Prints a table in Markdown
// (data/manual/results/performance.md).
//   savings_bench [--repeat=5] [--tol=1e-6]

#include <fmt/format.h>
#include <stdlib.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "bench/command/blas_kernels.h"
#include "core/linear/frontal_lu.h"
#include "core/motion/time_stepping.h"
#include "core/run_files/run_output.h"
#include "core/scene/contact_detection.h"
#include "core/scene/generators.h"
#include "core/scene/scene_family.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

int repeat = 5;
double tol = 1e-6;

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

double median(std::vector<double> x) {
  std::nth_element(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2), x.end());
  return x[x.size() / 2];
}

/// One row. `check` describes how the answers agree, and throws if they do not.
void row(const std::string& what, const std::function<void()>& without,
         const std::function<void()>& with, const std::function<std::string()>& check) {
  std::vector<double> slow, fast;
  for (int k = 0; k < repeat; ++k) {
    double before = cpu_seconds();
    without();
    slow.push_back(cpu_seconds() - before);
    before = cpu_seconds();
    with();
    fast.push_back(cpu_seconds() - before);
  }
  const double a = median(slow), b = median(fast);
  fmt::print("| {} | {:.4f} | {:.4f} | {:.2f} | {} |\n", what, a, b, a / b, check());
  std::fflush(stdout);
}

/// Both have converged: the measured errors.
std::string errors_of(const SolveResult& a, const SolveResult& b) {
  if (!is_success(a.status) || !is_success(b.status)) {
    throw std::runtime_error(a.message + " | " + b.message);
  }
  return fmt::format("errors {:.1e}, {:.1e}", a.error.guarded(), b.error.guarded());
}

/// `small` free pyramids of 4 rows beside one of `rows`, all falling on one floor at 1 m/s. Those
/// of the second material have no friction.
Scene<2> pyramids(int small, int rows, int slippery) {
  Scene<2> scene = make_family_scene("pyramid", rows);
  scene.materials = {"rough", "slippery"};
  scene.laws = {{.mu = 0.3}, {.mu = 0}, {.mu = 0}, {.mu = 0}};
  double left = rows + 2.0;
  for (int k = 0; k < small; ++k, left += 6) {
    for (Disk d : pyramid(4, 0.5, Vec2(left, 0))) {
      d.mass = scene.bodies[0].mass;
      d.inertia = scene.bodies[0].inertia;
      d.material = k < slippery ? 1 : 0;
      scene.bodies.push_back(d);
    }
  }
  for (Disk& d : scene.bodies) d.v = Vec2(0, -1);
  return scene;
}

ContactProblem first_step(const Scene<2>& scene) {
  return step_problem(scene, initial_state(scene), false);
}

void without_friction() {
  const ContactProblem one = first_step(make_family_scene("triangular", 40, {.mu = 0}));
  ContactProblem two = first_step(make_family_scene("triangular", 40, {.mu = 0.3}));
  two.mu.setZero();
  SolveResult slow, fast;
  row(
      fmt::format("no friction: d = 1 without rotations ({} contacts, `auto`)", one.num_contacts()),
      [&] { slow = solve("auto", two, {.tol = tol, .islands = false}); },
      [&] { fast = solve("auto", one, {.tol = tol, .islands = false}); },
      [&] {
        double largest = 0;
        for (int c = 0; c < one.num_contacts(); ++c) {
          largest = std::max(largest, std::abs(slow.u[2 * c] - fast.u[c]));
        }
        return fmt::format("{}; normal velocities within {:.0e} g h", errors_of(slow, fast),
                           largest / (9.81 * 0.01));
      });
}

void islands(const std::string& what, const Scene<2>& scene) {
  const ContactProblem p = first_step(scene);
  SolveResult slow, fast;
  row(
      fmt::format("{} ({} contacts, `auto`)", what, p.num_contacts()),
      [&] { slow = solve("auto", p, {.tol = tol, .islands = false}); },
      [&] { fast = solve("auto", p, {.tol = tol}); }, [&] { return errors_of(slow, fast); });
}

/// All at rest but the last pyramid, which is hit.
void islands_at_rest() {
  const ContactProblem before = first_step(pyramids(200, 15, 0));
  const Vector s0 = solve("auto", before, {.tol = 0.1 * tol}).s;
  Scene<2> scene = pyramids(200, 15, 0);
  scene.bodies.back().v = Vec2(-2, -3);
  const ContactProblem p = first_step(scene);
  SolveResult slow, fast;
  row(
      fmt::format("islands at rest keep their impulses; one is hit ({} contacts)",
                  p.num_contacts()),
      [&] { slow = solve("auto", p, {.tol = tol, .s0 = s0, .islands = false}); },
      [&] { fast = solve("auto", p, {.tol = tol, .s0 = s0}); },
      [&] { return errors_of(slow, fast); });
}

/// The same contacts with and without the degrees of freedom of bodies that touch nothing.
void free_bodies() {
  const ContactProblem p = first_step(make_family_scene("triangular", 20));
  ContactProblem all = p;
  const int n = p.num_dofs(), flying = 30000;
  all.A.conservativeResize(n + flying, n + flying);
  for (int k = 0; k < flying; ++k) all.A.insert(n + k, n + k) = 1;
  all.A.makeCompressed();
  all.H.conservativeResize(n + flying, p.num_rows());
  all.v_free.conservativeResize(n + flying);
  all.v_free.tail(flying).setZero();
  SolveResult slow, fast;
  row(
      fmt::format("10 000 bodies without contacts are integrated only ({} contacts, `apgd`)",
                  p.num_contacts()),
      [&] { slow = solve("apgd", all, {.tol = tol}); },
      [&] { fast = solve("apgd", p, {.tol = tol}); },
      [&] {
        return fmt::format("{}; impulses differ by {:.0e}", errors_of(slow, fast),
                           (slow.s - fast.s).norm() / fast.s.norm());
      });
}

/// A step whose contacts are those of the step before.
void kept_analysis(const std::string& family, int side) {
  const ContactProblem p = first_step(make_family_scene(family, side));
  SolveResult slow, fast;
  row(
      fmt::format("analysis of the contact graph kept while it does not change, {} {} (`ipm`)",
                  family, side),
      [&] {
        FrontalTree::forget();
        slow = solve("ipm", p, {.tol = tol});
      },
      [&] { fast = solve("ipm", p, {.tol = tol}); },
      [&] {
        if (slow.s != fast.s) throw std::runtime_error("impulses differ");
        return errors_of(slow, fast) + "; the same bits";
      });
}

/// 100 steps of disks that move by a thousandth of their radius a step.
void kept_contacts() {
  const Scene<2> scene = make_family_scene("triangular", 100);
  std::size_t slow = 0, fast = 0;
  const auto walk = [&](const auto& detect, std::size_t& found) {
    std::vector<Disk> disks = scene.bodies;
    found = 0;
    for (int k = 0; k < 100; ++k) {
      found += detect(disks).size();
      for (std::size_t i = 0; i < disks.size(); ++i) {
        const double angle = 0.7 * static_cast<double>(i);
        disks[i].x += 5e-4 * Vec2(std::cos(angle), std::sin(angle));
      }
    }
  };
  row(
      fmt::format(
          "contact lists kept while nothing moved by more than a skin ({} disks, 100 steps)",
          scene.bodies.size()),
      [&] { walk([&](const auto& d) { return detect_contacts(d, scene.walls, 0.01); }, slow); },
      [&] {
        KeptContacts<2> kept;
        walk([&](const auto& d) { return kept(d, scene.walls, 0.01); }, fast);
      },
      [&] {
        if (slow != fast) throw std::runtime_error("contact lists differ");
        return fmt::format("{} contacts in both", slow);
      });
}

/// A folder for the files of a run that is deleted with this object.
class PassingFolder {
 public:
  PassingFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "savings_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no folder to write to");
    path_ = name;
  }
  ~PassingFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  PassingFolder(const PassingFolder&) = delete;
  PassingFolder& operator=(const PassingFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// The lines of a ledger by their step.
std::map<int, std::string> ledger_rows(const std::filesystem::path& path) {
  std::map<int, std::string> rows;
  std::ifstream in(path);
  std::string line;
  for (std::getline(in, line); std::getline(in, line);) rows[std::stoi(line)] = line;
  return rows;
}

/// Steps of disks in free fall, each with a row of the ledger or only with those that are due.
void rows_asked_for() {
  constexpr int kSteps = 20, kEvery = 10;
  Scene<2> scene = make_family_scene("triangular", 316);
  scene.walls.clear();
  for (Disk& d : scene.bodies) d.radius *= 0.9;
  const StepSolver none = [](const ContactProblem& p, const Vector&) {
    return StepSolution{.converged = true, .s = Vector::Zero(p.num_rows())};
  };
  const PassingFolder folder;
  const auto fall = [&](const std::string& name, int every) {
    scene.output.ledger_every = every;
    State<2> state = initial_state(scene);
    TimeStepper<2> stepper(scene, none, false);
    RunWriter<2> writer(folder / name, scene, "");
    for (int k = 0; k < kSteps; ++k) {
      const StepReport<2> report = stepper.advance(state);
      writer.step(state, report);
    }
    writer.finish(state);
  };
  row(
      fmt::format("stress and area of the sample only where the ledger has a row, every {}th step "
                  "({} disks in free fall, {} steps)",
                  kEvery, scene.bodies.size(), kSteps),
      [&] { fall("all", 1); }, [&] { fall("some", kEvery); },
      [&] {
        const auto all = ledger_rows(folder / "all/ledger.csv");
        const auto some = ledger_rows(folder / "some/ledger.csv");
        if (some.size() != kSteps / kEvery) throw std::runtime_error("rows are missing");
        for (const auto& [step, line] : some) {
          if (all.at(step) != line) throw std::runtime_error("rows differ");
        }
        return fmt::format("{} rows, the same bits", some.size());
      });
}

}  // namespace
}  // namespace bipot

int main(int argc, char** argv) {
  bipot::take_kernels_of_this_processor(argv);
  using namespace bipot;
  CLI::App app{"What is saved by doing only what a scene requires, as a table"};
  app.add_option("--repeat", repeat, "Pairs of runs a row")->check(CLI::Range(1, 1000));
  app.add_option("--tol", tol, "Tolerance of the solves")->check(CLI::PositiveNumber);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  try {
    fmt::print("| what | without [s] | with [s] | ratio | the same answer |\n");
    fmt::print("| --- | --- | --- | --- | --- |\n");
    without_friction();
    islands("islands: 200 pyramids of 4 rows beside one of 15", pyramids(200, 15, 0));
    islands("islands, half of them without friction (d = 1)", pyramids(200, 15, 100));
    islands_at_rest();
    islands("nothing to cut: one pyramid of 15 rows", pyramids(0, 15, 0));
    free_bodies();
    kept_contacts();
    kept_analysis("square", 60);
    rows_asked_for();
  } catch (const std::exception& e) {
    fmt::print(stderr, "savings_bench: {}\n", e.what());
    return 1;
  }
  return 0;
}
