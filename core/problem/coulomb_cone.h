#pragma once

#include <cmath>

#include "core/base/types.h"

namespace bipot {

/// A vector in the frame of one contact, normal component first. Not aligned, so that Eigen keeps
/// the components in separate registers: they come from scalar code and return to it.
template <int D>
using Local = Eigen::Matrix<double, D, 1, Eigen::DontAlign>;

/// Norm of the tangential part; 0 for D = 1.
template <int D>
inline double tangential_norm(const Local<D>& x) {
  if constexpr (D == 1) {
    return 0;
  } else if constexpr (D == 2) {
    return std::abs(x[1]);
  } else {
    return x.template tail<D - 1>().norm();
  }
}

/// max(x, 0), exactly, without a branch; NaN stays NaN.
inline double positive_part(double x) { return 0.5 * (x + std::abs(x)); }

/// x limited to [-radius, radius] without a branch; NaN stays NaN.
inline double cut_off(double x, double radius) {
  const double above = x < -radius ? -radius : x;
  return above > radius ? radius : above;
}

/// Projection (34) of tau on the Coulomb cone K_mu = {|s_t| <= mu s_n}, Euclidean metric.
/// Three cases: take-off (tau in the polar cone: 0), stick (tau in the cone: tau), slip (on the
/// edge). The result of the slip case satisfies |s_t| = mu s_n up to one rounding.
template <int D>
inline Local<D> project_coulomb_cone(const Local<D>& tau, double mu) {
  if constexpr (D == 1) {
    return Local<1>(positive_part(tau[0]));
  } else if constexpr (D == 2) {
    // The normal part of the three cases is the largest of 0, tau_n and the slip formula. The
    // tangential part is tau_t cut off at the edge. No branch, since statuses cannot be predicted.
    const double edge = (tau[0] + mu * std::abs(tau[1])) / (1 + mu * mu);
    const double sn = positive_part(edge > tau[0] ? edge : tau[0]);
    return Local<2>(sn, cut_off(tau[1], mu * sn));
  } else {
    const double tn = tau[0];
    const double tt = tangential_norm<D>(tau);
    if (mu * tt <= -tn) return Local<D>::Zero();
    if (tt <= mu * tn) return tau;
    const double sn = (tn + mu * tt) / (1 + mu * mu);
    Local<D> s;
    s[0] = sn;
    s.template tail<D - 1>() = (mu * sn / tt) * tau.template tail<D - 1>();
    return s;
  }
}

/// A contact counts as sliding from this fraction of the cone's edge on.
inline constexpr double kConeEdge = 1 - 1e-9;

/// De Saxcé's modified velocity û = u + mu |u_t| n, see (19).
template <int D>
inline Local<D> de_saxce_velocity(const Local<D>& u, double mu) {
  Local<D> hat = u;
  hat[0] += mu * tangential_norm<D>(u);
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
