#pragma once

#include <vector>

#include "core/motion/state.h"
#include "core/scene/disk_union.h"

namespace bipot {

/// One body of what is measured: a disk or a sphere, or a cluster with its centre of mass as its place.
template <int D>
struct MeasuredBody {
  Vec<D> x = Vec<D>::Zero(), v = Vec<D>::Zero();
  Spin<D> spin = no_turn<D>();
  double mass = 0;
  double size = 0;                 ///< area (of a cluster: of the union), volume     [m² | m³]
  std::vector<std::size_t> parts;  ///< its disks, increasing
};

/// The bodies of a state, each where its first disk stands among the disks. Disks that are glued to a wall are none.
template <int D>
struct MeasuredBodies {
  std::vector<MeasuredBody<D>> list;
  std::vector<int> of_disk;  ///< of each disk, its body; -1: glued
};
template <int D>
MeasuredBodies<D> measured_bodies(const State<D>& state);

/// What of a body lies in a box along the axes, where it is or at an image of it; what several disks of a cluster cover counts
/// once.                                                                            [m² | m³]
template <int D>
double part_in_box(const State<D>& state, const MeasuredBody<D>& body, const Vec<D>& shift,
                   const Vec<D>& low, const Vec<D>& high);

}  // namespace bipot
