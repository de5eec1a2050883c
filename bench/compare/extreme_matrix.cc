#include "bench/compare/extreme_matrix.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/compare/isolated_jobs.h"
#include "bench/measure/independent_check.h"
#include "bench/measure/limited_solve.h"
#include "bench/measure/stopwatch.h"
#include "core/base/nearest_name.h"
#include "solvers/registry.h"
#include "solvers/simulation/scene_run.h"

namespace bipot {

/// What a child process says of a cell.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ExtremeCell, end, status, message, guarded, true_error,
                                   energy_error, iterations, cpu_seconds, steps_solved, steps)

namespace {

constexpr double kEnergyGrace = 1e-6;  // of the energy moved: allowance for the tolerance

/// Work of the impulses on the mean velocities if it is a gain (the law requires a loss), over the
/// energy that they move.
double energy_created(const Vector& s, const Vector& u, const ContactProblem& p) {
  double gain = 0, moved = 0;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const auto sc = s.segment(c * p.dim, p.dim), uc = u.segment(c * p.dim, p.dim);
    gain += sc.dot(uc);
    moved += 0.5 * std::abs(sc.dot(uc - p.u_free.segment(c * p.dim, p.dim)));
  }
  return moved > 0 ? std::max(gain, 0.0) / moved : 0;
}

double limit_of(const ExtremeCase& of, const ExtremeMatrix::Options& options) {
  return std::max(options.time_limit, of.least_seconds);
}

ExtremeCell solve_problem(const ExtremeMatrix::Case& of, const std::string& solver,
                          const ExtremeMatrix::Options& options) {
  ExtremeCell cell;
  ContactProblem problem;
  try {
    problem = of.problem();
  } catch (const std::invalid_argument& e) {
    cell.end =
        of.expect == ExtremeCase::Expect::kRefused ? ExtremeCell::kRefused : ExtremeCell::kWrong;
    cell.status = "refused";
    cell.message = e.what();
    return cell;
  }
  const SolverEntry& entry = require_solver(solver);
  const double begin = cpu_seconds();
  const SolveResult r = solve_within(entry, problem, {.tol = options.tol}, limit_of(of, options));
  cell.cpu_seconds = cpu_seconds() - begin;
  cell.status = to_string(r.status);
  cell.message = r.message;
  cell.iterations = r.iterations;
  if (r.status == SolveStatus::kInvalidInput) {
    const bool beyond = !beyond_solver(entry, problem).empty();
    const bool may_be = of.expect == ExtremeCase::Expect::kOpen;
    cell.end = beyond   ? ExtremeCell::kNotForIt
               : may_be ? ExtremeCell::kRefused
                        : ExtremeCell::kUnsolved;
    return cell;
  }
  const IndependentCheck check = independent_check(problem, r.s);
  cell.guarded = check.guarded;
  const bool finite = r.s.allFinite() && r.u.allFinite();
  if (finite) {
    cell.energy_error = energy_created(r.s, r.u, problem);
    if (of.true_error) cell.true_error = of.true_error(r.s, r.u);
  }
  const bool claimed = is_success(r.status);
  // If an energy underflows, no error exists in double precision, and none is claimed.
  const bool confirmed = check.confirms(options.tol);
  if (!finite || (claimed && !confirmed) || (claimed && of.verdict == Existence::kNone)) {
    cell.end = ExtremeCell::kWrong;
    if (finite) cell.message += fmt::format(" (independent check {:.2e})", check.guarded);
  } else if (claimed) {
    cell.end = ExtremeCell::kSolved;
    cell.steps_solved = 1;
  } else {
    cell.end = of.verdict == Existence::kNone ? ExtremeCell::kNone
               : of.floor > options.tol       ? ExtremeCell::kBeyond
                                              : ExtremeCell::kUnsolved;
  }
  return cell;
}

ExtremeCell run_case(const ExtremeCase& of, const std::string& solver,
                     const ExtremeMatrix::Options& options) {
  ExtremeCell cell{.guarded = 0, .energy_error = 0, .steps = of.steps};
  const Scene<2> scene = of.scene();
  const SolverEntry& entry = require_solver(solver);
  SceneRunOptions<2> run{.steps = of.steps};
  bool wrong = false, beyond = false;
  const auto fail = [&](bool is_wrong, const std::string& status, const std::string& message) {
    if (cell.message.empty() || (is_wrong && !wrong)) {
      cell.status = status;
      cell.message = message;
    }
    wrong = wrong || is_wrong;
  };
  const double begin = cpu_seconds();
  run.solver = [&](const ContactProblem& p, const Vector& s0) {
    const double left = std::max(1e-3, limit_of(of, options) - (cpu_seconds() - begin));
    const SolveResult r = solve_within(entry, p, {.tol = options.tol, .s0 = s0}, left);
    cell.iterations += r.iterations;
    StepSolution step = taken_step(r);
    if (step.refused) {
      beyond = true;
      fail(false, std::string(to_string(r.status)), r.message);
      return step;
    }
    const double guarded = p.num_contacts() == 0 ? 0 : independent_check(p, r.s).guarded;
    if (!(guarded <= cell.guarded)) cell.guarded = guarded;
    if (!r.s.allFinite()) fail(true, "not finite", r.message);
    if (step.converged && !(guarded <= options.tol)) {
      fail(true, "false claim", fmt::format("{} (independent check {:.2e})", r.message, guarded));
    } else if (!step.converged) {
      fail(false, std::string(to_string(r.status)), r.message);
    }
    return step;
  };
  State<2> state = initial_state(scene);
  const double initial = kinetic_energy(state);
  double loss = 0;
  run.on_step = [&](const SceneStep<2>& s) {
    cell.steps_solved += s.report.converged ? 1 : 0;
    const EnergyLedger& e = s.report.energy;
    const double now = e.friction_loss + e.shock_loss;
    const double scale = std::max({initial, e.kinetic, std::abs(now)});
    const double allowed = s.report.force_energy;
    const double created = scale > 0 ? (loss - now - allowed) / scale : 0;
    cell.energy_error = std::max(cell.energy_error, of.must_conserve ? std::abs(created) : created);
    if (of.must_dissipate && s.report.converged &&
        (of.must_conserve ? std::abs(created) : created) > kEnergyGrace) {
      fail(true, "energy",
           fmt::format("step {}: the contacts changed the energy by {:.2e} of it", s.report.step,
                       created));
    }
    loss = now;
    return true;
  };
  const SceneRun<2> done = run_scene(scene, state, run);
  cell.cpu_seconds = cpu_seconds() - begin;
  if (done.failure && !beyond) fail(false, "failed", done.failure->what());
  if (wrong) {
    cell.end = ExtremeCell::kWrong;
  } else if (beyond) {
    cell.end = ExtremeCell::kNotForIt;
  } else if (cell.steps_solved == of.steps) {
    cell.end = ExtremeCell::kSolved;
    cell.status = "converged";
    cell.message = fmt::format("{} steps", of.steps);
  } else {
    cell.end = ExtremeCell::kUnsolved;
  }
  return cell;
}

/// Tries to prove that the case has a solution.
void certify(ExtremeMatrix::Case& c) {
  if (!c.problem) return;
  try {
    const ContactProblem p = c.problem();
    if (const std::string defect = validate(p); !defect.empty()) {
      c.existence = "refused: " + defect;
      return;
    }
    const ExistenceCertificate certificate = certify_existence(p);
    c.verdict = certificate.verdict;
    c.existence = to_text(certificate);
    if (c.solution) c.floor = independent_check(p, c.solution()).guarded;
  } catch (const std::invalid_argument& e) {
    c.existence = std::string("refused: ") + e.what();
  }
}

}  // namespace

const ExtremeCell::Words& words_of(ExtremeCell::End end) {
  static constexpr ExtremeCell::Words kWords[] = {{"solved", "ok", "good"},
                                                  {"not solved", "--", "weak"},
                                                  {"beyond double", "rd", "beyond"},
                                                  {"no solution", "no", "none"},
                                                  {"refused", "rf", "grey"},
                                                  {"not for it", "", ""},
                                                  {"wrong", "!!", "bad"}};
  return kWords[static_cast<int>(end)];
}

const ExtremeCell* ExtremeMatrix::find(const std::string& name, const std::string& solver) const {
  for (const ExtremeCell& c : cells) {
    if (c.name == name && c.solver == solver) return &c;
  }
  return nullptr;
}

ExtremeMatrix measure_extremes(const ExtremeMatrix::Options& options) {
  ExtremeMatrix matrix{.solvers = options.solvers, .tol = options.tol};
  require_solvers(options.solvers);
  std::vector<std::string> names;
  for (const ExtremeCase& c : extreme_cases()) {
    if (options.quick && c.large) {
      if (c.name != options.only) continue;
      throw std::invalid_argument(options.only + " has no short form: leave out --quick");
    }
    names.push_back(c.name);
    if (c.name == options.only) {  // a whole name is that case alone
      matrix.cases = {{c}};
      break;
    }
    if (c.name.starts_with(options.only)) matrix.cases.push_back({c});
  }
  if (matrix.cases.empty()) {
    throw std::invalid_argument(unknown_name_message("case", options.only, names));
  }
  std::ranges::for_each(matrix.cases, &certify);
  const int solvers = static_cast<int>(matrix.solvers.size());
  const auto of = [&](int k) -> const ExtremeMatrix::Case& {
    return matrix.cases[to_size(k / solvers)];
  };
  IsolatedJobs jobs{.count = static_cast<int>(matrix.cases.size()) * solvers,
                    .seconds = std::max(30.0, 10 * options.time_limit),
                    .interrupted = options.watch.interrupted};
  jobs.job = [&](int k) {
    const std::string& solver = matrix.solvers[to_size(k % solvers)];
    return of(k).scene ? run_case(of(k), solver, options) : solve_problem(of(k), solver, options);
  };
  jobs.on_end = [&](int k, const IsolatedJobs::End& end) {
    ExtremeCell cell;
    if (end.kind == IsolatedJobs::End::Kind::kDone) {
      end.result.get_to(cell);
    } else {
      cell.status = end.kind == IsolatedJobs::End::Kind::kHung ? "hung" : "crashed";
      cell.message = end.cause;
    }
    cell.name = of(k).name;
    cell.solver = matrix.solvers[to_size(k % solvers)];
    cell.time_limit = limit_of(of(k), options);
    matrix.cells.push_back(cell);
    options.watch.tell(k + 1, jobs.count, cell.name + ", " + cell.solver);
  };
  run_isolated(jobs);
  matrix.complete = static_cast<int>(matrix.cells.size()) == jobs.count;
  return matrix;
}

int count_cells(const ExtremeMatrix& matrix, ExtremeCell::End end, const std::string& solver) {
  return static_cast<int>(std::ranges::count_if(matrix.cells, [&](const ExtremeCell& c) {
    return c.end == end && (solver.empty() || c.solver == solver);
  }));
}

std::vector<std::string> solved_by_others(const ExtremeMatrix& matrix, const std::string& name) {
  const ExtremeCell* first = matrix.find(name, "auto");
  if (first == nullptr || first->end == ExtremeCell::kSolved) return {};
  std::vector<std::string> others;
  for (const ExtremeCell& c : matrix.cells) {
    if (c.name == name && c.end == ExtremeCell::kSolved) others.push_back(c.solver);
  }
  return others;
}

}  // namespace bipot
