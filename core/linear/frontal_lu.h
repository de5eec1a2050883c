#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <vector>

#include "core/base/types.h"
#include "core/linear/factor_stop.h"
#include "core/linear/frontal_tree.h"

namespace bipot {

/// Sparse LU of a matrix of symmetric pattern, by dense fronts (multifrontal method: Duff and Reid
/// 1983, Liu 1992). The columns of a front are eliminated by dense kernels; rows are exchanged
/// within the front alone. The structure is then independent of the values, and one analysis serves
/// all of them. Rows and columns are scaled before by powers of two, to about one.
///
/// Limit: a pivot that is small against rows outside the front makes the factor inaccurate. Check
/// `largest_multiplier()`.
class FrontalLU {
 public:
  /// A column (or row) of a matrix for assembly into the front that eliminates it: call add() for
  /// each entry once, in any order.
  class Line {
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
  /// A matrix that need not be stored. Both members give all entries of the line; zeros are
  /// allowed.
  class MatrixByLines {
   public:
    virtual ~MatrixByLines() = default;
    virtual double diagonal(int j) const = 0;
    virtual void add_column(int j, Line& to) const = 0;
    virtual void add_row(int i, Line& to) const = 0;

   protected:
    MatrixByLines() = default;
    MatrixByLines(const MatrixByLines&) = default;
    MatrixByLines& operator=(const MatrixByLines&) = default;
  };
  /// Compressed columns. Column j holds the rows row[start[j]] .. row[start[j + 1] - 1], ascending.
  struct Columns {
    std::vector<std::int64_t> start{0}, row;
    std::vector<double> value;

    void clear() {
      start.assign(1, 0);
      row.clear();
      value.clear();
    }
    void add(std::int64_t i, double a) {
      row.push_back(i);
      value.push_back(a);
    }
    void end_column() { start.push_back(static_cast<std::int64_t>(row.size())); }
  };
  FrontalLU();
  ~FrontalLU();
  FrontalLU(FrontalLU&&) noexcept;
  FrontalLU& operator=(FrontalLU&&) noexcept;

  /// factor() asks it now and then.
  void stop_by(FactorStop stop);
  /// The symbolic analysis alone, of a symmetric pattern with the diagonal. Throws std::bad_alloc.
  void analyse(const SymmetricPattern& pattern);
  /// A: with the pattern of the analysis. False: a pivot is zero or not finite. Throws
  /// std::bad_alloc, FactorStopped.
  [[nodiscard]] bool factor(const MatrixByLines& A);
  /// Both for a compressed matrix, rows ascending.
  [[nodiscard]] bool factor(const SparseMatrix& A);
  /// x = A⁻¹ b without refinement. Requires a successful factor().
  void solve(const Vector& b, Vector& x) const;
  /// x[k] = A⁻¹ b_k of the columns of B, at most kRightSides (eight_right_sides.h), in the time of
  /// two single ones. Each has the same bits whatever the others are. Requires a successful
  /// factor().
  void solve(const Columns& B, Vector* x) const;
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

}  // namespace bipot
