#pragma once

#include <filesystem>

namespace bipot {

/// Holds a folder or a file against others that lock it too, as long as it lives. The end of the
/// program frees it, however it ends. File systems without locks, as some on networks, do not stop
/// a second program.
class PathLock {
 public:
  /// Throws std::invalid_argument if another lock holds it, FileError if it cannot be opened.
  explicit PathLock(const std::filesystem::path& path);
  ~PathLock();
  PathLock(const PathLock&) = delete;
  PathLock& operator=(const PathLock&) = delete;

 private:
  int descriptor_ = -1;
};

}  // namespace bipot
