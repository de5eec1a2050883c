#pragma once

#include <string>
#include <type_traits>
#include <vector>

#include "core/scene/contact.h"
#include "core/scene/scene.h"

namespace bipot {

/// A body that is where it cannot be when a scene starts.
template <int D>
struct StartOverlap {
  /// With a negative gap. j: a body, bodies + wall, or bodies + walls + outlet. At an outlet the
  /// gap is the way of the centre out of it, and there is no normal.
  Contact<D> contact;
  double radii = 0;  ///< depth over the smaller radius
};

/// Overlaps of the bodies of a scene with each other, across the border of a cell, and with walls,
/// the deepest one in radii first. Bodies behind a half-plane or outside a hollow circle are among
/// them, and those in outlets, which would leave at once. Disks glued to walls and those of one
/// cluster may overlap, and a segment has no side that is wrong. Not counted: up to 1e-6 of the
/// smaller radius; with the model dem up to a tenth. Throws std::invalid_argument for two centres
/// in one place.
template <int D>
std::vector<StartOverlap<D>> start_overlaps(const Scene<D>& scene, int threads = 1);

/// "disk 17 and wall 'top'"
template <int D>
std::string overlap_name(const Scene<D>& scene, const std::type_identity_t<Contact<D>>& contact);

/// Numbers of the bodies that take part, increasing.
template <int D>
std::vector<int> overlapping_bodies(const Scene<D>& scene,
                                    const std::vector<StartOverlap<D>>& overlaps);

/// How many bodies overlap, and the worst pair; empty for none.
template <int D>
std::string start_sentence(const Scene<D>& scene, const std::vector<StartOverlap<D>>& overlaps);

}  // namespace bipot
