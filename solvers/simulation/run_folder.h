#pragma once

#include <filesystem>
#include <optional>

#include "core/run_files/film.h"
#include "core/run_files/run_output.h"
#include "solvers/simulation/scene_run.h"

namespace bipot {

/// True if a step's state is written, whole or in part.
bool needs_state(const OutputChoice& output, int step);

/// The folder of a run: the files of RunWriter, the film for its page, on request the contact problems of its steps, and
/// the pictures that the scene asks for. A problem has the start of its solver as a guess, and its
/// geometry. Throws FileError.
template <int D>
class RunFolder {
 public:
  /// Writes the frame of the initial state. The scene must outlive the folder.
  RunFolder(const Scene<D>& scene, const State<D>& state, const RunFolderOptions& options);

  void step(const SceneStep<D>& step);
  /// Writes the last frame, the indices, the problem of a failed step, and the pictures.
  void finish(const State<D>& state, const SceneRun<D>& run);

 private:
  std::filesystem::path problem_path(int step) const;
  void write_problem(const ContactProblem& problem, const Vector& start,
                     const StepReport<D>& report);
  void draw(const State<D>& state, const SceneTotals<D>& totals) const;

  const Scene<D>& scene_;
  RunFolderOptions options_;
  RunWriter<D> writer_;
  std::optional<FilmRecorder<D>> film_;  // for the page, unless the scene has none
  bool framed_ = true;                   // the last step has its frame
};

}  // namespace bipot
