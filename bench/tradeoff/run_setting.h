#pragma once

#include <functional>
#include <map>
#include <string>

#include "core/motion/time_stepping.h"
#include "solvers/simulation/scene_run.h"

namespace bipot {

/// How a scene is run. Numbers that do not apply are NaN.
struct RunSetting {
  Model model = Model::kNonsmooth;
  std::string solver;       ///< nonsmooth
  double tol = kNaN;        ///< nonsmooth
  double step_factor = 1;   ///< time step over the scene's
  double accuracy = 0;      ///< > 0: steps are cut by this accuracy; 0: as the scene says
  double overlap = kNaN;    ///< springs: target, relative to the smallest radius, or
  double stiffness = kNaN;  ///< springs: given                                 [N/m]
  std::map<std::string, std::string> parameters = {};  ///< of the solver

  bool dem() const { return model == Model::kSpringDashpot; }
  bool cut() const { return accuracy > 0; }
  bool equal_steps() const { return !dem() && !cut(); }
  /// Same run.
  bool operator==(const RunSetting& other) const;
  /// "auto, tol 1e-3, h" or "springs, overlap 1e-3".
  std::string label() const;
};

/// Bounds of a run.
struct RunLimits {
  double cpu_seconds = kInfinity;        ///< of this process
  std::function<double()> seconds_left;  ///< wall time, of the solve that begins; may be empty
  std::function<bool()> cancelled;       ///< polled inside of solves; may be empty
  /// A step that is not solved, with a guarded error above this, ends the run.
  double accepted = kInfinity;

  bool stopped() const { return cancelled && cancelled(); }
};

/// What a run did and cost.
struct RunRecord {
  std::string status = "not run", message;  ///< "completed" alone is a result
  double step = kNaN;                       ///< h                                   [s]
  int steps = 0, steps_planned = 0, steps_converged = 0;
  double simulated = 0;         ///< time reached                                    [s]
  double cpu = kNaN;            ///< of this process                                 [s]
  double solve_cpu = 0;         ///< of it, in the solves of steps with contacts     [s]
  int solves = 0;               ///< their number
  bool whole = false;           ///< all steps were taken, and each was accepted
  double iterations = kNaN;     ///< mean per step; springs: substeps per step
  double worst_guarded = kNaN;  ///< largest guarded error of a step; nonsmooth
  double stiffness = kNaN;      ///< springs: k_n                                    [N/m]
  double penetration = kNaN;    ///< largest overlap of the run over the smaller radius
  int penetration_step = -1;    ///< where

  bool completed() const { return status == "completed"; }
  double cpu_per_second() const { return simulated > 0 ? cpu / simulated : kNaN; }
};

/// Callbacks of a run, as in SceneRunOptions; both may be empty.
template <int D>
struct RunObserver {
  std::function<void(State<D>&)> before_step;
  std::function<bool(const SceneStep<D>&)> on_step;
};

/// The longest step that an accuracy may cut, over the scene's: a divisor of `steps`, at most 50
/// and the distance of frames and of observations. 1 where bodies come and go at each step.
template <int D>
int longest_cut_step(const Scene<D>& scene, int steps);

/// Steps of the setting in the time of `steps` of the scene's.
int steps_of(int steps, const RunSetting& setting);

/// The scene with this model and step, for steps_of(num_steps) steps.
template <int D>
Scene<D> with_setting(Scene<D> scene, const RunSetting& setting);

/// Whether `bipot run` takes the setting too, where a contact distance of the scene's own stays.
template <int D>
bool run_takes(const Scene<D>& scene, const RunSetting& setting);

/// Takes the steps of with_setting(scene, setting) from the state, which was made with steps of the
/// scene's: the impulses from which the first step starts are scaled. `state` becomes the last one.
/// Time on the wall decides nothing unless `limits` ask for it.
template <int D>
RunRecord run_setting(const Scene<D>& made, State<D>& state, const RunSetting& setting,
                      const RunLimits& limits, const RunObserver<D>& observer);

}  // namespace bipot
