#include "solvers/simulation/scene_stepper.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "solvers/analysis/existence.h"
#include "solvers/registry.h"
#include "solvers/simulation/split_step.h"

namespace bipot {
namespace {

constexpr double kProofSeconds = 10;  // at most, for one step

}  // namespace

template <int D>
std::string needs_whole_state(const Scene<D>& scene,
                              const std::type_identity_t<SceneRunOptions<D>>& options) {
  if (options.processes == nullptr) return "one process";
  if (options.solver) return "the solver is the caller's";
  if (options.reproducible) return "--reproducible";
  if (options.folder.problems != RunFolderOptions::Problems::kNone) return "--dump-problems";
  if (options.on_failure == OnFailure::kStop) return "--on-failure stop";
  if (options.on_failure == OnFailure::kSmallerStep) return "--on-failure smaller-step";
  if (options.on_tunnel == OnTunnel::kSmallerStep) return "--on-tunnel smaller-step";
  if (scene.model == Model::kSpringDashpot) return "the model dem";
  if (!scene.clusters.empty()) return "the scene has clusters";
  if (!scene.joints.empty()) return "the scene has pins or ropes";
  const bool surface = std::any_of(scene.walls.begin(), scene.walls.end(),
                                   [](const Wall<D>& wall) { return wall.is_surface(); });
  if (surface) return "the scene has triangles or cones";
  if (scene.has_gates()) return "the scene has inlets or outlets";
  if (scene.cell.periodic()) return "the scene is periodic";
  if (scene.observables) return "the scene measures observables";
  if (!scene.forces.empty() || scene.drag.coefficient > 0) return "the scene has forces or drag";
  if (scene.has_cohesion()) return "the scene has cohesion";
  if (scene.has_rolling()) return "the scene has rolling friction";
  if (scene.impact != ContactLaw::Impact::kNewton) return "the scene's law of impact";
  if (scene.travel > 0) return "the scene cuts its steps by travel";
  if (scene.accuracy > 0) return "the scene cuts its steps by accuracy";
  if (scene.predict_gaps) return "the scene predicts gaps";
  if (scene.project_overlaps) return "the scene projects overlaps";
  return {};
}

template <int D>
SceneStepper<D>::SceneStepper(const Scene<D>& scene, SceneRunOptions<D> options)
    : scene_(scene), options_(std::move(options)) {
  if (!options_.solver && scene.model == Model::kSpringDashpot) {
    if (options_.processes != nullptr) {
      throw std::invalid_argument("the model dem runs on one process, not under mpirun");
    }
    springs_.emplace(scene, [this] { return is_over(); });
    if (options_.on_tunnel != OnTunnel::kWarn) springs_->refuse_passages();
    return;
  }
  if (!options_.solver) {
    own_ = {.solver = scene.solver.name,
            .options = to_options(scene.solver),
            .watch = watch_,
            .time_limit = options_.time_limit,
            .processes = options_.processes,
            .reproducible = options_.reproducible};
    own_.options.cancelled = options_.cancelled;
    own_.options.on_iteration = options_.on_iteration;
    if (options_.on_failure == OnFailure::kSmallerStep && !scene.solver.limits_iterations &&
        scene.solver.max_iterations == SolverChoice{}.max_iterations) {
      own_.options.max_iterations = kAttemptIterations;
    }
    own_.options.execution.threads = options_.threads;
    own_.check();
    if (needs_whole_state(scene, options_).empty()) return;  // begin() goes on
    options_.solver = [this](const ContactProblem& problem, Vector s0) {
      StepSolution solution = to_step_solution(own_.solve(problem, std::move(s0)));
      if (options_.on_failure != OnFailure::kSmallerStep) {
        seek_proof([&] { return problem; }, solution);
      }
      return solution;
    };
  }
  const StepSolver remembering = [this](const ContactProblem& problem, const Vector& start) {
    start_ = start;
    return options_.solver(problem, start);
  };
  if (scene.accuracy > 0) {
    accurate_.emplace(scene, options_, remembering, [this] { return is_over(); });
    return;
  }
  rigid_.emplace(scene, remembering, options_.threads);
  if (options_.on_tunnel != OnTunnel::kWarn) rigid_->refuse_passages();
}

template <int D>
void SceneStepper<D>::seek_proof(const std::function<ContactProblem()>& problem,
                                 StepSolution& solution) {
  if (options_.proof_seconds == 0 || solution.converged || solution.failed || solution.refused ||
      solution.cut_short) {
    return;
  }
  const ContactProblem whole = problem();
  std::string proof;
  const double left = std::min({options_.proof_seconds - proof_seconds_, kProofSeconds,
                                options_.time_limit - watch_.seconds()});
  if ((options_.processes == nullptr || options_.processes->rank() == 0) && left > 0) {
    const Stopwatch watch;
    const ExistenceCertificate found = certify_existence(whole, left, options_.cancelled);
    proof_seconds_ += watch.seconds();
    if (found.verdict == Existence::kNone) proof = to_text(found);
  }
  if (options_.processes != nullptr) proof = options_.processes->first_text(proof);
  if (proof.empty()) return;
  solution.unsolvable = true;
  solution.failed = options_.on_failure != OnFailure::kContinue;
  solution.message = proof;
}

template <int D>
State<D>& SceneStepper<D>::begin(State<D>& state) {
  if (options_.on_failure != OnFailure::kSmallerStep) state.halvings = 0;  // of another run
  if (rigid_ || springs_ || accurate_) return state;
  const auto solve = [this](const ProblemPiece& piece, const Vector& s0) {
    return own_.solve(piece, s0);
  };
  const auto review = [this](StepSolution& solution) {
    seek_proof([&] { return domain_->gather_problem(); }, solution);
  };
  domain_.emplace(scene_, state, *options_.processes, solve, DomainOptions{.review = review});
  rigid_.emplace(scene_, *domain_);
  if (options_.on_tunnel != OnTunnel::kWarn) rigid_->refuse_passages();
  state = {};
  return domain_->state();
}

template <int D>
bool SceneStepper<D>::is_over() const {
  const bool here =
      (options_.cancelled && options_.cancelled()) || watch_.seconds() > options_.time_limit;
  return options_.processes != nullptr ? options_.processes->any(here) : here;
}

template <int D>
SceneRunOptions<D> SceneStepper<D>::options_of_parts() {
  cut_.emplace();
  cut_is_unsolved_ = false;
  SceneRunOptions<D> options = options_;
  options.solver = [this](const ContactProblem& problem, const Vector& start) {
    StepSolution solution = options_.solver(problem, start);
    if (!cut_is_unsolved_) {
      cut_ = problem;
      start_ = start;
      cut_is_unsolved_ = !solution.converged;
    }
    return solution;
  };
  return options;
}

template <int D>
StepReport<D> SceneStepper<D>::advance(State<D>& state) {
  if (scene_.joints.empty()) return take(state);
  State<D> next = state;
  StepReport<D> report = take(next);
  const std::string made = joint_energy_.add(report);
  if (!made.empty()) throw StepFailure(StepFailure::Kind::kPlaces, state, made);
  state = std::move(next);
  return report;
}

template <int D>
StepReport<D> SceneStepper<D>::take(State<D>& state) {
  parts_ = 1;
  cut_.reset();
  if (springs_) return springs_->advance(state);
  try {
    return accurate_ ? accurate_->advance(state) : take_rigid(state);
  } catch (const StepFailure& failure) {
    if (failure.kind != StepFailure::Kind::kNotConverged ||
        options_.on_failure != OnFailure::kSmallerStep) {
      throw;
    }
    StepSolution none;
    seek_proof([&] { return problem(); }, none);
    if (!none.unsolvable) throw;
    throw StepFailure(StepFailure::Kind::kUnsolvable, state, none.message);
  }
}

template <int D>
StepReport<D> SceneStepper<D>::take_rigid(State<D>& state) {
  const bool splits_unsolved = options_.on_failure == OnFailure::kSmallerStep;
  const bool splits_passages = options_.on_tunnel == OnTunnel::kSmallerStep;
  const auto in_parts = [&](const SceneRunOptions<D>& options, int halvings, int most_halvings) {
    SplitStep<D> split = advance_in_parts(scene_, options, state, halvings, most_halvings);
    parts_ = split.parts;
    if (splits_unsolved) state.halvings = split.next_halvings;
    return std::move(split.report);
  };
  const int travel = travel_halvings(scene_, state);
  const int most = travel + (splits_unsolved || splits_passages ? kMostHalvings : 0);
  const int halvings = splits_unsolved ? std::clamp(state.halvings, travel, most) : travel;
  if (halvings > 0) return in_parts(options_of_parts(), halvings, most);
  if (options_.takes_unsolved() && !splits_passages) return rigid_->advance(state);
  State<D> next = state;
  StepReport<D> whole;
  bool unsolved = true;
  try {
    whole = rigid_->advance(next);
    if (whole.converged || options_.takes_unsolved()) {
      state = std::move(next);
      return whole;
    }
    if (options_.on_failure == OnFailure::kStop) {
      throw StepFailure(StepFailure::Kind::kNotConverged, state, whole.message);
    }
  } catch (const StepFailure& failure) {
    const bool passed = failure.is_of_places() && splits_passages;
    unsolved = failure.may_yield() && splits_unsolved;
    if (!passed && !unsolved) throw;
  }
  StepReport<D> report = in_parts(unsolved ? options_ : options_of_parts(), 1, most);
  report.add_cost(whole);
  return report;
}

template <int D>
std::shared_ptr<const SpringDashpotSetup> SceneStepper<D>::springs() const {
  return springs_ ? std::make_shared<SpringDashpotSetup>(springs_->setup()) : nullptr;
}

template std::string needs_whole_state(const Scene<2>&, const SceneRunOptions<2>&);
template std::string needs_whole_state(const Scene<3>&, const SceneRunOptions<3>&);
template class SceneStepper<2>;
template class SceneStepper<3>;

}  // namespace bipot
