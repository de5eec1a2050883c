#pragma once

#include <array>
#include <vector>

#include "core/linear/eight_right_sides.h"
#include "core/linear/frontal_lu.h"
#include "core/linear/sparse_factor.h"
#include "solvers/homotopy/cell_matrix.h"
#include "solvers/homotopy/exchanged_columns.h"
#include "solvers/homotopy/law_point.h"

namespace bipot {

/// The matrix B of a point's cells (cell_matrix.h) and its factor. It is multifrontal
/// (frontal_lu.h) in the pattern of W, zeros of unit columns included, so that one analysis serves
/// all cells. If a front's pivots are too small, SparseLU factors with exchanges of any rows.
/// Between factorisations columns are exchanged as in exchanged_columns.h.
class CellBasis {
 public:
  /// `stop`: ends factorisations.
  explicit CellBasis(const LawProblem& problem, const FactorStop& stop = {});

  /// Factors B of the point, whose columns must be sorted; `proximal`: the diagonal of D, m, which
  /// is referred to. False: singular. Throws std::bad_alloc, FactorStopped.
  [[nodiscard]] bool factor(const LawPoint& point, const Vector& proximal);
  /// True if B should be factored again before another exchange.
  bool full() const { return exchanged_.full(); }

  /// x = B⁻¹ g. The factor by fronts allocates nothing.
  void solve(const Vector& g, Vector& x);
  /// Changes x, which was B⁻¹ g right after factor(), to the present B.
  void update(Vector& x) const { exchanged_.apply(x); }

  /// A column to enter in place of the one in `slot`, and entry `slot` of B⁻¹ times it.
  struct Entering {
    int slot = -1, number = -1;  ///< number: of exchanged_, -1 if the factor has it there
    double pivot = 0;
    double size = 0;  ///< largest entry of that column in terms of the factor's
  };
  Entering entering(int contact, Column column, int slot);
  /// A column of a contact to enter in place of the one in `slot`.
  struct Candidate {
    int contact;
    Column column;
    int slot;
  };
  /// True if entering() of it costs a solve with the factor.
  bool is_unknown(const Candidate& candidate) const;
  /// Prepares entering() of the candidates by one solve; all unknown, at most kRightSides.
  void prepare(const std::vector<Candidate>& candidates);
  /// Requires a pivot that is not 0. False: singular to working precision.
  [[nodiscard]] bool exchange(const Entering& entering) {
    return exchanged_.exchange(entering.slot, entering.number);
  }

  /// +1 or -1: sign of det B times (-1)^(number of impulse columns), for the B of the factor. It is
  /// +1 if dt is along the component of the path that joins t = -infinity to the solution.
  int orientation(const LawPoint& point) const;

  /// x with B x = g + weight h, improved `refinements` times by residuals in 80 bits. Without them
  /// the error is that of D's condition, 1e-16 / D. The point's columns are those of B.
  void solve_refined(const LawPoint& point, const Vector& g, long double weight, const Vector& h,
                     int refinements, Vector& x);
  /// Continues with x, which solve_refined() returned for the same arguments.
  void refine(const LawPoint& point, const Vector& g, long double weight, const Vector& h,
              int refinements, Vector& x);

 private:
  bool factor_with_exchanges();
  /// Slot that the column has in the factored B, -1: none.
  int factored_slot(int contact, Column column) const;
  void solve_factored(const Vector& g, Vector& x);
  static int key(int contact, Column column);

  const LawProblem& problem_;
  CellMatrix matrix_;  // of the columns that were factored
  FrontalLU fronts_;
  SparseLU rows_exchanged_{SparseLU::Strategy::kSymmetric};
  FactorStop stop_;
  bool by_fronts_ = false;  // which of them holds the factor
  bool analysed_ = false;
  ExchangedColumns exchanged_;
  Vector rhs_, change_, error_, y_;  // scratch
  FrontalLU::Columns several_;
  std::array<Vector, kRightSides> solutions_;
};

}  // namespace bipot
