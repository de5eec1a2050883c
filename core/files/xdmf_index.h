#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "core/file_error.h"

namespace bipot {

/// What the index of a run must know of a frame.
struct FrameEntry {
  int step = 0;
  double time = 0;  ///< [s]
  std::size_t contacts = 0;
  bool stress = true;  ///< false: of a version that did not write stresses
};

/// run.xdmf: the frames of a run for ParaView. Three collections of one grid a frame: disks as
/// points, contacts as lines between the centres, walls as lines.
class XdmfIndex {
 public:
  XdmfIndex(std::size_t disks, std::size_t walls) : num_disks_(disks), num_walls_(walls) {}

  void add(const FrameEntry& frame);
  /// Whole or not at all (AtomicFile). Throws FileError.
  void write(const std::filesystem::path& path) const;

 private:
  std::size_t num_disks_ = 0, num_walls_ = 0;
  std::string disks_, contacts_, walls_;  // grids of all frames
};

}  // namespace bipot
