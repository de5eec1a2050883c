#pragma once

#include <filesystem>

namespace bipot {

/// Holds a folder against other programs that lock it too, as long as it lives. The end of the
/// program frees it, however it ends. File systems without locks, as some on networks, do not stop
/// a second program.
class FolderLock {
 public:
  /// Throws std::invalid_argument if another program holds the folder, FileError if it cannot be
  /// opened.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_ = -1;
};

}  // namespace bipot
