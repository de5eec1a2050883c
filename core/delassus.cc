#include "core/delassus.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "core/sparse_factor.h"

namespace bipot {
namespace {

SparseRows assemble_diagonal(const SparseMatrix& A, const SparseMatrix& H, int dim) {
  const int rows = static_cast<int>(H.cols());
  const int contacts = rows / dim;
  Vector inverse_mass = A.diagonal().cwiseInverse();
  const SparseRows by_dof = H;  // row k: the contact directions that act on degree of freedom k

  // Per block row: the coupled contacts are collected through the shared degrees of freedom.
  std::vector<int> slot(contacts, -1);  // contact -> position in `neighbours`
  std::vector<int> neighbours;
  std::vector<double> blocks;  // neighbours.size() blocks of dim x dim, row-major
  std::vector<int> order;
  std::vector<int> columns;
  std::vector<double> values;
  std::vector<int> row_start(rows + 1, 0);
  const std::size_t guess = static_cast<std::size_t>(rows) * 11 * dim;
  columns.reserve(guess);
  values.reserve(guess);
  const int block_size = dim * dim;
  for (int c = 0; c < contacts; ++c) {
    neighbours.clear();
    blocks.clear();
    for (int a = 0; a < dim; ++a) {
      for (SparseMatrix::InnerIterator entry(H, c * dim + a); entry; ++entry) {
        for (SparseRows::InnerIterator other(by_dof, entry.row()); other; ++other) {
          const int k = static_cast<int>(other.col()) / dim;
          if (slot[k] < 0) {
            slot[k] = static_cast<int>(neighbours.size());
            neighbours.push_back(k);
            blocks.resize(blocks.size() + block_size, 0.0);
          }
          blocks[slot[k] * block_size + a * dim + static_cast<int>(other.col()) % dim] +=
              entry.value() * other.value() * inverse_mass[entry.row()];
        }
      }
    }
    order.assign(neighbours.begin(), neighbours.end());
    std::sort(order.begin(), order.end());
    for (int a = 0; a < dim; ++a) {
      for (int k : order) {
        for (int b = 0; b < dim; ++b) {
          columns.push_back(k * dim + b);
          values.push_back(blocks[slot[k] * block_size + a * dim + b]);
        }
      }
      row_start[c * dim + a + 1] = static_cast<int>(columns.size());
    }
    for (int k : neighbours) slot[k] = -1;
  }
  return Eigen::Map<const SparseRows>(rows, rows, static_cast<Eigen::Index>(values.size()),
                                      row_start.data(), columns.data(), values.data());
}

SparseRows assemble_general(const SparseMatrix& A, const SparseMatrix& H) {
  SparseCholesky factor;
  if (!factor.factor(A)) throw std::runtime_error("the mass matrix A is not positive definite");
  const SparseMatrix velocity = factor.solve(H);
  const SparseMatrix W = SparseMatrix(H.transpose()) * velocity;
  const SparseMatrix transposed = W.transpose();
  return SparseRows(0.5 * (W + transposed));  // symmetric up to the rounding of the solves
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

SparseRows assemble_delassus(const SparseMatrix& A, const SparseMatrix& H, int dim) {
  return is_diagonal(A) ? assemble_diagonal(A, H, dim) : assemble_general(A, H);
}

DelassusOperator::DelassusOperator(const ContactProblem& problem, Form form) : problem_(problem) {
  const bool can_two_pass = problem.has_velocities() && is_diagonal(problem.A);
  two_pass_ = can_two_pass && form != Form::kExplicit;
  if (form == Form::kTwoPass && !can_two_pass) {
    throw std::invalid_argument("the two-pass form needs H and a diagonal A");
  }
  if (two_pass_) {
    inverse_mass_ = problem.A.diagonal().cwiseInverse();
    disks_ = disk_structure(problem);
    velocity_.resize(disks_ ? 4 * static_cast<Eigen::Index>(disks_->bodies.size())
                            : problem.num_dofs());
    return;
  }
  if (!problem.has_delassus() && problem.has_velocities()) {
    own_delassus_ = assemble_delassus(problem.A, problem.H, problem.dim);
    delassus_ = &own_delassus_;
  } else {
    delassus_ = &problem.W;
  }
}

template <int D>
void DelassusOperator::apply_disks(const double* s, double* u) const {
  double* const v = velocity_.data();
  velocity_.setZero();
  for (const DiskStructure::Contact& c : disks_->contacts) {
    double* const vi = v + 4 * c.i;
    double* const vj = v + 4 * c.j;
    const double normal = c.normal * s[0];
    double x = normal * c.n[0], y = normal * c.n[1];
    if constexpr (D == 2) {
      const double tangential = c.tangential * s[1];
      x -= tangential * c.n[1];
      y += tangential * c.n[0];
      vi[2] -= tangential;
      vj[2] -= tangential;
    }
    vi[0] += x;
    vi[1] += y;
    vj[0] -= x;
    vj[1] -= y;
    s += D;
  }
  double* body_velocity = v;
  for (const DiskStructure::Body& body : disks_->bodies) {
    body_velocity[0] *= body.inverse_mass;
    body_velocity[1] *= body.inverse_mass;
    body_velocity[2] *= body.inverse_inertia;
    body_velocity += 4;
  }
  for (const DiskStructure::Contact& c : disks_->contacts) {
    const double* const vi = v + 4 * c.i;
    const double* const vj = v + 4 * c.j;
    const double x = vi[0] - vj[0], y = vi[1] - vj[1];
    u[0] = c.normal * (c.n[0] * x + c.n[1] * y);
    if constexpr (D == 2) u[1] = c.tangential * (c.n[0] * y - c.n[1] * x - (vi[2] + vj[2]));
    u += D;
  }
}

void DelassusOperator::apply(const Eigen::Ref<const Vector>& s, Vector& u) const {
  if (disks_) {
    u.resize(problem_.num_rows());
    if (problem_.dim == 1) {
      apply_disks<1>(s.data(), u.data());
    } else {
      apply_disks<2>(s.data(), u.data());
    }
  } else if (two_pass_) {
    velocity_.noalias() = problem_.H * s;
    velocity_.array() *= inverse_mass_.array();
    u.noalias() = problem_.H.transpose() * velocity_;
  } else {
    u.noalias() = *delassus_ * s;
  }
}

void DelassusOperator::velocity(const Eigen::Ref<const Vector>& s, Vector& u) const {
  apply(s, u);
  u += problem_.u_free;
}

Eigen::MatrixXd DelassusOperator::diagonal_block(int contact) const {
  const int d = problem_.dim;
  Eigen::MatrixXd block = Eigen::MatrixXd::Zero(d, d);
  if (two_pass_) {
    for (int a = 0; a < d; ++a) {
      for (int b = 0; b < d; ++b) {
        SparseMatrix::InnerIterator x(problem_.H, contact * d + a);
        SparseMatrix::InnerIterator y(problem_.H, contact * d + b);
        while (x && y) {
          if (x.row() == y.row()) {
            block(a, b) += x.value() * y.value() * inverse_mass_[x.row()];
            ++x;
            ++y;
          } else if (x.row() < y.row()) {
            ++x;
          } else {
            ++y;
          }
        }
      }
    }
  } else {
    for (int a = 0; a < d; ++a) {
      for (SparseRows::InnerIterator it(*delassus_, contact * d + a); it; ++it) {
        const int b = static_cast<int>(it.col()) - contact * d;
        if (b >= 0 && b < d) block(a, b) += it.value();
      }
    }
  }
  return block;
}

Vector DelassusOperator::diagonal() const {
  Vector diagonal = Vector::Zero(problem_.num_rows());
  if (two_pass_) {
    for (int i = 0; i < problem_.num_rows(); ++i) {
      for (SparseMatrix::InnerIterator it(problem_.H, i); it; ++it) {
        diagonal[i] += it.value() * it.value() * inverse_mass_[it.row()];
      }
    }
  } else {
    for (int i = 0; i < problem_.num_rows(); ++i) {
      for (SparseRows::InnerIterator it(*delassus_, i); it; ++it) {
        if (it.col() == i) diagonal[i] += it.value();
      }
    }
  }
  return diagonal;
}

Vector body_velocities(const ContactProblem& p, const Eigen::Ref<const Vector>& s) {
  if (!p.has_velocities()) {
    throw std::invalid_argument("body velocities need a problem with A and H");
  }
  const Vector wrench = p.H * s;
  if (is_diagonal(p.A)) return p.v_free + wrench.cwiseQuotient(p.A.diagonal());
  SparseCholesky factor;
  if (!factor.factor(p.A)) throw std::runtime_error("the mass matrix A is not positive definite");
  return p.v_free + factor.solve(wrench);
}

}  // namespace bipot
