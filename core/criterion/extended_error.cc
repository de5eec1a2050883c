#include "core/criterion/extended_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/base/parallel.h"
#include "core/problem/coulomb_cone.h"

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

template <class Real, int D>
using Frame = std::array<Real, to_size(D)>;

template <class Real, std::size_t D>
Real slip_of(const std::array<Real, D>& x) {
  if constexpr (D == 1) return Real(0);
  if constexpr (D == 2) return x[1] < 0 ? -x[1] : x[1];
  if constexpr (D == 3) return root(x[1] * x[1] + x[2] * x[2]);
}

template <class Real, std::size_t D>
std::array<Real, D> onto_cone(const std::array<Real, D>& x, Real mu) {
  const Real norm = slip_of(x);
  if (mu * norm <= -x[0]) return {};
  if (norm <= mu * x[0]) return x;
  std::array<Real, D> foot{(x[0] + mu * norm) / (1 + mu * mu)};
  for (std::size_t k = 1; k < D; ++k) foot[k] = mu * foot[0] / norm * x[k];
  return foot;
}

/// A row of W x, and W's diagonal there; in the problem's variables.
template <class Real>
struct WideRow {
  Real moved = 0, diagonal = 0;
};

/// Rows of W x by way of the bodies.
template <class Real>
class BodyProduct {
 public:
  BodyProduct(const ContactProblem& p, const std::vector<Real>& x)
      : H_(p.H), dofs_(to_size(p.num_dofs())) {
    for (Eigen::Index row = 0; row < p.num_rows(); ++row) {
      if (x[to_size(row)] == 0) continue;
      for (SparseMatrix::InnerIterator it(H_, row); it; ++it) {
        dofs_[to_size(it.row())].velocity += Real(it.value()) * x[to_size(row)];
      }
    }
    const Vector mass = p.A.diagonal();
    for (int k = 0; k < p.num_dofs(); ++k) {
      Dof& dof = dofs_[to_size(k)];
      dof.inverse_mass = 1 / Real(mass[k]);
      dof.velocity *= dof.inverse_mass;
    }
  }

  WideRow<Real> operator()(Eigen::Index row, bool diagonal) const {
    WideRow<Real> out;
    for (SparseMatrix::InnerIterator it(H_, row); it; ++it) {
      const Real h = it.value();
      const Dof& dof = dofs_[to_size(it.row())];
      out.moved += h * dof.velocity;
      if (diagonal) out.diagonal += h * h * dof.inverse_mass;
    }
    return out;
  }

 private:
  struct Dof {
    Real velocity = 0, inverse_mass = 0;
  };
  const SparseMatrix& H_;
  std::vector<Dof> dofs_;
};

/// Rows of W x by W.
template <class Real>
class DelassusProduct {
 public:
  DelassusProduct(const ContactProblem& p, const std::vector<Real>& x) : W_(p.W), x_(x) {}

  WideRow<Real> operator()(Eigen::Index row, bool) const {
    WideRow<Real> out;
    for (SparseRows::InnerIterator it(W_, row); it; ++it) {
      out.moved += Real(it.value()) * x_[to_size(it.col())];
      if (it.col() == row) out.diagonal += Real(it.value());
    }
    return out;
  }

 private:
  const SparseRows& W_;
  const std::vector<Real>& x_;
};

/// x / r and x r, r the physical scale of the row; divisions in a wide type are slow.
template <class Real>
Real unscaled(const ContactProblem& p, Eigen::Index row, const Real& x) {
  return p.row_scale.size() == 0 ? x : x / Real(p.row_scale[row]);
}
template <class Real>
Real scaled(const ContactProblem& p, Eigen::Index row, const Real& x) {
  return p.row_scale.size() == 0 ? x : x * Real(p.row_scale[row]);
}

template <class Real>
Real physical_friction(const ContactProblem& p, int contact) {
  if (p.dim == 1) return Real(0);
  const Eigen::Index n = static_cast<Eigen::Index>(contact) * p.dim;
  return unscaled(p, n + 1, scaled(p, n, Real(p.mu[contact])));
}

/// s on the cones, in the problem's variables.
template <int D, class Real>
std::vector<Real> projected(const ContactProblem& p, const Eigen::Ref<const Vector>& s,
                            int threads) {
  std::vector<Real> x(to_size(s.size()));
  run_pieces(threads, p.num_contacts(), [&](int begin, int end) {
    for (int c = begin; c < end; ++c) {
      const Eigen::Index n = static_cast<Eigen::Index>(c) * D;
      Frame<Real, D> given{};
      for (int k = 0; k < D; ++k) given[to_size(k)] = unscaled(p, n + k, Real(s[n + k]));
      const Frame<Real, D> impulse = onto_cone(given, physical_friction<Real>(p, c));
      for (int k = 0; k < D; ++k) x[to_size(n + k)] = scaled(p, n + k, impulse[to_size(k)]);
    }
  });
  return x;
}

template <class Real>
struct WideSums {
  Real gap = 0, approach = 0, map = 0, dissipation = 0, free_energy = 0, work = 0;
};

/// Of the contacts begin .. end - 1. x on the cones; `product`: rows of W x.
template <int D, class Real, class Product>
WideSums<Real> sums_of(const ContactProblem& p, const std::vector<Real>& x, const Product& product,
                       int begin, int end) {
  Real gap = 0, approach = 0, map = 0, dissipation = 0, free_energy = 0, work = 0;
  for (int c = begin; c < end; ++c) {
    const Eigen::Index n = static_cast<Eigen::Index>(c) * D;
    const Real mu = physical_friction<Real>(p, c);
    Real w_nn = 0, tangential = 0;
    Frame<Real, D> impulse{}, u{};
    for (int k = 0; k < D; ++k) {
      const std::size_t row = to_size(n + k), at = to_size(k);
      const WideRow<Real> made = product(n + k, k == 0);
      if (k == 0) w_nn = scaled(p, n, scaled(p, n, made.diagonal));
      impulse[at] = unscaled(p, n + k, x[row]);
      u[at] = unscaled(p, n + k, made.moved + Real(p.u_free[n + k]));
      if (k > 0) tangential += impulse[at] * u[at];
      work += x[row] * made.moved;
    }
    const Real free = unscaled(p, n, Real(p.u_free[n])), slip = slip_of(u), rho = 1 / w_nn;
    const Real friction = mu * impulse[0] * slip;
    dissipation += friction;
    gap += std::max(friction + tangential, Real(0));
    gap += impulse[0] * (u[0] < 0 ? -u[0] : u[0]);
    if (u[0] < 0) approach += rho * u[0] * u[0] / 2;
    if (free < 0) free_energy += rho * free * free / 2;
    if (impulse[0] == 0 && u[0] >= 0) continue;  // the law exactly
    u[0] += mu * slip;
    Frame<Real, D> foot{};
    for (std::size_t k = 0; k < D; ++k) foot[k] = impulse[k] - rho * u[k];
    foot = onto_cone(foot, mu);
    Real miss = 0;
    for (std::size_t k = 0; k < D; ++k) miss += (impulse[k] - foot[k]) * (impulse[k] - foot[k]);
    map += miss * w_nn / 2;
  }
  return {gap, approach, map, dissipation, free_energy, work};
}

/// Of all contacts, in pieces.
template <int D, class Real, class Product>
ErrorSums sums_of(const ContactProblem& p, const std::vector<Real>& x, const Product& product,
                  int threads) {
  std::vector<WideSums<Real>> pieces(to_size((p.num_contacts() + kPieceItems - 1) / kPieceItems));
  run_pieces(threads, p.num_contacts(), [&](int begin, int end) {
    pieces[to_size(begin / kPieceItems)] = sums_of<D>(p, x, product, begin, end);
  });
  WideSums<Real> all;
  for (const WideSums<Real>& piece : pieces) {
    all.gap += piece.gap;
    all.approach += piece.approach;
    all.map += piece.map;
    all.dissipation += piece.dissipation;
    all.free_energy += piece.free_energy;
    all.work += piece.work;
  }
  ErrorSums sums;
  sums.friction = static_cast<double>(all.dissipation);
  sums.gap = static_cast<double>(all.gap);
  sums.penetration = static_cast<double>(all.approach);
  sums.natural = static_cast<double>(all.map);
  sums.moved = static_cast<double>(all.work);
  sums.free_energy = static_cast<double>(all.free_energy);
  return sums;
}

template <class Real>
double guarded_error(const ContactProblem& p, const Eigen::Ref<const Vector>& s,
                     const ErrorShare& share, int threads) {
  // An assembled W is rounded, which friction multiplies as well: bodies come first.
  const bool by_bodies = p.has_velocities() && is_diagonal(p.A);
  if (!by_bodies && !p.has_delassus()) return kNaN;
  return dispatch_dim(p.dim, [&](auto d) {
    constexpr int D = d();
    const std::vector<Real> x = projected<D, Real>(p, s, threads);
    const ErrorSums sums = by_bodies ? sums_of<D>(p, x, BodyProduct<Real>(p, x), threads)
                                     : sums_of<D>(p, x, DelassusProduct<Real>(p, x), threads);
    return error_of(sums, share).guarded();
  });
}

}  // namespace

double extended_guarded_error(const ContactProblem& p, const Eigen::Ref<const Vector>& s,
                              const ErrorShare& share, int threads) {
  return guarded_error<long double>(p, s, share, threads);
}

double quadruple_guarded_error(const ContactProblem& p, const Eigen::Ref<const Vector>& s,
                               const ErrorShare& share, int threads) {
  return guarded_error<Quadruple>(p, s, share, threads);
}

}  // namespace bipot
