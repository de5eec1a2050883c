#pragma once

#include "core/base/number_types.h"
#include "core/base/types.h"

namespace bipot {

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

/// Projection (34) of tau on the Coulomb cone K_mu = {|s_t| <= mu s_n}, Euclidean metric.
/// Three cases: take-off (tau in the polar cone: 0), stick (tau in the cone: tau), slip (on the
/// edge). The result of the slip case satisfies |s_t| = mu s_n up to one rounding.
template <int D, class V, class Real>
[[gnu::always_inline]] inline V onto_cone(const V& tau, const Real& mu) {
  V s;
  // The normal part of the three cases is the largest of 0, tau_n and the slip formula. The
  // tangential part is tau_t cut off at the edge. No branch, since statuses cannot be predicted.
  if constexpr (D == 1) {
    s[0] = positive_part<Real>(tau[0]);
  } else if constexpr (D == 2) {
    const Real tn = tau[0], tt = tau[1];
    const Real edge = (tn + mu * absolute(tt)) / (1 + mu * mu);
    s[0] = positive_part(select(edge > tn, edge, tn));
    s[1] = cut_off(tt, Real(mu * s[0]));
  } else {
    const Real tn = tau[0], tt = tangential_norm<D>(tau);
    const Real edge = (tn + mu * tt) / (1 + mu * mu);
    s[0] = positive_part(select(edge > tn, edge, tn));
    const Real radius = mu * s[0];
    const Real shrink = select(tt > radius, Real(radius / tt), Real(Real{} + 1));
    s[1] = shrink * tau[1];
    s[2] = shrink * tau[2];
  }
  return s;
}

/// onto_cone() for expressions of Eigen.
template <int D>
inline Local<D> project_coulomb_cone(const Local<D>& tau, double mu) {
  return onto_cone<D>(tau, mu);
}

/// A contact counts as sliding from this fraction of the cone's edge on.
inline constexpr double kConeEdge = 1 - 1e-9;

/// Normal part of De Saxcé's modified velocity û = u + mu |u_t| n, see (19).
template <class Real>
[[gnu::always_inline]] inline Real modified_normal(const Real& u_n, const Real& slip,
                                                   const Real& mu) {
  return u_n + mu * slip;
}

/// De Saxcé's modified velocity û.
template <int D>
inline Local<D> de_saxce_velocity(const Local<D>& u, double mu) {
  Local<D> hat = u;
  hat[0] = modified_normal(u[0], tangential_norm<D>(u), mu);
  return hat;
}

/// Calls f with std::integral_constant<int, d>: the only dispatch from d as data to a kernel.
template <class F>
decltype(auto) dispatch_dim(int dim, F&& f) {
  if (dim == 1) return f(std::integral_constant<int, 1>{});
  if (dim == 2) return f(std::integral_constant<int, 2>{});
  return f(std::integral_constant<int, 3>{});
}

/// Segment of contact c in a stacked vector.
template <int D>
inline Local<D> local(const Eigen::Ref<const Vector>& x, int c) {
  return x.template segment<D>(c * D);
}

}  // namespace bipot
