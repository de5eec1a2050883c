#pragma once

#include <span>
#include <vector>

#include "core/base/types.h"

namespace bipot {

/// Space cut into one box for each process by recursive coordinate bisection (Berger and Bokhari,
/// IEEE Trans. Comput. 36, 1987). The longest side of the points' box is cut so that the weights on
/// both sides have the ratio of the numbers of processes; each side is cut again. Cuts lie halfway
/// between two coordinates. Points with the same coordinate stay together, so that a cell may be
/// empty. The same points and weights give the same cells everywhere.
class CellTree {
 public:
  /// One cell for everything.
  CellTree() = default;
  /// `weights`: one for each point, >= 0; if all are 0, every point counts 1. cells >= 1. Throws
  /// std::invalid_argument for other sizes or values.
  CellTree(std::span<const Vec3> points, std::span<const double> weights, int cells);

  /// The tree with these to_numbers(), so that one process may cut for all. Throws
  /// std::invalid_argument for other numbers.
  static CellTree from_numbers(std::span<const double> numbers);
  std::vector<double> to_numbers() const;

  int cells() const { return cells_; }
  int cell_of(const Vec3& point) const;

 private:
  struct Cut {
    int axis = 0;
    double at = 0;              // points below go left
    int left = -1, right = -1;  // another cut, or ~cell
  };
  int cut(std::span<const Vec3> points, std::span<const double> weights, std::span<int> chosen,
          int first_cell, int cells);

  int cells_ = 1;
  int root_ = ~0;
  std::vector<Cut> cuts_;
};

/// The largest of the weights over their mean: 1 is even. 1 if all are 0.
double imbalance(std::span<const double> weights);

}  // namespace bipot
