#pragma once

#include "core/criterion/contact_error.h"
#include "core/problem/coulomb_cone.h"

namespace bipot {

// The terms of the criterion (contact_error.h) of one contact, for every number type: double, lanes
// (vector_error.cc), long double and Quadruple (extended_error.cc), and Rounded (rounded.h). Terms
// are added by `a = a + b`, sums over contacts by `+=`: Rounded distinguishes the two.

template <class Real, int D>
[[gnu::always_inline]] inline FrameVector<Real, D> operator-(const FrameVector<Real, D>& a,
                                                             const FrameVector<Real, D>& b) {
  FrameVector<Real, D> c;
  each_component<D>([&](int k) { c[k] = a[k] - b[k]; });
  return c;
}
/// a_k / b_k.
template <class Real, int D>
[[gnu::always_inline]] inline FrameVector<Real, D> operator/(const FrameVector<Real, D>& a,
                                                             const FrameVector<Real, D>& b) {
  FrameVector<Real, D> c;
  each_component<D>([&](int k) { c[k] = a[k] / b[k]; });
  return c;
}
/// Normal part first, in Eigen's order of three products.
template <class Real, int D>
[[gnu::always_inline]] inline Real dot(const FrameVector<Real, D>& a,
                                       const FrameVector<Real, D>& b) {
  if constexpr (D == 1) return a[0] * b[0];
  if constexpr (D == 2) return a[0] * b[0] + a[1] * b[1];
  if constexpr (D == 3) return a[0] * b[0] + (a[1] * b[1] + a[2] * b[2]);
  if constexpr (D == 6) {
    return a[0] * b[0] + (a[1] * b[1] + a[2] * b[2]) + (a[3] * b[3] + a[4] * b[4]) + a[5] * b[5];
  }
}

/// Physical friction coefficient, mu = mu_phys r_t / r_n; r: row_scale of the contact.
template <class Real, int D>
[[gnu::always_inline]] inline Real physical_friction(const Real& mu,
                                                     const FrameVector<Real, D>& r) {
  if constexpr (D == 1) return mu;
  if constexpr (D > 1) return mu * r[0] / r[1];
}
template <class Real, int D>
inline RollingFriction<Real> physical_friction(const RollingFriction<Real>& friction,
                                               const FrameVector<Real, D>& r) {
  constexpr int kRoll = 1 + ContactRows(D, true).tangents();
  return {friction.slide * r[0] / r[1], friction.roll * r[0] / r[kRoll],
          friction.spin * r[0] / r[D - 1]};
}

/// Rolling rows in the units of the others, by a length (rolling_arms()): impulses over it,
/// velocities times it, coefficients over it. Contacts without rolling stay as they are.
template <ContactRows K, class Real>
[[gnu::always_inline]] inline FrameVector<Real, K> times_arm(FrameVector<Real, K> x,
                                                             const Real& arm) {
  if constexpr (K.rolls) {
    for (int k = 1 + K.tangents(); k < K; ++k) x[k] = x[k] * arm;
  }
  return x;
}
template <class Real>
[[gnu::always_inline]] inline Real over_arm(const Real& mu, const Real&) {
  return mu;
}
template <class Real>
inline RollingFriction<Real> over_arm(const RollingFriction<Real>& friction, const Real& arm) {
  return {friction.slide, friction.roll / arm, friction.spin / arm};
}

/// The friction of a contact in another number type.
template <class Real>
inline Real as_number(double mu) {
  return Real(mu);
}
template <class Real>
inline RollingFriction<Real> as_number(const RollingFriction<double>& friction) {
  return {Real(friction.slide), Real(friction.roll), Real(friction.spin)};
}

/// The projection of s on the cone, taken in physical variables: both variables have the same edge
/// of the cone, but different nearest points.
template <class Real, int D, class Friction>
[[gnu::always_inline]] inline FrameVector<Real, D> physical_projection(
    bool scaled, const FrameVector<Real, D>& s, const FrameVector<Real, D>& r, const Friction& mu) {
  if (!scaled) return onto_cone<D>(s, mu);
  FrameVector<Real, D> on_cone = onto_cone<D>(s / r, physical_friction(mu, r));
  each_component<D>([&](int k) { on_cone[k] = on_cone[k] * r[k]; });
  return on_cone;
}

/// Calls f(rows, scaled) with integral constants: ContactRows, and whether the problem has a
/// row_scale.
template <class F>
decltype(auto) dispatch_form(const ContactProblem& p, F&& f) {
  return dispatch_rows(p, [&](auto d) {
    return p.row_scale.size() != 0 ? f(d, std::true_type{}) : f(d, std::false_type{});
  });
}

/// |u_t|; with rolling friction the sum of the speeds times their coefficients.
template <int D, class V, class Real>
[[gnu::always_inline]] inline auto slip_of(const V& u, const Real&) {
  return tangential_norm<D>(u);
}
template <int D, class V, class Real>
inline Real slip_of(const V& u, const RollingFriction<Real>& friction) {
  return friction_speed<D>(u, friction);
}
/// What friction dissipates, mu s_n |u_t|, for that slip.
template <class Real>
[[gnu::always_inline]] inline Real friction_power(const Real& mu, const Real& s_n,
                                                  const Real& slip) {
  return mu * s_n * slip;
}
template <class Real>
inline Real friction_power(const RollingFriction<Real>&, const Real& s_n, const Real& slip) {
  return s_n * slip;
}

/// One contact in physical variables, rolling rows times their arm; s on the cone.
template <class Real, int D, class Friction = Real>
struct PhysicalContact {
  FrameVector<Real, D> s, u;
  Real slip;  ///< slip_of()
  Friction mu;
  Real w_nn, rho_nn;  ///< rho_nn = 1 / w_nn
  Real moved;         ///< its term of sᵀ W s
};

/// From s, u = W s + b and b in the problem's variables, with physical w_nn and rho_nn. r is read
/// only if scaled. Rolling rows are times their arm already.
template <class Real, int D, class Friction>
[[gnu::always_inline]] inline PhysicalContact<Real, D, Friction> physical_contact(
    bool scaled, const FrameVector<Real, D>& s, const FrameVector<Real, D>& u,
    const FrameVector<Real, D>& b, const FrameVector<Real, D>& r, const Friction& mu,
    const Real& w_nn, const Real& rho_nn) {
  // sᵀ W s is the same in both variables: (r s)ᵀ (W / r r) (r s).
  const Real moved = dot(s, u - b);
  PhysicalContact<Real, D, Friction> c{s, u, {}, mu, w_nn, rho_nn, moved};
  if (scaled) {
    c.s = s / r;
    c.u = u / r;
    c.mu = physical_friction(mu, r);
  }
  c.slip = slip_of<D>(c.u, c.mu);
  return c;
}

/// ½ rho (u_n⁻)², the energy of an approach.
template <class Real>
[[gnu::always_inline]] inline Real approach_energy(const Real& rho, const Real& u_n) {
  const Real closing = positive_part(Real(-u_n));
  return 0.5 * rho * closing * closing;
}

/// The terms of D, G and V.
template <class Real>
struct LawTerms {
  Real friction;     ///< mu s_n |u_t|, and the like of rolling
  Real excess;       ///< (mu s_n |u_t| + s_t·u_t)₊, rolling included
  Real normal;       ///< s_n |u_n|
  Real penetration;  ///< ½ (u_n⁻)² / W_nn
};

template <class Real, int D, class Friction>
[[gnu::always_inline]] inline LawTerms<Real> law_terms(
    const PhysicalContact<Real, D, Friction>& c) {
  const Real friction = friction_power(c.mu, c.s[0], c.slip);
  Real excess = friction;
  if constexpr (D > 1) excess = excess + c.s[1] * c.u[1];
  if constexpr (D > 2) excess = excess + c.s[2] * c.u[2];
  if constexpr (D > 3) {
    for (int k = 3; k < D; ++k) excess = excess + c.s[k] * c.u[k];
  }
  return {friction, positive_part(excess), c.s[0] * absolute(c.u[0]),
          approach_energy(c.rho_nn, c.u[0])};
}

/// True if s_n = 0 and u_n >= 0, which is the law exactly: a projection would leave rounding. A
/// single comparison, s_n + u_n⁻ = 0, since g++ splits a conjunction of masks into lanes.
template <class Real, int D, class Friction>
[[gnu::always_inline]] inline auto takes_off(const PhysicalContact<Real, D, Friction>& c) {
  return c.s[0] + positive_part(Real(-c.u[0])) == 0;
}

/// tau = s - rho û.
template <class Real, int D, class Friction>
[[gnu::always_inline]] inline FrameVector<Real, D> natural_step(
    const PhysicalContact<Real, D, Friction>& c, const Real& rho) {
  FrameVector<Real, D> tau = c.u;
  tau[0] = modified_normal(c.u[0], c.slip, c.mu);
  each_component<D>([&](int k) { tau[k] = c.s[k] - rho * tau[k]; });
  return tau;
}

/// |a - b| - |b| of the parts from kFirst on of a = s and b = rho u, where `length` is |a - b|. The
/// difference of the two would have the rounding of |b|, which may be far larger than a.
template <int kFirst, int kCount, class V, class Real>
[[gnu::always_inline]] inline Real lengthening(const V& s, const V& u, const Real& rho,
                                               const Real& length, const Real& speed) {
  if constexpr (kCount == 1) {
    const Real b = absolute(Real(rho * u[kFirst])), minus = -s[kFirst];
    const Real along = select(u[kFirst] < 0, minus, s[kFirst]);
    const Real first = -along, second = along - 2 * b;
    return select(first > second, first, second);
  } else {
    const Real product = s[kFirst] * (s[kFirst] - 2 * rho * u[kFirst]) +
                         s[kFirst + 1] * (s[kFirst + 1] - 2 * rho * u[kFirst + 1]);
    const Real both = length + rho * speed;
    return select(both > 0, Real(product / both), Real{});
  }
}

/// P_K(s - rho û), where onto_cone() of the step would have the rounding of rho |u_t|: of a contact
/// that slides much faster than it approaches this may exceed s_n. The slip formula of
/// onto_cone() is (s_n - rho u_n + mu (|tau_t| - rho |u_t|)) / (1 + mu²).
template <class Real, int D>
[[gnu::always_inline]] inline FrameVector<Real, D> natural_point(
    const PhysicalContact<Real, D, Real>& c, const Real& rho) {
  const FrameVector<Real, D> tau = natural_step(c, rho);
  if constexpr (D == 1) {
    return onto_cone<D>(tau, c.mu);
  } else {
    const Real length = tangential_norm<D>(tau);
    const Real edge =
        (c.s[0] - rho * c.u[0] + c.mu * lengthening<1, D - 1>(c.s, c.u, rho, length, c.slip)) /
        (1 + c.mu * c.mu);
    return cone_point<D>(tau, c.mu, length, edge);
  }
}

/// The same with rolling friction: for a set S of parts
/// (s_n - rho u_n + Σ_S mu_g (|tau_g| - rho |u_g|) - Σ_not S rho mu_g |u_g|) / (1 + Σ_S mu_g²).
template <class Real, int D>
inline FrameVector<Real, D> natural_point(const PhysicalContact<Real, D, RollingFriction<Real>>& c,
                                          const Real& rho) {
  FrameVector<Real, D> tau = natural_step(c, rho);
  Real longer[3], kept[3], bounds[3];
  int parts = 0;
  each_bounded<D>(c.mu, [&](auto first, auto count, const Real& bound) {
    const Real speed = part_norm<first(), count()>(c.u);
    longer[parts] =
        lengthening<first(), count()>(c.s, c.u, rho, Real(part_norm<first(), count()>(tau)), speed);
    kept[parts] = rho * speed;
    bounds[parts++] = bound;
  });
  tau[0] = positive_part(tau[0]);  // that of the empty set, or of take-off
  for (int set = 1; set < 1 << parts; ++set) {
    Real pushed = c.s[0] - rho * c.u[0], weight = Real{} + 1;
    for (int k = 0; k < parts; ++k) {
      const bool in = (set >> k & 1) != 0;
      pushed = pushed + bounds[k] * (in ? longer[k] : Real(-kept[k]));
      if (in) weight = weight + bounds[k] * bounds[k];
    }
    const Real crossing = pushed / weight;
    if (crossing > tau[0]) tau[0] = crossing;
  }
  cut_off_parts<D>(tau, c.mu);
  return tau;
}

/// N = s - P_K(s - rho û).
template <class Real, int D, class Friction>
[[gnu::always_inline]] inline FrameVector<Real, D> natural_map(
    const PhysicalContact<Real, D, Friction>& c, const Real& rho) {
  return c.s - natural_point(c, rho);
}

/// ½ W_nn |N|².
template <class Real, int D>
[[gnu::always_inline]] inline Real natural_energy(const Real& w_nn, const FrameVector<Real, D>& N) {
  return 0.5 * w_nn * dot(N, N);
}

/// Terms of one contact in the numerators of epsilon and eta, to find the worst one.
template <class Real>
struct ContactTerms {
  Real violation;  ///< to G + V                                                   [J]
  Real natural;    ///< to the natural map's sum; -1 if the contact takes off   [J]
};

/// Adds the contact to the sums of epsilon and eta, except the free one.
template <class Real, int D, class Friction>
[[gnu::always_inline]] inline ContactTerms<Real> add_law_terms(
    const PhysicalContact<Real, D, Friction>& c, const LawTerms<Real>& law, ErrorSumsOf<Real>& e) {
  const Real gap = law.excess + law.normal;
  e.friction += law.friction;
  e.gap += gap;
  e.penetration += law.penetration;
  e.moved += c.moved;
  ContactTerms<Real> terms{gap + law.penetration, Real{} - 1};
  const auto open = takes_off(c);
  if (surely(open)) return terms;
  const Real natural = natural_energy(c.w_nn, natural_map(c, c.rho_nn));
  e.natural += select(open, Real{}, natural);
  terms.natural = select(open, terms.natural, natural);
  return terms;
}

/// Adds the contact to the sums of raw42 and natural_map.
template <class Real, int D, class Friction>
[[gnu::always_inline]] inline void add_reported_terms(const PhysicalContact<Real, D, Friction>& c,
                                                      const LawTerms<Real>& law,
                                                      const Real& rho_nat, ErrorSumsOf<Real>& e) {
  e.gap_clipped += law.excess + c.s[0] * positive_part(c.u[0]);
  e.impulse2 += dot(c.s, c.s);
  const auto open = takes_off(c);
  if (surely(open)) return;
  const FrameVector<Real, D> N = natural_map(c, rho_nat);
  e.natural_rel += select(open, Real{}, dot(N, N));
}

/// The sums that make epsilon and eta, rounded to double.
template <class Real>
ErrorSums in_double(const ErrorSumsOf<Real>& e) {
  ErrorSums sums;
  sums.friction = static_cast<double>(e.friction);
  sums.gap = static_cast<double>(e.gap);
  sums.penetration = static_cast<double>(e.penetration);
  sums.natural = static_cast<double>(e.natural);
  sums.moved = static_cast<double>(e.moved);
  sums.free_energy = static_cast<double>(e.free_energy);
  return sums;
}

}  // namespace bipot
