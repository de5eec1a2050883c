#include "bench/measure/independent_check.h"

#include <cmath>
#include <limits>
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

/// The nearest point of the cone |x_t| <= mu x_n: x itself, the apex, or the foot on the edge.
void to_cone(Quad* x, int dim, Quad mu) {
  const Quad slip = length(x + 1, dim - 1);
  if (x[0] >= 0 && slip <= mu * x[0]) return;
  const Quad along = (x[0] + mu * slip) / (1 + mu * mu);
  if (!(along > 0)) {
    for (int k = 0; k < dim; ++k) x[k] = 0;
    return;
  }
  x[0] = along;
  for (int k = 1; k < dim; ++k) x[k] *= mu * along / slip;
}

Quad quotient(Quad numerator, Quad denominator) {
  if (numerator == 0) return 0;
  return denominator > 0 ? numerator / denominator : std::numeric_limits<double>::infinity();
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

/// W(c, c) of a normal row, in the problem's variables.
Quad normal_diagonal(const ContactProblem& p, int row, bool by_bodies) {
  if (!by_bodies) return static_cast<Quad>(p.W.coeff(row, row));
  Quad sum = 0;
  for (SparseMatrix::InnerIterator it(p.H, row); it; ++it) {
    const Quad h = static_cast<Quad>(it.value());
    sum += h * h / static_cast<Quad>(p.A.coeff(it.row(), it.row()));
  }
  return sum;
}

}  // namespace

IndependentCheck independent_check(const ContactProblem& p, const Vector& given) {
  IndependentCheck check;
  if (given.size() != p.num_rows() || !given.allFinite() || p.rolls()) return check;
  const bool by_bodies = p.has_velocities() && is_diagonal(p.A);
  if (!by_bodies && !p.has_delassus()) return check;
  const int d = p.dim;
  const std::size_t rows = to_size(p.num_rows());
  Values r(rows, 1), s(rows), mu(to_size(p.num_contacts()), 0);
  for (std::size_t i = 0; i < rows; ++i) {
    const Eigen::Index k = static_cast<Eigen::Index>(i);
    if (p.row_scale.size() > 0) r[i] = static_cast<Quad>(p.row_scale[k]);
    s[i] = static_cast<Quad>(given[k]) / r[i];
  }
  for (int c = 0; c < p.num_contacts(); ++c) {
    const std::size_t n = to_size(c * d);
    if (d > 1) mu[to_size(c)] = static_cast<Quad>(p.mu[c]) * r[n] / r[n + 1];
    to_cone(&s[n], d, mu[to_size(c)]);
  }
  // The product in the problem's variables, then everything in physical ones: u = u' / r.
  Values scaled(rows), u(rows), b(rows);
  for (std::size_t i = 0; i < rows; ++i) scaled[i] = s[i] * r[i];
  const Values moved = product(p, scaled, by_bodies);
  Quad energy = 0, free_energy = 0, dissipation = 0, gap = 0, approach = 0, map = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    b[i] = static_cast<Quad>(p.u_free[static_cast<Eigen::Index>(i)]) / r[i];
    u[i] = moved[i] / r[i] + b[i];
    energy += scaled[i] * moved[i] / 2;
  }
  for (int c = 0; c < p.num_contacts(); ++c) {
    const std::size_t n = to_size(c * d);
    const Quad m = mu[to_size(c)], rho = 1 / (normal_diagonal(p, c * d, by_bodies) * r[n] * r[n]);
    const Quad slip = length(&u[n + (d > 1 ? 1 : 0)], d - 1);
    Quad power = 0;
    for (int k = 1; k < d; ++k) power += s[n + to_size(k)] * u[n + to_size(k)];
    const Quad friction = m * s[n] * slip;
    dissipation += friction;
    gap += std::max(friction + power, Quad{0}) + s[n] * magnitude(u[n]);
    if (u[n] < 0) approach += rho * u[n] * u[n] / 2;
    if (b[n] < 0) free_energy += rho * b[n] * b[n] / 2;
    Quad foot[3] = {0, 0, 0};
    for (int k = 0; k < d; ++k) {
      foot[k] = s[n + to_size(k)] - rho * (u[n + to_size(k)] + (k == 0 ? m * slip : 0));
    }
    to_cone(foot, d, m);
    for (int k = 0; k < d; ++k) {
      const Quad miss = s[n + to_size(k)] - foot[k];
      map += miss * miss / (2 * rho);
    }
  }
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
    check.u[static_cast<Eigen::Index>(i)] = static_cast<double>(u[i] * r[i]);
  }
  return check;
}

}  // namespace bipot
