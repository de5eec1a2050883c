#include "core/files/path_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "core/base/file_error.h"

namespace bipot {

PathLock::PathLock(const std::filesystem::path& path)
    : descriptor_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (descriptor_ < 0) throw FileError(path, "", std::strerror(errno));
  if (flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  close(descriptor_);
  throw std::invalid_argument(
      fmt::format("another run writes into {} at this moment", path.string()));
}

PathLock::~PathLock() { close(descriptor_); }

}  // namespace bipot
