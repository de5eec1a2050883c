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
  /// `circles`: number of walls that are circles. `cell_lines`: number of lines of the outline of a
  /// periodic cell, whose disks are shown at their places in it.
  XdmfIndex(std::size_t disks, std::size_t walls, std::size_t circles = 0,
            std::size_t cell_lines = 0)
      : num_disks_(disks), num_walls_(walls), num_circles_(circles), num_cell_lines_(cell_lines) {}

  /// Spheres as points, contacts as lines, walls as pieces with four corners.
  static XdmfIndex in_space(std::size_t spheres, std::size_t wall_pieces, std::size_t cell_lines) {
    XdmfIndex index(spheres, wall_pieces, 0, cell_lines);
    index.dimensions_ = 3;
    return index;
  }

  /// For a run whose bodies come or go: each frame gives their number.
  void let_bodies_change() { bodies_change_ = true; }

  /// Each frame gives the cluster of each disk.
  void let_disks_be_joined() { clusters_ = true; }

  void add(const Frame& frame);
  /// Whole or not at all (AtomicFile). Throws FileError.
  void write(const std::filesystem::path& path) const;

 private:
  int dimensions_ = 2;
  bool bodies_change_ = false, clusters_ = false;
  std::size_t num_disks_ = 0, num_walls_ = 0, num_circles_ = 0, num_cell_lines_ = 0;
  std::string disks_, contacts_, walls_, circles_, cell_;  // grids of all frames
};

}  // namespace bipot
