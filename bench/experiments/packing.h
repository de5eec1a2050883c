#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "bench/report/chart.h"
#include "core/motion/stress_tensor.h"
#include "core/motion/time_stepping.h"

namespace bipot {

/// Result of a number of steps.
struct PackingRun {
  int steps = 0, converged = 0;
  long iterations = 0;
  int far_starts = 0;     ///< steps that started with the impulses of two steps before
  double mean_error = 0;  ///< geometric mean over the steps with an error above 0
};

/// Runs up to scene.num_steps steps from a state, with the scene's solver, tolerance and iteration
/// limit. A step that does not meet the tolerance is taken as it is, and counted. `on_step`
/// receives the states before and after a step and ends the run by returning false. `interrupted`
/// is polled before each step and inside solves; it may be empty. Throws StepFailure for a failed
/// step, std::runtime_error if it was interrupted.
PackingRun run_packing(const Scene<2>& scene, State<2>& state,
                       const std::function<bool()>& interrupted,
                       const std::function<bool(const State<2>& before, const State<2>& after,
                                                const StepReport<2>&)>& on_step);

/// Kinetic energy of the velocities that move the bodies during a step, the means of those before
/// and after it (38), (43); driven walls included.                                         [J]
double displacement_energy(const State<2>& before, const State<2>& after);

/// Mean number of loaded contacts of a disk, with walls or not.
double coordination(const State<2>& state);

/// Area covered by the disks over `area`. Overlaps of two disks count once, parts in a wall's
/// half-plane do not count; overlaps of three are not corrected. Overlaps are those of the step's
/// contacts.
double covered_fraction(const State<2>& state, double area);

/// Pearson's correlation of the normal impulses of two steps, over the pairs of bodies loaded in
/// either. NaN if either does not vary.
double force_correlation(std::span<const ContactOutcome<2>> a,
                         std::span<const ContactOutcome<2>> b);

/// The tail of the distribution of forces begins at this multiple of the mean force.
inline constexpr double kForceTail = 1.5;

/// Loaded normal forces over the mean of their layer, of `layers` layers of equal height.
std::vector<double> relative_forces(const State<2>& state, int layers);
/// Probability density of forces, in bins of that width.
Chart::Series force_histogram(const std::string& name, int style, const std::vector<double>& forces,
                              double bin);

/// Contacts of a number of steps, averaged pair by pair; an unloaded pair counts with zero. Normals
/// and gaps are those of the last step that had the pair.
class MeanContacts {
 public:
  void add(const State<2>& state);
  /// A copy of `state` with the mean impulses as its contacts.
  State<2> in(const State<2>& state) const;

 private:
  int steps_ = 0;
  std::vector<ContactOutcome<2>> sums_;  // sorted by (i, j)
};

/// The upper surface of a packing: the highest point of a disk in each of `bins` equal bins between
/// `left` and `right`.
struct Surface {
  double roughness = 0;  ///< rms distance of the points from their mean height       [m]
  double slope = 0;      ///< of the straight line through them, by least squares
  double heap = 0;       ///< decrease from the middle to both sides: of a line in |x - middle|
  double height = 0;     ///< mean                                                    [m]
};
Surface measure_surface(const State<2>& state, double left, double right, int bins);

}  // namespace bipot
