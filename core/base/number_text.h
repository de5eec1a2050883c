#pragma once

#include <charconv>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/types.h"

namespace bipot {

/// The number at the begin of a text, NaN without one. The decimal sign is a point in any locale.
inline double number_at(std::string_view text) {
  double x = kNaN;
  std::from_chars(text.data(), text.data() + text.size(), x);
  return x;
}

/// The number that a text is, blanks excluded; empty: it is none, or beyond the type.
template <class Number>
std::optional<Number> whole_number(std::string_view text) {
  Number x{};
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, x);
  if (error != std::errc() || end != last) return std::nullopt;
  return x;
}

/// The number that other programs print as this whole text: a plus may stand before it. Beyond the
/// largest double it is infinite, below the smallest 0.
inline std::optional<double> printed_number(std::string_view text) {
  const bool plus = text.starts_with('+') && !text.starts_with("+-");
  if (plus) text.remove_prefix(1);
  double x = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), x);
  if (end != text.data() + text.size()) return std::nullopt;
  if (error == std::errc::result_out_of_range) {
    const bool small = text.find_first_of("eE") < text.rfind('-') && text.rfind('-') != text.npos;
    return small ? 0 : (text.starts_with('-') ? -kInfinity : kInfinity);
  }
  return error == std::errc() ? std::optional(x) : std::nullopt;
}

/// 1e-6 and not 1e-06; 0.01.
std::string tolerance_label(double tol);

}  // namespace bipot
