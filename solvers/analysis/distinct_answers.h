#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/criterion/contact_error.h"
#include "core/problem/contact_problem.h"
#include "core/problem/delassus.h"

namespace bipot {

/// An impulse that was judged on the problem alone.
struct VerifiedAnswer {
  Vector s;            ///< projected on K_mu, the problem's variables                    [N s]
  ContactError error;  ///< of s
  double guarded = 0;  ///< of s, see accurate_guarded_error()
  std::string found_by;
  /// largest distance of an exact answer that the error of s allows, see DistinctAnswers [J^½]
  double explained = 0;
};

/// Decides whether impulses that satisfy the contact law are one answer or several, by their
/// velocities. Distances are ‖v - v'‖_A = sqrt(dᵀ W d), d = s - s', [J^½]: unlike impulses,
/// velocities do not depend on self-stress.
///
/// An error explains a distance of
///
///     explained(s) = sqrt(2 (max(ε, η) + ρ) max(D, θ E)),    ρ: that of s, see rounding_floor()
///
/// from an exact answer, for any conditioning of W, where the law is monotone (no friction, or
/// friction of given normal forces). Answers count as distinct beyond 100 times that, for Coulomb's
/// law. [ours] The reasons are in data/manual/explanation/answers.md.
class DistinctAnswers {
 public:
  static constexpr double kTrusted = 1e-9;  ///< guarded error above which nothing is believed
  static constexpr double kFactor = 100;

  /// The problem must outlive this.
  explicit DistinctAnswers(const ContactProblem& problem);

  /// Index of the answer that s is: an earlier one, or a new one. -1 if the error of s exceeds
  /// kTrusted.
  int add(const Vector& s, std::string_view found_by);

  /// The error of s, s on the cone, and the distance that the error explains.
  VerifiedAnswer judge(const Vector& s, std::string_view found_by);
  /// True if farther apart than kFactor times the distances that both errors explain, both trusted.
  bool are_distinct(const VerifiedAnswer& a, const VerifiedAnswer& b) const;
  /// ‖v(a) - v(b)‖_A                                                                     [J^½]
  double distance(const Vector& a, const Vector& b) const;
  /// A distance over ‖v - v_free‖_A of the first answer; NaN if that is zero.
  double relative(double distance) const;
  /// Index of the answer nearest to s, of those that `among` takes; -1 without any.
  int nearest(const Vector& s, const std::function<bool(const VerifiedAnswer&)>& among) const;

  const std::vector<VerifiedAnswer>& answers() const { return answers_; }
  /// Largest relative distance between two answers; 0 with one, NaN with none.
  double spread() const;

 private:
  const ContactProblem& problem_;
  ContactErrorEvaluator evaluate_;
  // Restitution: largest ratio of the problem's energies to physical ones.
  double largest_scale_ = 1;
  std::vector<VerifiedAnswer> answers_;
};

}  // namespace bipot
