#include "solvers/interior/series_weights.h"

#include <algorithm>
#include <limits>

#include "core/linear/dense_factor.h"

namespace bipot {
namespace {

constexpr int kCancelled = 2;  // terms, the last ones

}  // namespace

SeriesWeights::SeriesWeights(int order)
    : order_(order), last_(order), denominator_(Vector::Ones(1)) {}

void SeriesWeights::fit(const Eigen::MatrixXd& terms, double length) {
  const int cancelled = std::min(kCancelled, order_ - 1);
  last_ = order_ - cancelled;
  const int degree = std::min(2 * order_ / 3, last_);
  // z_n + D_1 z_(n-1) + D_2 z_(n-2) + ... = 0 for each of the last orders n.
  const Eigen::Index rows = terms.rows();
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(cancelled * rows, degree);
  Vector right(cancelled * rows);
  for (int e = 0; e < cancelled; ++e) {
    const int n = order_ - e;
    right.segment(e * rows, rows) = -terms.col(n - 1);
    for (int i = 1; i <= std::min(degree, n - 1); ++i) {
      system.col(i - 1).segment(e * rows, rows) = terms.col(n - i - 1);
    }
  }
  denominator_.resize(degree + 1);
  const auto pivots = static_cast<double>(std::min(system.rows(), system.cols()));
  const double rounding = std::numeric_limits<double>::epsilon() * pivots;
  denominator_ << 1, least_norm_and_rank(system, right, rounding).first;
  double scale = 1;
  for (int i = 1; i <= degree; ++i) denominator_[i] *= scale /= length;
}

SeriesWeights::At SeriesWeights::at(double alpha) const {
  const Eigen::Index degree = denominator_.size() - 1;
  Vector sum(degree + 1), slope(degree + 1);  // of D_0, D_1, ... and their derivatives
  sum[0] = denominator_[0];
  slope[0] = 0;
  double power = 1;  // alpha^(i - 1)
  for (Eigen::Index i = 1; i <= degree; ++i) {
    slope[i] = slope[i - 1] + static_cast<double>(i) * denominator_[i] * power;
    power *= alpha;
    sum[i] = sum[i - 1] + denominator_[i] * power;
  }
  const double D = sum[degree], growth = slope[degree] / D;
  At at{Vector::Zero(order_ + 1), Vector::Zero(order_ + 1), D > 0};
  at.value[0] = 1;
  power = 1;  // alpha^(k - 1)
  for (int k = 1; k <= last_; ++k) {
    const Eigen::Index i = std::min<Eigen::Index>(degree, last_ - k);
    at.slope[k] = power * (k * sum[i] + alpha * (slope[i] - growth * sum[i])) / D;
    power *= alpha;
    at.value[k] = power * sum[i] / D;
  }
  return at;
}

}  // namespace bipot
