#include "core/problem/extended_error.h"

#include <algorithm>
#include <cmath>

#include "core/problem/contact_error.h"

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

}  // namespace

double extended_guarded_error(const ContactProblem& p, const Eigen::Ref<const Vector>& s) {
  // An assembled W is rounded, which friction multiplies as well: bodies come first.
  const bool given = !p.has_velocities() || !is_diagonal(p.A);
  if (given && !p.has_delassus()) return kNaN;
  const Reals x = s.cast<Real>();
  Reals moved;
  if (given) {
    moved = p.W.cast<Real>() * x;
  } else {
    const Eigen::SparseMatrix<Real> H = p.H.cast<Real>();
    const Vector masses = p.A.diagonal();
    Reals v = H * x;
    for (Eigen::Index i = 0; i < v.size(); ++i) v[i] /= static_cast<Real>(masses[i]);
    moved = H.transpose() * v;
  }
  Reals r = Reals::Ones(x.size());
  for (Eigen::Index i = 0; i < p.row_scale.size(); ++i) r[i] = static_cast<Real>(p.row_scale[i]);
  const int d = p.dim;
  Real power = 0, approach = 0, map = 0, dissipation = 0, free_energy = 0;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const Eigen::Index n = static_cast<Eigen::Index>(c) * d;
    Real w_nn = 0;
    if (given) {
      w_nn = static_cast<Real>(p.W.coeff(n, n));
    } else {
      for (SparseMatrix::InnerIterator it(p.H, n); it; ++it) {
        const Real h = static_cast<Real>(it.value());
        w_nn += h * h / static_cast<Real>(p.A.coeff(it.row(), it.row()));
      }
    }
    const Real rho = 1 / (w_nn * r[n] * r[n]);
    const Real mu = d == 1 ? 0 : static_cast<Real>(p.mu[c]) * r[n] / r[n + 1];
    Frame impulse = Frame::Zero(), free = Frame::Zero(), u = Frame::Zero();
    for (int k = 0; k < d; ++k) {
      impulse[k] = x[n + k] / r[n + k];
      free[k] = static_cast<Real>(p.u_free[n + k]) / r[n + k];
      u[k] = moved[n + k] / r[n + k] + free[k];
    }
    const Real slip = u.tail<2>().norm();
    const Real friction = mu * impulse[0] * slip;
    dissipation += friction;
    power += std::max<Real>(friction + impulse.tail<2>().dot(u.tail<2>()), 0);
    power += impulse[0] * std::abs(u[0]);
    if (u[0] < 0) approach += rho * u[0] * u[0] / 2;
    if (free[0] < 0) free_energy += rho * free[0] * free[0] / 2;
    u[0] += mu * slip;
    map += (impulse - onto_cone(impulse - rho * u, mu)).squaredNorm() / (2 * rho);
  }
  const Real scale =
      std::max(dissipation, static_cast<Real>(kTheta) * std::max(x.dot(moved) / 2, free_energy));
  const auto over = [scale](Real numerator) {
    if (numerator == 0) return 0.0;
    return scale > 0 ? static_cast<double>(numerator / scale) : kInfinity;
  };
  return std::max(over(power + approach), std::sqrt(over(map)));
}

}  // namespace bipot
