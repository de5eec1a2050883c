#pragma once

#include <algorithm>
#include <cctype>
#include <string>

namespace bipot {

/// The text as part of a test's name: letters and digits stay, the rest becomes '_'.
inline std::string test_name(std::string text) {
  const auto other = [](unsigned char c) { return std::isalnum(c) == 0; };
  std::replace_if(text.begin(), text.end(), other, '_');
  return text;
}

}  // namespace bipot
