#include "core/criterion/extended_error.h"

#include <cmath>
#include <functional>
#include <vector>

#include "core/base/parallel.h"
#include "core/criterion/error_terms.h"
#include "core/criterion/rounding_bound.h"
#include "core/problem/delassus.h"

namespace bipot {
namespace {

/// A row of W x, and the diagonal entry of W; in the problem's variables.
template <class Real>
struct WideRow {
  Real moved = 0, diagonal = 0;
};

/// Rows of W x through the bodies.
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

/// Contact c of a stacked vector, or zeros if that is empty.
template <class Real, int D>
FrameVector<Real, D> wide(const Eigen::Ref<const Vector>& x, int c) {
  FrameVector<Real, D> v{};
  for (int k = 0; k < D && x.size() > 0; ++k) v[k] = Real(x[c * D + k]);
  return v;
}

/// s on the cones, in the problem's variables.
template <ContactRows D, class Real>
std::vector<Real> projected(const ContactProblem& p, const Eigen::Ref<const Vector>& s,
                            const Vector& arms, int threads) {
  const bool scaled = p.row_scale.size() != 0;
  std::vector<Real> x(to_size(s.size()));
  run_pieces(threads, p.num_contacts(), [&](int begin, int end) {
    for (int c = begin; c < end; ++c) {
      const Real arm = D.rolls ? arms[c] : 1;
      const auto on_cone =
          times_arm<D>(physical_projection(scaled, times_arm<D>(wide<Real, D>(s, c), Real(1 / arm)),
                                           wide<Real, D>(p.row_scale, c),
                                           over_arm(as_number<Real>(friction_of<D>(p, c)), arm)),
                       arm);
      for (int k = 0; k < D; ++k) x[to_size(c * D + k)] = on_cone[k];
    }
  });
  return x;
}

/// Gives a row of W x. It is called through a pointer: the terms are then compiled once.
template <class Real>
using WideProduct = std::function<WideRow<Real>(Eigen::Index row, bool diagonal)>;

/// Sums over the contacts begin .. end - 1. x on the cones.
template <ContactRows D, class Real>
ErrorSumsOf<Real> sums_of(const ContactProblem& p, const std::vector<Real>& x, const Vector& arms,
                          const WideProduct<Real>& product, int begin, int end) {
  const bool scaled = p.row_scale.size() != 0;
  ErrorSumsOf<Real> sums;
  for (int c = begin; c < end; ++c) {
    const FrameVector<Real, D> b = wide<Real, D>(p.u_free, c), r = wide<Real, D>(p.row_scale, c);
    FrameVector<Real, D> s, u;
    Real w_nn = 0, free = b[0];
    for (int k = 0; k < D; ++k) {
      const int row = c * D + k;
      const WideRow<Real> made = product(row, k == 0);
      s[k] = x[to_size(row)];
      u[k] = made.moved + b[k];
      if (k == 0) w_nn = made.diagonal;
    }
    if (scaled) {
      w_nn = r[0] * r[0] * w_nn;
      free = free / r[0];
    }
    const Real rho_nn = 1 / w_nn;
    const Real arm = D.rolls ? arms[c] : 1;
    const auto contact = physical_contact(
        scaled, times_arm<D>(s, Real(1 / arm)), times_arm<D>(u, arm), times_arm<D>(b, arm), r,
        over_arm(as_number<Real>(friction_of<D>(p, c)), arm), w_nn, rho_nn);
    add_law_terms(contact, law_terms(contact), sums);
    sums.free_energy += approach_energy(rho_nn, free);
  }
  return sums;
}

/// Sums over all contacts, in pieces.
template <ContactRows D, class Real>
ErrorSums sums_of(const ContactProblem& p, const std::vector<Real>& x, const Vector& arms,
                  const WideProduct<Real>& product, int threads) {
  return in_double(join_pieces(
      threads, p.num_contacts(), ErrorSumsOf<Real>(),
      [&](int begin, int end) { return sums_of<D>(p, x, arms, product, begin, end); },
      [](ErrorSumsOf<Real>& all, const ErrorSumsOf<Real>& piece) { all += piece; }));
}

template <class Real>
double guarded_error(const ContactProblem& p, const Eigen::Ref<const Vector>& s,
                     const ErrorShare& share, int threads) {
  // Bodies come first, because an assembled W is rounded, and friction multiplies this rounding.
  const bool by_bodies = p.has_velocities() && is_diagonal(p.A);
  if (!by_bodies && !p.has_delassus()) return kNaN;
  return dispatch_rows(p, [&](auto d) {
    constexpr ContactRows D = d();
    const Vector arms = D.rolls ? rolling_arms(p, DelassusOperator(p).diagonal()) : Vector();
    const std::vector<Real> x = projected<D, Real>(p, s, arms, threads);
    const WideProduct<Real> product =
        by_bodies ? WideProduct<Real>(BodyProduct<Real>(p, x)) : DelassusProduct<Real>(p, x);
    return error_of(sums_of<D>(p, x, arms, product, threads), share).guarded();
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

double accurate_guarded_error(const ContactProblem& p, const Eigen::Ref<const Vector>& s,
                              const ContactError& error) {
  const RoundedSums sums = rounded_sums(p, s);
  const auto hides = [&](Precision precision, double figure) {
    return !(rounding_bound(sums, p.num_contacts(), precision).guarded() <= figure);
  };
  double figure = error.guarded();
  if (hides(Precision::kDouble, figure)) figure = extended_guarded_error(p, s);
  if (hides(Precision::kExtended, figure)) figure = quadruple_guarded_error(p, s);
  return std::isnan(figure) ? error.guarded() : figure;  // without W and with a general A
}

}  // namespace bipot
