#pragma once

#include <charconv>
#include <optional>
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

}  // namespace bipot
