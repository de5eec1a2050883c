#pragma once

namespace bipot {

/// The map P of solvers/methods/accelerated_gradient.h.
enum class GradientMap { kSplit, kFollowed };

}  // namespace bipot
