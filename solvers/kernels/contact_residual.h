#pragma once

#include <algorithm>
#include <cmath>

#include "core/problem/coulomb_cone.h"

namespace bipot {

/// Equation f(s, u) = 0 of one contact, equivalent to Coulomb's law, with one element of its
/// generalized Jacobian: df = P ds + Q du. s and u must have comparable sizes (equilibrated
/// variables), as the steps of both residuals are 1.
template <int D>
struct LocalResidual {
  using Block = Eigen::Matrix<double, D, D>;
  Local<D> f = Local<D>::Zero();
  Block P = Block::Zero(), Q = Block::Zero();
};

/// Alart and Curnier (1991), standard form:
///     f_n = s_n - max(0, s_n - u_n),
///     f_t = s_t - proj(s_t - u_t, disk of radius mu max(0, s_n - u_n)),
/// and likewise for rolling and spin. On the edges of its cases the Jacobian is that of sticking, or of take-off.
template <ContactRows D>
LocalResidual<D> alart_curnier(const Local<D>& s, const Local<D>& u, FrictionOf<D> mu) {
  LocalResidual<D> r;
  const double normal = s[0] - u[0];
  const bool closed = normal > 0;
  r.f[0] = closed ? u[0] : s[0];
  (closed ? r.Q : r.P)(0, 0) = 1;
  each_bounded<D>(mu, [&](auto first, auto count, double bound) {
    constexpr int kFirst = first(), kCount = count();
    using Tangent = Eigen::Matrix<double, kCount, 1>;
    using Square = Eigen::Matrix<double, kCount, kCount>;
    const Tangent st = s.template segment<kCount>(kFirst), ut = u.template segment<kCount>(kFirst);
    const Tangent tau = st - ut;
    const double radius = closed ? bound * normal : 0.0;
    const double length = tau.norm();
    auto f = r.f.template segment<kCount>(kFirst);
    if (length <= radius && closed) {  // stick
      f = ut;
      r.Q.template block<kCount, kCount>(kFirst, kFirst).setIdentity();
    } else if (!closed || radius == 0) {  // no friction
      f = st;
      r.P.template block<kCount, kCount>(kFirst, kFirst).setIdentity();
    } else {  // slip
      const Tangent direction = tau / length;
      f = st - radius * direction;
      const Square turn =
          (radius / length) * (Square::Identity() - direction * direction.transpose());
      r.P.template block<kCount, kCount>(kFirst, kFirst) = Square::Identity() - turn;
      r.Q.template block<kCount, kCount>(kFirst, kFirst) = turn;
      r.P.template block<kCount, 1>(kFirst, 0) = -bound * direction;
      r.Q.template block<kCount, 1>(kFirst, 0) = bound * direction;
    }
  });
  return r;
}

/// Projection of Alart and Curnier at z, s_n on the half-line and then s_t on the disk of radius
/// mu s_n (rolling and spin likewise), and a generalised Jacobian of it.
template <ContactRows D>
Local<D> split_projection(const Local<D>& z, const FrictionOf<D>& mu,
                          Eigen::Matrix<double, D.count, D.count>& jacobian) {
  Local<D> s = Local<D>::Zero();
  jacobian.setZero();
  if (z[0] <= 0) return s;
  s[0] = z[0];
  jacobian(0, 0) = 1;
  each_bounded<D>(mu, [&](auto first, auto count, double bound) {
    constexpr int kFirst = first(), kCount = count();
    using Square = Eigen::Matrix<double, kCount, kCount>;
    const double norm = part_norm<kFirst, kCount>(z);
    const double radius = bound * z[0];
    if (norm <= radius) {
      s.template segment<kCount>(kFirst) = z.template segment<kCount>(kFirst);
      jacobian.template block<kCount, kCount>(kFirst, kFirst).setIdentity();
    } else {
      const Eigen::Matrix<double, kCount, 1> t = z.template segment<kCount>(kFirst) / norm;
      s.template segment<kCount>(kFirst) = radius * t;
      jacobian.template block<kCount, 1>(kFirst, 0) = bound * t;
      jacobian.template block<kCount, kCount>(kFirst, kFirst) =
          radius / norm * (Square::Identity() - t * t.transpose());
    }
  });
  return s;
}

/// Fischer-Burmeister function of the Jordan product (Fukushima, Luo, Tseng 2002):
///     f = x + y - (x∘x + y∘y)^{1/2},   x = (s_n, s_t / mu),   y = (u_n + mu |u_t|, mu u_t),
/// both in the self-dual cone |z_t| <= z_n, x·y = s·û. [ours] The tangential rows are multiplied by
/// min(mu, 1), so that they keep size one as mu -> 0. mu = 0 is s_t = 0 and the scalar function.
///
/// The smaller spectral value of x∘x + y∘y is formed as a sum of squares: the difference in the
/// textbook formula would lose half of the digits. Where it vanishes (x + y on the edge of the
/// cone), the Jacobian replaces its root by 1e-10 of the larger one.
template <int D>
LocalResidual<D> fischer_burmeister(const Local<D>& s, const Local<D>& u, double mu) {
  LocalResidual<D> r;
  if constexpr (D == 1) {
    const double root = std::hypot(s[0], u[0]);
    // s + u - root without cancellation: 2 s u / (s + u + root).
    const double sum = s[0] + u[0];
    r.f[0] = sum > 0 ? 2 * s[0] * u[0] / (sum + root) : sum - root;
    r.P(0, 0) = root > 0 ? 1 - s[0] / root : 1;
    r.Q(0, 0) = root > 0 ? 1 - u[0] / root : 1;
    return r;
  } else {
    using Tangent = Eigen::Matrix<double, D - 1, 1>;
    using Block = Eigen::Matrix<double, D, D>;
    if (mu == 0) {
      const LocalResidual<1> n = fischer_burmeister<1>(Local<1>(s[0]), Local<1>(u[0]), 0);
      r.f = s;
      r.f[0] = n.f[0];
      r.P.setIdentity();
      r.P(0, 0) = n.P(0, 0);
      r.Q(0, 0) = n.Q(0, 0);
      return r;
    }
    const Tangent ut = u.template tail<D - 1>();
    const double slip = ut.norm();
    Local<D> x = s, y = u;
    x.template tail<D - 1>() /= mu;
    y[0] += mu * slip;
    y.template tail<D - 1>() *= mu;
    const Tangent xt = x.template tail<D - 1>(), yt = y.template tail<D - 1>();

    Tangent edge = x[0] * xt + y[0] * yt;
    const double edge_norm = edge.norm();
    if (edge_norm > 0) {
      edge /= edge_norm;
    } else {
      edge = Tangent::Unit(0);
    }
    const double xe = xt.dot(edge), ye = yt.dot(edge);
    const double aside = (xt - xe * edge).squaredNorm() + (yt - ye * edge).squaredNorm();
    const auto root = [&](double sign) {
      const double a = x[0] + sign * xe, b = y[0] + sign * ye;
      return std::sqrt(a * a + b * b + aside);
    };
    const double small = root(-1), large = root(+1);
    r.f = x + y;
    r.f[0] -= (large + small) / 2;
    r.f.template tail<D - 1>() -= (large - small) / 2 * edge;

    // L_w has the eigenvectors (1, ∓edge) and, for D = 3, the direction across.
    Block inverse = Block::Zero();
    if (large > 0) {
      Local<D> c1, c2;
      c1[0] = c2[0] = std::sqrt(0.5);
      c1.template tail<D - 1>() = -c1[0] * edge;
      c2.template tail<D - 1>() = c2[0] * edge;
      const double guarded = std::max(small, 1e-10 * large);
      inverse = (Block::Identity() - c1 * c1.transpose() - c2 * c2.transpose()) *
                    (2 / (guarded + large)) +
                c1 * c1.transpose() / guarded + c2 * c2.transpose() / large;
    }
    const auto arrow = [](const Local<D>& z) {
      Block L = z[0] * Block::Identity();
      L.template topRightCorner<1, D - 1>() = z.template tail<D - 1>().transpose();
      L.template bottomLeftCorner<D - 1, 1>() = z.template tail<D - 1>();
      return L;
    };
    Block dx = Block::Identity(), dy = Block::Identity();
    dx.template bottomRightCorner<D - 1, D - 1>() /= mu;
    dy.template bottomRightCorner<D - 1, D - 1>() *= mu;
    if (slip > 0) dy.template topRightCorner<1, D - 1>() = mu / slip * ut.transpose();
    r.P = (Block::Identity() - inverse * arrow(x)) * dx;
    r.Q = (Block::Identity() - inverse * arrow(y)) * dy;
    const double row = std::min(mu, 1.0);
    r.f.template tail<D - 1>() *= row;
    r.P.template bottomRows<D - 1>() *= row;
    r.Q.template bottomRows<D - 1>() *= row;
    return r;
  }
}

}  // namespace bipot
