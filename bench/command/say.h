#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <utility>

namespace bipot {

/// Writes to standard error. A message that cannot be written stops nothing.
template <class... Values>
void say(fmt::format_string<Values...> text, Values&&... values) {
  std::fputs(fmt::format(text, std::forward<Values>(values)...).c_str(), stderr);
}

}  // namespace bipot
