#pragma once

#include <cstdint>

#include "core/base/types.h"
#include "core/scene/contact_frame.h"

namespace bipot {

/// A candidate contact of disk (in space: sphere) i with the body j: a disk (j > i, or glued to a wall) or the wall
/// j - num_disks. In a periodic cell with an image of j (core/scene/cell.h).
template <int D>
struct Contact {
  int i = -1, j = -1;
  Vec<D> n = Vec<D>::Zero();     ///< unit normal, from j to i
  double gap = 0;                ///< |X_i - X_j| - (a_i + a_j), negative: overlap (11)   [m]
  int image_x = 0, image_y = 0;  ///< numbers of the image of j

  bool with_image() const { return image_x != 0 || image_y != 0; }
};

enum class ContactStatus : std::int8_t { kTakeOff = 0, kStick = 1, kSlip = 2 };

/// What one step found at a contact, physical variables. In the plane s_t and u_t are along
/// t = e3 x n, in space they are vectors (core/scene/contact_frame.h).
template <int D>
struct ContactOutcome {
  Contact<D> contact;
  double s_n = 0;                 ///< impulse of the step on disk i; force = s/h       [N s]
  Tangent<D> s_t = no_turn<D>();  ///< its tangential part                              [N s]
  double u_n = 0;                 ///< relative velocity at the end of the step         [m/s]
  Tangent<D> u_t = no_turn<D>();  ///< its tangential part                              [m/s]
  ContactStatus status = ContactStatus::kTakeOff;
  double spring = 0;  ///< tangential spring's elongation, spring-dashpot model only  [m]
};

}  // namespace bipot
