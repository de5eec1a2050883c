#include "bench/measure/independent_check.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace bipot {
namespace {

#if __LDBL_MANT_DIG__ >= 113
using Quad = long double;
#else
__extension__ typedef __float128 Quad;
#endif
using Values = std::vector<Quad>;

/// One Newton step from the root in long double, which doubles its digits.
Quad root(Quad x) {
  const Quad near = std::sqrt(static_cast<long double>(x));
  if (!(near > 0) || std::isinf(static_cast<long double>(x))) return near;
  return (near + x / near) / 2;
}

Quad magnitude(Quad x) { return x < 0 ? -x : x; }

Quad length(const Quad* x, int size) {
  Quad sum = 0;
  for (int k = 0; k < size; ++k) sum += x[k] * x[k];
  return root(sum);
}

/// Rows of a contact whose length friction bounds by a coefficient times the normal impulse.
struct BoundedRows {
  int first, count;
  Quad coefficient;
};

/// The rows of contact c that friction bounds, in the problem's variables.
std::vector<BoundedRows> bounded_rows(const ContactProblem& p, int c) {
  if (p.dim == 1) return {};
  if (!p.rolls()) return {{1, p.dim - 1, static_cast<Quad>(p.mu[c])}};
  const Quad slide = static_cast<Quad>(p.mu[c]), roll = static_cast<Quad>(p.mu_r[c]);
  if (p.dim == 3) return {{1, 1, slide}, {2, 1, roll}};
  return {{1, 2, slide}, {3, 2, roll}, {5, 1, static_cast<Quad>(p.mu_spin[c])}};
}

/// The nearest point of the cone: its normal part x is the root of x - y_n - Σ μ (|y| - μ x)₊ or,
/// if that is negative, 0. The function rises and is concave: Newton's steps from 0 rise to the
/// root, and each leaves out the bounds that it has passed.
void to_cone(Quad* y, const std::vector<BoundedRows>& bounds) {
  Quad normal = 0;
  for (std::size_t step = 0; step <= bounds.size(); ++step) {
    Quad sum = y[0], slope = 1;
    for (const auto& [first, count, mu] : bounds) {
      const Quad size = length(y + first, count);
      if (size <= mu * normal) continue;
      sum += mu * size;
      slope += mu * mu;
    }
    normal = sum / slope;
    if (!(normal > 0)) break;
  }
  y[0] = normal > 0 ? normal : 0;
  for (const auto& [first, count, mu] : bounds) {
    const Quad size = length(y + first, count), most = mu * y[0];
    if (size <= most) continue;
    for (int k = first; k < first + count; ++k) y[k] *= most / size;
  }
}

/// Of a sum of squares, relative: what the projection leaves on the edge of the cone.
constexpr double kRounding = 1e-60;

Quad quotient(Quad numerator, Quad denominator) {
  if (numerator == 0) return 0;
  return denominator > 0 ? numerator / denominator : kInfinity;
}

/// W s in the problem's variables.
Values product(const ContactProblem& p, const Values& s, bool by_bodies) {
  Values result(s.size(), 0);
  if (!by_bodies) {
    for (int i = 0; i < p.num_rows(); ++i) {
      for (SparseRows::InnerIterator it(p.W, i); it; ++it) {
        result[to_size(i)] += static_cast<Quad>(it.value()) * s[to_size(it.col())];
      }
    }
    return result;
  }
  Values v(to_size(p.num_dofs()), 0);
  for (int j = 0; j < p.num_rows(); ++j) {
    for (SparseMatrix::InnerIterator it(p.H, j); it; ++it) {
      v[to_size(it.row())] += static_cast<Quad>(it.value()) * s[to_size(j)];
    }
  }
  for (int i = 0; i < p.num_dofs(); ++i) v[to_size(i)] /= static_cast<Quad>(p.A.coeff(i, i));
  for (int j = 0; j < p.num_rows(); ++j) {
    for (SparseMatrix::InnerIterator it(p.H, j); it; ++it) {
      result[to_size(j)] += static_cast<Quad>(it.value()) * v[to_size(it.row())];
    }
  }
  return result;
}

/// A diagonal entry of W, in the problem's variables.
Quad diagonal(const ContactProblem& p, int row, bool by_bodies) {
  if (!by_bodies) return static_cast<Quad>(p.W.coeff(row, row));
  Quad sum = 0;
  for (SparseMatrix::InnerIterator it(p.H, row); it; ++it) {
    const Quad h = static_cast<Quad>(it.value());
    sum += h * h / static_cast<Quad>(p.A.coeff(it.row(), it.row()));
  }
  return sum;
}

/// The length of contact c that turns rolling rows into sliding ones: a force at this distance has
/// their moment. With it the physical mobility W_nn is the mean one of the rolling rows. Where
/// these cannot move: the larger coefficient, or 1.
Quad lever(const ContactProblem& p, int c, const Values& r, bool by_bodies) {
  const auto mobility = [&](int row) {
    return diagonal(p, row, by_bodies) * r[to_size(row)] * r[to_size(row)];
  };
  const int begin = c * p.dim, plain = p.dim == 6 ? 3 : 2;
  Quad rolling = 0;
  for (int k = plain; k < p.dim; ++k) rolling += mobility(begin + k);
  if (rolling > 0) return root((p.dim - plain) * mobility(begin) / rolling);
  const double most = p.dim == 6 ? std::max(p.mu_r[c], p.mu_spin[c]) : p.mu_r[c];
  return most > 0 ? static_cast<Quad>(most) : 1;
}

}  // namespace

IndependentCheck independent_check(const ContactProblem& p, const Vector& given) {
  IndependentCheck check;
  if (given.size() != p.num_rows() || !given.allFinite()) return check;
  const bool by_bodies = p.has_velocities() && is_diagonal(p.A);
  if (!by_bodies && !p.has_delassus()) return check;
  const int d = p.dim;
  const std::size_t rows = to_size(p.num_rows());
  // Physical impulses s / r and velocities u / r. Rolling rows: moments over the lever, and angular
  // velocities times it.
  Values r(rows, 1), levers(rows, 1), s(rows);
  for (std::size_t i = 0; i < rows; ++i) {
    if (p.row_scale.size() > 0) r[i] = static_cast<Quad>(p.row_scale[static_cast<Eigen::Index>(i)]);
  }
  std::vector<std::vector<BoundedRows>> bounds(to_size(p.num_contacts()));
  for (int c = 0; c < p.num_contacts(); ++c) {
    const std::size_t n = to_size(c * d);
    if (p.rolls()) {
      const Quad arm = lever(p, c, r, by_bodies);
      for (int k = d == 6 ? 3 : 2; k < d; ++k) levers[n + to_size(k)] = arm;
    }
    bounds[to_size(c)] = bounded_rows(p, c);
    for (BoundedRows& bound : bounds[to_size(c)]) {
      const std::size_t row = n + to_size(bound.first);
      bound.coefficient *= r[n] / (r[row] * levers[row]);
    }
    for (std::size_t i = n; i < n + to_size(d); ++i) {
      s[i] = static_cast<Quad>(given[static_cast<Eigen::Index>(i)]) / (r[i] * levers[i]);
    }
    to_cone(&s[n], bounds[to_size(c)]);
  }
  // The product in the problem's variables, then everything in those of s.
  Values scaled(rows), u(rows), b(rows);
  for (std::size_t i = 0; i < rows; ++i) scaled[i] = s[i] * r[i] * levers[i];
  const Values moved = product(p, scaled, by_bodies);
  Quad energy = 0, free_energy = 0, dissipation = 0, gap = 0, approach = 0, map = 0, size = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    b[i] = static_cast<Quad>(p.u_free[static_cast<Eigen::Index>(i)]) / r[i] * levers[i];
    u[i] = moved[i] / r[i] * levers[i] + b[i];
    energy += scaled[i] * moved[i] / 2;
  }
  for (int c = 0; c < p.num_contacts(); ++c) {
    const std::size_t n = to_size(c * d);
    const std::vector<BoundedRows>& bounded = bounds[to_size(c)];
    const Quad rho = 1 / (diagonal(p, c * d, by_bodies) * r[n] * r[n]);
    Quad speed = 0, power = 0;
    for (const auto& [first, count, mu] : bounded) {
      speed += mu * length(&u[n + to_size(first)], count);
    }
    for (std::size_t i = n + 1; i < n + to_size(d); ++i) power += s[i] * u[i];
    const Quad friction = s[n] * speed;
    dissipation += friction;
    gap += std::max(friction + power, Quad{0}) + s[n] * magnitude(u[n]);
    if (u[n] < 0) approach += rho * u[n] * u[n] / 2;
    if (b[n] < 0) free_energy += rho * b[n] * b[n] / 2;
    Quad foot[6];
    for (int k = 0; k < d; ++k) {
      foot[k] = s[n + to_size(k)] - rho * (u[n + to_size(k)] + (k == 0 ? speed : 0));
    }
    for (int k = 0; k < d; ++k) size += foot[k] * foot[k] / (2 * rho);
    to_cone(foot, bounded);
    for (int k = 0; k < d; ++k) {
      const Quad miss = s[n + to_size(k)] - foot[k];
      map += miss * miss / (2 * rho);
    }
  }
  if (map <= kRounding * size) map = 0;
  const Quad scale = std::max(dissipation, std::max(energy, free_energy) / 10);
  check.epsilon = static_cast<double>(quotient(gap + approach, scale));
  check.eta = static_cast<double>(root(quotient(map, scale)));
  check.guarded = std::isnan(check.epsilon) || std::isnan(check.eta)
                      ? kNaN
                      : std::max(check.epsilon, check.eta);
  check.s.resize(p.num_rows());
  check.u.resize(p.num_rows());
  for (std::size_t i = 0; i < rows; ++i) {
    check.s[static_cast<Eigen::Index>(i)] = static_cast<double>(scaled[i]);
    check.u[static_cast<Eigen::Index>(i)] = static_cast<double>(u[i] * r[i] / levers[i]);
  }
  return check;
}

}  // namespace bipot
