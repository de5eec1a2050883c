#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <bit>
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
/// Rolling friction adds parts of the same two kinds, |m| <= mu_r s_n and |m_spin| <= mu_spin s_n.
/// Bit g of `parts` tells that part g (each_bounded()) has friction; others have no pairs.
template <ContactRows D>
struct ContactJordan {
  using Friction = FrictionOf<D>;
  static constexpr int kParts = D == 1 ? 0 : !D.rolls ? 1 : D == 6 ? 3 : 2;
  static constexpr int P = D + kParts;                 ///< components of X and of Y
  static constexpr int kEigenvalues = 1 + 2 * kParts;  ///< rank of the algebra
  /// Not aligned, as Local is (core/problem/coulomb_cone.h).
  using Pairs = Eigen::Matrix<double, P, 1, Eigen::DontAlign>;
  using Spectrum = Eigen::Matrix<double, kEigenvalues, 1>;
  using Frame = Local<D>;

  /// The parts that have friction.
  static unsigned parts_of(const Friction& friction) {
    unsigned parts = 0, bit = 1;
    each_bounded<D>(friction, [&](auto, auto, double bound) {
      if (bound > 0) parts |= bit;
      bit <<= 1;
    });
    return parts;
  }
  static int rank(unsigned parts) { return 1 + 2 * std::popcount(parts); }

  /// Calls f(first row, rows, first pair, coefficient) for the parts with friction.
  template <class F>
  static void each_part(unsigned parts, const Friction& friction, const F& f) {
    each_bounded<D>(friction, [&](auto first, auto count, double bound) {
      constexpr int kPart = first() == 1 ? 0 : first() == 5 ? 2 : 1;
      if ((parts >> kPart & 1U) == 0) return;
      f(first, count, std::integral_constant<int, first() + kPart>{}, bound);
    });
  }
  template <class F>
  static void each_part(unsigned parts, const F& f) {
    each_part(parts, Friction{},
              [&](auto first, auto count, auto pair, double) { f(first, count, pair); });
  }
  /// Rows without friction become 0.
  static void clear_smooth_rows(Frame& x, unsigned parts) {
    each_bounded<D>(Friction{}, [&](auto first, auto count, double) {
      constexpr int kPart = first() == 1 ? 0 : first() == 5 ? 2 : 1;
      if ((parts >> kPart & 1U) == 0) x.template segment<count()>(first()).setZero();
    });
  }

  /// X = T s.
  static Pairs pairs_of_impulse(const Frame& s, const Friction& mu, unsigned parts) {
    Pairs x = Pairs::Zero();
    x[0] = s[0];
    each_part(parts, mu, [&](auto first, auto count, auto pair, double bound) {
      if constexpr (count() == 1) {
        x[pair()] = bound * s[0] - s[first()];
        x[pair() + 1] = bound * s[0] + s[first()];
      } else {
        x[pair()] = bound * s[0];
        x.template segment<2>(pair() + 1) = s.template segment<2>(first());
      }
    });
    return x;
  }
  /// The impulse of X. In the plane the edge distances a, c are kept to full relative accuracy in X.
  static Frame impulse_of_pairs(const Pairs& x, unsigned parts) {
    Frame s = velocity_of_pairs(x, parts);
    each_part(parts, [&](auto first, auto count, auto) {
      if constexpr (count() == 1) s[first()] *= 0.5;
    });
    return s;
  }
  /// The copies of s_n in X must not drift apart.
  static void join_copies(Pairs& x, const Friction& mu, unsigned parts) {
    each_part(parts, mu, [&](auto, auto count, auto pair, double bound) {
      if constexpr (count() == 2) x[pair()] = bound * x[0];
    });
  }
  /// u = U Y, u_n = w: the exact law has no dilatancy.
  static Frame velocity_of_pairs(const Pairs& y, unsigned parts) {
    Frame u = Frame::Zero();
    u[0] = y[0];
    each_part(parts, [&](auto first, auto count, auto pair) {
      if constexpr (count() == 1) {
        u[first()] = y[pair() + 1] - y[pair()];
      } else {
        u.template segment<2>(first()) = y.template segment<2>(pair() + 1);
      }
    });
    return u;
  }

  static Pairs product(const Pairs& x, const Pairs& y, unsigned parts) {
    Pairs z = Pairs::Zero();
    z[0] = x[0] * y[0];
    each_part(parts, [&](auto, auto count, auto pair) {
      constexpr int p = pair();
      if constexpr (count() == 1) {
        z[p] = x[p] * y[p];
        z[p + 1] = x[p + 1] * y[p + 1];
      } else {
        z[p] = 0.5 * x.template segment<3>(p).dot(y.template segment<3>(p));
        z.template segment<2>(p + 1) =
            0.5 * (x[p] * y.template segment<2>(p + 1) + y[p] * x.template segment<2>(p + 1));
      }
    });
    return z;
  }

  /// y with product(x, y) = z.
  static Pairs divide(const Pairs& z, const Pairs& x, unsigned parts) {
    Pairs y = Pairs::Zero();
    y[0] = z[0] / x[0];
    each_part(parts, [&](auto, auto count, auto pair) {
      constexpr int p = pair();
      if constexpr (count() == 1) {
        y[p] = z[p] / x[p];
        y[p + 1] = z[p + 1] / x[p + 1];
      } else {
        const Eigen::Vector2d x_t = x.template segment<2>(p + 1),
                              z_t = z.template segment<2>(p + 1);
        const double norm = x_t.norm();
        const double det = (x[p] - norm) * (x[p] + norm);
        y[p] = 2 * (x[p] * z[p] - x_t.dot(z_t)) / det;
        y.template segment<2>(p + 1) = (2 * z_t - y[p] * x_t) / x[p];
      }
    });
    return y;
  }

  /// The multiple alpha of the identity.
  static Pairs identity(double alpha, unsigned parts) {
    Pairs z = Pairs::Zero();
    z[0] = alpha;
    each_part(parts, [&](auto, auto count, auto pair) {
      z[pair()] = alpha;
      if constexpr (count() == 1) z[pair() + 1] = alpha;
    });
    return z;
  }

  /// Eigenvalues, two for each part from place 1 + 2 part on, the smaller one of a disk first; x_0
  /// for parts without friction.
  static Spectrum eigenvalues(const Pairs& x, unsigned parts) {
    Spectrum e = Spectrum::Constant(x[0]);
    each_part(parts, [&](auto first, auto count, auto pair) {
      constexpr int p = pair(), at = 1 + 2 * (p - first());
      if constexpr (count() == 1) {
        e.template segment<2>(at) = x.template segment<2>(p);
      } else {
        const double norm = x.template segment<2>(p + 1).norm();
        e[at] = x[p] - norm;
        e[at + 1] = x[p] + norm;
      }
    });
    return e;
  }
  static double trace(const Pairs& x, unsigned parts) {
    double sum = x[0];
    each_part(parts, [&](auto, auto count, auto pair) {
      sum += count() == 1 ? x[pair()] + x[pair() + 1] : 2 * x[pair()];
    });
    return sum;
  }

  /// Largest t with x + t dx in the cone (infinity if the ray stays inside).
  static double longest_step(const Pairs& x, const Pairs& dx, unsigned parts) {
    double t = dx[0] < 0 ? -x[0] / dx[0] : kInfinity;
    each_part(parts, [&](auto, auto count, auto pair) {
      constexpr int p = pair();
      if constexpr (count() == 1) {
        if (dx[p + 1] < 0) t = std::min(t, -x[p + 1] / dx[p + 1]);
      } else {
        // (x1 + t dx1)² = |x_t + t dx_t|²: c + 2 b t + a t² = 0 with c > 0.
        const Eigen::Vector2d x_t = x.template segment<2>(p + 1),
                              dx_t = dx.template segment<2>(p + 1);
        const double norm = x_t.norm();
        const double c = (x[p] - norm) * (x[p] + norm);
        const double b = x[p] * dx[p] - x_t.dot(dx_t);
        const double a = dx[p] * dx[p] - dx_t.squaredNorm();
        const double root2 = b * b - a * c;
        if (root2 >= 0) {
          const double q = -b + (b > 0 ? -std::sqrt(root2) : std::sqrt(root2));
          // Roots c / q and q / a; the smallest positive one leaves the cone.
          if (q != 0 && c / q > 0) t = std::min(t, c / q);
          if (a != 0 && q / a > 0) t = std::min(t, q / a);
        }
      }
      if (dx[p] < 0) t = std::min(t, -x[p] / dx[p]);
    });
    return t;
  }
};

}  // namespace bipot
