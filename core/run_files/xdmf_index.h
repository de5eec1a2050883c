#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "core/base/file_error.h"

namespace bipot {

/// A circular wall is drawn as a closed polygon of this number of points.
inline constexpr int kRimPoints = 97;

/// run.xdmf: the frames of a run for ParaView. Three collections have one grid for each frame:
/// disks as points, contacts as lines between the centres, walls as lines. Two more hold circular
/// walls and the cell of periodic scenes.
class XdmfIndex {
 public:
  /// Entry of one frame in the index of a run.
  struct Frame {
    int step = 0;
    double time = 0;  ///< [s]
    std::size_t contacts = 0;
    bool stress = true;              ///< false: of a version that did not write stresses
    std::size_t bodies = 0;          ///< where their number changes
    std::string group = "/bodies/";  ///< of the bodies (run_layout.h)
  };
  /// What the frames of a run have.
  struct Contents {
    int dimensions = 2;
    std::size_t bodies = 0;
    std::size_t walls = 0;       ///< lines; in 3D pieces with four corners
    std::size_t circles = 0;     ///< walls that are circles
    std::size_t cell_lines = 0;  ///< outline of a periodic cell; bodies are at their places in it
    bool bodies_change = false;  ///< bodies come or go: each frame gives their number
    bool clusters = false;       ///< each frame gives the cluster of each body
  };
  explicit XdmfIndex(const Contents& contents) : has_(contents) {}

  void add(const Frame& frame);
  /// Whole or not at all (AtomicFile). Throws FileError.
  void write(const std::filesystem::path& path) const;

 private:
  Contents has_;
  std::string disks_, contacts_, walls_, circles_, cell_;  // grids of all frames
};

}  // namespace bipot
