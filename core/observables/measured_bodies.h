#pragma once

#include <vector>

#include "core/base/types.h"
#include "core/motion/state.h"
#include "core/scene/disk_union.h"

namespace bipot {

/// One body for measurements: a disk, a sphere, or a cluster at its centre of mass.
template <int D>
struct MeasuredBody {
  Vec<D> x = Vec<D>::Zero(), v = Vec<D>::Zero();
  Spin<D> spin = no_turn<D>();
  double mass = 0;
  double size = 0;                 ///< area (of a cluster: of the union), volume     [m² | m³]
  std::vector<std::size_t> parts;  ///< its disks, increasing
};

/// The bodies of a state, each at the place of its first disk in the list of disks. Disks glued to
/// a wall are left out.
template <int D>
struct MeasuredBodies {
  std::vector<MeasuredBody<D>> list;
  std::vector<int> of_disk;  ///< of each disk, its body; -1: glued
};
template <int D>
MeasuredBodies<D> measured_bodies(const State<D>& state);

/// Area or volume of a body within a box along the axes, at its place or at an image. Overlaps
/// within a cluster count once. [m² | m³]
template <int D>
double part_in_box(const State<D>& state, const MeasuredBody<D>& body, const Vec<D>& shift,
                   const Box<D>& box);

}  // namespace bipot
