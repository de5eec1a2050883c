#pragma once

#include <string>

#include "bench/report/json_output.h"
#include "solvers/simulation/scene_run.h"
#include "solvers/simulation/scene_start.h"

namespace bipot {

/// Data of the summary of `bipot run`.
template <int D>
struct RunSummary {
  const Scene<D>& scene;
  const State<D>& state;  ///< at the end
  const SceneRun<D>& run;
  std::string status;
  int exit_code = 0;
  double wall_seconds = 0;  ///< of the whole command
  std::string out;          ///< folder of the results
  StartReport start;
  std::string note;  ///< empty: none
};

/// summary.json; data/manual/reference/files.md describes the keys.
template <int D>
Json to_json(const RunSummary<D>& summary);

/// The same in short, for the terminal.
template <int D>
std::string to_text(const RunSummary<D>& summary);

}  // namespace bipot
