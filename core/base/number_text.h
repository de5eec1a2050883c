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

/// The number that other programs print as this whole text: a plus may stand before it, and the
/// exponent may be Fortran's, as in 1.5D-03 and, beyond 99, 1.5-100. Beyond the largest double it is
/// infinite, below the smallest 0.
std::optional<double> printed_number(std::string_view text);

/// 1e-6 and not 1e-06; 0.01.
std::string tolerance_label(double tol);

}  // namespace bipot
