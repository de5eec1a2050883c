#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "core/base/types.h"
#include "core/problem/coulomb_cone.h"

namespace bipot {

/// The complementarity pairs of one contact, as a Euclidean Jordan algebra. Coulomb's law reads
///
///     s_n u_n = 0,    x ∘ y = 0,    x = (mu s_n, s_t) ∈ L,  y = (gamma, u_t) ∈ L,
///
/// with L the Lorentz cone of R^d and gamma = |u_t| the slip speed, a free multiplier. With x ∘ y =
/// 0, s_t maximises dissipation on the disk of radius mu s_n. This is the exact law, de Saxcé's
/// term included: s·û = s_n u_n + x·y. On the central path s_n u_n = tau and x ∘ y = 2 tau e.
///
/// d = 2: L is the quadrant in the coordinates (x_0 - x_1, x_0 + x_1), and the pairs are
///   X = (s_n, a, c) = (s_n, mu s_n - s_t, mu s_n + s_t),  Y = (w, la, lc),  u = (w, lc - la).
/// d = 3: X = (s_n, mu s_n, s_t), Y = (w, gamma, u_t), with the product x ∘ y / 2 in the second
/// part. Both eigenvalues are then tau on the path. Newton on x ∘ y = r is the direction of
/// Alizadeh, Haeberly and Overton (1998); for d = 2 it is the coordinatewise one.
///
/// d = 1 and contacts without friction have the first pair only (`friction` false).
template <int D>
struct ContactJordan {
  static constexpr int P = D == 1 ? 1 : D + 1;         ///< components of X and of Y
  static constexpr int kEigenvalues = D == 1 ? 1 : 3;  ///< rank of the algebra
  using Pairs = Eigen::Matrix<double, P, 1>;
  using Frame = Local<D>;

  static int rank(bool friction) { return D > 1 && friction ? 3 : 1; }

  /// X = T s.
  static Pairs pairs_of_impulse(const Frame& s, double mu, bool friction) {
    Pairs x = Pairs::Zero();
    x[0] = s[0];
    if (D > 1 && friction) {
      if constexpr (D == 2) {
        x[1] = mu * s[0] - s[1];
        x[2] = mu * s[0] + s[1];
      } else if constexpr (D == 3) {
        x[1] = mu * s[0];
        x[2] = s[1];
        x[3] = s[2];
      }
    }
    return x;
  }
  /// The impulse of X. For d = 2 the edge distances a, c are kept to full relative accuracy in X.
  static Frame impulse_of_pairs(const Pairs& x, bool friction) {
    Frame s = Frame::Zero();
    s[0] = x[0];
    if (D > 1 && friction) {
      if constexpr (D == 2) s[1] = 0.5 * (x[2] - x[1]);
      if constexpr (D == 3) s.template tail<2>() = x.template tail<2>();
    }
    return s;
  }
  /// Slip speed gamma of Y.
  static double slip_speed(const Pairs& y, bool friction) {
    if (!(D > 1 && friction)) return 0;
    if constexpr (D == 2) return y[1] + y[2];
    if constexpr (D == 3) return y[1];
    return 0;
  }
  /// u = U Y, u_n = w: the exact law has no dilatancy.
  static Frame velocity_of_pairs(const Pairs& y, bool friction) {
    Frame u = Frame::Zero();
    u[0] = y[0];
    if (D > 1 && friction) {
      if constexpr (D == 2) u[1] = y[2] - y[1];
      if constexpr (D == 3) u.template tail<2>() = y.template tail<2>();
    }
    return u;
  }

  static Pairs product(const Pairs& x, const Pairs& y, bool friction) {
    Pairs z = Pairs::Zero();
    z[0] = x[0] * y[0];
    if (D > 1 && friction) {
      if constexpr (D == 2) {
        z[1] = x[1] * y[1];
        z[2] = x[2] * y[2];
      } else if constexpr (D == 3) {
        z[1] = 0.5 * x.template tail<3>().dot(y.template tail<3>());
        z.template tail<2>() = 0.5 * (x[1] * y.template tail<2>() + y[1] * x.template tail<2>());
      }
    }
    return z;
  }

  /// y with product(x, y) = z.
  static Pairs divide(const Pairs& z, const Pairs& x, bool friction) {
    Pairs y = Pairs::Zero();
    y[0] = z[0] / x[0];
    if (D > 1 && friction) {
      if constexpr (D == 2) {
        y[1] = z[1] / x[1];
        y[2] = z[2] / x[2];
      } else if constexpr (D == 3) {
        const double norm = x.template tail<2>().norm();
        const double det = (x[1] - norm) * (x[1] + norm);
        y[1] = 2 * (x[1] * z[1] - x.template tail<2>().dot(z.template tail<2>())) / det;
        y.template tail<2>() = (2 * z.template tail<2>() - y[1] * x.template tail<2>()) / x[1];
      }
    }
    return y;
  }

  /// The multiple alpha of the identity.
  static Pairs identity(double alpha, bool friction) {
    Pairs z = Pairs::Zero();
    z[0] = alpha;
    if (D > 1 && friction) {
      z[1] = alpha;
      if constexpr (D == 2) z[2] = alpha;
    }
    return z;
  }

  /// Eigenvalues, rank(friction) of them.
  static Eigen::Vector3d eigenvalues(const Pairs& x, bool friction) {
    Eigen::Vector3d e(x[0], x[0], x[0]);
    if (D > 1 && friction) {
      if constexpr (D == 2) {
        e[1] = x[1];
        e[2] = x[2];
      } else if constexpr (D == 3) {
        const double norm = x.template tail<2>().norm();
        e[1] = x[1] - norm;
        e[2] = x[1] + norm;
      }
    }
    return e;
  }
  static double trace(const Pairs& x, bool friction) {
    if (!(D > 1 && friction)) return x[0];
    if constexpr (D == 2) return x[0] + x[1] + x[2];
    if constexpr (D == 3) return x[0] + 2 * x[1];
    return x[0];
  }

  /// Largest t with x + t dx in the cone (infinity if the ray stays inside).
  static double longest_step(const Pairs& x, const Pairs& dx, bool friction) {
    double t = dx[0] < 0 ? -x[0] / dx[0] : kInfinity;
    if (D > 1 && friction) {
      if constexpr (D == 2) {
        if (dx[1] < 0) t = std::min(t, -x[1] / dx[1]);
        if (dx[2] < 0) t = std::min(t, -x[2] / dx[2]);
      } else if constexpr (D == 3) {
        // (x1 + t dx1)² = |x_t + t dx_t|²: c + 2 b t + a t² = 0 with c > 0.
        const double norm = x.template tail<2>().norm();
        const double c = (x[1] - norm) * (x[1] + norm);
        const double b = x[1] * dx[1] - x.template tail<2>().dot(dx.template tail<2>());
        const double a = dx[1] * dx[1] - dx.template tail<2>().squaredNorm();
        const double root2 = b * b - a * c;
        if (root2 >= 0) {
          const double q = -b + (b > 0 ? -std::sqrt(root2) : std::sqrt(root2));
          // Roots c / q and q / a; the smallest positive one leaves the cone.
          if (q != 0 && c / q > 0) t = std::min(t, c / q);
          if (a != 0 && q / a > 0) t = std::min(t, q / a);
        }
        if (dx[1] < 0) t = std::min(t, -x[1] / dx[1]);
      }
    }
    return t;
  }
};

}  // namespace bipot
