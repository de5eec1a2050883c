#pragma once

#include "core/problem/contact_problem.h"

namespace bipot {

/// Dense, in extended precision.
using NaiveMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

/// The criterion straight from its written definition: dense matrices and plain loops. On purpose
/// it uses nothing of core/ but the problem's fields, and repeats all formulas: the independent
/// check of the agreement tests. In extended precision, since unequal masses cost many digits.
/// Slow.
struct NaiveError {
  double epsilon = 0, eta = 0, raw42 = 0;
  /// ‖s - P_K(s - rho û)‖ / max(‖s‖, ‖rho b‖), rho = d / tr W_cc.
  double natmap_scaled = 0;
  Eigen::VectorXd u;  ///< physical mean velocities, recomputed from the projected impulse

  double guarded() const { return epsilon >= eta ? epsilon : eta; }
};

/// Of an impulse in the problem's variables, admissible or not.
NaiveError naive_error(const ContactProblem& problem, const Eigen::VectorXd& s);

/// W of the problem, dense, and the same with W at hand: for many impulses of one problem.
NaiveMatrix naive_delassus(const ContactProblem& problem);
NaiveError naive_error(const ContactProblem& problem, const NaiveMatrix& delassus,
                       const Eigen::VectorXd& s);

}  // namespace bipot
