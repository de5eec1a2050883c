#include "solvers/analysis/distinct_answers.h"

#include <algorithm>
#include <cmath>

#include "core/base/types.h"
#include "core/criterion/extended_error.h"
#include "core/criterion/rounding_bound.h"
#include "core/problem/energy_norm.h"

namespace bipot {

DistinctAnswers::DistinctAnswers(const ContactProblem& problem)
    : problem_(problem), evaluate_(problem) {
  if (problem.row_scale.size() != 0) {
    largest_scale_ = std::max(1.0, problem.row_scale.cwiseAbs2().maxCoeff());
  }
}

VerifiedAnswer DistinctAnswers::judge(const Vector& s, std::string_view found_by) {
  VerifiedAnswer answer{.error = evaluate_(s), .found_by = std::string(found_by)};
  answer.s = evaluate_.impulse();
  answer.guarded = accurate_guarded_error(problem_, answer.s, answer.error);
  const double scale = std::max(answer.error.friction_power, kTheta * answer.error.energy);
  const double rounding = rounding_floor(problem_, answer.s, answer.error);
  const double error = answer.guarded + (std::isfinite(rounding) ? rounding : 0);
  answer.explained = std::sqrt(2 * error * largest_scale_ * scale);
  return answer;
}

bool DistinctAnswers::are_distinct(const VerifiedAnswer& a, const VerifiedAnswer& b) const {
  return a.guarded <= kTrusted && b.guarded <= kTrusted &&
         distance(a.s, b.s) > kFactor * (a.explained + b.explained);
}

int DistinctAnswers::add(const Vector& s, std::string_view found_by) {
  if (s.size() != problem_.num_rows() || !s.allFinite()) return -1;
  VerifiedAnswer answer = judge(s, found_by);
  if (!(answer.guarded <= kTrusted)) return -1;
  // Near several answers, as in a family: the nearest.
  const int same =
      nearest(answer.s, [&](const VerifiedAnswer& other) { return !are_distinct(answer, other); });
  if (same >= 0) return same;
  answers_.push_back(std::move(answer));
  return static_cast<int>(answers_.size()) - 1;
}

double DistinctAnswers::distance(const Vector& a, const Vector& b) const {
  return std::sqrt(energy_product(problem_, evaluate_.delassus(), a - b));
}

double DistinctAnswers::relative(double distance) const {
  if (answers_.empty()) return kNaN;
  return relative_error(
      distance, std::sqrt(energy_product(problem_, evaluate_.delassus(), answers_.front().s)));
}

int DistinctAnswers::nearest(const Vector& s,
                             const std::function<bool(const VerifiedAnswer&)>& among) const {
  int best = -1;
  double closest = kInfinity;
  for (std::size_t k = 0; k < answers_.size(); ++k) {
    if (!among(answers_[k])) continue;
    const double apart = distance(s, answers_[k].s);
    if (best >= 0 && !(apart < closest)) continue;
    best = static_cast<int>(k);
    closest = apart;
  }
  return best;
}

double DistinctAnswers::spread() const {
  if (answers_.empty()) return kNaN;
  double largest = 0;
  for (std::size_t i = 0; i < answers_.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      largest = std::max(largest, distance(answers_[i].s, answers_[j].s));
    }
  }
  return relative(largest);
}

}  // namespace bipot
