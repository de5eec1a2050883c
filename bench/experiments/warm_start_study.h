#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/experiments/stop_test_study.h"
#include "core/scene/scene.h"

namespace bipot {

/// One step's problem, solved from s = 0 and from the impulses of the previous step.
struct WarmStartRow {
  std::string solver;
  int step = 0;
  double time = 0;     ///< at the end of the step                                     [s]
  double kinetic = 0;  ///< before the step, disks and driven walls                    [J]
  int contacts = 0;
  int carried = 0;         ///< contacts that start from an impulse > 0 of the previous step
  int cold = 0, warm = 0;  ///< iterations
  bool cold_met = false, warm_met = false;    ///< the tolerance was met
  double cold_seconds = 0, warm_seconds = 0;  ///< CPU
};

struct WarmStartOptions {
  std::vector<SolverVariant> solvers;
  double tol = 1e-3;                            ///< of the compared solves
  SolverVariant runner = {"apgd", "apgd", {}};  ///< of the run
  int run_iterations = 20000;                   ///< a step that needs more is taken as it is
  double run_tol = 1e-3;                        ///< of the run, whose impulses are the warm start
  int every = 25;                               ///< steps from one compared step to the next
  int max_iterations = 20000;                   ///< of the compared solves
  std::function<void(int step)> on_step;        ///< after each step; may be empty
  std::function<bool()> interrupted;            ///< asked at each step; may be empty
};

/// Runs the scene with `runner`, warm, to run_tol. It solves the problem of each `every`-th step
/// that has contacts twice with each solver. All then solve the same problems, and warm and cold
/// differ in the start alone. The run itself does not depend on the compared solvers. (Impulses are
/// not unique, and the start is the runner's choice among them. One made by a solver of another
/// kind, such as the interior point, may serve a solver worse.) Throws StepFailure; empty if
/// interrupted.
std::vector<WarmStartRow> study_warm_start(Scene<2> scene, const WarmStartOptions& options);

}  // namespace bipot
