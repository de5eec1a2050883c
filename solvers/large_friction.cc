#include "solvers/large_friction.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/problem/extended_error.h"

namespace bipot {
namespace {

// From this friction on, rounding of the criterion in double precision may pass for convergence.
constexpr double kLargeFriction = 1e4;
// What the extended figure may exceed the tolerance by: the solver could not see it.
constexpr double kExtendedGrace = 1.25;
constexpr int kRounds = 10;
// Rounding of so many tolerances is looked at.
constexpr double kVisible = 0.05;

bool is_large(const ContactProblem& p) {
  return p.num_contacts() > 0 && p.mu.maxCoeff() >= kLargeFriction;
}

/// Bound of what rounding of W s leaves in ε, sᵀ|W|s <= (Σ |s_i| W_ii^½)² times its unit; 0 where
/// the packing is not hyperstatic.
double rounding(const ContactProblem& p, const Eigen::Ref<const Vector>& s,
                const ContactError& error) {
  if (p.has_velocities() && (p.num_rows() <= p.num_dofs() || !is_diagonal(p.A))) return 0;
  double sum = 0;
  for (Eigen::Index i = 0; i < s.size(); ++i) {
    if (s[i] == 0) continue;
    double w = 0;
    if (p.has_velocities()) {
      for (SparseMatrix::InnerIterator it(p.H, i); it; ++it) {
        w += it.value() * it.value() / p.A.coeff(it.row(), it.row());
      }
    } else {
      w = p.W.coeff(i, i);
    }
    sum += std::abs(s[i]) * std::sqrt(w);
  }
  return std::numeric_limits<double>::epsilon() * sum * sum /
         std::max(error.friction_power, kTheta * error.energy);
}

}  // namespace

ExtendedClaim claim_in_extended_precision(const ContactProblem& p, const SolverOptions& options,
                                          const Eigen::Ref<const Vector>& s,
                                          const ContactError& error) {
  ExtendedClaim claim;
  if (options.stop != StopTest::kGuarded || p.num_contacts() == 0) return claim;
  if (!is_large(p) && !(rounding(p, s, error) > kVisible * options.tol)) return claim;
  claim.error = extended_guarded_error(p, s);
  claim.holds = !(claim.error > kExtendedGrace * options.tol);
  return claim;
}

double cancel_rounding(const ContactProblem& p, const SolverOptions& options,
                       ContactErrorEvaluator& evaluate, Vector& s) {
  if (!is_large(p)) return evaluate(s).guarded();
  const auto judge = [&](const Vector& x) {
    const double error = evaluate(x).guarded();
    return std::max(error, extended_guarded_error(p, evaluate.impulse()) / kExtendedGrace);
  };
  double error = judge(s);
  bool better = true;
  for (int round = 0; round < kRounds && better && error > options.tol; ++round) {
    better = false;
    if (options.cancelled && options.cancelled()) break;
    for (double& entry : s) {
      if (entry == 0) continue;
      for (const double towards : {-kInfinity, kInfinity}) {
        const double before = entry;
        entry = std::nextafter(before, towards);
        const double changed = judge(s);
        if (changed < error) {
          error = changed;
          better = true;
        } else {
          entry = before;
        }
      }
    }
  }
  return error;
}

}  // namespace bipot
