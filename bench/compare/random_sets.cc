#include "bench/compare/random_sets.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/compare/isolated_jobs.h"
#include "bench/compare/random_problem.h"
#include "bench/compare/random_scene.h"
#include "bench/measure/independent_check.h"
#include "bench/measure/limited_solve.h"
#include "bench/measure/stopwatch.h"
#include "solvers/analysis/existence.h"
#include "solvers/registry.h"
#include "solvers/simulation/scene_run.h"

namespace bipot {
namespace {

/// Interval of problems that are certified even if they were solved.
constexpr int kCertifyEvery = 10;

/// One solve, as the child process tells it.
struct SolveRecord {
  std::string solver, message;
  bool refused = false, solved = false, false_claim = false, not_finite = false;
  bool certified = false;  ///< its existence was looked at
  Existence existence = Existence::kUndecided;
  double seconds = 0;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SolveRecord, solver, message, refused, solved, false_claim,
                                   not_finite, certified, existence, seconds)

/// A problem, or a scene.
struct JobRecord {
  std::vector<SolveRecord> solves;
  bool planted = false, plant_holds = false;
  bool certified = false, false_certificate = false;
  Existence existence = Existence::kUndecided;
  int without_contacts = 0;  ///< steps
  bool grew = false;         ///< the energy, against theory
  std::string message;       ///< of a run
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(JobRecord, solves, planted, plant_holds, certified,
                                   false_certificate, existence, without_contacts, grew, message)

SolveRecord judge(const std::string& solver, const ContactProblem& problem, const SolveResult& r,
                  double tol, double seconds) {
  SolveRecord v{.solver = solver,
                .message = fmt::format("{}: {}", to_string(r.status), r.message),
                .refused = r.status == SolveStatus::kInvalidInput,
                .seconds = seconds};
  if (v.refused) return v;
  v.not_finite = !r.s.allFinite() || !r.u.allFinite();
  const IndependentCheck check = independent_check(problem, r.s);
  v.solved = is_success(r.status) && check.confirms(tol);
  v.false_claim = is_success(r.status) && !v.solved;
  if (is_success(r.status)) v.message += fmt::format(" (independent check {:.2e})", check.guarded);
  return v;
}

/// The solvers that run on problem `index`.
std::vector<std::string> solvers_of(const RandomSets::Options& options, int index) {
  std::vector<std::string> names = {options.solvers.front()};
  const int others = static_cast<int>(options.solvers.size()) - 1;
  if (others > 0) names.push_back(options.solvers[to_size(1 + index % others)]);
  return names;
}

JobRecord problem_job(const RandomSets::Options& options, int index) {
  const RandomProblem random = random_problem(options.seed, index);
  const ContactProblem& p = random.problem;
  JobRecord record{.planted = random.planted.size() > 0};
  record.plant_holds =
      record.planted && independent_check(p, random.planted).guarded <= options.tol / 10;
  for (const std::string& solver : solvers_of(options, index)) {
    const double begin = cpu_seconds();
    const SolveResult result =
        solve_within(require_solver(solver), p, {.tol = options.tol}, options.time_limit);
    record.solves.push_back(judge(solver, p, result, options.tol, cpu_seconds() - begin));
  }
  if (!record.solves.front().solved || index % kCertifyEvery < 2) {
    record.certified = true;
    record.existence = certify_existence(p, options.time_limit).verdict;
    record.false_certificate =
        record.existence == Existence::kNone &&
        (record.plant_holds || std::ranges::any_of(record.solves, &SolveRecord::solved));
  }
  return record;
}

/// Sums the results of the jobs.
class Ledger {
 public:
  explicit Ledger(const RandomSets::Options& options) : options_(options) {
    for (const std::string& name : options.solvers) result_.tallies.emplace_back().solver = name;
  }

  void add_problem(int index, const JobRecord& record) {
    if (record.planted && !record.plant_holds) ++result_.poor_plants;
    if (record.certified) ++result_.certificates;
    if (record.false_certificate) {
      ++result_.false_certificates;
      find("false certificate", index, "", "no solution was said to exist, but one does");
    }
    for (const SolveRecord& solve : record.solves) {
      add_solve(index, solve, record.plant_holds, record.existence);
      if (record.solves.front().solved || !solve.solved) continue;
      ++tally(solve.solver).missed_by_first;
      find("missed by the first", index, solve.solver, solve.message);
    }
  }

  void add_scene(int index, const JobRecord& record) {
    RandomSets::Tally& t = result_.tallies.front();
    for (const SolveRecord& solve : record.solves) {
      if (solve.certified) ++result_.certificates;
      add_solve(index, solve, false, solve.existence);
    }
    t.other_solved += record.without_contacts;
    t.other += record.without_contacts;
    t.tried += record.without_contacts;
    if (record.grew) ++result_.energy_grew;
    if (record.grew || !record.message.empty()) {
      find(record.grew ? "energy grew" : "run ended early", index, t.solver, record.message);
    }
  }

  /// Counts the job. True for a crash or a hang, which counts for the first solver: the job gives
  /// no more information.
  bool lost(int index, const IsolatedJobs::End& end) {
    ++result_.done;
    if (end.kind == IsolatedJobs::End::Kind::kDone) return false;
    RandomSets::Tally& t = result_.tallies.front();
    const bool hung = end.kind == IsolatedJobs::End::Kind::kHung;
    ++(hung ? t.hung : t.crashed);
    find(hung ? "hung" : "crashed", index, "", end.cause);
    return true;
  }

  RandomSets result() { return std::move(result_); }

 private:
  RandomSets::Tally& tally(const std::string& solver) {
    return *std::ranges::find_if(result_.tallies,
                                 [&](const RandomSets::Tally& t) { return t.solver == solver; });
  }

  void find(const char* kind, int index, const std::string& solver, const std::string& message) {
    result_.findings.push_back({kind, index, solver, message});
  }

  void add_solve(int index, const SolveRecord& solve, bool planted, Existence existence) {
    RandomSets::Tally& t = tally(solve.solver);
    ++t.tried;
    t.cpu_seconds += solve.seconds;
    if (solve.refused) {
      ++t.refused;
      return;
    }
    ++(planted ? t.planted : t.other);
    if (solve.solved) ++(planted ? t.planted_solved : t.other_solved);
    if (solve.false_claim) {
      ++t.false_claims;
      find("false claim", index, t.solver, solve.message);
    }
    if (solve.not_finite) {
      ++t.not_finite;
      find("not finite", index, t.solver, solve.message);
    }
    const bool first = t.solver == options_.solvers.front();
    if (solve.solved || planted) {
      if (!solve.solved && first) find("planted, not solved", index, t.solver, solve.message);
      return;
    }
    if (existence == Existence::kNone) {
      ++t.none_proved;
    } else if (existence == Existence::kUndecided) {
      ++t.undecided;
    } else {
      ++t.exists_unsolved;
      if (first) find("exists, not solved", index, t.solver, solve.message);
    }
  }

  const RandomSets::Options& options_;
  RandomSets result_;
};

/// Runs a scene and records each of its solves.
JobRecord scene_job(const RandomSets::Options& options, int index) {
  const Scene<2> scene = random_scene(options.seed, index);
  const std::string& name = options.solvers.front();
  const SolverEntry& entry = require_solver(name);
  JobRecord record;
  SceneRunOptions<2> run;
  run.steps = kStepsOfAScene;
  run.solver = [&](const ContactProblem& p, const Vector& s0) {
    const double begin = cpu_seconds();
    const SolveResult r =
        solve_within(entry, p, {.tol = options.tol, .s0 = s0}, options.time_limit);
    StepSolution step = taken_step(r);
    if (p.num_contacts() == 0) {
      ++record.without_contacts;
      return step;
    }
    SolveRecord solve = judge(name, p, r, options.tol, cpu_seconds() - begin);
    solve.certified = !solve.solved && !solve.refused;
    if (solve.certified) solve.existence = certify_existence(p, options.time_limit).verdict;
    record.solves.push_back(std::move(solve));
    return step;
  };
  // Impulses act through the mean of the velocities before and after: the energy taken by contacts
  // is the loss.
  const bool must_dissipate = contacts_must_dissipate(scene);
  double loss = 0, scale = 0;
  run.on_step = [&](const SceneStep<2>& s) {
    const EnergyLedger& e = s.report.energy;
    const double now = e.friction_loss + e.shock_loss;
    scale = std::max({scale, e.kinetic, std::abs(now)});
    // A step that obeys the law to the tolerance may have an energy error of that fraction.
    if (must_dissipate && s.report.converged && now < loss - s.report.force_energy - 1e-6 * scale) {
      record.grew = true;
      record.message = fmt::format("step {}: contacts created {:.3g} J of {:.3g} J", s.report.step,
                                   loss - now, scale);
    }
    loss = now;
    return true;
  };
  State<2> state = initial_state(scene);
  try {
    const SceneRun<2> done = run_scene(scene, state, run);
    if (done.failure) record.message = done.failure->what();
  } catch (const std::invalid_argument& e) {
    record.message = e.what();
  }
  return record;
}

RandomSets run_set(const RandomSets::Options& options, const char* what,
                   JobRecord (*job)(const RandomSets::Options&, int),
                   void (Ledger::*add)(int, const JobRecord&), int solves_of_a_job) {
  Ledger ledger(options);
  // Twice the CPU limit of each solve, since the machine has other work as well.
  IsolatedJobs jobs{.count = options.count,
                    .seconds = std::max(30.0, 10.0 * solves_of_a_job * options.time_limit),
                    .interrupted = options.watch.interrupted};
  jobs.job = [&](int k) { return job(options, options.first + k); };
  jobs.on_end = [&](int k, const IsolatedJobs::End& end) {
    if (!ledger.lost(options.first + k, end)) {
      (ledger.*add)(options.first + k, end.result.get<JobRecord>());
    }
    options.watch.tell(k + 1, options.count, what);
  };
  run_isolated(jobs);
  return ledger.result();
}

}  // namespace

bool RandomSets::sound() const {
  return false_certificates == 0 && std::ranges::all_of(tallies, [](const Tally& t) {
           return t.false_claims + t.not_finite + t.crashed + t.hung == 0;
         });
}

RandomSets run_random_problems(const RandomSets::Options& options) {
  return run_set(options, "random problems", &problem_job, &Ledger::add_problem, 3);
}

RandomSets run_random_scenes(const RandomSets::Options& options) {
  RandomSets::Options one = options;
  one.solvers.resize(1);
  return run_set(one, "random scenes", &scene_job, &Ledger::add_scene, kStepsOfAScene);
}

std::string to_text(const RandomSets& r, const std::string& what) {
  std::string text = fmt::format("{} {}\n", r.done, what);
  text += fmt::format(
      "  {:<10} {:>7} {:>17} {:>17} {:>8} {:>9} {:>9} {:>7} {:>5} {:>7} {:>5} {:>9} {:>9}\n",
      "solver", "tried", "planted: solved", "others: solved", "none", "exists,", "undecided",
      "false", "NaN", "crashed", "hung", "missed by", "CPU s");
  text += fmt::format(
      "  {:<10} {:>7} {:>17} {:>17} {:>8} {:>9} {:>9} {:>7} {:>5} {:>7} {:>5} {:>9}\n", "", "", "",
      "", "exists", "unsolved", "unsolved", "claims", "", "", "", "the first");
  for (const RandomSets::Tally& t : r.tallies) {
    text += fmt::format(
        "  {:<10} {:>7} {:>17} {:>17} {:>8} {:>9} {:>9} {:>7} {:>5} {:>7} {:>5} {:>9} {:>9.1f}\n",
        t.solver, t.tried - t.refused, fmt::format("{} of {}", t.planted_solved, t.planted),
        fmt::format("{} of {}", t.other_solved, t.other), t.none_proved, t.exists_unsolved,
        t.undecided, t.false_claims, t.not_finite, t.crashed, t.hung, t.missed_by_first,
        t.cpu_seconds);
  }
  text +=
      fmt::format("  {} certificates looked at, {} false", r.certificates, r.false_certificates);
  if (r.poor_plants > 0) {
    text += fmt::format("; {} planted solutions are lost to rounding and stand with the others",
                        r.poor_plants);
  }
  if (r.energy_grew > 0) text += fmt::format("; energy grew against theory in {}", r.energy_grew);
  return text + "\n";
}

}  // namespace bipot
