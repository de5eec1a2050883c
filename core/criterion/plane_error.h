#pragma once

#include "core/criterion/contact_error.h"

namespace bipot {

/// What the contacts of one piece add to the criterion, and the worst of them.
struct PieceSums : ErrorSums {
  double worst_gap = -1, worst_natural = -1;
  int worst_epsilon = -1, worst_eta = -1;

  /// Those of a later piece: of two that are as bad, the first contact counts.
  void add(const PieceSums& later);
};

/// What the criterion reads of the contacts of a problem with d = 2: two numbers of each in s, u, b
/// and row_scale, one in the others.
struct PlaneContacts {
  const double* s;  ///< on the cone
  const double* u;  ///< W s + b
  const double* b;
  const double* row_scale;  ///< or null
  const double* mu;
  const double *w_nn, *rho_nn, *rho_nat;  ///< ErrorWeights
};

/// project_physically() of error_terms.h for the contacts [begin, end), as many at once as the
/// machine's registers hold, and the sums of add_error_terms(). Compiled for several instruction
/// sets, with the same bits from all: every eighth contact is added to the same sum, and these in
/// one order.
void project_on_plane_cones(const PlaneContacts& p, int begin, int end, double* s);
PieceSums sum_plane_errors(const PlaneContacts& p, int begin, int end);

}  // namespace bipot
