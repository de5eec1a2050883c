#pragma once

#include <string>

#include "bench/report/json.h"
#include "bench/scenes/scene_run.h"

namespace bipot {

/// What `bipot run` says of a run when it is over.
struct RunSummary {
  const Scene& scene;
  const State& state;  ///< at the end
  const SceneRun& run;
  std::string status;
  int exit_code = 0;
  double wall_seconds = 0;  ///< of the whole command
  std::string out;          ///< folder of the results; empty: none
};

/// summary.json; data/formats.md describes the keys.
Json to_json(const RunSummary& summary);

/// The same in short, for the terminal.
std::string to_text(const RunSummary& summary);

}  // namespace bipot
