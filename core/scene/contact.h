#pragma once

#include <cstdint>

#include "core/types.h"

namespace bipot {

/// A candidate contact of disk i with the body j: a disk (j > i) or the wall j - num_disks.
struct Contact {
  int i = -1, j = -1;
  Vec2 n = Vec2::Zero();  ///< unit normal, from j to i
  double gap = 0;         ///< |X_i - X_j| - (a_i + a_j), negative: overlap (11)   [m]
};

enum class ContactStatus : std::int8_t { kTakeOff = 0, kStick = 1, kSlip = 2 };

/// What one step found at a contact, physical variables. t = e3 x n.
struct ContactOutcome {
  Contact contact;
  double s_n = 0, s_t = 0;  ///< impulse of the step on disk i; force = s/h       [N s]
  double u_n = 0, u_t = 0;  ///< relative velocity at the end of the step         [m/s]
  ContactStatus status = ContactStatus::kTakeOff;
  double spring = 0;  ///< tangential spring's elongation, spring-dashpot model only  [m]
};

}  // namespace bipot
