#pragma once

#include <functional>
#include <string>

#include "core/base/types.h"

namespace bipot {

/// minimise cost·x subject to A x = 0, 0 <= x <= upper. x = 0 is always feasible, so that a bounded
/// programme has an optimum.
struct LinearProgramme {
  /// x and multipliers y with cost - Aᵀ y >= 0 at x = 0, <= 0 at the upper bound.
  struct Optimum {
    bool found = false;
    std::string message;  ///< why not
    double value = kNaN;  ///< cost·x
    Vector x;             ///< n
    Vector y;             ///< k
    int pivots = 0;
  };
  SparseMatrix A;  ///< k x n
  Vector cost;     ///< n
  Vector upper;    ///< n, may hold kInfinity
};

/// Solves it by the dual simplex method (CLP, COIN-OR) in floating point. Proofs need a separate
/// check. `stopped`, asked in each pivot: true ends it.
LinearProgramme::Optimum solve(const LinearProgramme& programme,
                               const std::function<bool()>& stopped);

}  // namespace bipot
