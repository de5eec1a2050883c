#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <type_traits>

#include "core/base/types.h"
#include "core/linear/frontal_tree.h"
#include "core/linear/sparse_factor.h"

namespace bipot {

/// A column (or row) of a matrix for assembly into the front that eliminates it: call add() for
/// each entry once, in any order.
class FrontLine {
 public:
  /// True if this front stores the entry at index `other`. Entries of earlier fronts are ignored.
  bool takes(int other) const { return position_ == nullptr || position_[other] >= least_; }
  void add(int other, double value) {
    if (!takes(other)) return;
    const double entry = value * scale_ * scales_[other];
    within_ &= std::abs(entry) <= most_;
    if (value_ != nullptr) {
      value_[position_[other]] += entry;
    } else if (largest_ != nullptr) {
      for (const int i : {line_, other}) largest_[i] = std::max(largest_[i], std::abs(entry));
    }
  }

 private:
  template <class Real>
  friend class FrontalLU;
  const int* position_ = nullptr;  // of a line of the matrix in the front, -1 if others took it
  int least_ = 0;                  // that it takes
  const double* scales_ = nullptr;
  double scale_ = 1;           // of the line
  double* value_ = nullptr;    // the line in the front, if it is to be filled
  double most_ = kInfinity;    // that an entry may be
  bool within_ = true;         // none was larger, or not a number
  int line_ = 0;               // of the matrix
  double* largest_ = nullptr;  // of each row and column, to inspect the entries alone
};

/// A matrix that need not be stored. Both members give all entries of the line; zeros are allowed.
class MatrixByLines {
 public:
  virtual ~MatrixByLines() = default;
  virtual double diagonal(int j) const = 0;
  virtual void add_column(int j, FrontLine& to) const = 0;
  virtual void add_row(int i, FrontLine& to) const = 0;

 protected:
  MatrixByLines() = default;
  MatrixByLines(const MatrixByLines&) = default;
  MatrixByLines& operator=(const MatrixByLines&) = default;
};

/// Sparse LU of a matrix of symmetric pattern, by dense fronts (multifrontal method: Duff and Reid
/// 1983, Liu 1992). The columns of a front are eliminated by dense kernels; rows are exchanged
/// within the front alone. The structure is then independent of the values, and one analysis serves
/// all of them. Rows and columns are scaled before by powers of two, to about one.
///
/// Limit: a pivot that is small against rows outside the front makes the factor inaccurate. Check
/// `largest_multiplier()`.
///
/// Real is the type of the stored factor: double, or float at half the memory, whose solutions are
/// good to 1e-6 at best and need refinement. The computation is in double precision.
template <class Real>
class FrontalLU {
 public:
  FrontalLU();
  ~FrontalLU();
  FrontalLU(FrontalLU&&) noexcept;
  FrontalLU& operator=(FrontalLU&&) noexcept;

  /// The symbolic analysis alone, of a symmetric pattern with the diagonal. False: memory ran out.
  [[nodiscard]] bool analyse(const SymmetricPattern& pattern);
  /// A: with the pattern of the analysis. False: a pivot is zero or not finite, or memory ran out.
  [[nodiscard]] bool factor(const MatrixByLines& A);
  /// Both of a compressed matrix, rows ascending.
  [[nodiscard]] bool factor(const SparseMatrix& A);
  /// x = A⁻¹ b without refinement. Requires a successful factor().
  void solve(const Vector& b, Vector& x) const;
  /// x[k] = A⁻¹ b_k of the columns of B, at most kRightSides (eight_right_sides.h), in the time of
  /// two single ones. Each has the same bits whatever the others are. Requires a successful
  /// factor().
  void solve(const SparseColumns& B, Vector* x) const requires std::is_same_v<Real, double>;
  /// -1 or +1: sign of det A. Requires a successful factor().
  int determinant_sign() const;
  /// max |l_ij| over the rows with which a pivot could not be exchanged.
  double largest_multiplier() const;
  /// Numbers in L and U together.
  std::size_t num_entries() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

extern template class FrontalLU<double>;
extern template class FrontalLU<float>;

}  // namespace bipot
