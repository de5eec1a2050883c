#pragma once

#include <algorithm>
#include <cctype>
#include <map>
#include <string>
#include <utility>

namespace bipot {

/// The text as part of a test's name: letters and digits stay, the rest becomes '_'.
inline std::string test_name(std::string text) {
  const auto other = [](unsigned char c) { return std::isalnum(c) == 0; };
  std::replace_if(text.begin(), text.end(), other, '_');
  return text;
}

/// A solver and its parameters as the name of a test.
inline std::string test_name(std::string solver,
                             const std::map<std::string, std::string>& parameters) {
  for (const auto& [key, value] : parameters) solver += "_" + key + "_" + value;
  return test_name(std::move(solver));
}

}  // namespace bipot
