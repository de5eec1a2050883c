#include "bench/compare/random_sets.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "bench/compare/isolated_jobs.h"
#include "bench/compare/random_problem.h"
#include "bench/compare/random_scene.h"
#include "bench/measure/independent_check.h"
#include "bench/measure/limited_solve.h"
#include "bench/measure/stopwatch.h"
#include "bench/report/json_output.h"
#include "solvers/analysis/existence.h"
#include "solvers/registry.h"
#include "solvers/simulation/force_energy.h"
#include "solvers/simulation/scene_run.h"

namespace bipot {
namespace {

/// Interval of problems that are certified even if they were solved.
constexpr int kCertifyEvery = 10;

/// Result of one solve.
struct Verdict {
  bool refused = false, solved = false, false_claim = false, not_finite = false;
  std::string message;
};

Verdict judge(const ContactProblem& problem, const SolveResult& r, double tol) {
  Verdict v;
  v.refused = r.status == SolveStatus::kInvalidInput;
  v.message = fmt::format("{}: {}", to_string(r.status), r.message);
  if (v.refused) return v;
  v.not_finite = !r.s.allFinite() || !r.u.allFinite();
  const IndependentCheck check = independent_check(problem, r.s);
  v.solved = is_success(r.status) && check.confirms(tol);
  v.false_claim = is_success(r.status) && !v.solved;
  if (is_success(r.status)) v.message += fmt::format(" (independent check {:.2e})", check.guarded);
  return v;
}

Json to_json(const std::string& solver, const Verdict& v, double seconds) {
  return {{"solver", solver},       {"refused", v.refused},       {"solved", v.solved},
          {"false", v.false_claim}, {"not_finite", v.not_finite}, {"message", v.message},
          {"seconds", seconds}};
}

/// The solvers that run on problem `index`.
std::vector<std::string> solvers_of(const RandomSets::Options& options, int index) {
  std::vector<std::string> names = {options.solvers.front()};
  const int others = static_cast<int>(options.solvers.size()) - 1;
  if (others > 0) names.push_back(options.solvers[to_size(1 + index % others)]);
  return names;
}

std::string problem_job(const RandomSets::Options& options, int index) {
  const RandomProblem random = random_problem(options.seed, index);
  const ContactProblem& p = random.problem;
  Json record{{"planted", random.planted.size() > 0}, {"solves", Json::array()}};
  if (random.planted.size() > 0) {
    record["plant_holds"] = independent_check(p, random.planted).guarded <= options.tol / 10;
  }
  bool any_solved = false, first_solved = false;
  for (const std::string& solver : solvers_of(options, index)) {
    const double begin = cpu_seconds();
    const SolveResult result = solve_within(solver, p, options.tol, options.time_limit);
    const Verdict v = judge(p, result, options.tol);
    record["solves"].push_back(to_json(solver, v, cpu_seconds() - begin));
    any_solved = any_solved || v.solved;
    if (solver == options.solvers.front()) first_solved = v.solved;
  }
  if (!first_solved || !any_solved || index % kCertifyEvery < 2) {
    const ExistenceCertificate c = certify_existence(p, options.time_limit);
    record["verdict"] = static_cast<int>(c.verdict);
    record["false_certificate"] =
        c.verdict == Existence::kNone && (any_solved || record.value("plant_holds", false));
  }
  return json_text(record);
}

/// Sums the results of the jobs.
class Ledger {
 public:
  explicit Ledger(const RandomSets::Options& options) : options_(options) {
    for (const std::string& name : options.solvers) result_.tallies.emplace_back().solver = name;
  }

  void add_problem(int index, const IsolatedJobs::End& end) {
    ++result_.done;
    if (lost(index, end)) return;
    const Json record = Json::parse(end.text);
    const bool plant_holds = record.value("plant_holds", false);
    if (record.at("planted").get<bool>() && !plant_holds) ++result_.poor_plants;
    std::optional<Existence> verdict;
    if (record.contains("verdict")) {
      verdict = static_cast<Existence>(record.at("verdict").get<int>());
      ++result_.certificates;
      if (record.at("false_certificate").get<bool>()) {
        ++result_.false_certificates;
        find("false certificate", index, "", "no solution was said to exist, but one does");
      }
    }
    const bool first_solved = record.at("solves").at(0).at("solved").get<bool>();
    for (const Json& solve : record.at("solves")) {
      add_solve(index, solve, plant_holds, verdict);
      if (first_solved || !solve.at("solved").get<bool>()) continue;
      const std::string solver = solve.at("solver").get<std::string>();
      ++tally(solver).missed_by_first;
      find("missed by the first", index, solver, solve.at("message").get<std::string>());
    }
  }

  void add_scene(int index, const IsolatedJobs::End& end) {
    ++result_.done;
    if (lost(index, end)) return;
    const Json record = Json::parse(end.text);
    RandomSets::Tally& t = result_.tallies.front();
    for (const Json& solve : record.at("solves")) {
      std::optional<Existence> verdict;
      if (solve.contains("verdict")) {
        ++result_.certificates;
        verdict = static_cast<Existence>(solve.at("verdict").get<int>());
      }
      add_solve(index, solve, false, verdict);
    }
    t.other_solved += record.at("without_contacts").get<int>();
    t.other += record.at("without_contacts").get<int>();
    t.tried += record.at("without_contacts").get<int>();
    if (record.at("grew").get<bool>()) {
      ++result_.energy_grew;
      find("energy grew", index, t.solver, record.at("message").get<std::string>());
    } else if (!record.at("message").get<std::string>().empty()) {
      find("run ended early", index, t.solver, record.at("message").get<std::string>());
    }
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

  /// A crash or a hang is counted for the first solver: the job gives no more information.
  bool lost(int index, const IsolatedJobs::End& end) {
    if (end.kind == IsolatedJobs::End::Kind::kDone) return false;
    RandomSets::Tally& t = result_.tallies.front();
    const bool hung = end.kind == IsolatedJobs::End::Kind::kHung;
    ++(hung ? t.hung : t.crashed);
    find(hung ? "hung" : "crashed", index, "", end.text);
    return true;
  }

  void add_solve(int index, const Json& solve, bool planted, std::optional<Existence> verdict) {
    RandomSets::Tally& t = tally(solve.at("solver").get<std::string>());
    const std::string message = solve.at("message").get<std::string>();
    ++t.tried;
    t.cpu_seconds += solve.at("seconds").get<double>();
    if (solve.at("refused").get<bool>()) {
      ++t.refused;
      return;
    }
    const bool solved = solve.at("solved").get<bool>();
    ++(planted ? t.planted : t.other);
    if (solved) ++(planted ? t.planted_solved : t.other_solved);
    if (solve.at("false").get<bool>()) {
      ++t.false_claims;
      find("false claim", index, t.solver, message);
    }
    if (solve.at("not_finite").get<bool>()) {
      ++t.not_finite;
      find("not finite", index, t.solver, message);
    }
    const bool first = t.solver == options_.solvers.front();
    if (solved || planted) {
      if (!solved && first) find("planted, not solved", index, t.solver, message);
      return;
    }
    if (verdict == Existence::kNone) {
      ++t.none_proved;
    } else if (verdict == Existence::kExists || verdict == Existence::kExistsNearby) {
      ++t.exists_unsolved;
      if (first) find("exists, not solved", index, t.solver, message);
    } else {
      ++t.undecided;
    }
  }

  const RandomSets::Options& options_;
  RandomSets result_;
};

/// Runs a scene and records each of its solves.
std::string scene_job(const RandomSets::Options& options, int index) {
  const Scene<2> scene = random_scene(options.seed, index);
  const std::string& name = options.solvers.front();
  Json record{{"solves", Json::array()}, {"grew", false}, {"message", ""}};
  int without_contacts = 0;
  SceneRunOptions<2> run;
  run.steps = kStepsOfAScene;
  run.solver = [&](const ContactProblem& p, const Vector& s0) {
    const double begin = cpu_seconds();
    const SolveResult r = solve_within(name, p, options.tol, options.time_limit, s0);
    StepSolution step = taken_step(r);
    if (p.num_contacts() == 0) {
      ++without_contacts;
      return step;
    }
    const Verdict v = judge(p, r, options.tol);
    Json solve = to_json(name, v, cpu_seconds() - begin);
    if (!v.solved && !v.refused) {
      solve["verdict"] = static_cast<int>(certify_existence(p, options.time_limit).verdict);
    }
    record["solves"].push_back(std::move(solve));
    return step;
  };
  run.explicit_delassus = require_solver(name).needs_delassus;
  // Impulses act through the mean of the velocities before and after: the energy taken by contacts
  // is the loss.
  const bool must_dissipate = contacts_must_dissipate(scene);
  double loss = 0, scale = 0;
  run.on_step = [&](const SceneStep<2>& s) {
    const EnergyLedger& e = s.report.energy;
    const double now = e.friction_loss + e.shock_loss;
    scale = std::max({scale, e.kinetic, std::abs(now)});
    // A step that obeys the law to the tolerance may have an energy error of that fraction.
    if (must_dissipate && s.report.converged &&
        now < loss - force_energy(scene, s.report) - 1e-6 * scale) {
      record["grew"] = true;
      record["message"] = fmt::format("step {}: contacts created {:.3g} J of {:.3g} J",
                                      s.report.step, loss - now, scale);
    }
    loss = now;
    return true;
  };
  State<2> state = initial_state(scene);
  try {
    const SceneRun<2> done = run_scene(scene, state, run);
    if (done.failure) record["message"] = done.failure->what();
  } catch (const std::invalid_argument& e) {
    record["message"] = e.what();
  }
  record["without_contacts"] = without_contacts;
  return json_text(record);
}

RandomSets run_set(const RandomSets::Options& options,
                   std::string (*job)(const RandomSets::Options&, int),
                   void (Ledger::*add)(int, const IsolatedJobs::End&), int solves_of_a_job) {
  Ledger ledger(options);
  // Twice the CPU limit of each solve, since the machine has other work as well.
  IsolatedJobs jobs{.count = options.count,
                    .seconds = std::max(30.0, 10.0 * solves_of_a_job * options.time_limit),
                    .interrupted = options.interrupted};
  jobs.job = [&](int k) { return job(options, options.first + k); };
  jobs.on_end = [&](int k, const IsolatedJobs::End& end) {
    (ledger.*add)(options.first + k, end);
    if (options.on_progress) options.on_progress(k + 1);
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
  return run_set(options, &problem_job, &Ledger::add_problem, 3);
}

RandomSets run_random_scenes(const RandomSets::Options& options) {
  RandomSets::Options one = options;
  one.solvers.resize(1);
  return run_set(one, &scene_job, &Ledger::add_scene, kStepsOfAScene);
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
