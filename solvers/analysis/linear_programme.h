#pragma once

#include <string>

#include "core/base/types.h"

namespace bipot {

/// minimise cost·x subject to A x = 0, 0 <= x <= upper. The point x = 0 is always allowed, so that
/// a bounded programme has an optimum.
struct LinearProgramme {
  SparseMatrix A;  ///< k x n
  Vector cost;     ///< n
  Vector upper;    ///< n, may hold kInfinity
};

/// x and multipliers y with cost - Aᵀ y >= 0 where x is 0, <= 0 where it is at its upper bound.
struct LinearOptimum {
  bool found = false;
  std::string message;  ///< why not
  double value = kNaN;  ///< cost·x
  Vector x;             ///< n
  Vector y;             ///< k
  int pivots = 0;
};

/// By the dual simplex method (CLP, COIN-OR). `seconds`: wall-clock limit. In floating point: what
/// must hold has to be checked by whoever asks.
LinearOptimum solve(const LinearProgramme& programme, double seconds);

}  // namespace bipot
