#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "bench/measure/test_problem.h"
#include "core/base/interrupt.h"

namespace bipot {

/// A problem made on demand: a continued comparison makes only those with rows to fill.
struct ProblemSource {
  std::string name;    ///< unique in a comparison
  std::string target;  ///< target of the command line that gives this problem
  /// Throws FileError, std::invalid_argument, StepFailure or Interrupted.
  std::function<TestProblem()> load;
  /// Problems of one series differ in size alone ("square:tilt=10", sizes 10 and 32); empty: none.
  std::string series = {};
  double size = kNaN;
};

struct TargetOptions {
  int scene_problems = 3;  ///< number of steps of a scene or a moving family, evenly along its run
  int scene_steps = std::numeric_limits<int>::max();             ///< a run is cut there
  std::optional<int> step;                                       ///< the only one, of one run
  bool quick = false;                                            ///< the small benchmark
  std::function<bool()> cancelled = &InterruptGuard::requested;  ///< ends the runs behind problems
  std::function<void(const std::string&)> warn;  ///< told what scenes leave out; may be empty
};

/// Names of the families below.
std::vector<std::string> target_families();

/// The problems of the targets, in order. A target is
///   - a problem file (FCLIB, Siconos text), the name of a shipped one, or a folder of them,
///   - a scene file or the name of a shipped scene: contact problems along a run made with `auto`,
///     with ":steps=N" behind it for another length,
///   - a family "square:30", "triangular:30", "pyramid:20", "random:30" (scene_family.h, the first
///     step), "pile:32" (settled_pile.h, 32² disks at rest) or "impact:32" (such a pile hit by one
///     more disk at 20 m/s), with options: "square:30:mu=0.5:tilt=10:ratio=1e4:seed=2:e=0.5"
///     (friction, degrees, mass ratio, restitution);
///   - a family of spheres "cannonballs:6" or "cubic:6" (sphere_problems.h), with :mu and :tilt;
///   - a moving family "pour:32", "collapse:32", "tilt:32:angle=30" or "strike:32"
///     (moving_scene.h): steps along one run, each with its start, kept in a cache folder
///     (moving_problems.h), with the options :mu, :tilt, :e and :seed; in space "pour3d:8", "pipe:8"
///     or "shear3d:8" (moving_scene.h);
///   - one step of a scene or a moving family, "drum@120" or "pour:32:seed=2@120";
///   - "benchmark": series of families from 10² to 10⁴ disks, the shipped problems and those of the
///     folder that the environment variable BIPOT_PROBLEMS names.
/// Throws std::invalid_argument for other targets, and for two problems of one name.
std::vector<ProblemSource> expand_targets(const std::vector<std::string>& targets,
                                          const TargetOptions& options = {});

}  // namespace bipot
