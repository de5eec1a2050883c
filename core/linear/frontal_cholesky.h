#pragma once

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/types.h"
#include "core/linear/factor_stop.h"
#include "core/linear/frontal_tree.h"
#include "core/linear/supernodal_solve.h"

namespace bipot {

/// Sparse Cholesky factorisation A = L Lᵀ by dense fronts (multifrontal method: Duff and Reid 1983,
/// Liu 1992). For matrices that are factored dozens of times with one pattern, each with about a
/// hundred solves. Therefore the analysis is kept (FrontalTree), and solves use SupernodalSolve. The
/// factor is in single precision: a solve is a correction of an approximation by its residual, which
/// converges quickly while the condition of A, with a diagonal of ones, is below 1e6.
class FrontalCholesky {
 public:
  /// Destination of the entries of a column of the matrix in the front that eliminates it.
  struct Column {
    const int* place;     ///< of each row of the matrix in the order of elimination
    const int* position;  ///< of these in the front
    int first;            ///< the front's first; rows before belong to other fronts
    double* value;        ///< the column in the front
    const double* scale;  ///< of each row
    double own_scale;     ///< of the column

    bool takes(int row) const { return place[row] >= first; }
    void add(int row, double number) const {
      value[position[place[row]]] += number * scale[row] * own_scale;
    }
  };
  /// factor() asks it now and then.
  void stop_by(FactorStop stop) { stop_ = std::move(stop); }
  /// The symbolic analysis alone, for callers who check their clock before the first factor().
  /// Throws std::bad_alloc.
  void analyse(const SymmetricPattern& A);
  /// A: symmetric, both triangles stored, compressed, rows ascending, with the diagonal in its
  /// pattern. False if A is not positive definite in single precision or not finite. Throws
  /// std::bad_alloc, FactorStopped.
  [[nodiscard]] bool factor(const SparseMatrix& A);
  /// The same for a matrix that is not stored, with the pattern of the analysis. `add(j, to)` adds
  /// the entries (i, j) with to.takes(i) by to.add(i, entry); each column once. `diagonal`: positive
  /// numbers of the order of the diagonal's; with them units do not matter.
  using AddColumn = std::function<void(int column, const Column& to)>;
  [[nodiscard]] bool factor(const AddColumn& add, const Vector& diagonal);
  /// x = A⁻¹ b in single precision, for corrections x += A⁻¹ (b - A x); x may be b. Requires a
  /// successful factor(). No allocation after the first call.
  void solve(const Vector& b, Vector& x) const;
  /// Numbers stored of L. Requires a successful factor().
  std::size_t num_entries() const { return entries_; }

 private:
  bool eliminate(const AddColumn& add);
  void assemble(int front, const AddColumn& add, float* panel);

  std::shared_ptr<const FrontalTree> tree_;
  std::vector<int> place_;       // of each column of A in the tree's order
  std::vector<int> position_;    // scratch of a front
  Vector scale_;                 // of rows and columns of A, powers of two
  std::vector<float> panel_;     // scratch of a front
  std::vector<double> column_;   // scratch of a column of the front
  std::vector<float> diagonal_;  // of A in its pivots
  std::vector<float> stack_;     // contributions
  FactorStop stop_;
  bool factored_ = false;
  std::size_t entries_ = 0;
  mutable SupernodalSolve supernodes_;
  mutable std::vector<float> permuted_;
};

}  // namespace bipot
