#pragma once

#include <cmath>

#include "core/base/large_pages.h"
#include "core/criterion/contact_error.h"
#include "core/problem/coulomb_cone.h"

namespace bipot {

// What single contacts add to the criterion of contact_error.h: for whoever adds up in an order of
// his own, a problem on one process or one that lies on several.

/// Physical row scale r of a row.
inline double physical_row_scale(const ContactProblem& p, int row) {
  return p.row_scale.size() == 0 ? 1.0 : p.row_scale[row];
}

/// Physical friction coefficient: mu = mu_phys r_t / r_n.
inline double physical_mu(const ContactProblem& p, int contact) {
  if (p.row_scale.size() == 0 || p.dim == 1) return p.mu[contact];
  const int row = contact * p.dim;
  return p.mu[contact] * p.row_scale[row] / p.row_scale[row + 1];
}

/// Per contact, physical.
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

/// What a contact adds to free_energy and free_impulse2, whatever the impulse.
inline void add_free_terms(const ContactProblem& p, const ErrorWeights& weights, int contact,
                           ErrorSums& e) {
  const int first = contact * p.dim;
  const double opening = p.u_free[first] / physical_row_scale(p, first);
  if (opening < 0) e.free_energy += 0.5 * opening * opening / weights.w_nn[contact];
  for (int k = 0; k < p.dim; ++k) {
    const double b =
        weights.rho_nat[contact] * p.u_free[first + k] / physical_row_scale(p, first + k);
    e.free_impulse2 += b * b;
  }
}

/// s of one contact <- its projection on the cone, in physical variables.
template <int D, bool kScaled>
inline void project_physically(const ContactProblem& p, int c, Vector& s) {
  if constexpr (kScaled) {
    // The edge of the cone is the same set in scaled and in physical variables, its projection
    // is not: the paper's projection is taken physically.
    const Local<D> r = p.row_scale.segment<D>(c * D);
    const Local<D> x = s.segment<D>(c * D).cwiseQuotient(r);
    s.segment<D>(c * D) = project_coulomb_cone<D>(x, physical_mu(p, c)).cwiseProduct(r);
  } else {
    const Local<D> x = s.segment<D>(c * D);
    s.segment<D>(c * D) = project_coulomb_cone<D>(x, p.mu[c]);
  }
}

/// What one contact adds to the numerators of epsilon and eta: how the worst one is found.
struct ContactTerms {
  double violation = 0;  ///< to G + V                       [J]
  double natural = 0;    ///< to the natural map's sum       [J]
};

/// Adds the terms of contact c to all sums but the free ones. s on the cone, u = W s + u_free, both
/// of the whole problem p.
template <int D, bool kScaled>
inline ContactTerms add_error_terms(const ContactProblem& p, int c, const Vector& s,
                                    const Vector& velocity, double w_nn, double rho_nn,
                                    double rho_nat, ErrorSums& e) {
  Local<D> x = s.segment<D>(c * D);
  Local<D> u = velocity.segment<D>(c * D);
  // sᵀ W s is the same in both variables: (r s)ᵀ (W / r r) (r s).
  e.moved += x.dot(u - p.u_free.segment<D>(c * D));
  if constexpr (kScaled) {
    x = x.cwiseQuotient(p.row_scale.segment<D>(c * D));
    u = u.cwiseQuotient(p.row_scale.segment<D>(c * D));
  }
  const double mu = kScaled ? physical_mu(p, c) : p.mu[c];

  const double slip = tangential_norm<D>(u);
  const double dissipated = mu * x[0] * slip;
  double tangential = dissipated;
  for (int k = 1; k < D; ++k) tangential += x[k] * u[k];
  tangential = positive_part(tangential);  // >= 0 on the cone; rounding may say otherwise
  const double opening = positive_part(u[0]);
  const double closing = positive_part(-u[0]);
  const double contact_gap = tangential + x[0] * std::abs(u[0]);
  const double contact_penetration = 0.5 * rho_nn * closing * closing;
  e.friction += dissipated;
  e.gap += contact_gap;
  e.gap_clipped += tangential + x[0] * opening;
  e.penetration += contact_penetration;
  ContactTerms terms{contact_gap + contact_penetration, -1};

  e.impulse2 += x.squaredNorm();
  // s = 0 with u_n >= 0 is the law exactly; the projection below would leave rounding.
  if (x[0] == 0 && u[0] >= 0) return terms;
  const Local<D> hat = de_saxce_velocity<D>(u, mu);
  const Local<D> n = x - project_coulomb_cone<D>(x - rho_nn * hat, mu);
  terms.natural = 0.5 * w_nn * n.squaredNorm();
  e.natural += terms.natural;
  e.natural_rel += (x - project_coulomb_cone<D>(x - rho_nat * hat, mu)).squaredNorm();
  return terms;
}

}  // namespace bipot
