#pragma once

#include <vector>

#include "core/linear/frontal_lu.h"
#include "solvers/homotopy/law_point.h"

namespace bipot {

/// Solves with the matrix B of a point's cells (cell_matrix.h) in the velocities of bodies: with
/// W = Gᵀ A⁻¹ G, B x = g says of impulses s and velocities u
///
///     u - (W + D) s = g,   s = -C (g + Gᵀ v),   K v = -G C g,   K = A + G C Gᵀ,
///
/// C having of each contact what its cell lets an impulse do: 1/D where it sticks, (1, -+mu) / D_n
/// from the normal velocity alone where it slips, 0 where it is open. K has three rows for a body
/// and the pattern of `admm`'s matrix, whose analysis serves here, where B has two for a contact:
/// three quarters of the memory on poured disks. The factor is kept in single precision. Refers to
/// the problem, which must have `bodies`.
class CellVelocities final : public MatrixByLines {
 public:
  explicit CellVelocities(const LawProblem& problem) : problem_(problem) {}

  /// False: singular, or memory ran out. The columns must be sorted; `proximal`: the diagonal of D.
  /// Both are referred to by solve().
  [[nodiscard]] bool factor(const std::vector<Column>& columns, const Vector& proximal);
  /// x = B⁻¹ g without refinement. No allocation after the first.
  void solve(const Vector& g, Vector& x);
  /// Sign of det B times (-1)^(number of impulse columns): that of det K.
  int orientation() const { return fronts_.determinant_sign(); }

  double diagonal(int j) const override;
  void add_column(int j, FrontLine& to) const override { add_line(j, false, to); }
  void add_row(int i, FrontLine& to) const override { add_line(i, true, to); }

 private:
  /// C of a contact: impulse a from velocity b.
  struct Compliance {
    double at[2][2];
  };
  Compliance compliance(int contact) const;
  template <class Add>
  void for_line(int j, bool transposed, const Add& add) const;
  void add_line(int j, bool transposed, FrontLine& to) const;

  const LawProblem& problem_;
  const std::vector<Column>* columns_ = nullptr;
  const Vector* proximal_ = nullptr;
  FrontalLU<float> fronts_;
  bool analysed_ = false;
  Vector velocity_, momentum_;  // scratch
};

}  // namespace bipot
