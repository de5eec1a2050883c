#pragma once

#include <cstdint>
#include <utility>

#include "core/base/types.h"
#include "core/scene/contact_frame.h"

namespace bipot {

/// A distance of which only rounding is left, relative to the radius: it gives no normal.
constexpr double kNoDirection = 1e-12;

/// A candidate contact of disk (in 3D: sphere) i with the body j. The body is a disk (j > i, or
/// glued to a wall) or the wall j - num_disks. In a periodic cell it is an image of j
/// (core/scene/cell.h).
template <int D>
struct Contact {
  int i = -1, j = -1;
  Vec<D> n = Vec<D>::Zero();     ///< unit normal, from j to i
  double gap = 0;                ///< |X_i - X_j| - (a_i + a_j), negative: overlap (11)   [m]
  int image_x = 0, image_y = 0;  ///< numbers of the image of j

  std::pair<int, int> pair() const { return {i, j}; }
  bool with_image() const { return image_x != 0 || image_y != 0; }
};

enum class ContactStatus : std::int8_t { kTakeOff = 0, kStick = 1, kSlip = 2 };

/// Result of one step at a contact, in physical variables. In 2D s_t and u_t are components along t
/// = e3 x n, in 3D they are vectors (core/scene/contact_frame.h).
template <int D>
struct ContactOutcome {
  Contact<D> contact;
  double s_n = 0;  ///< impulse of the step on disk i, < 0: tension; force = s/h [N s]
  Tangent<D> s_t = no_turn<D>();  ///< its tangential part                              [N s]
  double u_n = 0;                 ///< relative velocity at the end of the step         [m/s]
  Tangent<D> u_t = no_turn<D>();  ///< its tangential part                              [m/s]
  ContactStatus status = ContactStatus::kTakeOff;
  /// Cohesion acted in the step; always true in scenes without cohesion.
  bool bonded = true;
  Tangent<D> spring = no_turn<D>();  ///< elongation along the contact, model dem only   [m]
  Spin<D> moment = no_turn<D>();     ///< of rolling friction, on disk i                 [N m s]

  /// It pushes, or cohesion holds it in tension.
  bool loaded() const { return s_n > 0 || (s_n < 0 && status != ContactStatus::kTakeOff); }
};

}  // namespace bipot
