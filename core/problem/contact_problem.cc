#include "core/problem/contact_problem.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace bipot {
namespace {

std::string check_size(const char* field, Eigen::Index got, Eigen::Index want) {
  if (got == want) return {};
  return fmt::format("{} has size {}, expected {}", field, got, want);
}

std::string check_finite(const char* field, const Vector& x) {
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i])) return fmt::format("{}[{}] = {} is not finite", field, i, x[i]);
  }
  return {};
}

template <class Sparse>
std::string check_finite_entries(const char* field, const Sparse& matrix) {
  for (int k = 0; k < matrix.outerSize(); ++k) {
    for (typename Sparse::InnerIterator it(matrix, k); it; ++it) {
      if (!std::isfinite(it.value())) {
        return fmt::format("{}({}, {}) = {} is not finite", field, it.row(), it.col(), it.value());
      }
    }
  }
  return {};
}

std::string check_dimension(const ContactProblem& p) {
  if (!p.rolls() && p.mu_spin.size() > 0) return "mu_spin is given without mu_r";
  if (!p.rolls() && (p.dim < 1 || p.dim > 3)) {
    return fmt::format("dim = {}, expected 1, 2 or 3", p.dim);
  }
  if (!p.rolls()) return {};
  if (p.dim != 3 && p.dim != 6) {
    return fmt::format("dim = {}, expected 3 or 6 rows a contact with rolling friction", p.dim);
  }
  if (auto e = check_size("mu_r", p.mu_r.size(), p.mu.size()); !e.empty()) return e;
  return check_size("mu_spin", p.mu_spin.size(), p.dim == 6 ? p.mu.size() : 0);
}

std::string check_mass_matrix(const SparseMatrix& A) {
  const Vector diagonal = A.diagonal();
  for (Eigen::Index i = 0; i < diagonal.size(); ++i) {
    if (!(diagonal[i] > 0)) {
      return fmt::format("A({}, {}) = {} is not positive", i, i, diagonal[i]);
    }
  }
  if (A.nonZeros() == A.rows()) return {};
  const SparseMatrix transposed = A.transpose();
  const SparseMatrix skew = A - transposed;
  for (int k = 0; k < skew.outerSize(); ++k) {
    for (SparseMatrix::InnerIterator it(skew, k); it; ++it) {
      const double scale = std::sqrt(diagonal[it.row()] * diagonal[it.col()]);
      if (std::abs(it.value()) > 1e-9 * scale) {
        return fmt::format("A is not symmetric: A({0}, {1}) - A({1}, {0}) = {2}", it.row(),
                           it.col(), it.value());
      }
    }
  }
  return {};
}

std::string check_delassus_diagonal(const ContactProblem& p) {
  const int d = p.dim;
  if (p.has_delassus()) {
    for (int c = 0; c < p.num_contacts(); ++c) {
      const double w_nn = p.W.coeff(c * d, c * d);
      if (!(w_nn > 0)) return fmt::format("W_nn of contact {} = {} is not positive", c, w_nn);
    }
    return {};
  }
  const Vector masses = p.A.diagonal();
  for (int c = 0; c < p.num_contacts(); ++c) {
    double norm = 0;
    for (SparseMatrix::InnerIterator it(p.H, c * d); it; ++it) {
      norm += it.value() * it.value();
      if (!std::isfinite(it.value() * it.value() / masses[it.row()])) {
        return fmt::format("W_nn of contact {} is beyond the largest number: A({}, {}) = {}", c,
                           it.row(), it.row(), masses[it.row()]);
      }
    }
    if (!(norm > 0)) {
      return fmt::format("normal column of H of contact {} is zero: no free body takes part", c);
    }
  }
  return {};
}

}  // namespace

bool is_diagonal(const SparseMatrix& A) {
  for (int k = 0; k < A.outerSize(); ++k) {
    for (SparseMatrix::InnerIterator it(A, k); it; ++it) {
      if (it.row() != it.col() && it.value() != 0) return false;
    }
  }
  return true;
}

std::string validate_vectors(const ContactProblem& p) {
  if (auto e = check_dimension(p); !e.empty()) return e;
  const Eigen::Index rows = static_cast<Eigen::Index>(p.dim) * p.mu.size();
  if (auto e = check_size("u_free", p.u_free.size(), rows); !e.empty()) return e;
  if (p.has_velocities()) {
    if (auto e = check_size("v_free", p.v_free.size(), p.H.rows()); !e.empty()) return e;
    if (auto e = check_finite("v_free", p.v_free); !e.empty()) return e;
  }
  if (auto e = check_finite("u_free", p.u_free); !e.empty()) return e;
  for (const auto& [field, values] :
       {std::pair{"mu", &p.mu}, std::pair{"mu_r", &p.mu_r}, std::pair{"mu_spin", &p.mu_spin}}) {
    if (auto e = check_finite(field, *values); !e.empty()) return e;
    for (Eigen::Index c = 0; c < values->size(); ++c) {
      if ((*values)[c] < 0) return fmt::format("{}[{}] = {} is negative", field, c, (*values)[c]);
    }
  }
  if (p.row_scale.size() != 0) {
    if (auto e = check_size("row_scale", p.row_scale.size(), rows); !e.empty()) return e;
    if (auto e = check_finite("row_scale", p.row_scale); !e.empty()) return e;
    for (Eigen::Index i = 0; i < rows; ++i) {
      if (!(p.row_scale[i] > 0)) {
        return fmt::format("row_scale[{}] = {} is not positive", i, p.row_scale[i]);
      }
    }
    for (int c = 0; c < p.num_contacts() && p.plain_dim() == 3; ++c) {
      const Vector r = p.row_scale.segment(c * p.dim, p.dim);
      if (r[1] != r[2]) {
        return fmt::format("row_scale of contact {} differs between its tangents: {} and {}", c,
                           r[1], r[2]);
      }
      if (p.rolls() && r[3] != r[4]) {
        return fmt::format("row_scale of contact {} differs between its rolling rows: {} and {}", c,
                           r[3], r[4]);
      }
    }
  }
  return {};
}

std::string validate(const ContactProblem& p) {
  if (auto e = validate_vectors(p); !e.empty()) return e;
  const Eigen::Index rows = p.u_free.size();
  if (rows > 0 && !p.has_delassus() && !p.has_velocities()) {
    return "neither W nor (A, H) is given";
  }
  if (p.has_delassus()) {
    if (auto e = check_size("W (rows)", p.W.rows(), rows); !e.empty()) return e;
    if (auto e = check_size("W (columns)", p.W.cols(), rows); !e.empty()) return e;
    if (!p.W.isCompressed()) return "W is not compressed: call makeCompressed()";
    if (auto e = check_finite_entries("W", p.W); !e.empty()) return e;
  }
  if (p.has_velocities()) {
    if (auto e = check_size("H (columns)", p.H.cols(), rows); !e.empty()) return e;
    if (auto e = check_size("A (rows)", p.A.rows(), p.H.rows()); !e.empty()) return e;
    if (auto e = check_size("A (columns)", p.A.cols(), p.H.rows()); !e.empty()) return e;
    if (auto e = check_finite_entries("H", p.H); !e.empty()) return e;
    if (auto e = check_finite_entries("A", p.A); !e.empty()) return e;
    if (auto e = check_mass_matrix(p.A); !e.empty()) return e;
  }
  return check_delassus_diagonal(p);
}

}  // namespace bipot
