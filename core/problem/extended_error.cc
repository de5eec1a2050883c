#include "core/problem/extended_error.h"

#include <algorithm>
#include <cmath>

namespace bipot {
namespace {

using Real = long double;
using Reals = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
using Frame = Eigen::Matrix<Real, 3, 1>;  // components beyond d are 0

Frame onto_cone(const Frame& x, Real mu) {
  const Real norm = x.tail<2>().norm();
  if (mu * norm <= -x[0]) return Frame::Zero();
  if (norm <= mu * x[0]) return x;
  Frame foot = x;
  foot[0] = (x[0] + mu * norm) / (1 + mu * mu);
  foot.tail<2>() *= mu * foot[0] / norm;
  return foot;
}

/// W x in the problem's variables.
Reals moved_by(const ContactProblem& p, const Reals& x, bool by_bodies) {
  Reals moved = Reals::Zero(x.size());
  if (!by_bodies) {
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      for (SparseRows::InnerIterator it(p.W, i); it; ++it) {
        moved[i] += static_cast<Real>(it.value()) * x[it.col()];
      }
    }
    return moved;
  }
  const Vector masses = p.A.diagonal();
  Reals v = Reals::Zero(masses.size());
  for (Eigen::Index j = 0; j < x.size(); ++j) {
    if (x[j] == 0) continue;
    for (SparseMatrix::InnerIterator it(p.H, j); it; ++it) {
      v[it.row()] += static_cast<Real>(it.value()) * x[j];
    }
  }
  for (Eigen::Index i = 0; i < v.size(); ++i) v[i] /= static_cast<Real>(masses[i]);
  for (Eigen::Index j = 0; j < x.size(); ++j) {
    for (SparseMatrix::InnerIterator it(p.H, j); it; ++it) {
      moved[j] += static_cast<Real>(it.value()) * v[it.row()];
    }
  }
  return moved;
}

/// W(row, row), in the problem's variables.
Real diagonal_of(const ContactProblem& p, Eigen::Index row, bool by_bodies) {
  if (!by_bodies) return static_cast<Real>(p.W.coeff(row, row));
  Real sum = 0;
  for (SparseMatrix::InnerIterator it(p.H, row); it; ++it) {
    const Real h = static_cast<Real>(it.value());
    sum += h * h / static_cast<Real>(p.A.coeff(it.row(), it.row()));
  }
  return sum;
}

}  // namespace

double extended_guarded_error(const ContactProblem& p, const Eigen::Ref<const Vector>& s,
                              const ErrorShare& share) {
  // An assembled W is rounded, which friction multiplies as well: bodies come first.
  const bool by_bodies = p.has_velocities() && is_diagonal(p.A);
  if (!by_bodies && !p.has_delassus()) return kNaN;
  const int d = p.dim;
  Reals r = Reals::Ones(s.size()), x(s.size()), mu = Reals::Zero(p.num_contacts());
  for (Eigen::Index i = 0; i < p.row_scale.size(); ++i) r[i] = static_cast<Real>(p.row_scale[i]);
  for (int c = 0; c < p.num_contacts(); ++c) {
    const Eigen::Index n = static_cast<Eigen::Index>(c) * d;
    if (d > 1) mu[c] = static_cast<Real>(p.mu[c]) * r[n] / r[n + 1];
    Frame given = Frame::Zero();
    for (int k = 0; k < d; ++k) given[k] = static_cast<Real>(s[n + k]) / r[n + k];
    const Frame impulse = onto_cone(given, mu[c]);
    for (int k = 0; k < d; ++k) x[n + k] = impulse[k] * r[n + k];
  }
  const Reals moved = moved_by(p, x, by_bodies);
  Real gap = 0, approach = 0, map = 0, dissipation = 0, free_energy = 0;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const Eigen::Index n = static_cast<Eigen::Index>(c) * d;
    const Real rho = 1 / (diagonal_of(p, n, by_bodies) * r[n] * r[n]);
    Frame impulse = Frame::Zero(), free = Frame::Zero(), u = Frame::Zero();
    for (int k = 0; k < d; ++k) {
      impulse[k] = x[n + k] / r[n + k];
      free[k] = static_cast<Real>(p.u_free[n + k]) / r[n + k];
      u[k] = moved[n + k] / r[n + k] + free[k];
    }
    const Real slip = u.tail<2>().norm();
    const Real friction = mu[c] * impulse[0] * slip;
    dissipation += friction;
    gap += std::max<Real>(friction + impulse.tail<2>().dot(u.tail<2>()), 0);
    gap += impulse[0] * std::abs(u[0]);
    if (u[0] < 0) approach += rho * u[0] * u[0] / 2;
    if (free[0] < 0) free_energy += rho * free[0] * free[0] / 2;
    if (impulse[0] == 0 && u[0] >= 0) continue;  // the law exactly
    u[0] += mu[c] * slip;
    map += (impulse - onto_cone(impulse - rho * u, mu[c])).squaredNorm() / (2 * rho);
  }
  ErrorSums sums;
  sums.friction = static_cast<double>(dissipation);
  sums.gap = static_cast<double>(gap);
  sums.penetration = static_cast<double>(approach);
  sums.natural = static_cast<double>(map);
  sums.moved = static_cast<double>(x.dot(moved));
  sums.free_energy = static_cast<double>(free_energy);
  return error_of(sums, share).guarded();
}

}  // namespace bipot
