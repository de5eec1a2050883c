#include "bench/measure/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/SpecialFunctions>

namespace bipot {
namespace {

/// By least squares.
struct FittedLine {
  double slope = kNaN, mean_x = 0, mean_y = 0;
  double spread = 0;  // Σ (x - mean_x)²
};

FittedLine fit_line(std::span<const double> x, std::span<const double> y) {
  FittedLine line;
  const double n = static_cast<double>(x.size());
  for (std::size_t k = 0; k < x.size(); ++k) {
    line.mean_x += x[k] / n;
    line.mean_y += y[k] / n;
  }
  double together = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    line.spread += (x[k] - line.mean_x) * (x[k] - line.mean_x);
    together += (x[k] - line.mean_x) * (y[k] - line.mean_y);
  }
  line.slope = together / line.spread;
  return line;
}

}  // namespace

double student_t(double probability, int degrees_of_freedom) {
  if (!(degrees_of_freedom >= 1)) return kNaN;
  // P(|T| > t) = I_{ν/(ν + t²)}(ν/2, 1/2), decreasing in t: bisection on x = ν/(ν + t²).
  const double nu = degrees_of_freedom;
  double low = 0, high = 1;
  for (int k = 0; k < 200; ++k) {
    const double x = 0.5 * (low + high);
    (Eigen::numext::betainc(0.5 * nu, 0.5, x) < 1 - probability ? low : high) = x;
  }
  return std::sqrt(nu / low - nu);
}

double fitted_slope(std::span<const double> x, std::span<const double> y) {
  return fit_line(x, y).slope;
}

PowerLaw fit_power_law(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<double> a, b;
  for (std::size_t k = 0; k < std::min(x.size(), y.size()); ++k) {
    if (!(x[k] > 0 && y[k] > 0 && std::isfinite(x[k]) && std::isfinite(y[k]))) continue;
    a.push_back(std::log(x[k]));
    b.push_back(std::log(y[k]));
  }
  PowerLaw law{.points = static_cast<int>(a.size())};
  if (law.points < 2) return law;
  const FittedLine line = fit_line(a, b);
  if (!(line.spread > 1e-20)) return law;
  law.exponent = line.slope;
  law.prefactor = std::exp(line.mean_y - law.exponent * line.mean_x);
  if (law.points < 3) return law;
  double residual = 0;
  for (int k = 0; k < law.points; ++k) {
    const double r = b[k] - line.mean_y - law.exponent * (a[k] - line.mean_x);
    residual += r * r;
  }
  law.confidence =
      student_t(0.95, law.points - 2) * std::sqrt(residual / (law.points - 2) / line.spread);
  return law;
}

std::string exponent_label(const PowerLaw& law) {
  if (!std::isfinite(law.exponent)) return "–";
  if (!std::isfinite(law.confidence)) return fmt::format("{:.2f}", law.exponent);
  return fmt::format("{:.2f} ± {:.2f}", law.exponent, law.confidence);
}

double median(std::vector<double> x) {
  std::erase_if(x, [](double value) { return !std::isfinite(value); });
  std::ranges::sort(x);
  return sorted_median(x);
}

double sorted_median(std::span<const double> sorted) {
  if (sorted.empty()) return kNaN;
  return 0.5 * (sorted[(sorted.size() - 1) / 2] + sorted[sorted.size() / 2]);
}

double quantile(std::span<const double> sorted, double q) {
  if (sorted.empty()) return kNaN;
  const double rank = std::ceil(q * static_cast<double>(sorted.size()) - 1e-9);
  return sorted[static_cast<std::size_t>(std::max(1.0, rank)) - 1];
}

MeanValue mean_value(std::span<const double> x) {
  MeanValue value;
  if (x.empty()) return value;
  const double n = static_cast<double>(x.size());
  double sum = 0, squares = 0;
  for (double y : x) sum += y;
  value.mean = sum / n;
  for (double y : x) squares += (y - value.mean) * (y - value.mean);
  if (x.size() > 1) {
    value.confidence =
        student_t(0.95, static_cast<int>(x.size()) - 1) * std::sqrt(squares / (n - 1) / n);
  }
  return value;
}

MeanValue mean_of_blocks(std::span<const std::vector<double>> blocks) {
  std::vector<double> means;
  for (const std::vector<double>& block : blocks) {
    if (!block.empty()) means.push_back(mean_value(block).mean);
  }
  return mean_value(means);
}

ExponentialTail fit_exponential_tail(std::vector<double> x, double from) {
  std::erase_if(x, [&](double value) { return !(value >= from); });
  std::ranges::sort(x);
  ExponentialTail tail{.points = static_cast<int>(x.size())};
  double sum = 0;
  for (double value : x) sum += value - from;
  if (!(sum > 0)) return tail;
  const double count = tail.points;
  tail.rate = count / sum;
  tail.confidence = 1.96 * tail.rate / std::sqrt(count);
  tail.distance = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double fitted = 1 - std::exp(-tail.rate * (x[k] - from));
    const double below = static_cast<double>(k) / count;
    tail.distance = std::max({tail.distance, fitted - below, below + 1 / count - fitted});
  }
  return tail;
}

}  // namespace bipot
