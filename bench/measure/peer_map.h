#pragma once

#include "core/problem/contact_problem.h"

namespace bipot {

/// The natural map as Siconos Numerics stops on it, in the units in which it is given problems here
/// (solvers/methods/siconos.h: the mean w of W_nn and the largest free velocity are one). In the
/// problem's variables, with u = W s + b, û = u + mu |u_t| n, of the impulse as given:
///
///   ‖s - P_K(s - û / w)‖ / max(‖s‖, ‖b‖ / w, ‖u‖ / w)
///
/// Dimensionless, and free of units where no contact has a row_scale. `s` has m entries; 0 contacts
/// give 0. Throws std::invalid_argument for a wrong size or where w is not positive.
double peer_natural_map(const ContactProblem& problem, const Vector& s);

}  // namespace bipot
