#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/file_error.h"
#include "core/motion/stress_tensor.h"
#include "core/motion/time_stepping.h"
#include "core/run_files/background_writer.h"
#include "core/run_files/csv_file.h"
#include "core/run_files/observable_output.h"
#include "core/run_files/xdmf_index.h"

namespace bipot {

/// Writes a run into a folder:
///   run.h5               what does not change: scene text, version, disks' radius, mass, inertia
///                        and material, walls, materials, solver; links /frames/<step> to
///                        the files below
///   frames/<step>.h5     one state: all that a restart needs, the contacts with impulses,
///                        forces, velocities and status, and the stresses that follow from them
///   run.xdmf             index of the frames for ParaView: disks (in space: spheres) as points, contacts as lines
///                        between the centres, walls as lines
///   ledger.csv           one row for each scene.output.ledger_every steps, and the last
///   gates.csv            what went through outlets and inlets, likewise, if the scene has any
///   observables.csv ...  what the scene asks to be measured (core/run_files/observable_output.h)
///   trajectory.csv       one row for each step and tracked disk, if scene.output.track names any
/// data/manual/reference/files.md describes each entry.
///
/// Every file but the CSV appears whole (AtomicFile): whenever the program is killed, all frames
/// written so far can be read, and ParaView may look on while the run goes on. run.h5 and run.xdmf
/// are rewritten after every frame up to the 32nd; later after every 1/32 of the frames so far,
/// which bounds the cost, and by close(). read_state() finds the frames without them.
/// Throws FileError.
template <int D>
class RunWriter {
 public:
  /// Creates the folder. Output of an earlier run in it is removed; with `resume_after` >= 0, what
  /// belongs to later steps is removed and the rest is continued. The scene must outlive the writer.
  RunWriter(std::filesystem::path folder, const Scene<D>& scene, std::string scene_text,
            int resume_after = -1);
  RunWriter(std::filesystem::path, Scene<D>&&, std::string, int = -1) = delete;
  /// Closes, but cannot report a failure: call close().
  ~RunWriter();
  RunWriter(const RunWriter&) = delete;
  RunWriter& operator=(const RunWriter&) = delete;

  /// Ledger and trajectories of a step. What only the ledger asks for (stress and area of the sample)
  /// is computed where a row is due; the frame of the same step takes it from there.
  void step(const State<D>& state, const StepReport<D>& report);
  /// A frame, which is written when this returns; the one of the same step again is not an error and
  /// does nothing.
  void frame(const State<D>& state);
  /// The same of a copy, while the caller goes on: files, bits and order are those of frame(). Waits
  /// for the frame before, of which there is one at most; what went wrong with it is thrown by the next
  /// call of frame(), frame_beside() or close(), or by step() where it is known by then.
  void frame_beside(const State<D>& state);
  /// The row of the ledger of the state `last`, where step() left it out, then close().
  void finish(const State<D>& last);
  /// Writes what is due at the end. Without effect the second time.
  void close();

 private:
  bool is_due(const State<D>& state);
  void write_row(const State<D>& state, const StepReport<D>& report);
  std::optional<MeanStress<D>> stress_if_known(const State<D>& state) const;
  void write_frame(const State<D>& state, const std::optional<MeanStress<D>>& stress);
  void write_frame_file(const State<D>& state, const MeanStress<D>& stress) const;
  void add_frame(const FrameEntry& frame);
  void write_index();
  void write_run_file() const;

  std::filesystem::path folder_;
  const Scene<D>& scene_;
  std::string scene_text_;
  std::vector<FrameEntry> frames_;
  std::optional<CsvFile> ledger_, trajectory_, gates_;
  std::optional<ObservableWriter<D>> observables_;
  std::optional<StepReport<D>> left_out_;               // of the last step, if its row was not due
  std::pair<int, MeanStress<D>> known_stress_{-1, {}};  // step and sample of the last row
  XdmfIndex xdmf_;
  std::size_t indexed_ = 0;  // frames that run.h5 and run.xdmf know
  bool closed_ = false;
  BackgroundWriter beside_;  // last: its job uses the others
};

}  // namespace bipot
