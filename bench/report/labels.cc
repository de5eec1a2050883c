#include "bench/report/labels.h"

#include <fmt/format.h>

#include <cmath>

namespace bipot {
namespace {

std::string with_exponent(double x, int decimals) {
  if (x == 0) return "0";
  if (!std::isfinite(x)) return "–";
  return short_exponent(fmt::format("{:.{}e}", x, decimals));
}

}  // namespace

std::string short_exponent(const std::string& text) {
  const std::size_t e = text.find('e');
  if (e == std::string::npos) return text;
  return fmt::format("{}e{}", text.substr(0, e), std::stoi(text.substr(e + 1)));
}

std::string count_label(double count) {
  return std::isfinite(count) ? fmt::format("{:.0f}", count) : "–";
}

std::string seconds_label(double seconds) {
  if (!std::isfinite(seconds)) return "–";
  if (seconds < 1e-3) return fmt::format("{:.3g} µs", seconds * 1e6);
  if (seconds < 1) return fmt::format("{:.3g} ms", seconds * 1e3);
  return fmt::format("{:.3g} s", seconds);
}

std::string duration_label(double seconds) {
  return seconds >= 120 ? fmt::format("{:.3g} min", seconds / 60) : seconds_label(seconds);
}

std::string error_label(double error) { return std::isinf(error) ? "∞" : compact_label(error); }

std::string ratio_label(double ratio) {
  if (std::isnan(ratio)) return "–";
  if (std::isinf(ratio)) return "∞";
  return ratio < 99.95 ? fmt::format("{:.3g}", ratio) : fmt::format("{:.0f}", ratio);
}

std::string accuracy_label(double accuracy) {
  return accuracy >= 1e-3 ? fmt::format("{:g} %", 100 * accuracy) : tolerance_label(accuracy);
}

std::string compact_label(double x) { return with_exponent(x, 1); }
std::string digit_label(double x) { return with_exponent(x, 0); }

std::string share_label(double x) {
  if (x >= 0.0995) return fmt::format("{:.0f} %", 100 * x);
  return x >= 1e-4 ? fmt::format("{:.2g} %", 100 * x) : compact_label(x);
}

std::string overlap_label(double x) { return fmt::format("{:.3g} %", 100 * x); }

std::string value_label(double x) {
  return std::isfinite(x) ? short_exponent(fmt::format("{:.4g}", x)) : "–";
}

}  // namespace bipot
