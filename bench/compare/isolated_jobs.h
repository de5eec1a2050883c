#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>

namespace bipot {

struct IsolatedJobs {
  /// End of a job that ran in a process of its own.
  struct End {
    enum class Kind { kDone, kCrashed, kHung };
    Kind kind = Kind::kDone;
    nlohmann::json result;
    std::string cause;  ///< of another end
  };
  int count = 0;
  double seconds = 60;  ///< wall time after which a job counts as hung and is killed
  std::function<nlohmann::json(int)> job;       ///< runs in the child; NaN arrives
  std::function<void(int, const End&)> on_end;  ///< runs here, in order
  std::function<bool()> interrupted;            ///< asked between and during jobs; may be empty
};

/// Runs the jobs 0 .. count - 1 one after the other in a child process. A crash or a hang of a job
/// is recorded and does not end the others: the next one then has a new child. An exception from a
/// job counts as a crash. Jobs after an interruption are not run. Throws std::system_error if no
/// process can be made.
void run_isolated(const IsolatedJobs& jobs);

}  // namespace bipot
