#pragma once

#include <algorithm>
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
  Vector arm;      ///< rolling_arms()                   [m]

  double arm_of(int contact) const { return arm.size() == 0 ? 1.0 : arm[contact]; }
};

/// For each contact the length that brings its rolling rows into the units of the normal one:
/// ℓ² = W_nn over the mean W_mm of these rows, all physical. Without mobility in rolling the larger
/// coefficient serves, or 1. Empty without rolling friction.
inline Vector rolling_arms(const ContactProblem& p, const Vector& delassus_diagonal) {
  Vector arms(p.mu_r.size());
  for (int c = 0; c < static_cast<int>(arms.size()); ++c) {
    const auto physical = [&](int row) {
      const double r = physical_row_scale(p, row);
      return r * r * delassus_diagonal[row];
    };
    const int first = c * p.dim, roll = p.plain_dim();
    double sum = 0;
    for (int k = roll; k < p.dim; ++k) sum += physical(first + k);
    const double bound = std::max(p.mu_r[c], p.dim == 6 ? p.mu_spin[c] : 0.0);
    const double mean = sum / (p.dim - roll);
    arms[c] = mean > 0 ? std::sqrt(physical(first) / mean) : (bound > 0 ? bound : 1.0);
  }
  return arms;
}

/// `delassus_diagonal`: of W in the problem's variables, m values.
inline ErrorWeights error_weights(const ContactProblem& p, const Vector& delassus_diagonal) {
  const int d = p.dim;
  ErrorWeights weights{large_vector(p.num_contacts()), large_vector(p.num_contacts()),
                       large_vector(p.num_contacts()), rolling_arms(p, delassus_diagonal)};
  for (int c = 0; c < p.num_contacts(); ++c) {
    double trace = 0;
    for (int k = 0; k < d; ++k) {
      const double r = physical_row_scale(p, c * d + k);
      const double arm = k < p.plain_dim() ? 1.0 : weights.arm_of(c);
      trace += arm * arm * r * r * delassus_diagonal[c * d + k];
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
    const double arm = k < p.plain_dim() ? 1.0 : weights.arm_of(contact);
    const double b =
        weights.rho_nat[contact] * arm * p.u_free[first + k] / physical_row_scale(p, first + k);
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

/// s of contact c <- its projection on the cone, in physical variables, rolling rows by their arm.
template <ContactRows D, bool kScaled>
inline void project_physically(const ContactProblem& p, int c, double arm, Vector& s) {
  FrameVector<double, D> r;
  if constexpr (kScaled) r = frame_vector<D>(p.row_scale, c);
  const auto on_cone =
      times_arm<D>(physical_projection(kScaled, times_arm<D>(frame_vector<D>(s, c), 1 / arm), r,
                                       over_arm(friction_of<D>(p, c), arm)),
                   arm);
  each_component<D>([&](int k) { s[c * D + k] = on_cone[k]; });
}

/// Adds the terms of contact c to all sums but the free ones. s on the cone, u = W s + u_free, both
/// of the whole problem p.
template <ContactRows D, bool kScaled>
inline ContactTerms<double> add_error_terms(const ContactProblem& p, int c, const Vector& s,
                                            const Vector& u, const ErrorWeights& weights,
                                            ErrorSums& e) {
  FrameVector<double, D> r;
  if constexpr (kScaled) r = frame_vector<D>(p.row_scale, c);
  const double arm = weights.arm_of(c);
  const auto contact = physical_contact(
      kScaled, times_arm<D>(frame_vector<D>(s, c), 1 / arm),
      times_arm<D>(frame_vector<D>(u, c), arm), times_arm<D>(frame_vector<D>(p.u_free, c), arm), r,
      over_arm(friction_of<D>(p, c), arm), weights.w_nn[c], weights.rho_nn[c]);
  const LawTerms<double> law = law_terms(contact);
  add_reported_terms(contact, law, weights.rho_nat[c], e);
  return add_law_terms(contact, law, e);
}

}  // namespace bipot
