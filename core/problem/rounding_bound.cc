#include "core/problem/rounding_bound.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/problem/error_terms.h"

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

/// u = W s + u_free with the error of each row, in the problem's variables.
struct RoundedVelocity {
  Vector u, error;     // error in units of roundoff
  Vector w;            // diagonal of W
  double longest = 0;  // entries of a row that w is added up from
};

RoundedVelocity by_bodies(const ContactProblem& p, const RoundedMomentum& pushed,
                          double of_product) {
  const Eigen::Index rows = p.num_rows();
  const Vector mass = p.A.diagonal();
  const Vector v = pushed.momentum.cwiseQuotient(mass), size = pushed.size.cwiseQuotient(mass);
  RoundedVelocity out{p.u_free, Vector::Zero(rows), Vector::Zero(rows), 0};
  for (Eigen::Index i = 0; i < rows; ++i) {
    double entries = of_product;
    for (SparseMatrix::InnerIterator it(p.H, i); it; ++it) ++entries;
    out.longest = std::max(out.longest, entries - of_product);
    for (SparseMatrix::InnerIterator it(p.H, i); it; ++it) {
      const double h = it.value();
      out.u[i] += h * v[it.row()];
      out.error[i] += std::abs(h) * size[it.row()] * (entries + pushed.count[it.row()]);
      out.w[i] += h * h / mass[it.row()];
    }
  }
  return out;
}

RoundedVelocity by_delassus(const ContactProblem& p, const Eigen::Ref<const Vector>& s) {
  const Eigen::Index rows = p.num_rows();
  RoundedVelocity out{p.u_free, Vector::Zero(rows), Vector::Zero(rows), 0};
  for (Eigen::Index i = 0; i < rows; ++i) {
    double entries = kOfAProduct, sum = 0;
    for (SparseRows::InnerIterator it(p.W, i); it; ++it) {
      out.u[i] += it.value() * s[it.col()];
      sum += std::abs(it.value() * s[it.col()]);
      if (s[it.col()] != 0) ++entries;
      if (it.col() == i) out.w[i] += it.value();
    }
    out.error[i] = entries * sum;
  }
  return out;
}

/// Adds what one contact has. u and its error physical.
void add_contact(const ContactProblem& p, int contact, const double* x, const double* u,
                 const double* error, const double* b, double w_nn, double term, RoundedSums& e) {
  const int d = p.dim;
  const double mu = d == 1 ? 0 : physical_mu(p, contact), rho = 1 / w_nn;
  double slip = 0, impulse = x[0] * x[0], slip_error = 0, tangential = 0;
  for (int k = 1; k < d; ++k) {
    slip += u[k] * u[k];
    slip_error += error[k] * error[k];
    impulse += x[k] * x[k];
    tangential += x[k] * u[k];
  }
  slip = std::sqrt(slip);
  slip_error = std::sqrt(slip_error);
  impulse = std::sqrt(impulse);
  const double friction = mu * x[0] * slip, closing = positive_part(-u[0]);
  e.value.friction += friction;
  e.value.gap += positive_part(friction + tangential) + x[0] * std::abs(u[0]);
  e.value.penetration += 0.5 * rho * closing * closing;
  e.friction += mu * x[0] * slip_error + term * friction;
  // |s_t| <= mu s_n
  e.gap +=
      2 * mu * x[0] * slip_error + x[0] * error[0] + term * (2 * friction + x[0] * std::abs(u[0]));
  if (u[0] < error[0])
    e.gap += rho * (closing + error[0]) * error[0] + term * rho * closing * closing;
  for (int k = 0; k < d; ++k) {
    e.value.moved += x[k] * (u[k] - b[k]);
    e.moved += std::abs(x[k]) * (error[k] + term * (std::abs(u[k]) + std::abs(b[k])));
  }
  if (b[0] < 0) {
    e.value.free_energy += 0.5 * rho * b[0] * b[0];
    e.free_energy += term * rho * b[0] * b[0];
  }
  double miss = 0;
  if (x[0] == 0 && u[0] >= 0) {
    // The law exactly, unless the contact closes within its error.
    miss = rho * std::max(error[0] - u[0], 0.0);
  } else {
    const double hat = std::hypot(u[0] + mu * slip, slip);
    miss =
        rho * (std::hypot(error[0] + mu * slip_error, slip_error)) + term * (impulse + rho * hat);
    Eigen::Vector3d foot = Eigen::Vector3d::Zero(), from = foot;
    for (int k = 0; k < d; ++k) {
      from[k] = x[k];
      foot[k] = x[k] - rho * (u[k] + (k == 0 ? mu * slip : 0));
    }
    e.value.natural += 0.5 * w_nn * (from - project_coulomb_cone<3>(foot, mu)).squaredNorm();
  }
  e.natural += 0.5 * w_nn * miss * miss;
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

RoundedSums sums_of(const ContactProblem& p, const Eigen::Ref<const Vector>& s,
                    const RoundedVelocity& velocity, Precision precision) {
  const double unit = unit_of(precision);
  const double term = unit * (kOfATerm + 2 * velocity.longest);
  RoundedSums sums;
  const int d = p.dim;
  for (int c = 0; c < p.num_contacts(); ++c) {
    double x[3] = {}, u[3] = {}, error[3] = {}, b[3] = {};
    for (int k = 0; k < d; ++k) {
      const int row = c * d + k;
      const double r = physical_row_scale(p, row);
      x[k] = s[row] / r;
      b[k] = p.u_free[row] / r;
      u[k] = velocity.u[row] / r;
      error[k] = unit * (velocity.error[row] / r + 4 * std::abs(u[k]));
    }
    const double r = physical_row_scale(p, c * d);
    add_contact(p, c, x, u, error, b, velocity.w[c * d] * r * r, term, sums);
  }
  return sums;
}

}  // namespace

RoundedMomentum rounded_momentum(const ContactProblem& p, const Eigen::Ref<const Vector>& s) {
  const Vector zero = Vector::Zero(p.num_dofs());
  RoundedMomentum pushed{zero, zero, zero};
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
                         const RoundedMomentum& pushed, Precision precision) {
  const double packing = precision != Precision::kDouble || p.dim == 3 ? 0 : kOfPacking;
  return sums_of(p, s, by_bodies(p, pushed, kOfAProduct + packing), precision);
}

RoundingBound rounding_bound(const ContactProblem& p, const Eigen::Ref<const Vector>& s,
                             Precision precision, const ErrorShare& share) {
  const bool bodies = p.has_velocities() && is_diagonal(p.A);
  if (!bodies && !p.has_delassus()) return {kInfinity, kInfinity};
  const RoundedSums sums = bodies ? rounded_sums(p, s, rounded_momentum(p, s), precision)
                                  : sums_of(p, s, by_delassus(p, s), precision);
  return rounding_bound(sums, p.num_contacts(), precision, share);
}

RoundingBound rounding_bound(const RoundedSums& sums, int contacts, Precision precision,
                             const ErrorShare& share) {
  // Of the sums over the contacts, and of a result that is handed on in double.
  const double adding = unit_of(precision) * (contacts + kOfATerm) + std::ldexp(1.0, -50);
  const RoundedError whole = error_with_bound(sums, share.others, adding, 1 / share.share);
  if (!(share.alone > 0)) return whole.bound;
  // The smaller of two figures counts: at most the smaller of what both may be.
  const RoundedError own = error_with_bound(sums, {}, adding, share.alone);
  const auto of_smaller = [](double a, double da, double b, double db) {
    return std::min(a + da, b + db) - std::min(a, b);
  };
  return {of_smaller(whole.epsilon, whole.bound.epsilon, own.epsilon, own.bound.epsilon),
          of_smaller(whole.eta, whole.bound.eta, own.eta, own.bound.eta)};
}

}  // namespace bipot
