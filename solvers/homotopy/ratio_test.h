#pragma once

namespace bipot {

/// True if one of n bounded parameters becomes zero before `step` (finite or not). Its value is
/// bound ∘ value, its change over a step of 1 is -direction bound ∘ x. Vectorised, without
/// branches; no allocation.
bool any_nearer(const double* bound, const double* value, const double* x, double direction,
                double step, int n);

}  // namespace bipot
