#pragma once

#include "core/problem/contact_problem.h"

namespace bipot {

/// The natural map by which Siconos Numerics stops, in the units of its problems here. There the
/// mean w of W_nn and the largest free velocity are one (solvers/methods/siconos.h). In the
/// problem's variables, with u = W s + b, û = u + mu |u_t| n, of the impulse as given:
///
///   ‖s - P_K(s - û / w)‖ / max(‖s‖, ‖b‖ / w, ‖u‖ / w)
///
/// Dimensionless, and independent of units if no contact has a row_scale. `s` has m entries; 0
/// contacts give 0. Throws std::invalid_argument for a wrong size or if w is not positive.
double peer_natural_map(const ContactProblem& problem, const Vector& s);

}  // namespace bipot
