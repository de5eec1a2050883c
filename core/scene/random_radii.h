#pragma once

#include <vector>

#include "core/base/portable_random.h"
#include "core/scene/generators.h"

namespace bipot {

/// Throws std::invalid_argument for a count, classes or a spacing that no filling can have.
void check_filling(int count, const std::vector<RadiusClass>& classes, double spacing);

/// `count` radii in random order, whose numbers per class follow by largest remainders. Throws
/// std::invalid_argument for classes without sound radii and shares.
std::vector<double> drawn_radii(int count, const std::vector<RadiusClass>& classes,
                                PortableRandom& random);

}  // namespace bipot
