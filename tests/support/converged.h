#pragma once

#include <source_location>

#include "solvers/registry.h"
#include "solvers/solve.h"
#include "tests/support/test.h"

namespace bipot {

/// The result, which must have ended so: else the caller's line fails with its message and `what`
/// was solved.
template <class Result, class What = const char*>
Result ended(SolveStatus expected, Result result, const What& what = "",
             const std::source_location& here = std::source_location::current()) {
  if (result.status != expected) {
    ADD_FAILURE_AT(here.file_name(), static_cast<int>(here.line()))
        << what << ": " << to_string(result.status) << " and not " << to_string(expected) << ", "
        << result.message;
  }
  return result;
}
template <class Result, class What = const char*>
Result converged(Result result, const What& what = "",
                 const std::source_location& here = std::source_location::current()) {
  return ended(SolveStatus::kConverged, std::move(result), what, here);
}

}  // namespace bipot
