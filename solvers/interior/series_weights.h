#pragma once

#include "core/base/types.h"

namespace bipot {

/// How the terms of a vector power series z_0 + z_1 alpha + ... + z_n alpha^n are summed: as they
/// stand, or as a rational function whose one denominator serves all components,
///
///     sum_k z_k alpha^k D_(l-k)(alpha) / D(alpha),   k = 0 ... l < n,
///
/// where D_j has the terms of D up to order j, and D(0) = 1. The sum stays linear in the z_k: linear
/// equations that every term satisfies hold for it too. Near a pole or a fold it is accurate
/// further than Taylor's polynomial. Padé approximants of vectors: Cochelin, Damil and
/// Potier-Ferry, Int. J. Numer. Methods Eng. 37, 1994; Elhage-Hussein, Potier-Ferry and Damil,
/// Int. J. Solids Struct. 37, 2000. They orthogonalise the terms, and D cancels the projection of
/// the last one. Here D is of lower degree and cancels the last two terms by least squares.
class SeriesWeights {
 public:
  struct At {
    Vector value;  ///< order + 1: z = sum_k value_k z_k; zero for the terms left out
    Vector slope;  ///< its derivative with respect to alpha
    bool regular;  ///< the denominator is positive
  };

  /// Taylor's polynomial of this order, at least 1.
  explicit SeriesWeights(int order);

  /// The rational sum. `terms`: z_k length^k in column k - 1, of all components or of a sample.
  void fit(const Eigen::MatrixXd& terms, double length);

  At at(double alpha) const;

 private:
  int order_;
  int last_;            // l
  Vector denominator_;  // coefficients of D
};

}  // namespace bipot
