#include "solvers/analysis/certificate_check.h"

#include <cmath>
#include <vector>

#include "core/problem/coulomb_cone.h"

namespace bipot {
namespace {

using Extended = long double;

/// Twice the unit round-off of Extended for each of n + 8 operations.
Extended rounding(Eigen::Index operations) {
  return static_cast<Extended>(operations + 8) * std::numeric_limits<Extended>::epsilon();
}

/// One row of u = Hᵀ y (or W y) + weight u_free: its value, and the sum of the absolute values of
/// its terms.
struct Sum {
  Extended value = 0, absolute = 0;
  Eigen::Index terms = 0;
  bool exact = true;  // every product is a double, so that two of them cancel without rounding
  void add(double a, double b) {
    const Extended x = static_cast<Extended>(a) * static_cast<Extended>(b);
    value += x;
    absolute += std::abs(x);
    ++terms;
    exact = exact && std::fma(a, b, -(a * b)) == 0;
  }
};

Sum row_of(const ContactProblem& p, Eigen::Index row, const Vector& y, double weight) {
  Sum sum;
  if (p.has_velocities()) {
    for (SparseMatrix::InnerIterator it(p.H, row); it; ++it) sum.add(it.value(), y[it.row()]);
  } else {
    for (SparseRows::InnerIterator it(p.W, row); it; ++it) sum.add(it.value(), y[it.col()]);
  }
  sum.add(weight, p.u_free[row]);
  return sum;
}

/// Residual of the self-stress, H_n r (or W_n r), in energy: a norm over sqrt of the diagonal of A
/// (or of W).
Extended leftover(const ContactProblem& p, const Vector& stress) {
  const Eigen::Index size = p.has_velocities() ? p.H.rows() : p.W.rows();
  std::vector<Sum> sums(to_size(size));
  for (Eigen::Index c = 0; c < stress.size(); ++c) {
    if (stress[c] == 0) continue;
    if (p.has_velocities()) {
      for (SparseMatrix::InnerIterator it(p.H, c * p.dim); it; ++it) {
        sums[to_size(it.row())].add(stress[c], it.value());
      }
    } else {
      // W is symmetric here: its row is its column.
      for (SparseRows::InnerIterator it(p.W, c * p.dim); it; ++it) {
        sums[to_size(it.col())].add(stress[c], it.value());
      }
    }
  }
  const Vector diagonal = p.has_velocities() ? Vector(p.A.diagonal()) : Vector(p.W.diagonal());
  Extended squares = 0;
  for (Eigen::Index i = 0; i < size; ++i) {
    const Sum& sum = sums[to_size(i)];
    const Extended size_i = std::abs(sum.value) + rounding(sum.terms) * sum.absolute;
    // Two equal and opposite impulses cancel exactly, without rounding.
    const bool nothing = sum.value == 0 && sum.terms <= 2 && sum.exact;
    const Extended left = nothing ? 0 : size_i;
    if (left == 0) continue;
    const Extended scale = static_cast<Extended>(diagonal[i]);
    if (!(scale > 0)) return static_cast<Extended>(kInfinity);
    squares += left * left / scale;
  }
  return std::sqrt(squares);
}

}  // namespace

double opening_margin(const ContactProblem& p, const Vector& y, double weight) {
  if (!y.allFinite() || !(weight >= 0) || !std::isfinite(weight)) return -1;
  Extended margin = 1;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const Sum normal = row_of(p, static_cast<Eigen::Index>(c) * p.dim, y, weight);
    Eigen::Index terms = normal.terms;
    Extended opening = normal.value, size = normal.absolute;
    dispatch_rows(p, [&](auto rows) {
      constexpr ContactRows K = rows();
      each_bounded<K>(friction_of<K>(p, c), [&](auto first, auto count, double bound) {
        const auto mu = static_cast<Extended>(bound);
        Extended slip2 = 0, slip_terms2 = 0;
        for (int k = first(); k < first() + count(); ++k) {
          const Sum tangent = row_of(p, static_cast<Eigen::Index>(c) * p.dim + k, y, weight);
          slip2 += tangent.value * tangent.value;
          slip_terms2 += tangent.absolute * tangent.absolute;
          terms += tangent.terms;
        }
        opening -= mu * std::sqrt(slip2);
        size += mu * std::sqrt(slip_terms2);
      });
    });
    if (!(size > 0) || !std::isfinite(static_cast<double>(size))) return -1;
    margin = std::min(margin, opening / size - rounding(terms));
  }
  return static_cast<double>(margin);
}

Obstruction obstruction(const ContactProblem& p, const Vector& stress) {
  Sum work;
  Extended data2 = 0;
  for (int c = 0; c < p.num_contacts(); ++c) {
    if (!(stress[c] >= 0) || !std::isfinite(stress[c])) return {};
    const Eigen::Index row = static_cast<Eigen::Index>(c) * p.dim;
    const Extended w = static_cast<Extended>(p.u_free[row]);
    if (stress[c] > 0) work.add(stress[c], p.u_free[row]);
    Extended w_nn = 0;
    if (p.has_velocities()) {
      for (SparseMatrix::InnerIterator it(p.H, row); it; ++it) {
        w_nn += static_cast<Extended>(it.value()) * static_cast<Extended>(it.value()) /
                static_cast<Extended>(p.A.coeff(it.row(), it.row()));
      }
    } else {
      w_nn = static_cast<Extended>(p.W.coeff(row, row));
    }
    if (w_nn > 0) data2 += w * w / w_nn;
  }
  if (!(work.absolute > 0)) return {};
  Obstruction result{.strength =
                         static_cast<double>(-work.value / work.absolute - rounding(work.terms))};
  if (!(result.strength > 0)) return result;
  const Extended left = leftover(p, stress);
  result.speed =
      left == 0 ? kInfinity : static_cast<double>(-work.value / (left * std::sqrt(data2)));
  return result;
}

}  // namespace bipot
