#include "solvers/parallel/distributed_solve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/stopwatch.h"
#include "solvers/parallel/cell_tree.h"
#include "solvers/parallel/contact_owners.h"
#include "solvers/parallel/distributed_methods.h"
#include "solvers/parallel/whole_problem.h"
#include "solvers/parameters.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

/// A sentence where the solve is refused, empty where it can be done. `p`: the whole, or what this
/// process has of it.
std::string refuse_input(std::string_view name, const ContactProblem& p, const SolverOptions& o,
                         const DistributedOptions& extra) {
  const DistributedSolver* solver = find_distributed_solver(name);
  if (solver == nullptr) {
    std::string names;
    for (const DistributedSolver& s : distributed_solvers()) {
      names += (names.empty() ? "" : ", ") + std::string(s.name);
    }
    return fmt::format("solver {} runs on one process; on several there are {}", name, names);
  }
  if (auto defect = validate(p); !defect.empty()) return defect;
  if (p.num_contacts() > 0) {
    if (auto defect = refuse_distributed(p); !defect.empty()) return defect;
  }
  if (!(o.tol > 0) || !std::isfinite(o.tol)) {
    return fmt::format("tol = {}, expected a positive finite number", o.tol);
  }
  if (o.max_iterations < 0) {
    return fmt::format("max_iterations = {}, expected >= 0", o.max_iterations);
  }
  if (!(o.time_limit > 0)) return fmt::format("time_limit = {} s, expected > 0", o.time_limit);
  if (o.s0.size() != 0 && o.s0.size() != p.num_rows()) {
    return fmt::format("start s0 has size {}, expected {}", o.s0.size(), p.num_rows());
  }
  if (!o.s0.allFinite()) return "start s0 has a non-finite entry";
  if (o.islands.value_or(false) || o.parameters.count(std::string(kIslandsParameter.name)) > 0) {
    return "islands are solved one by one on one process only";
  }
  if (!extra.contact_places.empty() &&
      static_cast<int>(extra.contact_places.size()) != p.num_contacts()) {
    return fmt::format("{} places for {} contacts", extra.contact_places.size(), p.num_contacts());
  }
  try {
    const Parameters parameters(o.parameters, solver->parameters);
    if (extra.reproducible && !solver->any_processes(parameters)) {
      return fmt::format(
          "the iterates of {} depend on the processes; --reproducible takes apgd, uzawa, and "
          "anderson with map = gradient",
          name);
    }
    return solver->refuse(parameters);
  } catch (const std::invalid_argument& e) {
    return fmt::format("solver {}: {}", name, e.what());
  }
}

/// Throws on all processes where these figures are not the same on each.
void require_same(std::span<const double> figures, ProcessGroup& group) {
  std::vector<double> both;
  for (const double x : figures) {
    both.push_back(x);
    both.push_back(-x);
  }
  group.largest(both);
  bool same = true;
  for (std::size_t k = 0; k < figures.size(); ++k) {
    same &= both[2 * k] == figures[k] && both[2 * k + 1] == -figures[k];
  }
  group.fail_where_any(same ? "" : "the processes were given different problems");
}

/// Throws on all processes where they were given different problems.
void require_one_problem(const ContactProblem& p, const SolverOptions& o, ProcessGroup& group) {
  const double s0 = o.s0.size() > 0 ? o.s0.sum() : 0;
  const double figures[] = {static_cast<double>(p.num_rows()),
                            static_cast<double>(p.num_dofs()),
                            p.u_free.sum(),
                            p.v_free.sum(),
                            p.mu.sum(),
                            s0,
                            o.tol};
  require_same(figures, group);
}

/// One solve on the pieces of all processes.
class DistributedSolve {
 public:
  /// Keeps references. `watch`: since the set-up began.
  DistributedSolve(DistributedSpace& space, WholeProblem& whole, const SolverOptions& options,
                   const DistributedOptions& extra, const Stopwatch& watch)
      : piece_(space.piece()),
        whole_(whole),
        options_(options),
        group_(space.group()),
        shared_factor_rows_(extra.shared_factor_rows),
        watch_(watch),
        space_(space),
        evaluate_(space) {}

  /// `start`: rows that are here; the same size, 0 included, on no process or on all where nobody
  /// gives one.
  SolveResult run(const DistributedSolver& solver, const Vector& start,
                  DistributedCounts& counted) {
    const Traffic before = group_.traffic();
    SolveResult result;
    const Vector zero = Vector::Zero(piece_.own.num_rows());
    started_ = group_.any(start.size() > 0);
    const Vector& s0 = start.size() == 0 ? zero : start;
    if (evaluate_(zero).guarded() == 0) {
      result.status = SolveStatus::kNothingToDo;
      result.message = "s = 0 satisfies the law";
      result.s = zero;
    } else if (started_ && start_holds(s0)) {
      result.status = SolveStatus::kConverged;
      result.message = "the start meets the stop test";
      result.s = s0;
    } else {
      iterate(solver, s0, result);
    }
    counted = counts(before);
    judge(result);
    return result;
  }

 private:
  void iterate(const DistributedSolver& solver, const Vector& s0, SolveResult& result) {
    const double before = watch_.seconds();
    try {
      if (solver.led != nullptr) {
        SolverOptions options = options_;
        options.s0 = started_ ? whole_.join(s0) : Vector();
        result = lead(solver, options);
      } else {
        DistributedMonitor monitor(
            space_, evaluate_, options_,
            [this](const Vector& s, const ContactError& error) { return claim(s, error).holds; },
            [this](const DistributedSolver& stage, const Vector& s, double seconds, int& done) {
              return lead_stage(stage, s, seconds, done);
            });
        solver.run(monitor, Parameters(options_.parameters, solver.parameters), s0);
        result = monitor.finish();
      }
    } catch (const CommonFailure& e) {
      result.status = SolveStatus::kNumericalFailure;
      result.message = fmt::format("{} failed: {}", solver.name, e.what());
      result.s = Vector::Zero(piece_.own.num_rows());
    }
    result.setup_seconds += before;
  }

  /// A led solver on the whole problem; the result's s is that of the rows here. The first process
  /// has the start.
  SolveResult lead(const DistributedSolver& solver, const SolverOptions& options) {
    SolveResult result;
    const bool shared = piece_.whole_contacts * piece_.own.dim >= shared_factor_rows_;
    const ContactProblem& whole = whole_.on_first();
    group_.lend_hands([&](SystemFactor& factor) {
      SystemFactor* const by = shared ? &factor : nullptr;
      SolverEntry entry{.name = solver.name,
                        .summary = solver.summary,
                        .run = [&](const ContactProblem& p,
                                   const SolverOptions& o) { return solver.led(p, o, by); },
                        .parameters = solver.parameters};
      result = solve(entry, whole, options);
    });
    // From the first process to all.
    const bool first = group_.rank() == 0;
    if (first && result.s.size() != whole.num_rows()) result.s = Vector::Zero(whole.num_rows());
    const double figures[] = {static_cast<double>(result.status),
                              static_cast<double>(result.iterations), result.setup_seconds,
                              result.solve_seconds};
    const auto of_first = [&](std::span<const double> values) {
      return group_.gather(first ? values : std::span<const double>());
    };
    const std::vector<double> known = of_first(figures);
    result.message = group_.first_text(first ? result.message : std::string());
    result.message +=
        shared ? "; systems factored by all processes" : "; systems factored by the first process";
    result.status = static_cast<SolveStatus>(static_cast<int>(known[0]));
    result.iterations = static_cast<int>(known[1]);
    result.setup_seconds = known[2];
    result.solve_seconds = known[3];
    result.s = whole_.part(result.s);
    return result;
  }

  /// The same as a stage of another method, from the impulse s of the rows here. What it says of
  /// itself is left out: the method judges the impulse.
  Vector lead_stage(const DistributedSolver& solver, const Vector& s, double seconds, int& done) {
    SolverOptions options = options_;
    options.parameters.clear();
    options.on_iteration = nullptr;
    options.stop = StopTest::kGuarded;
    options.time_limit = seconds;
    options.s0 = whole_.join(s);
    const SolveResult result = lead(solver, options);
    done = result.iterations;
    return result.s;
  }

  bool start_holds(const Vector& s0) {
    const ContactError error = evaluate_(s0);
    return meets(options_, error) && claim(evaluate_.impulse(), error).holds;
  }

  /// The last word of proved_claim.h, on the whole problem.
  ProvedClaim claim(const Vector& s, const ContactError& error) {
    if (options_.stop != StopTest::kGuarded) return {};
    return whole_.claim(options_, s, error);
  }

  void judge(SolveResult& result) {
    if (group_.any(!result.s.allFinite())) {
      result.message =
          fmt::format("the solver returned a non-finite impulse (it said: {})", result.message);
      result.status = SolveStatus::kNumericalFailure;
      result.s.setZero();
    }
    result.error = evaluate_.with_worst(result.s);
    const Vector s = evaluate_.impulse();
    const bool raw = options_.stop == StopTest::kRaw42 && result.status == SolveStatus::kConverged;
    const double measured = raw ? result.error.raw42 : result.error.guarded();
    const bool verifiable =
        options_.stop != StopTest::kImpulse || result.status == SolveStatus::kNothingToDo;
    if (is_success(result.status) && verifiable && !(measured <= options_.tol)) {
      result.message = fmt::format(
          "claim of convergence withdrawn: {} error {:.3e} on the original data, tolerance {:.1e} "
          "(it said: {})",
          raw ? "raw42" : "guarded", measured, options_.tol, result.message);
      result.status = SolveStatus::kNumericalFailure;
    } else if (result.status == SolveStatus::kConverged) {
      const ProvedClaim last = claim(s, result.error);
      if (!last.holds) {
        result.status = SolveStatus::kStalled;
        result.message = fmt::format(
            "stalled at rounding: guarded error {:.3e} in double, {:.3e} in extended precision (it "
            "said: {})",
            result.error.guarded(), last.error, result.message);
      }
    }
    result.s = s;
    result.u = evaluate_.velocity();
  }

  DistributedCounts counts(const Traffic& before) {
    const Traffic& now = group_.traffic();
    double most[5] = {static_cast<double>(now.messages - before.messages),
                      static_cast<double>(now.bytes - before.bytes),
                      static_cast<double>(now.reductions - before.reductions),
                      static_cast<double>(now.reduced_bytes - before.reduced_bytes),
                      static_cast<double>(piece_.halo.size())};
    group_.largest(most);
    DistributedCounts counts;
    counts.processes = group_.size();
    const double here[1] = {static_cast<double>(piece_.own.num_contacts())};
    const std::vector<double> contacts = group_.gather(here);
    counts.imbalance = imbalance(contacts);
    counts.most_contacts = static_cast<int>(*std::max_element(contacts.begin(), contacts.end()));
    counts.most_halo = static_cast<int>(most[4]);
    counts.traffic.messages = static_cast<std::int64_t>(most[0]);
    counts.traffic.bytes = static_cast<std::int64_t>(most[1]);
    counts.traffic.reductions = static_cast<std::int64_t>(most[2]);
    counts.traffic.reduced_bytes = static_cast<std::int64_t>(most[3]);
    return counts;
  }

  const ProblemPiece& piece_;
  WholeProblem& whole_;
  const SolverOptions& options_;
  ProcessGroup& group_;
  int shared_factor_rows_;
  const Stopwatch& watch_;
  DistributedSpace& space_;
  DistributedError evaluate_;
  bool started_ = false;  // some process was given a start
};

}  // namespace

DistributedResult distributed_solve(std::string_view name, const ContactProblem& problem,
                                    const SolverOptions& options, ProcessGroup& group,
                                    const DistributedOptions& extra) {
  DistributedResult out;
  out.counts.processes = group.size();
  const std::string refusal = group.first_text(refuse_input(name, problem, options, extra));
  if (!refusal.empty()) {
    out.result.status = SolveStatus::kInvalidInput;
    out.result.message = refusal;
    return out;
  }
  if (!group.any(problem.num_contacts() > 0)) {
    out.result.status = SolveStatus::kNothingToDo;
    out.result.message = "no contacts";
    out.result.error = contact_error(problem, Vector());
    return out;
  }
  require_one_problem(problem, options, group);
  const Stopwatch watch;
  const BodyNodes nodes = body_nodes(problem);
  const ContactOwners owners = contact_owners(problem, nodes, extra.contact_places, group.size());
  const ProblemPiece piece = cut_piece(problem, nodes, owners, group.rank());
  DistributedSpace space(piece, group, extra.reproducible);
  KnownWhole whole(problem, owners, group);
  const Vector start = options.s0.size() == 0 ? Vector() : whole.mine(options.s0);
  out.result = DistributedSolve(space, whole, options, extra, watch)
                   .run(*find_distributed_solver(name), start, out.counts);
  out.result.s = whole.join(out.result.s);
  out.result.u = whole.join(out.result.u);
  return out;
}

PieceResult distributed_solve(std::string_view name, const ProblemPiece& piece,
                              const SolverOptions& options, ProcessGroup& group,
                              const DistributedOptions& extra) {
  PieceResult out;
  out.counts.processes = group.size();
  const std::string refusal = group.first_text(refuse_input(name, piece.own, options, extra));
  if (!refusal.empty()) {
    out.result.status = SolveStatus::kInvalidInput;
    out.result.message = refusal;
    return out;
  }
  const double figures[] = {static_cast<double>(piece.whole_contacts),
                            static_cast<double>(piece.own.dim),
                            static_cast<double>(piece.everywhere_inverse_mass.size()), options.tol};
  require_same(figures, group);
  out.with_halo = Vector::Zero(piece.with_halo.num_rows());
  if (piece.whole_contacts == 0) {
    out.result.status = SolveStatus::kNothingToDo;
    out.result.message = "no contacts";
    out.result.error = contact_error(piece.own, Vector());
    return out;
  }
  const Stopwatch watch;
  DistributedSpace space(piece, group, extra.reproducible);
  GatheredWhole whole(space);
  out.result = DistributedSolve(space, whole, options, extra, watch)
                   .run(*find_distributed_solver(name), options.s0, out.counts);
  space.with_halo(out.result.s, out.with_halo);
  out.everywhere_momentum = space.everywhere_momentum(out.result.s);
  return out;
}

}  // namespace bipot
