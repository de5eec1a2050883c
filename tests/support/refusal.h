#pragma once

#include <gtest/gtest.h>

#include <exception>
#include <optional>
#include <string>

namespace bipot {

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
