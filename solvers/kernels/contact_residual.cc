#include "solvers/kernels/contact_residual.h"

#include <algorithm>
#include <cmath>

namespace bipot {

template <ContactRows D>
LocalResidual<D> alart_curnier(const Local<D>& s, const Local<D>& u, FrictionOf<D> mu) {
  LocalResidual<D> r;
  const double normal = s[0] - u[0];
  const bool closed = normal > 0;
  r.f[0] = closed ? u[0] : s[0];
  (closed ? r.Q : r.P)(0, 0) = 1;
  each_bounded<D>(mu, [&](int first, int count, double bound) {
    const int end = first + count;
    const Local<D> tau = s - u;
    double square = 0;
    for (int i = first; i < end; ++i) square += tau[i] * tau[i];
    const double radius = closed ? bound * normal : 0.0, length = std::sqrt(square);
    for (int i = first; i < end; ++i) {
      if (length <= radius && closed) {  // stick
        r.f[i] = u[i];
        r.Q(i, i) = 1;
      } else if (!closed || radius == 0) {  // no friction
        r.f[i] = s[i];
        r.P(i, i) = 1;
      } else {  // slip
        const double direction = tau[i] / length;
        r.f[i] = s[i] - radius * direction;
        for (int j = first; j < end; ++j) {
          const double same = i == j ? 1 : 0;
          const double turn = (radius / length) * (same - direction * (tau[j] / length));
          r.P(i, j) = same - turn;
          r.Q(i, j) = turn;
        }
        r.P(i, 0) = -bound * direction;
        r.Q(i, 0) = bound * direction;
      }
    }
  });
  return r;
}

template <ContactRows D>
Local<D> split_projection(const Local<D>& z, const FrictionOf<D>& mu,
                          Eigen::Matrix<double, D.count, D.count>& jacobian) {
  Local<D> s = Local<D>::Zero();
  jacobian.setZero();
  if (z[0] <= 0) return s;
  s[0] = z[0];
  jacobian(0, 0) = 1;
  each_bounded<D>(mu, [&](auto first, auto count, double bound) {
    const double norm = part_norm<first(), count()>(z), radius = bound * z[0];
    for (int i = first(); i < first() + count(); ++i) {
      if (norm <= radius) {
        s[i] = z[i];
        jacobian(i, i) = 1;
        continue;
      }
      const double t = z[i] / norm;
      s[i] = radius * t;
      jacobian(i, 0) = bound * t;
      for (int j = first(); j < first() + count(); ++j) {
        jacobian(i, j) = radius / norm * ((i == j ? 1 : 0) - t * (z[j] / norm));
      }
    }
  });
  return s;
}

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

#define BIPOT_RESIDUALS(rows)                                                              \
  template LocalResidual<rows> alart_curnier<rows>(const Local<rows>&, const Local<rows>&, \
                                                   FrictionOf<rows>);                      \
  template Local<rows> split_projection<rows>(                                             \
      const Local<rows>&, const FrictionOf<rows>&,                                         \
      Eigen::Matrix<double, ContactRows(rows).count, ContactRows(rows).count>&);
BIPOT_RESIDUALS(1)
BIPOT_RESIDUALS(2)
BIPOT_RESIDUALS(3)
BIPOT_RESIDUALS((ContactRows{3, true}))
BIPOT_RESIDUALS((ContactRows{6, true}))
#undef BIPOT_RESIDUALS
template LocalResidual<1> fischer_burmeister<1>(const Local<1>&, const Local<1>&, double);
template LocalResidual<2> fischer_burmeister<2>(const Local<2>&, const Local<2>&, double);
template LocalResidual<3> fischer_burmeister<3>(const Local<3>&, const Local<3>&, double);

}  // namespace bipot
