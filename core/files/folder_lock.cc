#include "core/files/folder_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "core/base/file_error.h"

namespace bipot {

FolderLock::FolderLock(const std::filesystem::path& folder)
    : descriptor_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ < 0) throw FileError(folder, "", std::strerror(errno));
  if (flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  close(descriptor_);
  throw std::invalid_argument(
      fmt::format("another command writes into {} at this moment", folder.string()));
}

FolderLock::~FolderLock() {
  flock(descriptor_, LOCK_UN);  // children may have the descriptor too
  close(descriptor_);
}

}  // namespace bipot
