#pragma once

#include <cmath>

#include "core/base/large_pages.h"
#include "core/criterion/contact_error.h"
#include "core/criterion/contact_terms.h"

namespace bipot {

// The terms of contact_terms.h in double precision, read from the vectors of a problem, for
// evaluators that add up in an order of their own.

/// Physical row scale r of a row.
inline double physical_row_scale(const ContactProblem& p, int row) {
  return p.row_scale.size() == 0 ? 1.0 : p.row_scale[row];
}

/// Weights of each contact, physical.
struct ErrorWeights {
  Vector w_nn;     ///< W_nn                          [1/kg]
  Vector rho_nn;   ///< 1 / W_nn                        [kg]
  Vector rho_nat;  ///< d / trace of the block of W     [kg]
};

/// `delassus_diagonal`: of W in the problem's variables, m values.
inline ErrorWeights error_weights(const ContactProblem& p, const Vector& delassus_diagonal) {
  const int d = p.dim;
  ErrorWeights weights{large_vector(p.num_contacts()), large_vector(p.num_contacts()),
                       large_vector(p.num_contacts())};
  for (int c = 0; c < p.num_contacts(); ++c) {
    double trace = 0;
    for (int k = 0; k < d; ++k) {
      const double r = physical_row_scale(p, c * d + k);
      trace += r * r * delassus_diagonal[c * d + k];
    }
    const double r = physical_row_scale(p, c * d);
    weights.w_nn[c] = r * r * delassus_diagonal[c * d];
    weights.rho_nn[c] = 1 / weights.w_nn[c];
    weights.rho_nat[c] = d / trace;
  }
  return weights;
}

/// Adds the contact's part of free_energy and free_impulse2, which do not depend on the impulse.
inline void add_free_terms(const ContactProblem& p, const ErrorWeights& weights, int contact,
                           ErrorSums& e) {
  const int first = contact * p.dim;
  e.free_energy +=
      approach_energy(weights.rho_nn[contact], p.u_free[first] / physical_row_scale(p, first));
  for (int k = 0; k < p.dim; ++k) {
    const double b =
        weights.rho_nat[contact] * p.u_free[first + k] / physical_row_scale(p, first + k);
    e.free_impulse2 += b * b;
  }
}

/// Contact c of a stacked vector.
template <int D>
[[gnu::always_inline]] inline FrameVector<double, D> frame_vector(const Vector& x, int c) {
  const double* const first = x.data() + static_cast<std::ptrdiff_t>(c) * D;
  FrameVector<double, D> v;
  each_component<D>([&](int k) { v[k] = first[k]; });
  return v;
}

/// s of contact c <- its projection on the cone, in physical variables.
template <int D, bool kScaled>
inline void project_physically(const ContactProblem& p, int c, Vector& s) {
  FrameVector<double, D> r;
  if constexpr (kScaled) r = frame_vector<D>(p.row_scale, c);
  const auto on_cone = physical_projection<kScaled>(frame_vector<D>(s, c), r, p.mu[c]);
  each_component<D>([&](int k) { s[c * D + k] = on_cone[k]; });
}

/// Adds the terms of contact c to all sums but the free ones. s on the cone, u = W s + u_free, both
/// of the whole problem p.
template <int D, bool kScaled>
inline ContactTerms<double> add_error_terms(const ContactProblem& p, int c, const Vector& s,
                                            const Vector& u, double w_nn, double rho_nn,
                                            double rho_nat, ErrorSums& e) {
  FrameVector<double, D> r;
  if constexpr (kScaled) r = frame_vector<D>(p.row_scale, c);
  const auto contact =
      physical_contact<kScaled>(frame_vector<D>(s, c), frame_vector<D>(u, c),
                                frame_vector<D>(p.u_free, c), r, p.mu[c], w_nn, rho_nn);
  const LawTerms<double> law = law_terms(contact);
  add_reported_terms(contact, law, rho_nat, e);
  return add_law_terms(contact, law, e);
}

}  // namespace bipot
