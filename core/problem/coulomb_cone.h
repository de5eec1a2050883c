#pragma once

#include "core/base/number_types.h"
#include "core/base/types.h"
#include "core/problem/contact_problem.h"

namespace bipot {

/// The rows of a contact, a constant of the kernels: the normal, then the tangents. With rolling
/// friction follow as many moments about the tangents (one in the plane), and in space that about
/// the normal. An int is a contact without rolling friction.
struct ContactRows {
  int count = 2;
  bool rolls = false;

  constexpr ContactRows(int rows, bool rolling = false)  // NOLINT(google-explicit-constructor)
      : count(rows), rolls(rolling) {}
  constexpr operator int() const { return count; }  // NOLINT(google-explicit-constructor)
  constexpr int tangents() const { return !rolls ? count - 1 : (count == 6 ? 2 : 1); }
  /// All laws in the plane have cones with flat faces.
  constexpr bool in_plane() const { return tangents() < 2; }

  /// Coefficients of the coupled cone |s_t| <= slide s_n, |m| <= roll s_n, |m_spin| <= spin s_n.
  template <class Real>
  struct Rolling {
    Real slide{};  ///< mu                       [-]
    Real roll{};   ///< mu_r                     [m]
    Real spin{};   ///< mu_spin, in space alone  [m]
  };
};
template <class Real>
using RollingFriction = ContactRows::Rolling<Real>;

// Instantiates a template for the rows of all contacts: BIPOT_FOR_ROWS(template class Name);
#define BIPOT_FOR_ROWS(name)  \
  name<1>;                    \
  name<2>;                    \
  name<3>;                    \
  name<ContactRows(3, true)>; \
  name<ContactRows(6, true)>

/// Friction of a contact: the coefficient mu, or a RollingFriction.
template <ContactRows K>
using FrictionOf = std::conditional_t<K.rolls, RollingFriction<double>, double>;

/// A vector in the frame of one contact, normal component first. Not aligned, so that Eigen keeps
/// the components in separate registers: they come from scalar code and return to it.
template <int D>
using Local = Eigen::Matrix<double, D, 1, Eigen::DontAlign>;

/// The same for any number type (number_types.h).
template <class Real, int D>
struct FrameVector {
  Real component[std::size_t{D}];

  [[gnu::always_inline]] Real& operator[](int k) { return component[k]; }
  [[gnu::always_inline]] const Real& operator[](int k) const { return component[k]; }
};

/// Calls f(k) for the components of a frame, without a loop: constant indices keep the components
/// in registers.
template <int D, class F>
[[gnu::always_inline]] inline void each_component(const F& f) {
  f(0);
  if constexpr (D > 1) f(1);
  if constexpr (D > 2) f(2);
  if constexpr (D > 3) {
    f(3);
    f(4);
    f(5);
  }
}

/// Norm of the tangential part of a Local or FrameVector; 0 for D = 1.
template <int D, class V>
[[gnu::always_inline]] inline auto tangential_norm(const V& x) {
  using Real = std::decay_t<decltype(x[0])>;
  if constexpr (D == 1) {
    return Real(0);
  } else if constexpr (D == 2) {
    return absolute<Real>(x[1]);
  } else {
    return root<Real>(x[1] * x[1] + x[2] * x[2]);
  }
}

/// The projection (34) for D > 1, from `length` = |tau_t| and `edge`, the normal part in the slip
/// case. The normal part of the three cases is the largest of 0, tau_n and `edge`. The tangential
/// part is tau_t cut off at the edge. No branch, since statuses cannot be predicted.
template <int D, class V, class Real>
[[gnu::always_inline]] inline V cone_point(V tau, const Real& mu, const Real& length,
                                           const Real& edge) {
  tau[0] = positive_part(select(edge > tau[0], edge, tau[0]));
  const Real radius = mu * tau[0];
  if constexpr (D == 2) {
    tau[1] = cut_off<Real>(tau[1], radius);
  } else {
    const Real shrink = select(length > radius, Real(radius / length), Real(Real{} + 1));
    tau[1] = shrink * tau[1];
    tau[2] = shrink * tau[2];
  }
  return tau;
}

/// Projection (34) of tau on the Coulomb cone K_mu = {|s_t| <= mu s_n}, Euclidean metric.
/// Three cases: take-off (tau in the polar cone: 0), stick (tau in the cone: tau), slip (on the
/// edge). The result of the slip case satisfies |s_t| = mu s_n up to one rounding.
template <int D, class V, class Real>
[[gnu::always_inline]] inline V onto_cone(const V& tau, const Real& mu) {
  if constexpr (D == 1) {
    V s;
    s[0] = positive_part<Real>(tau[0]);
    return s;
  } else {
    using Number = std::decay_t<decltype(tau[0])>;  // mu may be an int
    const Number length = tangential_norm<D>(tau);
    const Number edge = (tau[0] + mu * length) / (1 + mu * mu);
    return cone_point<D>(tau, Number(mu), length, edge);
  }
}

/// Calls f(first, count, coefficient) for the parts of a contact's D rows that friction bounds. The
/// first two are integral constants.
template <int D, class Real, class F>
inline void each_bounded(const Real& mu, const F& f) {
  using Tangents = std::integral_constant<int, D - 1>;
  if constexpr (D > 1) f(std::integral_constant<int, 1>{}, Tangents{}, mu);
}
template <int D, class Real, class F>
inline void each_bounded(const RollingFriction<Real>& friction, const F& f) {
  constexpr int kTangents = ContactRows(D, true).tangents();
  using Tangents = std::integral_constant<int, kTangents>;
  f(std::integral_constant<int, 1>{}, Tangents{}, friction.slide);
  f(std::integral_constant<int, 1 + kTangents>{}, Tangents{}, friction.roll);
  if constexpr (D == 6) {
    f(std::integral_constant<int, 5>{}, std::integral_constant<int, 1>{}, friction.spin);
  }
}

/// Norm of the kCount components from kFirst on.
template <int kFirst, int kCount, class V>
inline auto part_norm(const V& x) {
  using Real = std::decay_t<decltype(x[0])>;
  if constexpr (kCount == 1) {
    return absolute<Real>(x[kFirst]);
  } else {
    return root<Real>(x[kFirst] * x[kFirst] + x[kFirst + 1] * x[kFirst + 1]);
  }
}

/// Each bounded part of s cut off at its coefficient times s_n.
template <int D, class V, class Friction>
inline void cut_off_parts(V& s, const Friction& friction) {
  each_bounded<D>(friction, [&](auto first, auto count, const auto& bound) {
    using Real = std::decay_t<decltype(s[0])>;
    const Real radius = bound * s[0];
    if constexpr (count() == 1) {
      s[first()] = cut_off<Real>(s[first()], radius);
    } else {
      const Real length = part_norm<first(), count()>(s);
      if (!(length > radius)) return;
      for (int k = first(); k < first() + count(); ++k) s[k] = s[k] * (radius / length);
    }
  });
}

/// Projection of tau on the cone with rolling friction, Euclidean metric. Given s_n, each part is
/// tau's, cut off; s_n is the root of x - tau_n - Σ mu_g (|tau_g| - mu_g x)₊. That is the least of
/// the rising lines x - tau_n - Σ_S mu_g (|tau_g| - mu_g x) of all sets S of parts. Hence s_n is
/// the largest of 0 and of their roots.
template <int D, class V, class Real>
inline V onto_cone(const V& tau, const RollingFriction<Real>& friction) {
  Real lengths[3], bounds[3];
  int parts = 0;
  each_bounded<D>(friction, [&](auto first, auto count, const Real& bound) {
    lengths[parts] = part_norm<first(), count()>(tau);
    bounds[parts++] = bound;
  });
  V s = tau;
  s[0] = positive_part<Real>(tau[0]);
  for (int set = 1; set < 1 << parts; ++set) {
    Real pushed = tau[0], weight = Real{} + 1;
    for (int k = 0; k < parts; ++k) {
      if ((set >> k & 1) == 0) continue;
      pushed = pushed + bounds[k] * lengths[k];
      weight = weight + bounds[k] * bounds[k];
    }
    const Real crossing = pushed / weight;
    if (crossing > s[0]) s[0] = crossing;
  }
  cut_off_parts<D>(s, friction);
  return s;
}

/// onto_cone() for expressions of Eigen. `friction`: mu, or a RollingFriction.
template <int D, class Friction>
[[gnu::always_inline]] inline Local<D> project_coulomb_cone(const Local<D>& tau,
                                                            const Friction& friction) {
  return onto_cone<D>(tau, friction);
}

/// What friction adds to u_n in De Saxcé's modified velocity: mu |u_t|, with rolling friction
/// mu |u_t| + mu_r |w_r| + mu_spin |w_spin|.
template <int D, class V, class Real>
[[gnu::always_inline]] inline auto friction_speed(const V& u, const Real& mu) {
  return mu * tangential_norm<D>(u);
}
template <int D, class V, class Real>
inline Real friction_speed(const V& u, const RollingFriction<Real>& friction) {
  Real sum{};
  each_bounded<D>(friction, [&](auto first, auto count, const Real& bound) {
    sum = sum + bound * part_norm<first(), count()>(u);
  });
  return sum;
}

/// A contact counts as sliding from this fraction of the cone's edge on.
inline constexpr double kConeEdge = 1 - 1e-9;

/// True if an impulse that pushes is on a bound of its friction, from kConeEdge on: it slides or
/// rolls. A coefficient of rolling that is 0 does not count.
template <int D, class Friction>
inline bool on_edge(const Local<D>& s, const Friction& friction) {
  bool on = false;
  each_bounded<D>(friction, [&](auto first, auto count, double bound) {
    if (first() > 1 && bound == 0) return;
    on |= !(part_norm<first(), count()>(s) < kConeEdge * bound * s[0]);
  });
  return on;
}

/// Normal part of De Saxcé's modified velocity û = u + mu |u_t| n, see (19).
template <class Real>
[[gnu::always_inline]] inline Real modified_normal(const Real& u_n, const Real& slip,
                                                   const Real& mu) {
  return u_n + mu * slip;
}

/// `speed`: friction_speed().
template <class Real>
inline Real modified_normal(const Real& u_n, const Real& speed, const RollingFriction<Real>&) {
  return u_n + speed;
}

/// De Saxcé's modified velocity û. `friction`: mu, or a RollingFriction.
template <int D, class Friction>
inline Local<D> de_saxce_velocity(const Local<D>& u, const Friction& friction) {
  Local<D> hat = u;
  hat[0] = u[0] + friction_speed<D>(u, friction);
  return hat;
}

/// Calls f with std::integral_constant<int, d>, for contacts without rolling friction.
template <class F>
decltype(auto) dispatch_dim(int dim, F&& f) {
  if (dim == 1) return f(std::integral_constant<int, 1>{});
  if (dim == 2) return f(std::integral_constant<int, 2>{});
  return f(std::integral_constant<int, 3>{});
}

/// The same for code that asks for the number of rows alone: 1, 2, 3 or 6.
template <class F>
decltype(auto) dispatch_count(int rows, F&& f) {
  if (rows == 6) return f(std::integral_constant<int, 6>{});
  return dispatch_dim(rows, f);
}

/// Calls f with std::integral_constant<ContactRows, ...>: the only dispatch from a problem to
/// kernels that take rolling friction.
template <class F>
decltype(auto) dispatch_rows(const ContactProblem& p, F&& f) {
  using std::integral_constant;
  if (p.rolls() && p.dim == 6) return f(integral_constant<ContactRows, ContactRows(6, true)>{});
  if (p.rolls()) return f(integral_constant<ContactRows, ContactRows(3, true)>{});
  if (p.dim == 1) return f(integral_constant<ContactRows, ContactRows(1)>{});
  if (p.dim == 2) return f(integral_constant<ContactRows, ContactRows(2)>{});
  return f(integral_constant<ContactRows, ContactRows(3)>{});
}

/// Friction of contact c of a problem, or of other variables with mu, mu_r and mu_spin.
template <ContactRows K, class Vectors>
inline FrictionOf<K> friction_of(const Vectors& of, int c) {
  if constexpr (K.rolls) {
    return {of.mu[c], of.mu_r[c], K == 6 ? of.mu_spin[c] : 0.0};
  } else {
    return of.mu[c];
  }
}

/// Segment of contact c in a stacked vector.
template <int D>
inline Local<D> local(const Eigen::Ref<const Vector>& x, int c) {
  return x.template segment<D>(c * D);
}

}  // namespace bipot
