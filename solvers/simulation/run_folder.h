#pragma once

#include <filesystem>
#include <string>
#include <type_traits>

#include "core/run_files/run_output.h"
#include "solvers/simulation/scene_run.h"

namespace bipot {

struct RunFolderOptions {
  enum class Problems { kNone, kFailed, kAll };
  std::filesystem::path folder;
  std::string scene_text;  ///< kept in run.h5
  std::string program;     ///< name and version, kept in the problems' descriptions
  bool resume = false;     ///< the folder is that of the run that goes on: its files are continued
  Problems problems = Problems::kNone;  ///< contact problems that are written, as FCLIB files
};

/// The folder that a run leaves: what RunWriter writes, the steps' contact problems on request (each
/// with the impulse that its solver started from, as a guess, and with its geometry), and the
/// pictures that the scene asks for. data/manual/reference/files.md describes the files. Throws FileError.
template <int D>
class RunFolder {
 public:
  /// Writes the frame of the state that the run begins with. The scene must outlive the folder.
  RunFolder(const Scene<D>& scene, const State<D>& state, const RunFolderOptions& options);

  void step(const SceneStep<D>& step);
  /// The last frame, the indices, the problem of a step that was not taken, and the pictures.
  void finish(const State<D>& state, const SceneRun<D>& run);

 private:
  std::filesystem::path problem_path(int step) const;
  void write_problem(const ContactProblem& problem, const Vector& start,
                     const StepReport<D>& report);
  void draw(const State<D>& state, const SceneTotals<D>& totals) const;

  const Scene<D>& scene_;
  RunFolderOptions options_;
  RunWriter<D> writer_;
  bool framed_ = true;  // the last step has its frame
};

/// Runs the scene into the folder: run_scene() with every step written. The rows of what the caller's
/// on_step sees are on disk, its frame may still be being written.
template <int D>
SceneRun<D> run_scene_into(const Scene<D>& scene, State<D>& state,
                           const std::type_identity_t<SceneRunOptions<D>>& run,
                           const RunFolderOptions& folder);

}  // namespace bipot
