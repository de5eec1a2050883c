#include "core/criterion/rounding_bound.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/parallel.h"
#include "core/criterion/error_terms.h"

namespace bipot {
namespace {

// Roundings of a product through H or W beside those of its sums: the projection of s (at most 10 of each
// component), the inverse mass, the division by row_scale, the addition of u_free.
constexpr double kOfAProduct = 16;
// The packed form of disks may be off H by 16 epsilons = 32 roundings an entry, an arm counts twice in a product.
constexpr double kOfPacking = 100;
// Of the terms of a contact: its impulse's projection, products, square roots, weights of a row of few entries.
constexpr double kOfATerm = 40;
// Products of roundings.
constexpr double kSecondOrder = 1.01;

/// A row of u = W s + u_free, in the problem's variables.
struct RoundedRow {
  double u = 0, error = 0;  // error in units of roundoff
  double w = 0;             // diagonal of W
  double entries = 0;       // that w is added up from
};

/// Rows by way of the bodies.
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

/// Rows by W.
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

/// One contact in physical variables: impulse, velocity and its error, free velocity.
template <int D>
struct RoundedContact {
  Local<D> x, u, error, b;
  double mu = 0, w_nn = 0;
  double term = 0;  ///< rounding of its terms, relative
};

template <int D>
void add_contact(const RoundedContact<D>& c, RoundedSums& e) {
  const double mu = c.mu, term = c.term, rho = 1 / c.w_nn;
  const double normal = c.x[0], opening = c.u[0], error = c.error[0];
  const double slip = tangential_norm<D>(c.u), slip_error = tangential_norm<D>(c.error);
  const double friction = mu * normal * slip, closing = positive_part(-opening);
  double tangential = 0;
  for (int k = 1; k < D; ++k) tangential += c.x[k] * c.u[k];
  e.value.friction += friction;
  e.value.gap += positive_part(friction + tangential) + normal * std::abs(opening);
  e.value.penetration += 0.5 * rho * closing * closing;
  e.friction += mu * normal * slip_error + term * friction;
  // |s_t| <= mu s_n
  e.gap += 2 * mu * normal * slip_error + normal * error +
           term * (2 * friction + normal * std::abs(opening));
  if (opening < error) {
    e.gap += rho * (closing + error) * error + term * rho * closing * closing;
  }
  e.value.moved += c.x.dot(c.u - c.b);
  e.moved += c.x.cwiseAbs().dot(c.error + term * (c.u.cwiseAbs() + c.b.cwiseAbs()));
  if (c.b[0] < 0) {
    e.value.free_energy += 0.5 * rho * c.b[0] * c.b[0];
    e.free_energy += term * rho * c.b[0] * c.b[0];
  }
  double miss = 0;
  if (normal == 0 && opening >= 0) {
    // The law exactly, unless the contact closes within its error.
    miss = rho * std::max(error - opening, 0.0);
  } else {
    const auto length = [](double x, double y) { return std::sqrt(x * x + y * y); };
    const Local<D> hat = de_saxce_velocity<D>(c.u, mu);
    miss = rho * length(error + mu * slip_error, slip_error) +
           term * (c.x.norm() + rho * length(hat[0], slip));
    e.value.natural +=
        0.5 * c.w_nn * (c.x - project_coulomb_cone<D>(c.x - rho * hat, mu)).squaredNorm();
  }
  e.natural += 0.5 * c.w_nn * miss * miss;
}

/// A quotient's bound: (a ± da) / (m ± dm).
double of_quotient(double a, double da, double m, double dm) {
  if (da == 0 && a == 0) return 0;
  if (!(m > dm)) return kInfinity;
  return (da + a / m * dm) / (m - dm);
}

/// Figures and what rounding may add to them.
struct RoundedError {
  double epsilon = 0, eta = 0;
  RoundingBound bound;
};

RoundedError error_with_bound(const RoundedSums& own, const ErrorSums& others, double adding,
                              double factor) {
  ErrorSums whole = own.value;
  whole += others;
  const ContactError figures = error_of(whole);
  const double m = std::max(figures.friction_power, kTheta * figures.energy);
  const double dm =
      std::max(own.friction, kTheta * std::max(0.5 * own.moved, own.free_energy)) + adding * m;
  const double violation = whole.gap + whole.penetration;
  RoundedError e{factor * figures.epsilon, factor * figures.eta, {}};
  e.bound.epsilon =
      kSecondOrder * factor * of_quotient(violation, own.gap + adding * violation, m, dm);
  if (own.natural > 0 || whole.natural > 0) {
    e.bound.eta =
        m > dm ? kSecondOrder * factor *
                     (std::sqrt(own.natural / (m - dm)) + figures.eta * (dm / (m - dm) + adding))
               : kInfinity;
  }
  return e;
}

double unit_of(Precision precision) {
  return std::ldexp(1.0, precision == Precision::kDouble     ? -53
                         : precision == Precision::kExtended ? -64
                                                             : -113);
}

/// In double precision.
template <int D, class Rows>
RoundedSums sums_of(const ContactProblem& p, const Eigen::Ref<const Vector>& s, const Rows& rows,
                    int begin, int end) {
  const double unit = unit_of(Precision::kDouble);
  RoundedSums sums;
  for (int c = begin; c < end; ++c) {
    RoundedContact<D> contact;
    for (int k = 0; k < D; ++k) {
      const int row = c * D + k;
      const double r = physical_row_scale(p, row);
      const RoundedRow velocity = rows(row);
      contact.x[k] = s[row] / r;
      contact.b[k] = p.u_free[row] / r;
      contact.u[k] = velocity.u / r;
      contact.error[k] = unit * (velocity.error / r + 4 * std::abs(contact.u[k]));
      if (k > 0) continue;
      contact.w_nn = velocity.w * r * r;
      contact.term = unit * (kOfATerm + 2 * velocity.entries);
    }
    if constexpr (D > 1) contact.mu = physical_mu(p, c);
    add_contact(contact, sums);
  }
  return sums;
}

/// Of all contacts, in pieces.
template <class Rows>
RoundedSums sums_of(const ContactProblem& p, const Eigen::Ref<const Vector>& s, const Rows& rows,
                    int threads) {
  std::vector<RoundedSums> pieces(to_size((p.num_contacts() + kPieceItems - 1) / kPieceItems));
  dispatch_dim(p.dim, [&](auto d) {
    run_pieces(threads, p.num_contacts(), [&](int begin, int end) {
      pieces[to_size(begin / kPieceItems)] = sums_of<d()>(p, s, rows, begin, end);
    });
  });
  RoundedSums sums;
  for (const RoundedSums& piece : pieces) sums += piece;
  return sums;
}

/// The errors in another precision, or a little more: all are at most linear in the roundoff, the
/// natural map's a square.
RoundedSums in_precision(RoundedSums sums, Precision precision) {
  const double ratio = unit_of(precision) / unit_of(Precision::kDouble);
  for (double* error : {&sums.gap, &sums.friction, &sums.moved, &sums.free_energy}) {
    *error *= ratio;
  }
  sums.natural *= ratio * ratio;
  return sums;
}

}  // namespace

RoundedSums& RoundedSums::operator+=(const RoundedSums& more) {
  value += more.value;
  gap += more.gap;
  friction += more.friction;
  moved += more.moved;
  free_energy += more.free_energy;
  natural += more.natural;
  return *this;
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
  const double packing = p.dim == 3 ? 0 : kOfPacking;
  return sums_of(p, s, RoundedBodyRows(p, pushed, kOfAProduct + packing), threads);
}

RoundedSums rounded_sums(const ContactProblem& p, const Eigen::Ref<const Vector>& s, int threads) {
  if (p.has_velocities() && is_diagonal(p.A)) {
    return rounded_sums(p, s, rounded_momentum(p, s), threads);
  }
  if (p.has_delassus()) return sums_of(p, s, RoundedDelassusRows(p, s), threads);
  RoundedSums undefined;
  undefined.gap = undefined.friction = undefined.natural = kInfinity;
  return undefined;
}

RoundingBound rounding_bound(const ContactProblem& p, const Eigen::Ref<const Vector>& s,
                             Precision precision, const ErrorShare& share) {
  return rounding_bound(rounded_sums(p, s), p.num_contacts(), precision, share);
}

RoundingBound rounding_bound(const RoundedSums& sums, int contacts, Precision precision,
                             const ErrorShare& share) {
  // Of the sums over the contacts, and of a result that is handed on in double.
  const double adding = unit_of(precision) * (contacts + kOfATerm) + std::ldexp(1.0, -50);
  const RoundedSums own_sums = in_precision(sums, precision);
  const RoundedError whole = error_with_bound(own_sums, share.others, adding, 1 / share.share);
  if (!(share.alone > 0)) return whole.bound;
  // The smaller of two figures counts: at most the smaller of what both may be.
  const RoundedError own = error_with_bound(own_sums, {}, adding, share.alone);
  const auto of_smaller = [](double a, double da, double b, double db) {
    return std::min(a + da, b + db) - std::min(a, b);
  };
  return {of_smaller(whole.epsilon, whole.bound.epsilon, own.epsilon, own.bound.epsilon),
          of_smaller(whole.eta, whole.bound.eta, own.eta, own.bound.eta)};
}

}  // namespace bipot
