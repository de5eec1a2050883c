#include "core/problem/equality_rows.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/base/disjoint_sets.h"
#include "core/base/triplets.h"
#include "core/linear/dense_factor.h"
#include "core/problem/delassus.h"

namespace bipot {
namespace {

using Eigen::MatrixXd;

constexpr double kDependent = 1e-9;    // pivot of a row of unit norm
constexpr double kContradicts = 1e-6;  // of the largest b
constexpr double kNoMotion = 1e-12;    // of a column of H in the norm of A⁻¹
constexpr std::size_t kLargestPart = 5000;

void check_sizes(const ContactProblem& given, const SparseRows& G, const Vector& b) {
  if (given.A.rows() == 0) {
    throw std::invalid_argument("equality rows need bodies: A, H and v_free");
  }
  if (G.cols() != given.num_dofs() || G.rows() != b.size()) {
    throw std::invalid_argument(fmt::format("G is {} x {} and b has size {}, expected p x {} and p",
                                            G.rows(), G.cols(), b.size(), given.num_dofs()));
  }
  for (int row = 0; row < G.rows(); ++row) {
    double norm = 0;
    for (SparseRows::InnerIterator it(G, row); it; ++it) norm += std::abs(it.value());
    if (!std::isfinite(norm)) {
      throw std::invalid_argument(fmt::format("row {} of G is not finite", row));
    }
    if (!std::isfinite(b[row])) {
      throw std::invalid_argument(fmt::format("b[{}] = {} is not finite", row, b[row]));
    }
    if (norm == 0 && b[row] != 0) {
      throw std::invalid_argument(
          fmt::format("row {0} of G is zero, but b[{0}] = {1}", row, b[row]));
    }
  }
}

/// Parts with their degrees of freedom and rows; the other degrees of freedom go into rows.free.
void find_parts(EqualityRows& rows) {
  const SparseMatrix& A = rows.given.A;
  DisjointSets coupled(static_cast<int>(A.rows()));
  for (int k = 0; k < A.outerSize(); ++k) {
    for (SparseMatrix::InnerIterator it(A, k); it; ++it) {
      if (it.value() != 0) coupled.unite(static_cast<int>(it.row()), k);
    }
  }
  std::vector<int> first_dof(to_size(rows.G.rows()), -1);
  for (int row = 0; row < rows.G.rows(); ++row) {
    for (SparseRows::InnerIterator it(rows.G, row); it; ++it) {
      if (it.value() == 0) continue;
      int& first = first_dof[to_size(row)];
      const int dof = static_cast<int>(it.col());
      if (first < 0) first = dof;
      coupled.unite(first, dof);
    }
  }
  std::vector<int> part_of(to_size(A.rows()), -1);  // of each set
  for (int row = 0; row < rows.G.rows(); ++row) {
    if (first_dof[to_size(row)] < 0) continue;  // zero
    int& part = part_of[to_size(coupled.find(first_dof[to_size(row)]))];
    if (part < 0) {
      part = static_cast<int>(rows.parts.size());
      rows.parts.emplace_back();
    }
    rows.parts[to_size(part)].rows.push_back(row);
  }
  for (int dof = 0; dof < A.rows(); ++dof) {
    const int part = part_of[to_size(coupled.find(dof))];
    (part < 0 ? rows.free : rows.parts[to_size(part)].dofs).push_back(dof);
  }
}

/// Entries [dofs, dofs] of A, or [rows, dofs] of G.
template <class Sparse>
MatrixXd dense_block(const Sparse& matrix, const std::vector<int>& lines,
                     const std::vector<int>& place, std::size_t columns) {
  MatrixXd block =
      MatrixXd::Zero(static_cast<Eigen::Index>(lines.size()), static_cast<Eigen::Index>(columns));
  for (std::size_t k = 0; k < lines.size(); ++k) {
    for (typename Sparse::InnerIterator it(matrix, lines[k]); it; ++it) {
      const int column = place[to_size(it.index())];
      if (column >= 0) block(static_cast<Eigen::Index>(k), column) += it.value();
    }
  }
  return block;
}

/// Z, v_p and the map to λ of a part. `place`: of each dof in the part, else -1.
void factor(EqualityRows& rows, EqualityRows::Part& part, const std::vector<int>& place,
            bool lenient) {
  if (part.dofs.size() > kLargestPart) {
    throw std::invalid_argument(
        fmt::format("equality rows couple {} degrees of freedom; at most {} can be eliminated",
                    part.dofs.size(), kLargestPart));
  }
  const Eigen::LLT<MatrixXd> mass(dense_block(rows.given.A, part.dofs, place, part.dofs.size()));
  if (mass.info() != Eigen::Success) throw std::invalid_argument("A is not positive definite");
  // In w = Lᵀ v, A = L Lᵀ, the energy is |w|²/2. Columns: the rows of G, each of unit norm.
  MatrixXd unit =
      mass.matrixL().solve(dense_block(rows.G, part.rows, place, part.dofs.size()).transpose());
  const Vector norms = unit.colwise().norm();
  unit = unit * norms.cwiseInverse().asDiagonal();
  const Vector target = Vector(rows.b(part.rows)).cwiseQuotient(norms);

  const auto [inverse, left] = inverse_and_left_null_space(unit, kDependent);
  const Vector smallest = inverse.transpose() * target;
  const Vector miss = unit.transpose() * smallest - target;
  Eigen::Index worst = 0;
  const bool contradicts =
      miss.cwiseAbs().maxCoeff(&worst) > kContradicts * target.cwiseAbs().maxCoeff();
  if (contradicts && !lenient) {
    const int row = part.rows[to_size(worst)];
    throw std::invalid_argument(
        fmt::format("row {0} of G contradicts other rows: b[{0}] = {1}, the velocities nearest to "
                    "all of them have {2}",
                    row, rows.b[row], rows.b[row] + miss[worst] * norms[worst]));
  }
  part.basis = left;
  // Eigen takes the address of the first column, which a part without freedom lacks.
  if (left.cols() > 0) mass.matrixU().solveInPlace(part.basis);
  part.particular = mass.matrixU().solve(smallest);
  part.multipliers_map =
      norms.cwiseInverse().asDiagonal() * mass.matrixU().solve(inverse.transpose()).transpose();
}

/// Entries of H in the coordinates of the reduced problem. `blocked`: contacts without motion along
/// their normal, which get none.
Triplets reduced_wrenches(const EqualityRows& rows, const std::vector<int>& place,
                          const std::vector<int>& part_of, std::vector<int>& blocked) {
  const ContactProblem& given = rows.given;
  Triplets entries;
  std::vector<Vector> wrench(rows.parts.size());
  for (int column = 0; column < given.H.cols(); ++column) {
    bool moves = false;
    std::vector<int> touched;
    for (SparseMatrix::InnerIterator it(given.H, column); it; ++it) {
      const int part = part_of[to_size(it.row())], at = place[to_size(it.row())];
      if (part < 0) {
        entries.emplace_back(at, column, it.value());
        moves = true;
        continue;
      }
      Vector& own = wrench[to_size(part)];
      if (own.size() == 0) {
        own = Vector::Zero(static_cast<Eigen::Index>(rows.parts[to_size(part)].dofs.size()));
        touched.push_back(part);
      }
      own[at] += it.value();
    }
    for (const int k : touched) {
      const EqualityRows::Part& part = rows.parts[to_size(k)];
      Vector& own = wrench[to_size(k)];
      const Vector y = part.basis.transpose() * own;
      // What rounding leaves of a motion that the rows forbid is none.
      double unbound = 0;
      for (std::size_t l = 0; l < part.dofs.size(); ++l) {
        const double x = own[static_cast<int>(l)];
        unbound += x * x / given.A.coeff(part.dofs[l], part.dofs[l]);
      }
      own.resize(0);
      if (y.norm() <= kNoMotion * std::sqrt(unbound)) continue;
      moves = true;
      for (Eigen::Index l = 0; l < y.size(); ++l) {
        if (y[l] != 0) entries.emplace_back(part.first + static_cast<int>(l), column, y[l]);
      }
    }
    if (!moves && column % given.dim == 0) blocked.push_back(column / given.dim);
  }
  std::erase_if(entries, [&](const auto& entry) {
    return std::binary_search(blocked.begin(), blocked.end(), entry.col() / given.dim);
  });
  return entries;
}

}  // namespace

Vector EqualityRows::velocities(const Vector& y) const {
  Vector v(given.num_dofs());
  v(free) = y.head(static_cast<Eigen::Index>(free.size()));
  for (const Part& part : parts) {
    v(part.dofs) = part.particular + part.basis * y.segment(part.first, part.basis.cols());
  }
  return v;
}

ContactProblem with_equality_rows(ContactProblem given, SparseRows G, Vector b, bool lenient) {
  check_sizes(given, G, b);
  if (G.rows() == 0) return given;
  auto rows = std::make_shared<EqualityRows>();
  rows->given = std::move(given);
  rows->given.W = {};
  rows->G = std::move(G);
  rows->b = std::move(b);
  rows->lenient = lenient;
  find_parts(*rows);
  const ContactProblem& old = rows->given;
  std::vector<int> place(to_size(old.num_dofs()), -1), part_of(to_size(old.num_dofs()), -1);
  for (std::size_t k = 0; k < rows->free.size(); ++k) {
    place[to_size(rows->free[k])] = static_cast<int>(k);
  }
  int coordinates = static_cast<int>(rows->free.size());
  std::vector<int> own(place.size(), -1);  // places in one part
  for (EqualityRows::Part& part : rows->parts) {
    for (std::size_t k = 0; k < part.dofs.size(); ++k) {
      own[to_size(part.dofs[k])] = place[to_size(part.dofs[k])] = static_cast<int>(k);
      part_of[to_size(part.dofs[k])] = static_cast<int>(&part - rows->parts.data());
    }
    factor(*rows, part, own, lenient);
    for (const int dof : part.dofs) own[to_size(dof)] = -1;
    part.first = coordinates;
    coordinates += static_cast<int>(part.basis.cols());
  }

  std::vector<int>& blocked = rows->blocked;
  Triplets wrenches = reduced_wrenches(*rows, place, part_of, blocked);
  if (!blocked.empty() && !lenient) {
    throw std::invalid_argument(fmt::format(
        "contact {}: the equality rows leave no motion along its normal", blocked.front()));
  }
  // What a blocked contact moves is nothing else's.
  for (const int contact : blocked) {
    for (int row = 0; row < old.dim; ++row) {
      wrenches.emplace_back(coordinates++, contact * old.dim + row, 1.0);
    }
  }
  ContactProblem p{.dim = old.dim,
                   .mu = old.mu,
                   .mu_r = old.mu_r,
                   .mu_spin = old.mu_spin,
                   .row_scale = old.row_scale};
  Triplets masses;
  for (const int dof : rows->free) {
    for (SparseMatrix::InnerIterator it(old.A, dof); it; ++it) {
      if (it.value() == 0) continue;
      masses.emplace_back(place[to_size(it.row())], place[to_size(dof)], it.value());
    }
  }
  for (int k = static_cast<int>(rows->free.size()); k < coordinates; ++k) {
    masses.emplace_back(k, k, 1.0);
  }
  p.A = from_triplets(coordinates, coordinates, masses);
  p.H = from_triplets(coordinates, old.H.cols(), wrenches);
  p.v_free = Vector::Zero(coordinates);
  p.v_free.head(static_cast<Eigen::Index>(rows->free.size())) = old.v_free(rows->free);
  const Vector momentum = old.A * old.v_free;
  for (const EqualityRows::Part& part : rows->parts) {
    p.v_free.segment(part.first, part.basis.cols()) =
        part.basis.transpose() * Vector(momentum(part.dofs));
  }
  p.u_free = old.u_free + old.H.transpose() * (rows->velocities(p.v_free) - old.v_free);
  for (const int contact : blocked) {
    double& opens = p.u_free[static_cast<Eigen::Index>(contact) * p.dim];
    opens = std::max(opens, 0.0);
  }
  if (p.num_rows() > 0 && !is_diagonal(p.A)) p.W = assemble_delassus(p.A, p.H, p.dim);
  p.equality = std::move(rows);
  return p;
}

const ContactProblem& without_equality_rows(const ContactProblem& problem) {
  return problem.equality ? problem.equality->given : problem;
}

Vector multipliers(const ContactProblem& problem, const Eigen::Ref<const Vector>& s) {
  if (!problem.equality) return {};
  const EqualityRows& rows = *problem.equality;
  const Vector change = body_velocities(problem, s) - rows.given.v_free;
  const Vector impulse = rows.given.A * change - rows.given.H * s;
  Vector all = Vector::Zero(rows.G.rows());
  for (const EqualityRows::Part& part : rows.parts) {
    all(part.rows) = part.multipliers_map * Vector(impulse(part.dofs));
  }
  return all;
}

double equality_residual(const ContactProblem& problem, const Eigen::Ref<const Vector>& s) {
  if (!problem.equality) return 0;
  const EqualityRows& rows = *problem.equality;
  return (rows.G * body_velocities(problem, s) - rows.b).cwiseAbs().maxCoeff();
}

}  // namespace bipot
