#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/linear/dense_factor.h"
#include "core/problem/contact_problem.h"
#include "core/problem/delassus.h"

namespace bipot {
namespace {

// Rounded data of other codes: in the whole, and in a single entry.
constexpr double kTolerated = 1e-2, kToleratedEntry = 0.1;
constexpr int kDenseRows = 300, kProducts = 60;

/// Empty if a and b agree, with the diagonal of `a` scaled to 1, else the largest difference.
std::string difference(const SparseRows& a, const SparseRows& b, const Vector& scale,
                       const char* name) {
  const auto relative = [&scale](const SparseRows::InnerIterator& it) {
    const double x = std::abs(it.value());
    return x > 0 ? x / (scale[it.row()] * scale[it.col()]) : 0;  // infinite beside a zero diagonal
  };
  const SparseRows d = a - b;
  double squares = 0, size = 0, worst = 0;
  Eigen::Index row = 0, column = 0;
  for (int i = 0; i < d.outerSize(); ++i) {
    for (SparseRows::InnerIterator it(a, i); it; ++it) size += relative(it) * relative(it);
    for (SparseRows::InnerIterator it(d, i); it; ++it) {
      const double x = relative(it);
      squares += x * x;
      if (x <= worst) continue;
      worst = x;
      row = i;
      column = it.col();
    }
  }
  if (worst <= kToleratedEntry && squares <= kTolerated * kTolerated * size) return {};
  return fmt::format(fmt::runtime(name), row, column, a.coeff(row, column), b.coeff(row, column));
}

/// An upper bound of the smallest eigenvalue of a symmetric matrix.
double smallest_ritz_value(const SparseRows& s) {
  const Eigen::Index n = s.rows();
  Vector v(n), before = Vector::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) v[i] = 1 + std::sin(1.7 * static_cast<double>(i + 1));
  v.normalize();
  std::vector<double> diagonal, next;
  double beta = 0;
  for (int k = 0; k < kProducts; ++k) {
    Vector w = s * v - beta * before;
    diagonal.push_back(w.dot(v));
    w -= diagonal.back() * v;
    beta = w.norm();
    if (!(beta > 1e-12)) break;
    next.push_back(beta);
    before = v;
    v = w / beta;
  }
  const auto size = static_cast<Eigen::Index>(diagonal.size());
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(size, size);
  for (Eigen::Index k = 0; k < size; ++k) {
    lower(k, k) = diagonal[to_size(k)];
    if (k + 1 < size) lower(k + 1, k) = next[to_size(k)];
  }
  return smallest_eigenvalue(lower);
}

/// The symmetric part of W with the diagonal scaled to 1.
SparseRows scaled_symmetric_part(const SparseRows& w, const Vector& scale) {
  const SparseRows transposed = w.transpose();
  SparseRows s = 0.5 * (w + transposed);
  for (int i = 0; i < s.outerSize(); ++i) {
    for (SparseRows::InnerIterator it(s, i); it; ++it) {
      it.valueRef() /= scale[i] * scale[it.col()];
    }
  }
  return s;
}

std::string indefinite(double eigenvalue) {
  return fmt::format(
      "W is not positive semidefinite: with its diagonal scaled to 1 it has an eigenvalue of at "
      "most {:.3g}, so impulses can create energy",
      eigenvalue);
}

}  // namespace

std::string delassus_defect(const ContactProblem& p) {
  if (!p.has_delassus() || p.num_rows() == 0) return {};
  Vector scale(p.num_rows());
  for (int i = 0; i < p.num_rows(); ++i) {
    const double w = p.W.coeff(i, i);
    if (w < 0) return fmt::format("W is not positive semidefinite: W({0}, {0}) = {1}", i, w);
    scale[i] = std::sqrt(w);
  }
  // A row whose diagonal is 0 must be 0; entries that this leaves are told as asymmetry or below.
  const SparseRows transposed = p.W.transpose();
  if (auto e = difference(p.W, transposed, scale,
                          "W is not symmetric: W({0}, {1}) = {2}, W({1}, {0}) = {3}");
      !e.empty()) {
    return e;
  }
  if (p.has_velocities()) {
    const SparseRows made = assemble_delassus(p.A, p.H, p.dim);
    if (auto e = difference(p.W, made, scale,
                            "W is not that of A and H: W({0}, {1}) = {2}, HᵀA⁻¹H has {3}");
        !e.empty()) {
      return e;
    }
    return {};  // the operator of A and H is semidefinite
  }
  if (scale.minCoeff() == 0) {
    const double smallest = 1e-150 + 1e-12 * scale.maxCoeff();
    scale = scale.cwiseMax(smallest);
  }
  const SparseRows s = scaled_symmetric_part(p.W, scale);
  double largest_row = 0;
  for (int i = 0; i < s.outerSize(); ++i) {
    double sum = 0;
    for (SparseRows::InnerIterator it(s, i); it; ++it) sum += std::abs(it.value());
    largest_row = std::max(largest_row, sum);
  }
  const double shift = kTolerated * largest_row;
  if (s.rows() > kDenseRows) {
    const double bound = smallest_ritz_value(s);
    return bound < -shift ? indefinite(bound) : std::string();
  }
  Eigen::MatrixXd dense = s;
  dense.diagonal().array() += shift;
  if (Eigen::LLT<Eigen::MatrixXd>(dense).info() == Eigen::Success) return {};
  return indefinite(smallest_eigenvalue(s));
}

}  // namespace bipot
