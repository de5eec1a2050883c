#pragma once

namespace bipot {

/// Whether one of n bounded parameters becomes zero before `step` (finite or not): bound ∘ value, and
/// -direction bound ∘ x its change over a step of 1. In vectors, without branches; no allocation.
bool any_nearer(const double* bound, const double* value, const double* x, double direction,
                double step, int n);

}  // namespace bipot
