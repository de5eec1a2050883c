#include "core/files/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>
#include <utility>

#include "core/base/file_error.h"
#include "core/base/interrupt.h"

namespace bipot {
namespace {

/// Waits for the reader of a pipe as long as the program may go on. Whoever opens it next finds it.
int opened_pipe(const std::filesystem::path& path) {
  for (;;) {
    const int file = ::open(path.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
    if (file >= 0) return file;
    if (errno != ENXIO || InterruptGuard::requested()) {
      throw FileError(path, "", std::string("cannot be written: ") + std::strerror(errno));
    }
    ::usleep(20000);
  }
}

}  // namespace

AtomicFile::AtomicFile(std::filesystem::path path) : path_(std::move(path)), draft_(path_) {
  constexpr int kMostLinks = 40;  // as the system
  std::error_code failed;
  const auto type = std::filesystem::status(path_, failed).type();
  using enum std::filesystem::file_type;
  if (type == fifo) pipe_ = opened_pipe(path_);
  if (type == fifo || type == character || type == block || type == socket) return;
  for (int k = 0; k < kMostLinks && std::filesystem::is_symlink(path_, failed); ++k) {
    const std::filesystem::path next = std::filesystem::read_symlink(path_, failed);
    path_ = path_.parent_path() / next;
    draft_ = path_;
    if (next.string().starts_with("/proc/")) return;  // /dev/stdout: an open file, kept as it is
  }
  draft_ += ".part";
}

AtomicFile::~AtomicFile() {
  if (pipe_ >= 0) ::close(pipe_);
  if (draft_ == path_) return;
  std::error_code ignored;  // nothing to remove after commit()
  std::filesystem::remove(draft_, ignored);
}

void AtomicFile::copy_earlier() {
  std::error_code error;
  std::filesystem::copy_file(path_, draft_, std::filesystem::copy_options::overwrite_existing,
                             error);
  if (error) throw FileError(path_, "", "cannot write beside it: " + error.message());
}

void AtomicFile::commit() {
  if (draft_ == path_) return;
  std::error_code error;
  std::filesystem::rename(draft_, path_, error);
  if (error) throw FileError(path_, "", "cannot write: " + error.message());
}

void write_text_file(const std::filesystem::path& path, std::string_view text) {
  AtomicFile file(path);
  errno = 0;
  std::ofstream out(file.draft(), std::ios::binary);
  out << text;
  out.close();
  if (!out) {
    const std::string reason = errno != 0 ? std::string(": ") + std::strerror(errno) : "";
    throw FileError(path, "", "cannot be written" + reason);
  }
  file.commit();
}

}  // namespace bipot
