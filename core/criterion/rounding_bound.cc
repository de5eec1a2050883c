#include "core/criterion/rounding_bound.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "core/base/parallel.h"
#include "core/criterion/error_terms.h"
#include "core/problem/delassus.h"

namespace bipot {
namespace {

// Roundings of a product through H or W beside those of its sums: the projection of s (at most 10
// of each component), the inverse mass, the division by row_scale, the addition of u_free.
constexpr double kOfAProduct = 16;
// The packed form of disks or spheres may differ from H by 16 epsilons = 32 roundings an entry. An
// arm counts twice in a product.
constexpr double kOfPacking = 100;
// Roundings of a component of s by its projection: of one bound, and of the three of rolling.
constexpr double kOfAnImpulse = 10, kOfARollingImpulse = 30;
// Roundings of a diagonal entry of W beside those of its sum.
constexpr double kOfAWeight = 20;
// Roundings of the sums over contacts and of the figures beside those of the additions.
constexpr double kOfAFigure = 40;
// Factor for products of roundings.
constexpr double kSecondOrder = 1.01;

/// A row of u = W s + u_free, in the problem's variables.
struct RoundedRow {
  double u = 0, error = 0;  // error in units of roundoff
  double w = 0;             // diagonal of W
  double entries = 0;       // number of summands of w
};

/// Gives a row of u. It is called through a pointer: the terms are then compiled once.
using RoundedRows = std::function<RoundedRow(Eigen::Index row)>;

/// Rows through the bodies.
class RoundedBodyRows {
 public:
  RoundedBodyRows(const ContactProblem& p, const RoundedMomentum& pushed, double of_product)
      : p_(p), pushed_(pushed), inverse_mass_(p.A.diagonal().cwiseInverse()), own_(of_product) {}

  RoundedRow operator()(Eigen::Index row) const {
    RoundedRow out{p_.u_free[row], 0, 0, 0};
    for (SparseMatrix::InnerIterator it(p_.H, row); it; ++it) ++out.entries;
    for (SparseMatrix::InnerIterator it(p_.H, row); it; ++it) {
      const double h = it.value(), inverse_mass = inverse_mass_[it.row()];
      const double size = inverse_mass * pushed_.size[it.row()];
      out.u += h * (inverse_mass * pushed_.momentum[it.row()]);
      out.error += std::abs(h) * size * (out.entries + own_ + pushed_.count[it.row()]);
      out.w += h * h * inverse_mass;
    }
    return out;
  }

 private:
  const ContactProblem& p_;
  const RoundedMomentum& pushed_;
  const Vector inverse_mass_;
  const double own_;
};

/// Rows through W.
class RoundedDelassusRows {
 public:
  RoundedDelassusRows(const ContactProblem& p, const Eigen::Ref<const Vector>& s) : p_(p), s_(s) {}

  RoundedRow operator()(Eigen::Index row) const {
    RoundedRow out{p_.u_free[row], 0, 0, 0};
    double entries = kOfAProduct, sum = 0;
    for (SparseRows::InnerIterator it(p_.W, row); it; ++it) {
      out.u += it.value() * s_[it.col()];
      sum += std::abs(it.value() * s_[it.col()]);
      if (s_[it.col()] != 0) ++entries;
      if (it.col() == row) out.w += it.value();
    }
    out.error = entries * sum;
    return out;
  }

 private:
  const ContactProblem& p_;
  const Eigen::Ref<const Vector>& s_;
};

/// Error bound of the quotient (a ± da) / (m ± dm).
double of_quotient(double a, double da, double m, double dm) {
  if (da == 0 && a == 0) return 0;
  if (!(m > dm)) return kInfinity;
  return (da + a / m * dm) / (m - dm);
}

/// Figures and the bound on their rounding.
struct RoundedError {
  double epsilon = 0, eta = 0;
  RoundingBound bound;
};

RoundedError error_with_bound(const RoundedSums& own, const ErrorSums& others, double adding,
                              double factor) {
  ErrorSums whole = in_double(own);
  whole += others;
  const ContactError figures = error_of(whole);
  const double m = std::max(figures.friction_power, kTheta * figures.energy);
  const double dm = std::max(own.friction.error,
                             kTheta * std::max(0.5 * own.moved.error, own.free_energy.error)) +
                    adding * m;
  const double violation = whole.gap + whole.penetration;
  const double d_violation = own.gap.error + own.penetration.error + adding * violation;
  RoundedError e{factor * figures.epsilon, factor * figures.eta, {}};
  e.bound.epsilon = kSecondOrder * factor * of_quotient(violation, d_violation, m, dm);
  if (own.natural.error > 0 || whole.natural > 0) {
    e.bound.eta =
        m > dm
            ? kSecondOrder * factor *
                  (std::sqrt(own.natural.error / (m - dm)) + figures.eta * (dm / (m - dm) + adding))
            : kInfinity;
  }
  return e;
}

double unit_of(Precision precision) {
  return std::ldexp(1.0, precision == Precision::kDouble     ? -53
                         : precision == Precision::kExtended ? -64
                                                             : -113);
}

/// Sums over the contacts begin .. end - 1, in double precision.
template <ContactRows D>
RoundedSums sums_of(const ContactProblem& p, const Eigen::Ref<const Vector>& given,
                    const Vector& arms, const RoundedRows& rows, int begin, int end) {
  const bool scaled = p.row_scale.size() != 0;
  constexpr double unit = Rounded::kUnit;
  constexpr double of_impulse = D.rolls ? kOfARollingImpulse : kOfAnImpulse;
  RoundedSums sums;
  for (int c = begin; c < end; ++c) {
    FrameVector<Rounded, D> s, u, b, r;
    Rounded w_nn;
    for (int k = 0; k < D; ++k) {
      const int row = c * D + k;
      const RoundedRow made = rows(row);
      s[k] = {given[row], of_impulse * unit * std::abs(given[row])};
      u[k] = {made.u, unit * (made.error + 4 * std::abs(made.u))};
      b[k] = p.u_free[row];
      if (scaled) r[k] = p.row_scale[row];
      if (k == 0) w_nn = {made.w, unit * (2 * made.entries + kOfAWeight) * made.w};
    }
    if (scaled) w_nn = r[0] * r[0] * w_nn;
    const Rounded rho_nn = 1 / w_nn;
    const Rounded arm = D.rolls ? arms[c] : 1.0;
    const auto contact = physical_contact(
        scaled, times_arm<D>(s, 1 / arm), times_arm<D>(u, arm), times_arm<D>(b, arm), r,
        over_arm(as_number<Rounded>(friction_of<D>(p, c)), arm), w_nn, rho_nn);
    add_law_terms(contact, law_terms(contact), sums);
    sums.free_energy += approach_energy(rho_nn, scaled ? b[0] / r[0] : b[0]);
  }
  return sums;
}

/// Sums over all contacts, in pieces.
RoundedSums sums_of(const ContactProblem& p, const Eigen::Ref<const Vector>& s,
                    const RoundedRows& rows, int threads) {
  const Vector arms = p.rolls() ? rolling_arms(p, DelassusOperator(p).diagonal()) : Vector();
  return dispatch_rows(p, [&](auto d) {
    return join_pieces(
        threads, p.num_contacts(), RoundedSums(),
        [&](int begin, int end) { return sums_of<d()>(p, s, arms, rows, begin, end); },
        [](RoundedSums& all, const RoundedSums& piece) { all += piece; });
  });
}

/// The errors in another precision, or slightly more: all are at most linear in the roundoff,
/// except that of the natural map, a square.
RoundedSums in_precision(RoundedSums sums, Precision precision) {
  const double ratio = unit_of(precision) / Rounded::kUnit;
  for (Rounded* sum :
       {&sums.gap, &sums.penetration, &sums.friction, &sums.moved, &sums.free_energy}) {
    sum->error *= ratio;
  }
  sums.natural.error *= ratio * ratio;
  return sums;
}

}  // namespace

double rounding_floor(const ContactProblem& p, const Eigen::Ref<const Vector>& s,
                      const ContactError& error) {
  double sum = 0;
  if (p.has_velocities() && is_diagonal(p.A)) {
    const RoundedMomentum pushed = rounded_momentum(p, s);
    const Vector masses = p.A.diagonal();
    for (Eigen::Index row = 0; row < p.num_rows(); row += p.dim) {
      for (SparseMatrix::InnerIterator it(p.H, row); it; ++it) {
        sum += s[row] * std::abs(it.value()) * pushed.size[it.row()] / masses[it.row()];
      }
    }
  } else if (p.has_delassus()) {
    for (Eigen::Index row = 0; row < p.num_rows(); row += p.dim) {
      for (SparseRows::InnerIterator it(p.W, row); it; ++it) {
        sum += s[row] * std::abs(it.value() * s[it.col()]);
      }
    }
  }
  const double scale = std::max(error.friction_power, kTheta * error.energy);
  return scale > 0 ? Rounded::kUnit * sum / scale : 0;
}

RoundedMomentum rounded_momentum(const ContactProblem& p, const Eigen::Ref<const Vector>& s) {
  RoundedMomentum pushed;
  for (Vector* sum : {&pushed.momentum, &pushed.size, &pushed.count}) sum->setZero(p.num_dofs());
  for (Eigen::Index j = 0; j < p.num_rows(); ++j) {
    if (s[j] == 0) continue;
    for (SparseMatrix::InnerIterator it(p.H, j); it; ++it) {
      pushed.momentum[it.row()] += it.value() * s[j];
      pushed.size[it.row()] += std::abs(it.value() * s[j]);
      ++pushed.count[it.row()];
    }
  }
  return pushed;
}

RoundedSums rounded_sums(const ContactProblem& p, const Eigen::Ref<const Vector>& s,
                         const RoundedMomentum& pushed, int threads) {
  const RoundedBodyRows rows(p, pushed, kOfAProduct + kOfPacking);
  return sums_of(p, s, std::cref(rows), threads);
}

RoundedSums rounded_sums(const ContactProblem& p, const Eigen::Ref<const Vector>& s, int threads) {
  if (p.has_velocities() && is_diagonal(p.A)) {
    return rounded_sums(p, s, rounded_momentum(p, s), threads);
  }
  if (p.has_delassus()) return sums_of(p, s, RoundedDelassusRows(p, s), threads);
  RoundedSums undefined;
  undefined.gap.error = undefined.friction.error = undefined.natural.error = kInfinity;
  return undefined;
}

RoundingBound rounding_bound(const ContactProblem& p, const Eigen::Ref<const Vector>& s,
                             Precision precision, const ErrorShare& share) {
  return rounding_bound(rounded_sums(p, s), p.num_contacts(), precision, share);
}

RoundingBound rounding_bound(const RoundedSums& sums, int contacts, Precision precision,
                             const ErrorShare& share) {
  // Rounding of the sums over the contacts, and of the result, which is a double.
  const double adding = unit_of(precision) * (contacts + kOfAFigure) + std::ldexp(1.0, -50);
  const RoundedSums own_sums = in_precision(sums, precision);
  const RoundedError whole = error_with_bound(own_sums, share.others, adding, 1 / share.share);
  if (!(share.alone > 0)) return whole.bound;
  // The smaller of two figures counts. It is at most the smaller of their upper bounds.
  const RoundedError own = error_with_bound(own_sums, {}, adding, share.alone);
  const auto of_smaller = [](double a, double da, double b, double db) {
    return std::min(a + da, b + db) - std::min(a, b);
  };
  return {of_smaller(whole.epsilon, whole.bound.epsilon, own.epsilon, own.bound.epsilon),
          of_smaller(whole.eta, whole.bound.eta, own.eta, own.bound.eta)};
}

}  // namespace bipot
