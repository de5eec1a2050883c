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
///   run.h5               constant data: scene text, version, disks' radius, mass, inertia
///                        and material, walls, materials, solver; links /frames/<step> to
///                        the files below
///   frames/<step>.h5     one state: all that a restart needs, the contacts with impulses,
///                        forces, velocities and status, and the stresses that follow from them
///   run.xdmf             index of the frames for ParaView: disks (in 3D: spheres) as points,
///                        contacts as lines between the centres, walls as lines
///   ledger.csv           one row for each scene.output.ledger_every steps, and the last
///   gates.csv            bodies through outlets and inlets, likewise, if the scene has any
///   walls.csv            position, velocity, driving force and load of each wall, likewise
///   observables.csv ...  observables, if the scene asks for them (observable_output.h)
///   trajectory.csv       one row for each step and tracked disk, if scene.output.track names any
///   units.csv            unit of each column of these tables
/// data/manual/reference/files.md describes each entry.
///
/// Every file but the CSV appears whole (AtomicFile). If the program is killed, all frames written
/// so far can be read, and ParaView can be used during the run. run.h5 and run.xdmf are rewritten
/// after every frame up to the 32nd, later after every 1/32 of the frames so far, and by close().
/// This bounds the cost. read_state() finds the frames without them. Throws FileError.
template <int D>
class RunWriter {
 public:
  /// Creates the folder. An earlier run in it is removed. With `resume_after` >= 0 only its later
  /// steps are removed, and the rest is continued. The scene must outlive the writer.
  RunWriter(std::filesystem::path folder, const Scene<D>& scene, std::string scene_text,
            int resume_after = -1);
  RunWriter(std::filesystem::path, Scene<D>&&, std::string, int = -1) = delete;
  /// Closes without reporting failures: call close() first.
  ~RunWriter();
  RunWriter(const RunWriter&) = delete;
  RunWriter& operator=(const RunWriter&) = delete;

  /// Writes ledger and trajectories of a step. Stress and area of the sample are computed only if a
  /// row is due; the frame of the same step reuses them.
  void step(const State<D>& state, const StepReport<D>& report);
  /// Writes a frame before it returns. The same step again has no effect and is not an error.
  void frame(const State<D>& state);
  /// Writes a copy of the frame while the caller goes on: files, bits and order are those of
  /// frame(). Waits for the frame before, of which there is one at most. Its errors are thrown by
  /// the next call of frame(), frame_beside() or close(), or by step() if known by then.
  void frame_beside(const State<D>& state);
  /// Writes the row of the ledger for the state `last`, if step() left it out; then close().
  void finish(const State<D>& last);
  /// Writes all that is still due. Without effect the second time.
  void close();

 private:
  bool is_due(const State<D>& state);
  void write_row(const State<D>& state, const StepReport<D>& report);
  std::optional<MeanStress<D>> stress_if_known(const State<D>& state) const;
  void write_frame(const State<D>& state, const std::optional<MeanStress<D>>& stress);
  void add_frame(const XdmfIndex::Frame& frame);
  void write_index();
  void write_run_file() const;

  std::filesystem::path folder_;
  const Scene<D>& scene_;
  std::string scene_text_;
  std::string measured_;  // definition of the observables, if there are any
  std::vector<XdmfIndex::Frame> frames_;
  std::optional<CsvFile> ledger_, trajectory_, gates_, walls_;
  std::optional<ObservableWriter<D>> observables_;
  std::optional<StepReport<D>> left_out_;               // of the last step, if its row was not due
  std::pair<int, MeanStress<D>> known_stress_{-1, {}};  // step and sample of the last row
  XdmfIndex xdmf_;
  std::size_t indexed_ = 0;  // frames that run.h5 and run.xdmf know
  bool closed_ = false;
  BackgroundWriter beside_;  // last: its job uses the others
};

}  // namespace bipot
