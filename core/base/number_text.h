#pragma once

#include <charconv>
#include <string_view>

#include "core/base/types.h"

namespace bipot {

/// The number at the begin of a text, NaN without one. The decimal sign is a point in any locale.
inline double number_at(std::string_view text) {
  double x = kNaN;
  std::from_chars(text.data(), text.data() + text.size(), x);
  return x;
}

}  // namespace bipot
