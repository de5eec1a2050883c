#pragma once

namespace bipot {

/// The map P of solvers/methods/accelerated_gradient.h. kHeldDisk: x_n = max(0, tau_n), and x_t cut
/// off at a radius that is held (solvers/methods/tresca.h); for any problem, not in the vectors of
/// solvers/disks.
enum class GradientMap { kSplit, kFollowed, kHeldDisk };

}  // namespace bipot
