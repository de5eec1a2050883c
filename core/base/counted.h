#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

namespace bipot {

/// "1 step", "3 steps".
inline std::string counted(long number, std::string_view noun) {
  return fmt::format("{} {}{}", number, noun, number == 1 ? "" : "s");
}

}  // namespace bipot
