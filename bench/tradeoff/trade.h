#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/measure/watch.h"
#include "bench/tradeoff/run_setting.h"
#include "bench/tradeoff/trade_outcome.h"
#include "core/base/types.h"
#include "core/scene_files/scene_file.h"

namespace bipot {

struct Trade {
  /// A scene, and data known before its run.
  struct Scene {
    std::string name, target, title;
    AnyScene scene;
    double step = 0;  ///< [s]
    int num_steps = 0, bodies = 0;
    int whole_steps = 0;  ///< of the scene, before it was shortened
    int replicas = 1;
    std::vector<TradeQuantity> quantities;
  };
  /// One whole simulation.
  struct Row : RunRecord {
    std::string scene;
    RunSetting setting;
    int replica = 0;
    std::vector<double> values;  ///< of the scene's quantities; NaN unless completed
  };
  struct Options {
    /// Scene file or shipped name, followed by ":steps=N" if wanted.
    std::vector<std::string> targets;
    std::vector<std::string> solvers = {"auto"};
    std::vector<double> tols = {1e-1, 1e-2, 1e-3, 1e-4, 1e-6};
    std::vector<double> step_factors = {2, 1, 0.5, 0.25};
    std::vector<double> accuracies = {0.1, 0.03};       ///< that cut steps of one frame
    std::vector<double> overlaps = {1e-2, 1e-3, 1e-4};  ///< of the springs' rows, or
    std::vector<double> stiffness;                      ///< these instead            [N/m]
    double time_limit = 20;                             ///< CPU seconds of one run
    /// Scenes are shortened until a run at the tightest tolerance and the shortest step is expected
    /// to fit the limit, by a trial of a tenth of the steps. At least a twentieth remains.
    bool shorten = false;
    double negligible = 1e-4;  ///< relative error of an outcome: no solver has to be better
    /// A solver that runs once more at the tightest tolerance that the first solver completed. On
    /// steps with several exact answers, solvers choose different ones. Empty, or one of `solvers`:
    /// none.
    std::string witness;
    int replicas = 3;  ///< of scenes whose disks fly freely: runs with small perturbations
    /// The total is an upper bound: the number of replicas is not known before.
    Watch watch;
    std::function<void(const std::string&)> warn;  ///< told what scenes leave out; may be empty
  };
  std::vector<Scene> scenes;
  std::vector<Row> rows;
  double negligible = 0;  ///< of the options
  bool complete = false;
};

/// The default targets and settings, or those of --quick.
Trade::Options trade_options(bool quick);

/// Throws as run_trade() does before its first run.
void check_trade(const Trade::Options& options);

/// Runs whole simulations, scene by scene:
///   1. every solver at every tolerance, loose to tight, with the scene's time step, and the
///      witness at the tightest;
///   2. the first solver at every other time step, at the tightest completed tolerance whose cost
///      is expected to fit the time limit at the shortest step;
///   3. the first solver at every accuracy, at the same tolerance, in steps of a frame;
///   4. the spring-dashpot model at every stiffness, with the scene's step.
/// If disks fly freely, nearby runs diverge. Each setting then runs `replicas` times: the first as
/// the scene says, the others with random velocities of 1e-3 √(a r) added to each disk. Here a is
/// the acceleration of gravity or driven walls, and r the smallest radius; the velocities are the
/// same for every setting. A run that fails or exceeds its time is a row with that status. Costlier
/// runs (tighter tolerance, further replicas, stiffer springs) are then skipped, with a message.
/// Throws std::invalid_argument and SceneFileError for impossible targets, solvers and stiffness.
Trade run_trade(const Trade::Options& options);

}  // namespace bipot
