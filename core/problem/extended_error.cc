#include "core/problem/extended_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace bipot {
namespace {

#if __LDBL_MANT_DIG__ >= 113
using Quadruple = long double;
#else
__extension__ typedef __float128 Quadruple;
#endif

long double root(long double x) { return std::sqrt(x); }

#if __LDBL_MANT_DIG__ < 113
/// A step of Newton from the root in long double doubles its digits.
Quadruple root(Quadruple x) {
  const Quadruple near = std::sqrt(static_cast<long double>(x));
  return near > 0 ? (near + x / near) / 2 : near;
}
#endif

template <class Real>
using Frame = std::array<Real, 3>;  // components beyond d are 0

template <class Real>
Real slip_of(const Frame<Real>& x) {
  return root(x[1] * x[1] + x[2] * x[2]);
}

template <class Real>
Frame<Real> onto_cone(const Frame<Real>& x, Real mu) {
  const Real norm = slip_of(x);
  if (mu * norm <= -x[0]) return {};
  if (norm <= mu * x[0]) return x;
  const Real normal = (x[0] + mu * norm) / (1 + mu * mu), by = mu * normal / norm;
  return {normal, by * x[1], by * x[2]};
}

/// The problem's data, one by one in a wider type.
template <class Real>
class WideProblem {
 public:
  // An assembled W is rounded, which friction multiplies as well: bodies come first.
  explicit WideProblem(const ContactProblem& p)
      : p_(p), by_bodies_(p.has_velocities() && is_diagonal(p.A)) {}

  bool defined() const { return by_bodies_ || p_.has_delassus(); }

  Real row_scale(Eigen::Index row) const {
    return p_.row_scale.size() == 0 ? Real(1) : Real(p_.row_scale[row]);
  }

  /// W x in the problem's variables.
  std::vector<Real> moved(const std::vector<Real>& x) const {
    std::vector<Real> moved(x.size(), Real(0));
    const Eigen::Index rows = p_.num_rows();
    if (!by_bodies_) {
      for (Eigen::Index i = 0; i < rows; ++i) {
        for (SparseRows::InnerIterator it(p_.W, i); it; ++it) {
          moved[to_size(i)] += Real(it.value()) * x[to_size(it.col())];
        }
      }
      return moved;
    }
    const Vector masses = p_.A.diagonal();
    std::vector<Real> v(to_size(masses.size()), Real(0));
    for (Eigen::Index j = 0; j < rows; ++j) {
      if (x[to_size(j)] == 0) continue;
      for (SparseMatrix::InnerIterator it(p_.H, j); it; ++it) {
        v[to_size(it.row())] += Real(it.value()) * x[to_size(j)];
      }
    }
    for (Eigen::Index i = 0; i < masses.size(); ++i) v[to_size(i)] /= Real(masses[i]);
    for (Eigen::Index j = 0; j < rows; ++j) {
      for (SparseMatrix::InnerIterator it(p_.H, j); it; ++it) {
        moved[to_size(j)] += Real(it.value()) * v[to_size(it.row())];
      }
    }
    return moved;
  }

  /// W(row, row), in the problem's variables.
  Real diagonal(Eigen::Index row) const {
    if (!by_bodies_) return Real(p_.W.coeff(row, row));
    Real sum = 0;
    for (SparseMatrix::InnerIterator it(p_.H, row); it; ++it) {
      sum += Real(it.value()) * Real(it.value()) / Real(p_.A.coeff(it.row(), it.row()));
    }
    return sum;
  }

 private:
  const ContactProblem& p_;
  bool by_bodies_;
};

template <class Real>
double guarded_error(const ContactProblem& p, const Eigen::Ref<const Vector>& s,
                     const ErrorShare& share) {
  const WideProblem<Real> wide(p);
  if (!wide.defined()) return kNaN;
  const int d = p.dim;
  std::vector<Real> x(to_size(s.size())), mu(to_size(p.num_contacts()), Real(0));
  for (int c = 0; c < p.num_contacts(); ++c) {
    const Eigen::Index n = static_cast<Eigen::Index>(c) * d;
    if (d > 1) mu[to_size(c)] = Real(p.mu[c]) * wide.row_scale(n) / wide.row_scale(n + 1);
    Frame<Real> given{};
    for (int k = 0; k < d; ++k) given[to_size(k)] = Real(s[n + k]) / wide.row_scale(n + k);
    const Frame<Real> impulse = onto_cone(given, mu[to_size(c)]);
    for (int k = 0; k < d; ++k) x[to_size(n + k)] = impulse[to_size(k)] * wide.row_scale(n + k);
  }
  const std::vector<Real> moved = wide.moved(x);
  Real gap = 0, approach = 0, map = 0, dissipation = 0, free_energy = 0, work = 0;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const Eigen::Index n = static_cast<Eigen::Index>(c) * d;
    const Real r_n = wide.row_scale(n), friction_factor = mu[to_size(c)];
    const Real rho = 1 / (wide.diagonal(n) * r_n * r_n);
    Frame<Real> impulse{}, u{};
    for (int k = 0; k < d; ++k) {
      const std::size_t row = to_size(n + k), at = to_size(k);
      const Real r = wide.row_scale(n + k);
      impulse[at] = x[row] / r;
      u[at] = (moved[row] + Real(p.u_free[n + k])) / r;
      work += x[row] * moved[row];
    }
    const Real free = Real(p.u_free[n]) / r_n, slip = slip_of(u);
    const Real friction = friction_factor * impulse[0] * slip;
    dissipation += friction;
    gap += std::max(friction + impulse[1] * u[1] + impulse[2] * u[2], Real(0));
    gap += impulse[0] * (u[0] < 0 ? -u[0] : u[0]);
    if (u[0] < 0) approach += rho * u[0] * u[0] / 2;
    if (free < 0) free_energy += rho * free * free / 2;
    if (impulse[0] == 0 && u[0] >= 0) continue;  // the law exactly
    u[0] += friction_factor * slip;
    Frame<Real> foot{};
    for (std::size_t k = 0; k < 3; ++k) foot[k] = impulse[k] - rho * u[k];
    foot = onto_cone(foot, friction_factor);
    for (std::size_t k = 0; k < 3; ++k) {
      map += (impulse[k] - foot[k]) * (impulse[k] - foot[k]) / (2 * rho);
    }
  }
  ErrorSums sums;
  sums.friction = static_cast<double>(dissipation);
  sums.gap = static_cast<double>(gap);
  sums.penetration = static_cast<double>(approach);
  sums.natural = static_cast<double>(map);
  sums.moved = static_cast<double>(work);
  sums.free_energy = static_cast<double>(free_energy);
  return error_of(sums, share).guarded();
}

}  // namespace

double extended_guarded_error(const ContactProblem& p, const Eigen::Ref<const Vector>& s,
                              const ErrorShare& share) {
  return guarded_error<long double>(p, s, share);
}

double quadruple_guarded_error(const ContactProblem& p, const Eigen::Ref<const Vector>& s,
                               const ErrorShare& share) {
  return guarded_error<Quadruple>(p, s, share);
}

}  // namespace bipot
