#pragma once

#include "core/criterion/contact_error.h"
#include "solvers/proved_claim.h"
#include "solvers/solver.h"

namespace bipot {

/// What solve() makes of a problem once for all that work on it during that solve: the criterion,
/// set up, and the last claim that was proved. One caller at a time; refers to the problem.
class PreparedProblem {
 public:
  PreparedProblem(const ContactProblem& problem, int threads)
      : problem_(problem), threads_(threads), criterion_(problem, threads) {}
  PreparedProblem(const PreparedProblem&) = delete;
  PreparedProblem& operator=(const PreparedProblem&) = delete;

  bool serves(const ContactProblem& problem, int threads) const {
    return &problem == &problem_ && threads == threads_;
  }
  ContactErrorEvaluator& criterion() { return criterion_; }

  /// The claim of a convergence to `tol` by exactly this impulse, if it is the last that was proved.
  const ProvedClaim* proved(double tol, const Eigen::Ref<const Vector>& s) const;
  void remember(double tol, const Eigen::Ref<const Vector>& s, const ProvedClaim& claim);

 private:
  const ContactProblem& problem_;
  int threads_;
  ContactErrorEvaluator criterion_;
  double proved_tol_ = kNaN;
  Vector proved_impulse_;
  ProvedClaim proved_claim_;
};

/// options.prepared where it is of this problem, else nothing.
PreparedProblem* prepared(const ContactProblem& problem, const SolverOptions& options);

/// An evaluator for the caller alone, judging with options.share: from what solve() prepared where that
/// is of this problem, else made anew.
ContactErrorEvaluator criterion_of(const ContactProblem& problem, const SolverOptions& options);

}  // namespace bipot
