#pragma once

#include "solvers/registry.h"
#include "solvers/solve.h"
#include "tests/support/test.h"

namespace bipot {

// The caller's place by built-in functions: clang 14 has no std::source_location.

/// The result, which must have ended so: else the caller's line fails with its message and `what`
/// was solved.
template <class Result, class What = const char*>
Result ended(SolveStatus expected, Result result, const What& what = "",
             const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
  if (result.status != expected) {
    ADD_FAILURE_AT(file, line) << what << ": " << to_string(result.status) << " and not "
                               << to_string(expected) << ", " << result.message;
  }
  return result;
}
template <class Result, class What = const char*>
Result converged(Result result, const What& what = "", const char* file = __builtin_FILE(),
                 int line = __builtin_LINE()) {
  return ended(SolveStatus::kConverged, std::move(result), what, file, line);
}

}  // namespace bipot
