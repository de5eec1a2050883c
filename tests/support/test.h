#pragma once

// What nearly every test needs: GoogleTest, common parts of the standard library, and the way to
// ask what a call refuses.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

namespace bipot {

namespace fs = std::filesystem;

/// The message of the exception of this type that `call` throws; "nothing was thrown" without one.
template <class Exception = std::exception, class Call>
std::string refusal_of(const Call& call) {
  try {
    call();
  } catch (const Exception& e) {
    return e.what();
  }
  return "nothing was thrown";
}

/// The exception of this type that `call` must throw; without one the test fails.
template <class Exception, class Call>
std::optional<Exception> caught(const Call& call) {
  try {
    call();
  } catch (const Exception& e) {
    return e;
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

/// Whether the text has this part; a failed expectation shows both.
inline testing::AssertionResult says(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << '\'' << text << "' lacks '" << part << '\'';
}

}  // namespace bipot
