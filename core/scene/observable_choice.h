#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/types.h"

namespace bipot {

/// Surface that mass may cross: a line in 2D, a plane face in 3D.
template <int D>
struct FluxSurface;

/// A line. Flux is positive to its left, seen from a to b.
template <>
struct FluxSurface<2> {
  std::string name;
  Vec2 a = Vec2::Zero(), b = Vec2::Zero();  ///< different                              [m]
};
using FluxLine = FluxSurface<2>;

/// A face: a disk, a rectangle, or an infinite plane, of which the part within a periodic cell
/// counts. Flux is positive along the normal.
template <>
struct FluxSurface<3> {
  enum class Shape { kPlane, kDisk, kRectangle };
  std::string name;
  Shape shape = Shape::kPlane;
  Vec3 point = Vec3::Zero();    ///< its middle                                          [m]
  Vec3 normal = Vec3::UnitZ();  ///< unit
  double radius = 0;            ///< of a disk, > 0                                      [m]
  Vec3 along = Vec3::UnitX();   ///< of the first side of a rectangle: unit, across the normal
  Vec2 size = Vec2::Zero();     ///< of a rectangle: its sides, > 0                      [m]
};
using FluxFace = FluxSurface<3>;

/// Bins across one axis, equal in width.
struct ProfileChoice {
  int axis = 1;              ///< 0: bins along x, 1: along y, 2: along z
  int bins = 20;             ///< > 0
  double low = 0, high = 0;  ///< ends, low < high                                      [m]
};

/// Observables of a run besides its ledger (core/observables). Empty entries are not measured.
template <int D>
struct ObservableChoice {
  int every = 10;     ///< steps between measurements, > 0
  double starts = 0;  ///< averages begin here                                          [s]
  /// Rectangle (in 3D box) in which everything but flux is measured; else the whole sample. [m]
  std::optional<Box<D>> window;
  std::optional<ProfileChoice> profile;
  std::vector<FluxSurface<D>> crossings;
  int force_bins = 30;     ///< of the distribution of normal forces, > 0
  double force_limit = 6;  ///< its end, in mean forces, > 0; larger forces count in the last bin
};

}  // namespace bipot
