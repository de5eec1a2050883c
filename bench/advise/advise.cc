#include "bench/advise/advise.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <deque>
#include <map>
#include <stdexcept>

#include "bench/measure/reference_solution.h"
#include "bench/measure/test_problem.h"
#include "bench/measure/true_error.h"
#include "bench/measure/warm_up.h"
#include "core/motion/time_stepping.h"
#include "core/scene/contact_detection.h"
#include "core/types.h"
#include "solvers/registry.h"
#include "solvers/solve.h"
#include "solvers/step_solver.h"

namespace bipot {
namespace {

constexpr std::size_t kMaxCheckpoints = 64;
// Parts of the time limit after which a stage must be done.
constexpr double kTightRunEnd = 0.06, kRunEnd = 0.25, kStepsEnd = 0.52, kReferencesEnd = 0.66,
                 kTrialsEnd = 0.8, kStretchesEnd = 0.92;

class Clock {
 public:
  explicit Clock(double limit) : limit_(limit) {}
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  /// Seconds until that part of the limit is spent; never below a millisecond.
  double until(double part) const { return std::max(1e-3, part * limit_ - seconds()); }
  bool past(double part) const { return seconds() >= part * limit_; }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double limit_;
};

double smallest_goal(const Accuracy& goal) {
  double smallest = kInfinity;
  for (auto m : Accuracy::kMeasures) smallest = std::fmin(smallest, goal.*m);
  return smallest;
}

/// Tight enough that its own error does not show beside the goal; for everything but the trials.
/// (A looser one opens contacts at rest by more than the contact distance now and then.)
double tight_tolerance(const Accuracy& goal) {
  return std::clamp(1e-3 * smallest_goal(goal), 1e-9, 1e-3);
}
/// Of the run that steps are sampled from, where a tight one takes too long: its errors move the
/// samples, they do not enter errors. (Too loose, contacts at rest come and go.)
double loose_tolerance(const Accuracy& goal) {
  return std::clamp(0.1 * smallest_goal(goal), 1e-9, 1e-2);
}

/// A state from which the next step has contacts, and an earlier one from which a window reaches
/// over it.
struct Checkpoint {
  State state, lead;
};

struct WindowLength {
  double seconds = 0;
  int steps = 0;  // of the scene's step, a multiple of 4
};
WindowLength window_length(const Scene& scene, double asked) {
  const double seconds = asked > 0 ? asked : scene.num_steps * scene.step / 50;
  const int fours = std::max(4, static_cast<int>(std::lround(seconds / scene.step / 4)));
  return {4 * fours * scene.step, 4 * fours};
}

/// The run that samples are taken from.
struct SampledRun {
  SceneSample seen;
  std::vector<Checkpoint> checkpoints;  // evenly along the steps with contacts
};

SampledRun run_scene(const Scene& scene, double tol, double part, const AdviseOptions& options,
                     const Clock& clock) {
  SampledRun run;
  run.seen.steps_planned = scene.num_steps;
  SolverOptions solver;
  solver.tol = tol;
  solver.cancelled = options.interrupted;
  TimeStepper stepper(
      scene,
      [&](const ContactProblem& p, const Vector& s0) {
        solver.time_limit = clock.until(part);
        return make_step_solver(*find_solver("auto"), solver)(p, s0);
      },
      false);
  State state = initial_state(scene);
  int stride = 1;
  double overhead = 0;
  // States of every quarter of a window: a window from the third last of them has the present in
  // its middle, where its weight is large.
  const int quarter = window_length(scene, options.window).steps / 4;
  std::deque<State> leads;
  for (int k = 0; k < scene.num_steps; ++k) {
    const State before = state;
    if (k % quarter == 0) {
      leads.push_back(state);
      if (leads.size() > 3) leads.pop_front();
    }
    StepReport report;
    try {
      report = stepper.advance(state);
    } catch (const StepFailure& e) {
      run.seen.note = e.kind == StepFailure::Kind::kCutShort
                          ? fmt::format("time for the run was up after {} steps", k)
                          : fmt::format("the run ended: {}", e.what());
      break;
    }
    ++run.seen.steps_run;
    overhead += report.detection_seconds + report.assembly_seconds;
    run.seen.contacts_max = std::max(run.seen.contacts_max, report.contacts);
    if (report.contacts > 0) {
      if (run.seen.contact_steps % stride == 0) run.checkpoints.push_back({before, leads.front()});
      ++run.seen.contact_steps;
      if (run.checkpoints.size() > kMaxCheckpoints) {
        for (std::size_t i = 1; 2 * i < run.checkpoints.size(); ++i) {
          run.checkpoints[i] = std::move(run.checkpoints[2 * i]);
        }
        run.checkpoints.resize((run.checkpoints.size() + 1) / 2);
        stride *= 2;
      }
    }
    if (k + 1 < scene.num_steps && clock.past(part)) {
      run.seen.note = fmt::format("time for the run was up after {} steps", k + 1);
      break;
    }
  }
  if (run.seen.steps_run > 0) run.seen.overhead_seconds = overhead / run.seen.steps_run;
  return run;
}

/// Which checkpoints to choose on, and which to verify on: evenly spaced, each third one fresh.
struct Selection {
  std::vector<std::size_t> sample, fresh;
};
Selection select_steps(std::size_t available, int samples, int fresh) {
  Selection selection;
  const std::size_t wanted = std::min<std::size_t>(available, samples + fresh);
  for (std::size_t i = 0; i < wanted; ++i) {
    const std::size_t at = wanted == 1 ? 0 : i * (available - 1) / (wanted - 1);
    // The second of each group is fresh; the first and the last step stay in the sample.
    const int all = samples + fresh, next = static_cast<int>(i) + 2;
    const bool take = i + 1 < wanted && next * fresh / all > (next - 1) * fresh / all;
    (take ? selection.fresh : selection.sample).push_back(at);
  }
  return selection;
}

/// ---- Time step ----

struct WindowRun {
  bool usable = false;
  std::vector<Vec2> force;  // mean contact force on each body, disks then driven walls   [N]
  double dissipated = 0;    // [J]
  double penetration = 0;   // largest overlap added by one step                          [m]
};

using Overlaps = std::map<std::pair<int, int>, double>;
Overlaps overlaps_of(const State& state) {
  Overlaps overlaps;
  for (const Contact& c : detect_contacts(state.disks, state.walls, 0)) {
    if (c.gap < 0) overlaps[{c.i, c.j}] = -c.gap;
  }
  return overlaps;
}

/// Impulses of lasting contacts, the warm start, scale with the step.
void scale_impulses(State& state, double factor) {
  for (ContactOutcome& out : state.contacts) {
    out.s_n *= factor;
    out.s_t *= factor;
  }
}

/// Follows the scene from a state for `steps` of its steps, which are `factor` times as long as
/// those that the state was made with.
WindowRun run_window(const Scene& scene, State state, double factor, int steps,
                     const StepSolver& solver, double accepted) {
  scale_impulses(state, factor);
  WindowRun run;
  const double h = scene.step;
  TimeStepper stepper(scene, solver, false);
  run.force.assign(state.disks.size() + state.walls.size(), Vec2::Zero());
  const double before = state.friction_loss + state.shock_loss;
  Overlaps overlaps = overlaps_of(state);
  double weights = 0;
  for (int k = 0; k < steps; ++k) {
    const State last = state;
    StepReport report;
    try {
      report = stepper.advance(state);
    } catch (const StepFailure&) {
      return run;
    }
    if (!report.converged && !(report.error.guarded() <= accepted)) return run;
    const double weight = 1 - std::abs((2.0 * k + 1) / steps - 1);
    weights += weight * h;
    for (std::size_t i = 0; i < state.disks.size(); ++i) {
      const Disk& d = state.disks[i];
      run.force[i] += weight * d.mass * (d.v - last.disks[i].v - h * scene.gravity);
    }
    for (std::size_t w = 0; w < state.walls.size(); ++w) {
      const Wall& wall = state.walls[w];
      if (wall.motion != Wall::Motion::kDriven) continue;
      run.force[state.disks.size() + w] +=
          weight * (wall.mass * (wall.v - last.walls[w].v) - h * wall.force * wall.direction);
    }
    Overlaps now = overlaps_of(state);
    for (const auto& [pair, overlap] : now) {
      const auto old = overlaps.find(pair);
      run.penetration =
          std::max(run.penetration, overlap - (old == overlaps.end() ? 0 : old->second));
    }
    overlaps = std::move(now);
  }
  for (Vec2& f : run.force) f /= weights;
  run.dissipated = state.friction_loss + state.shock_loss - before;
  run.usable = true;
  return run;
}

/// Dissipation below this is nothing: a thousandth of what moves, or falls by a radius.
double energy_floor(const Scene& scene, const State& state) {
  double weight = 0;
  for (const Disk& d : state.disks) weight += d.mass * scene.gravity.norm();
  return 1e-3 * std::max(kinetic_energy(state), weight * smallest_radius(scene));
}

/// Errors of `runs` (one a window) against `reference`, see StepStudy; no scaling. The penetration
/// is the run's own.
Accuracy window_errors(const std::vector<WindowRun>& runs, const std::vector<WindowRun>& reference,
                       double radius, double floor) {
  Accuracy error;
  double energy = 0, energies = 0;
  for (std::size_t w = 0; w < runs.size(); ++w) {
    double apart = 0, largest = 0;
    for (std::size_t b = 0; b < runs[w].force.size(); ++b) {
      apart = std::max(apart, (runs[w].force[b] - reference[w].force[b]).norm());
      largest = std::max(largest, reference[w].force[b].norm());
    }
    if (largest > 0) error.force = std::fmax(error.force, apart / largest);
    error.penetration = std::fmax(error.penetration, runs[w].penetration / radius);
    energy += std::abs(runs[w].dissipated - reference[w].dissipated);
    energies += std::abs(reference[w].dissipated);
  }
  error.energy = energy / std::max(energies, floor);
  return error;
}

/// A study with the runs behind it.
struct StepRuns {
  StepStudy study;
  std::vector<const State*> starts;               // of the windows that were kept
  std::map<double, std::vector<WindowRun>> runs;  // by factor, in the order of `starts`
  double floor = 0;                               // energy_floor of all windows
};

StepRuns study_steps(const Scene& scene, const std::vector<const State*>& starts,
                     const AdviseOptions& options, const Clock& clock) {
  StepRuns all;
  StepStudy& study = all.study;
  const WindowLength window = window_length(scene, options.window);
  study.window = window.seconds;
  SolverOptions tight;
  tight.tol = tight_tolerance(options.goal);
  tight.cancelled = options.interrupted;
  double end = kTrialsEnd;  // the first window may take longer: without it nothing is known
  const StepSolver solver = [&](const ContactProblem& p, const Vector& s0) {
    tight.time_limit = clock.until(end);
    return make_step_solver(*find_solver("auto"), tight)(p, s0);
  };
  const auto run = [&](const State* start, double factor) {
    Scene other = scene;
    other.step = factor * scene.step;
    return run_window(other, *start, factor, static_cast<int>(std::lround(window.steps / factor)),
                      solver, 10 * tight.tol);
  };
  const auto stopped = [&] { return options.interrupted && options.interrupted(); };

  // The scene's own step and half of it: what must be known of a window.
  double halves = 0;  // seconds for the half steps of all windows kept
  double slowest = 0;
  for (const State* start : starts) {
    if (stopped()) return all;
    if (!all.starts.empty() && slowest > clock.until(kStepsEnd)) break;
    const double begin = clock.seconds();
    WindowRun whole = run(start, 1);
    const double between = clock.seconds();
    WindowRun half = whole.usable ? run(start, 0.5) : WindowRun();
    slowest = std::max(slowest, clock.seconds() - begin);
    if (!half.usable) continue;
    halves += clock.seconds() - between;
    all.starts.push_back(start);
    all.runs[1].push_back(std::move(whole));
    all.runs[0.5].push_back(std::move(half));
    all.floor += energy_floor(scene, *start);
    end = kStepsEnd;
  }
  study.windows = static_cast<int>(all.starts.size());
  study.windows_dropped = static_cast<int>(starts.size() - all.starts.size());
  if (all.starts.empty()) return all;

  // Then what time allows; a level counts when all windows came through.
  for (double factor : {2.0, 4.0, 0.25, 0.125}) {
    if (options.keep_step && factor > 1) continue;
    if (halves * 0.5 / factor > clock.until(kStepsEnd)) continue;
    std::vector<WindowRun> level;
    for (const State* start : all.starts) {
      if (stopped()) return all;
      level.push_back(run(start, factor));
      if (!level.back().usable) break;
    }
    if (level.back().usable) all.runs[factor] = std::move(level);
  }
  study.finest = all.runs.begin()->first;
  const std::vector<WindowRun>& reference = all.runs.at(study.finest);
  for (auto level = all.runs.rbegin(); level != all.runs.rend(); ++level) {
    const double factor = level->first;
    if (factor == study.finest || (options.keep_step && factor != 1)) continue;
    StepTrial trial{factor, factor * scene.step,
                    window_errors(level->second, reference, smallest_radius(scene), all.floor)};
    const double scale = factor / (factor - study.finest);
    trial.error.force *= scale;
    trial.error.energy *= scale;
    study.steps.push_back(trial);
  }
  return all;
}

/// ---- Solvers ----

/// A sampled step, and the step before it for warm starts.
struct SampledProblem {
  TestProblem given;
  ContactProblem before;
  std::vector<int> carried;  // contact of `before` for each contact, -1: new
  bool has_before = false;
  ReferenceSolution reference;
  bool several = false;
  std::shared_ptr<TrueErrorEvaluator> true_error;
};

/// Steps of size h from the state (made with steps of h / factor) until impulses act: the step
/// after that is the sample, if impulses act there as well, else that one, which then has nothing
/// before it. Nothing when no impulse acts within twice the state's step and two steps more, or a
/// step fails.
std::optional<SampledProblem> sample_problem(const Scene& scene, State state, double factor,
                                             const AdviseOptions& options, const Clock& clock) {
  SolverOptions solver;
  solver.tol = tight_tolerance(options.goal);
  solver.cancelled = options.interrupted;
  solver.time_limit = clock.until(kReferencesEnd);
  TimeStepper stepper(scene, make_step_solver(*find_solver("auto"), solver), false);
  scale_impulses(state, factor);
  SampledProblem sample;
  sample.given.step = scene.step;
  sample.given.smallest_radius = smallest_radius(scene);
  try {
    const int patience = static_cast<int>(std::ceil(2 / factor)) + 2;
    int active = 0;
    for (int k = 0; k < patience && active == 0; ++k) active = stepper.advance(state).active;
    if (active == 0) return std::nullopt;
    const std::vector<ContactOutcome> first = state.contacts;
    sample.before = stepper.problem();
    if (stepper.advance(state).active == 0) {
      sample.given.problem = sample.before;
      return sample;
    }
    sample.given.problem = stepper.problem();
    sample.has_before = true;
    std::map<std::pair<int, int>, int> index;
    for (std::size_t c = 0; c < first.size(); ++c) {
      index[{first[c].contact.i, first[c].contact.j}] = static_cast<int>(c);
    }
    for (const ContactOutcome& out : state.contacts) {
      const auto found = index.find({out.contact.i, out.contact.j});
      sample.carried.push_back(found == index.end() ? -1 : found->second);
    }
    return sample;
  } catch (const StepFailure&) {
    return std::nullopt;
  }
}

/// Impulses of the step before at the contacts of the same pairs, in the problem's variables.
Vector carry_over(const SampledProblem& sample, const Vector& s_before) {
  const ContactProblem& p = sample.given.problem;
  Vector s0 = Vector::Zero(p.num_rows());
  const auto scale = [](const ContactProblem& of, Eigen::Index row) {
    return of.row_scale.size() != 0 ? of.row_scale[row] : 1.0;
  };
  for (int c = 0; c < p.num_contacts(); ++c) {
    if (sample.carried[c] < 0) continue;
    for (int k = 0; k < p.dim; ++k) {
      const Eigen::Index row = c * p.dim + k, old = sample.carried[c] * p.dim + k;
      s0[row] = s_before[old] / scale(sample.before, old) * scale(p, row);
    }
  }
  return s0;
}

struct TimedSolve {
  SolveResult result;
  double seconds = 0;  // CPU, least of a few repeats where it is short
};
TimedSolve timed_solve(const SolverVariant& variant, const ContactProblem& p, double tol,
                       double limit, const Vector& s0, const AdviseOptions& options) {
  SolverOptions solver;
  solver.tol = tol;
  solver.time_limit = limit;
  solver.parameters = variant.parameters;
  solver.s0 = s0;
  solver.cancelled = options.interrupted;
  constexpr double kLong = 2e-3;
  TimedSolve timed;
  timed.seconds = kInfinity;
  for (int k = 0; k < 3; ++k) {
    const std::clock_t start = std::clock();
    timed.result = solve(variant.solver, p, solver);
    timed.seconds =
        std::min(timed.seconds, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    if (timed.seconds > kLong) break;
  }
  return timed;
}

void add(SolverTrial& trial, const SampledProblem& sample, const TimedSolve& timed) {
  ++trial.problems;
  trial.seconds += timed.seconds;
  trial.iterations += timed.result.iterations;
  if (!is_success(timed.result.status)) {
    if (trial.message.empty()) {
      trial.message = fmt::format("{}: {}", to_string(timed.result.status), timed.result.message);
    }
    return;
  }
  ++trial.solved;
  trial.guarded = std::fmax(trial.guarded, timed.result.error.guarded());
  if (sample.several) return;
  const TrueError error = (*sample.true_error)(timed.result.s);
  // Nothing is known more exactly than the reference.
  const double unknown = sample.reference.error.guarded();
  trial.error =
      worst_of(trial.error, {error.force + unknown, error.penetration, error.energy + unknown});
}

struct TrialPair {
  SolverTrial cold, warm;
};
/// One solver at one tolerance on all problems; gives up where a solve fails or takes `limit`.
TrialPair try_solver(const SolverVariant& variant, double tol,
                     const std::vector<SampledProblem>& problems, double limit,
                     const AdviseOptions& options) {
  TrialPair pair;
  for (SolverTrial* trial : {&pair.cold, &pair.warm}) {
    trial->solver = variant;
    trial->tol = tol;
  }
  pair.warm.warm = true;
  for (const SampledProblem& sample : problems) {
    const ContactProblem& p = sample.given.problem;
    const TimedSolve cold = timed_solve(variant, p, tol, limit, Vector(), options);
    add(pair.cold, sample, cold);
    if (!is_success(cold.result.status)) break;
    if (!sample.has_before) {
      add(pair.warm, sample, cold);  // nothing to start from
      continue;
    }
    const TimedSolve before = timed_solve(variant, sample.before, tol, limit, Vector(), options);
    const Vector s0 = before.result.s.size() == sample.before.num_rows()
                          ? carry_over(sample, before.result.s)
                          : Vector();
    add(pair.warm, sample, timed_solve(variant, p, tol, limit, s0, options));
  }
  for (SolverTrial* trial : {&pair.cold, &pair.warm}) {
    if (trial->problems == 0) continue;
    trial->seconds /= trial->problems;
    trial->iterations /= trial->problems;
    // Broken off: not all problems were tried.
    trial->problems = static_cast<int>(problems.size());
  }
  return pair;
}

struct Samples {
  std::vector<SampledProblem> chosen_on, fresh;
};
/// Problems with references, to choose on and fresh ones in turn, as many as time allows. Those
/// without a reference that is clearly better than the goal are left out.
Samples sample_problems(const Scene& scene, double factor, const std::vector<const State*>& sampled,
                        const std::vector<const State*>& fresh, const AdviseOptions& options,
                        const Clock& clock, Advice& advice) {
  constexpr double kReferenceSeconds = 5;
  const double target = std::clamp(1e-3 * smallest_goal(options.goal), 1e-12, 1e-7);
  Samples samples;
  samples.chosen_on.reserve(sampled.size());  // evaluators point into them
  samples.fresh.reserve(fresh.size());
  const auto take = [&](const State& state, std::vector<SampledProblem>& problems) {
    if (clock.past(kReferencesEnd) && !samples.chosen_on.empty()) return;
    if (options.interrupted && options.interrupted()) return;
    std::optional<SampledProblem> sample = sample_problem(scene, state, factor, options, clock);
    if (!sample) return;
    problems.push_back(std::move(*sample));
    SampledProblem& made = problems.back();
    made.reference =
        find_reference(made.given, std::min(kReferenceSeconds, clock.until(1)), target);
    made.several =
        made.reference.velocity_spread > std::max(ReferenceSolution::kSeveral, 1e3 * target);
    if (made.several) {
      ++advice.several_solutions;
    } else if (made.reference.error.guarded() > 0.1 * smallest_goal(options.goal)) {
      ++advice.without_reference;
      problems.pop_back();
      return;
    } else {
      advice.worst_reference = std::fmax(advice.worst_reference, made.reference.error.guarded());
      advice.reference_spread = std::fmax(advice.reference_spread, made.reference.velocity_spread);
    }
    made.true_error = std::make_shared<TrueErrorEvaluator>(made.given, made.reference);
  };
  // From the middle outwards: where time ends, the middle has been seen.
  const auto outwards = [](std::size_t k, std::size_t count) {
    const std::size_t middle = count / 2, away = (k + 1) / 2;
    return k % 2 == 0 ? middle + away : middle - away;
  };
  for (std::size_t k = 0; k < 2 * std::max(sampled.size(), fresh.size()) + 2; ++k) {
    if (const std::size_t i = outwards(k, sampled.size()); i < sampled.size()) {
      take(*sampled[i], samples.chosen_on);
    }
    if (const std::size_t i = outwards(k, fresh.size()); i < fresh.size()) {
      take(*fresh[i], samples.fresh);
    }
  }
  return samples;
}

void try_solvers(const std::vector<SampledProblem>& problems, const AdviseOptions& options,
                 const Clock& clock, Advice& advice) {
  const std::vector<SolverVariant> variants =
      options.solvers.empty() ? promising_solvers(advice.sample.contacts_max) : options.solvers;
  for (const SolverVariant& variant : variants) {
    if (const SolverEntry* entry = find_solver(variant.solver)) warm_up(*entry);
  }
  double best = kInfinity;  // seconds of a solve that meets all
  for (const SolverVariant& variant : variants) {
    if (options.say) options.say(fmt::format("trying {}", variant.label));
    int met = 0;
    for (int k = 1; k <= 12 && met < 2; ++k) {
      if (options.interrupted && options.interrupted()) return;
      if (clock.past(kTrialsEnd)) return;
      // Whoever takes twenty times as long as the best so far is out.
      const double limit = std::min(clock.until(kTrialsEnd), std::max(0.25, 20 * best));
      const TrialPair pair = try_solver(variant, std::pow(10.0, -k), problems, limit, options);
      const bool has_warm = std::any_of(problems.begin(), problems.end(),
                                        [](const SampledProblem& s) { return s.has_before; });
      advice.trials.push_back(pair.cold);
      if (has_warm && pair.cold.solved == pair.cold.problems) advice.trials.push_back(pair.warm);
      bool any = false;
      for (const SolverTrial* trial : {&pair.cold, &pair.warm}) {
        if (!meets(*trial, advice.budget)) continue;
        any = true;
        best = std::min(best, trial->seconds);
      }
      // One tolerance beyond the first that meets: in reserve for the fresh steps.
      if (meets(pair.cold, advice.budget) || (any && met > 0)) ++met;
      if (pair.cold.solved < pair.cold.problems) break;
    }
  }
}

/// Windows at the recommended step, solved tightly.
struct StretchReference {
  Scene scene;
  double factor = 1, window = 0, tol = 0, floor = 0;
  std::vector<const State*> starts;
  std::vector<WindowRun> runs;
};

/// Solves the windows again, more tightly. False, and no change, where a step fails.
bool tighten(StretchReference& reference, double tol, const AdviseOptions& options,
             const Clock& clock) {
  SolverOptions tight;
  tight.tol = tol;
  tight.cancelled = options.interrupted;
  const StepSolver solver = [&](const ContactProblem& p, const Vector& s0) {
    tight.time_limit = clock.until(1);
    return make_step_solver(*find_solver("auto"), tight)(p, s0);
  };
  const int steps = static_cast<int>(std::lround(reference.window / reference.scene.step));
  std::vector<WindowRun> runs;
  for (const State* start : reference.starts) {
    runs.push_back(run_window(reference.scene, *start, reference.factor, steps, solver, 10 * tol));
    if (!runs.back().usable) return false;
  }
  reference.runs = std::move(runs);
  reference.tol = tol;
  return true;
}

/// The trial over the windows of the study, against tight solves with the same step: errors of a
/// step are here the start of the next, which trials of single steps cannot show.
void run_stretches(SolverTrial& trial, StretchReference& reference, const AdviseOptions& options,
                   const Clock& clock) {
  trial.stretch = {kInfinity, kInfinity, kInfinity};
  // Who is no looser than the reference cannot be judged by it.
  constexpr double kTighter = 0.1;
  if (reference.tol > 1.01 * kTighter * trial.tol &&
      !tighten(reference, kTighter * trial.tol, options, clock)) {
    trial.message = "no reference for stretches that is tighter";
    return;
  }
  const int steps = static_cast<int>(std::lround(reference.window / reference.scene.step));
  Scene scene = reference.scene;
  scene.solver.warm_start = trial.warm;
  SolverOptions own;
  own.tol = trial.tol;
  own.parameters = trial.solver.parameters;
  own.cancelled = options.interrupted;
  int solves = 0;
  double seconds = 0;
  const StepSolver solver = [&](const ContactProblem& p, const Vector& s0) {
    own.time_limit = clock.until(1);
    const std::clock_t start = std::clock();
    StepSolution solution = make_step_solver(*find_solver(trial.solver.solver), own)(p, s0);
    if (p.num_contacts() > 0) {
      seconds += static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
      ++solves;
    }
    return solution;
  };
  std::vector<WindowRun> runs;
  for (const State* start : reference.starts) {
    runs.push_back(run_window(scene, *start, reference.factor, steps, solver, trial.tol));
    if (runs.back().usable) continue;
    trial.message = "a step of a stretch was not solved";
    return;
  }
  trial.stretches = static_cast<int>(runs.size());
  if (solves > 0) trial.run_seconds = seconds / solves;
  const double radius = smallest_radius(scene);
  trial.stretch = window_errors(runs, reference.runs, radius, reference.floor);
  trial.stretch.penetration = 0;  // what the solver adds to the step's own
  for (std::size_t w = 0; w < runs.size(); ++w) {
    const double more = (runs[w].penetration - reference.runs[w].penetration) / radius;
    trial.stretch.penetration = std::max(trial.stretch.penetration, more);
  }
}

/// Runs stretches with the trials that meet the budget, cheapest first. Where one misses it, the
/// same solver at a tighter tolerance joins the trials. Ends when what is left takes much longer
/// than the best so far, or with the time.
void try_stretches(StretchReference reference, const std::vector<SampledProblem>& problems,
                   const AdviseOptions& options, const Clock& clock, Advice& advice) {
  using Verdict = SolverTrial::Verdict;
  const auto same_line = [](const SolverTrial& a, const SolverTrial& b) {
    return a.solver.label == b.solver.label && a.warm == b.warm;
  };
  double best = kInfinity;  // seconds of a solve of what met the budget on stretches
  while (!(options.interrupted && options.interrupted())) {
    if (clock.past(best < kInfinity ? kStretchesEnd : 1)) return;
    int next = -1;
    for (int i : by_cost(advice.trials, advice.budget)) {
      const SolverTrial& trial = advice.trials[i];
      // Tried; or missed already at a tighter tolerance, or met at a looser one for less.
      const bool settled =
          std::any_of(advice.trials.begin(), advice.trials.end(), [&](const SolverTrial& t) {
            return same_line(t, trial) &&
                   ((t.tol <= trial.tol && t.verdict == Verdict::kStretchMissed) ||
                    (t.tol >= trial.tol && t.verdict == Verdict::kStretchMet));
          });
      if (settled) continue;
      next = i;
      break;
    }
    if (next < 0 || advice.trials[next].seconds > 3 * best) return;
    SolverTrial& trial = advice.trials[next];
    run_stretches(trial, reference, options, clock);
    if (share_of(trial.stretch, advice.budget) <= 1) {
      trial.verdict = Verdict::kStretchMet;
      best = std::min(best, trial.run_seconds);
      continue;
    }
    trial.verdict = Verdict::kStretchMissed;
    const SolverTrial missed = trial;  // adding to the trials moves them
    const double tol = 0.1 * missed.tol;
    const bool known = std::any_of(
        advice.trials.begin(), advice.trials.end(),
        [&](const SolverTrial& t) { return same_line(t, missed) && t.tol < 1.01 * tol; });
    if (known || tol < 1e-12) continue;
    const TrialPair pair = try_solver(missed.solver, tol, problems, clock.until(1), options);
    advice.trials.push_back(missed.warm ? pair.warm : pair.cold);
  }
}

/// The cheapest trial of those that met the budget on stretches which meets it on fresh steps too.
void choose_trial(const std::vector<SampledProblem>& fresh, const AdviseOptions& options,
                  const Clock& clock, Advice& advice) {
  using Verdict = SolverTrial::Verdict;
  std::vector<SolverTrial> in_runs = advice.trials;  // what they cost there
  const bool stretches = std::any_of(in_runs.begin(), in_runs.end(), [](const SolverTrial& t) {
    return t.verdict != Verdict::kNone;
  });
  for (SolverTrial& trial : in_runs) {
    if (trial.verdict == Verdict::kStretchMet) trial.seconds = trial.run_seconds;
  }
  for (int i : by_cost(in_runs, advice.budget)) {
    SolverTrial& trial = advice.trials[i];
    if (stretches && trial.verdict != Verdict::kStretchMet) continue;
    if (!fresh.empty()) {
      const TrialPair pair =
          try_solver(trial.solver, trial.tol, fresh,
                     std::max({clock.until(1), 1.0, 20 * trial.seconds}), options);
      advice.fresh = trial.warm ? pair.warm : pair.cold;
      if (!meets(advice.fresh, advice.budget)) {
        trial.verdict = Verdict::kFreshMissed;
        continue;
      }
    }
    trial.verdict = Verdict::kChosen;
    advice.choice = i;
    return;
  }
  advice.choice = nearest_trial(advice.trials, advice.budget);
}

/// The recommendation as a whole, from fresh states against the finest steps.
void check_windows(const Scene& scene, const std::vector<const State*>& states,
                   const AdviseOptions& options, const Clock& clock, Advice& advice) {
  if (advice.steps.finest == 0 || states.empty()) return;
  const SolverTrial& chosen = advice.trials[advice.choice];
  const WindowLength window = window_length(scene, options.window);
  SolverOptions tight, own;
  tight.tol = tight_tolerance(options.goal);
  own.tol = chosen.tol;
  own.parameters = chosen.solver.parameters;
  tight.cancelled = own.cancelled = options.interrupted;
  Scene finest = scene, recommended = scene;
  finest.step = advice.steps.finest * scene.step;
  recommended.step = advice.step_size;
  recommended.solver.warm_start = chosen.warm;
  const auto limited = [&](const SolverEntry& entry, SolverOptions& solver) {
    return [&entry, &solver, &clock](const ContactProblem& p, const Vector& s0) {
      solver.time_limit = clock.until(1);
      return make_step_solver(entry, solver)(p, s0);
    };
  };
  std::vector<WindowRun> runs, references;
  double floor = 0;
  for (const State* state : states) {
    if (clock.past(1) || (options.interrupted && options.interrupted())) break;
    WindowRun run = run_window(recommended, *state, recommended.step / scene.step,
                               static_cast<int>(std::lround(window.seconds / recommended.step)),
                               limited(*find_solver(chosen.solver.solver), own), 10 * own.tol);
    WindowRun reference = run_window(finest, *state, advice.steps.finest,
                                     static_cast<int>(std::lround(window.seconds / finest.step)),
                                     limited(*find_solver("auto"), tight), 10 * tight.tol);
    if (!run.usable || !reference.usable) continue;
    runs.push_back(std::move(run));
    references.push_back(std::move(reference));
    floor += energy_floor(scene, *state);
  }
  if (runs.empty()) return;
  advice.whole_windows = static_cast<int>(runs.size());
  advice.whole_window = window_errors(runs, references, smallest_radius(scene), floor);
}

void conclude(const Scene& scene, Advice& advice) {
  const auto wants = [&](const Accuracy& error) {
    std::string text;
    for (auto m : Accuracy::kMeasures) {
      if (std::isnan(advice.goal.*m)) continue;
      text += fmt::format("{}{} {} (goal {:.0e})", text.empty() ? "" : ", ", name_of(m),
                          std::isnan(error.*m) ? "not measured" : fmt::format("{:.1e}", error.*m),
                          advice.goal.*m);
    }
    return text;
  };
  if (advice.choice < 0) {
    advice.message = advice.trials.empty()
                         ? "no solver was tried: time was up; give more with --time-limit"
                         : "no solver reached its tolerance on all sampled steps";
    return;
  }
  const SolverTrial& chosen = advice.trials[advice.choice];
  const double share =
      static_cast<double>(advice.sample.contact_steps) / std::max(1, advice.sample.steps_run);
  advice.seconds_per_step = advice.sample.overhead_seconds +
                            share * (chosen.run_seconds > 0 ? chosen.run_seconds : chosen.seconds);
  advice.num_steps = static_cast<int>(std::lround(scene.num_steps * scene.step / advice.step_size));
  advice.seconds_in_all = advice.num_steps * advice.seconds_per_step;
  const bool solver_met = chosen.verdict == SolverTrial::Verdict::kChosen;
  const bool step_met = advice.step.index >= 0 && advice.step.met;
  if (advice.step.index < 0) {
    advice.message =
        "the error of the time step could not be measured: give more with --time-limit";
  } else if (!step_met) {
    const StepTrial &large = advice.steps.steps.front(), &small = advice.steps.steps.back();
    const char* what = share_of(advice.step_error, advice.goal) > 1
                           ? "meets the goal"
                           : "leaves a tenth of the goal to the solver";
    advice.message =
        advice.steps.steps.size() == 1
            ? fmt::format("of the time steps tried ({:g} s alone) none {}: {}", large.step, what,
                          wants(advice.step_error))
            : fmt::format("no time step from {:g} to {:g} s {}; the best is {:g} s with {}",
                          large.step, small.step, what, advice.step_size, wants(advice.step_error));
  } else if (!solver_met) {
    advice.message =
        fmt::format("no solver meets what the time step leaves; the best is {} to {:.0e} with {}",
                    chosen.solver.label, chosen.tol, wants(worst_of(chosen.error, chosen.stretch)));
  } else if (advice.whole_windows > 0 && share_of(advice.whole_window, advice.goal) > 1) {
    advice.message =
        fmt::format("on fresh stretches of the run the recommendation misses the goal: {}",
                    wants(advice.whole_window));
  } else {
    advice.status = Advice::Status::kMet;
    advice.message = "the goal is met on all sampled and fresh steps";
    if (advice.several_solutions > 0) {
      advice.message += "; those with several solutions were judged on stretches alone";
    }
  }
}

}  // namespace

std::string_view to_string(Advice::Status status) {
  switch (status) {
    case Advice::Status::kMet:
      return "met";
    case Advice::Status::kNotMet:
      return "not met";
    case Advice::Status::kNoContacts:
      return "no contacts";
    case Advice::Status::kInterrupted:
      return "interrupted";
  }
  return "not met";
}

std::vector<SolverVariant> promising_solvers(int contacts) {
  constexpr int kPivoting = 60;      // beyond it, pivoting is never the fastest
  constexpr int kSplitting = 20000;  // beyond it, its factors are too slow to set up
  std::vector<SolverVariant> variants;
  const auto add_if = [&](bool wanted, SolverVariant variant) {
    if (wanted && find_solver(variant.solver) != nullptr) variants.push_back(std::move(variant));
  };
  add_if(true, {"auto", "auto", {}});
  add_if(true, {"apgd", "apgd", {}});
  add_if(true, {"ipm", "ipm", {}});
  add_if(true, {"newton", "newton", {}});
  add_if(true, {"pgs", "pgs", {}});
  add_if(true, {"pgs omega=1.5", "pgs", {{"omega", "1.5"}}});
  add_if(contacts <= kSplitting, {"admm", "admm", {}});
  add_if(contacts <= kPivoting, {"lemke", "lemke", {}});
  return variants;
}

Advice advise(const Scene& scene, const AdviseOptions& options) {
  bool asked = false;
  for (auto m : Accuracy::kMeasures) {
    const double x = options.goal.*m;
    if (std::isnan(x)) continue;
    asked = true;
    if (!(x > 0) || !std::isfinite(x)) {
      throw std::invalid_argument(
          fmt::format("{}: expected a positive number, got {}", name_of(m), x));
    }
  }
  if (!asked) throw std::invalid_argument("nothing is asked for: give at least one goal");
  if (scene.model != Model::kNonsmooth) {
    throw std::invalid_argument(
        "the scene asks for springs and dashpots (model dem), which solve no contact problem: "
        "there is no solver to advise");
  }
  if (options.samples < 1 || options.fresh < 0) {
    throw std::invalid_argument("at least one step must be sampled");
  }
  for (const SolverVariant& variant : options.solvers) {
    if (find_solver(variant.solver) == nullptr) {
      throw std::invalid_argument(unknown_solver_message(variant.solver));
    }
  }
  const Clock clock(options.time_limit);
  const auto say = [&](const char* stage) {
    if (options.say) options.say(stage);
  };
  const auto stopped = [&] { return options.interrupted && options.interrupted(); };
  Advice advice;
  advice.goal = options.goal;
  advice.step_size = scene.step;
  advice.num_steps = scene.num_steps;
  const auto finish = [&] {
    advice.seconds_spent = clock.seconds();
    if (stopped()) {
      advice.status = Advice::Status::kInterrupted;
      advice.message = "interrupted";
      advice.choice = -1;
    }
    return advice;
  };

  say("running the scene");
  SampledRun run = run_scene(scene, tight_tolerance(options.goal), kTightRunEnd, options, clock);
  if (run.seen.steps_run < run.seen.steps_planned && !stopped()) {
    run = run_scene(scene, loose_tolerance(options.goal), kRunEnd, options, clock);
  }
  advice.sample = run.seen;
  if (stopped()) return finish();
  if (run.checkpoints.empty()) {
    const bool whole = run.seen.steps_run == run.seen.steps_planned;
    advice.status = whole ? Advice::Status::kNoContacts : Advice::Status::kNotMet;
    advice.message =
        whole ? "nothing touches in this scene: there is no contact problem to solve, any solver "
                "and tolerance will do"
              : fmt::format(
                    "nothing touches in the first {} of {} steps ({}): give more with "
                    "--time-limit",
                    run.seen.steps_run, run.seen.steps_planned, run.seen.note);
    return finish();
  }
  const Selection selection = select_steps(run.checkpoints.size(), options.samples, options.fresh);
  const auto states_of = [&](const std::vector<std::size_t>& chosen) {
    std::vector<const State*> states;
    for (std::size_t i : chosen) states.push_back(&run.checkpoints[i].state);
    return states;
  };
  const std::vector<const State*> sampled = states_of(selection.sample);
  const std::vector<const State*> fresh = states_of(selection.fresh);

  say("measuring the time step");
  // Middle, last, first and between: what is dropped when time is short stands last.
  std::vector<const State*> starts;
  const std::size_t count = selection.sample.size();
  for (std::size_t i : {count / 2, count - 1, std::size_t{0}, 3 * count / 4}) {
    const State* lead = &run.checkpoints[selection.sample[i]].lead;
    const auto same = [&](const State* other) { return other->step == lead->step; };
    if (std::none_of(starts.begin(), starts.end(), same)) starts.push_back(lead);
  }
  const StepRuns study = study_steps(scene, starts, options, clock);
  advice.steps = study.study;
  if (stopped()) return finish();
  advice.step = choose_step(advice.steps.steps, options.goal);
  if (advice.step.index >= 0) {
    advice.step_size = advice.steps.steps[advice.step.index].step;
    advice.step_error = advice.steps.steps[advice.step.index].error;
  }
  advice.budget = solver_budget(options.goal, advice.step_error);

  say("solving for references");
  Scene stepped = scene;
  stepped.step = advice.step_size;
  const double factor = advice.step.index < 0 ? 1 : advice.steps.steps[advice.step.index].factor;
  const Samples samples = sample_problems(stepped, factor, sampled, fresh, options, clock, advice);
  advice.problems = static_cast<int>(samples.chosen_on.size());
  advice.fresh_problems = static_cast<int>(samples.fresh.size());
  if (stopped()) return finish();
  if (!samples.chosen_on.empty()) {
    try_solvers(samples.chosen_on, options, clock, advice);
    if (stopped()) return finish();
    if (study.runs.contains(factor)) {
      say("trying stretches of the run");
      try_stretches({stepped, factor, advice.steps.window, tight_tolerance(options.goal),
                     study.floor, study.starts, study.runs.at(factor)},
                    samples.chosen_on, options, clock, advice);
    }
    mark_pareto(advice.trials, options.goal);
    say("verifying on fresh steps");
    choose_trial(samples.fresh, options, clock, advice);
    if (stopped()) return finish();
    if (advice.choice >= 0 &&
        advice.trials[advice.choice].verdict == SolverTrial::Verdict::kChosen) {
      std::vector<const State*> leads;  // of windows that were not seen yet
      for (std::size_t i : selection.fresh) {
        const State* lead = &run.checkpoints[i].lead;
        const auto same = [&](const State* other) { return other->step == lead->step; };
        if (std::none_of(starts.begin(), starts.end(), same) &&
            std::none_of(leads.begin(), leads.end(), same)) {
          leads.push_back(lead);
        }
      }
      check_windows(scene, leads, options, clock, advice);
    }
  }
  conclude(scene, advice);
  return finish();
}

}  // namespace bipot
