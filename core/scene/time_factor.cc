#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "core/scene/scene.h"

namespace bipot {

double TimeFactor::at(double time) const {
  if (frequency > 0) return std::sin(2 * std::numbers::pi * frequency * time + phase);
  if (times.empty()) return 1;
  const auto next = std::upper_bound(times.begin(), times.end(), time);
  if (next == times.begin()) return factors.front();
  if (next == times.end()) return factors.back();
  const auto k = static_cast<std::size_t>(next - times.begin());
  const double part = (time - *(next - 1)) / (*next - *(next - 1));
  return factors[k - 1] + part * (factors[k] - factors[k - 1]);
}

double TimeFactor::mean(double from, double to) const {
  if (frequency > 0) {
    const double half = std::numbers::pi * frequency * (to - from);
    return at(0.5 * (from + to)) * (half > 0 ? std::sin(half) / half : 1);
  }
  // Linear pieces between the given times.
  const auto first = std::upper_bound(times.begin(), times.end(), from);
  const auto last = std::lower_bound(first, times.end(), to);
  if (first == last) return 0.5 * (at(from) + at(to));
  double sum = 0, begin = from;
  for (auto next = first; begin < to; ++next) {
    const double end = next < last ? *next : to;
    sum += 0.5 * (at(begin) + at(end)) * (end - begin);
    begin = end;
  }
  return sum / (to - from);
}

double TimeFactor::largest(double from, double to) const {
  const double ends = std::max(std::abs(at(from)), std::abs(at(to)));
  if (frequency > 0) {
    // Half periods begin at the extrema.
    const auto half = [&](double time) {
      return std::floor(2 * frequency * time + phase / std::numbers::pi - 0.5);
    };
    return half(from) < half(to) ? 1 : ends;
  }
  double most = ends;
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (times[k] > from && times[k] < to) most = std::max(most, std::abs(factors[k]));
  }
  return most;
}

double TimeFactor::rate(double time) const {
  const double turn = 2 * std::numbers::pi * frequency;
  if (frequency > 0) return turn * std::cos(turn * time + phase);
  const auto next = std::upper_bound(times.begin(), times.end(), time);
  if (next == times.begin() || next == times.end()) return 0;
  const auto k = static_cast<std::size_t>(next - times.begin());
  return (factors[k] - factors[k - 1]) / (times[k] - times[k - 1]);
}

std::string check_time_factor(const TimeFactor& factor) {
  const auto finite = [](double x) { return std::isfinite(x); };
  const std::vector<double>& t = factor.times;
  if (t.size() != factor.factors.size()) return "as many factors as times are needed";
  if (!std::all_of(t.begin(), t.end(), finite) ||
      !std::all_of(factor.factors.begin(), factor.factors.end(), finite)) {
    return "times and factors must be finite";
  }
  if (std::adjacent_find(t.begin(), t.end(), std::greater_equal<>()) != t.end()) {
    return "times must increase";
  }
  if (!(factor.frequency >= 0) || !finite(factor.frequency) || !finite(factor.phase)) {
    return "frequency must be a number >= 0, phase a finite one";
  }
  if (!t.empty() && factor.frequency > 0) return "give either times and factors, or a frequency";
  return {};
}

}  // namespace bipot
