#pragma once

#include "core/problem/contact_problem.h"

namespace bipot {

/// The least and the largest normal impulse of a contact over all impulses that hold everything at
/// rest.
struct ForceRange {
  double low = kNaN, high = kNaN;  ///< [N s]
};

/// Force range of each contact of a problem with d = 2, H and no row_scale: over all s in K_mu with
/// A v_free + H s = 0, by two linear programmes for each contact (the cone is spanned by its
/// edges). Empty if there is no such s. `high` is infinite for a contact of a self-stress. Throws
/// std::invalid_argument for another form, std::runtime_error if a programme does not end.
std::vector<ForceRange> admissible_forces(const ContactProblem& problem);

/// Mean of (high - low) over the mean of the middles; NaN without contacts, infinite with a
/// self-stress.
double force_spread(const std::vector<ForceRange>& ranges);

}  // namespace bipot
