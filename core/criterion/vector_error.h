#pragma once

#include "core/criterion/contact_error.h"

namespace bipot {

/// Sums of the criterion over the contacts of one piece, and the worst of them.
struct PieceSums : ErrorSums {
  double worst_gap = -1, worst_natural = -1;
  int worst_epsilon = -1, worst_eta = -1;

  /// Adds a later piece. Of two equally bad contacts the first one counts.
  void add(const PieceSums& later);
};

/// Arrays of the contacts of a problem: d numbers of each in s, u, b and row_scale, one in the
/// others.
struct ContactArrays {
  const double* s;  ///< on the cone
  const double* u;  ///< W s + b
  const double* b;
  const double* row_scale;  ///< or null
  const double* mu;
  const double *w_nn, *rho_nn, *rho_nat;  ///< ErrorWeights
};

/// The projection in physical variables and the sums of the criterion (contact_terms.h) for the
/// contacts [begin, end), as many at once as the machine's registers hold. Compiled for several
/// instruction sets, with the same bits from all: every eighth contact is added to the same sum,
/// and these sums are added in one order.
///
/// For d = 2 and for d = 3.
void project_on_plane_cones(const ContactArrays& p, int begin, int end, double* s);
PieceSums sum_plane_errors(const ContactArrays& p, int begin, int end);
void project_on_space_cones(const ContactArrays& p, int begin, int end, double* s);
PieceSums sum_space_errors(const ContactArrays& p, int begin, int end);

}  // namespace bipot
