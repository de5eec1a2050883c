#include "core/problem_files/rehearsed_read.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <malloc.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <optional>

#include "core/base/file_error.h"
#include "core/files/hdf5_file.h"

namespace bipot {
namespace {

/// What the library says while it goes down concerns nobody, nor does the child's memory.
void be_silent() {
  const int nowhere = ::open("/dev/null", O_WRONLY);
  if (nowhere >= 0) {
    ::dup2(nowhere, STDOUT_FILENO);
    ::dup2(nowhere, STDERR_FILENO);
  }
  const rlimit none{0, 0};
  ::setrlimit(RLIMIT_CORE, &none);
  // An interrupt is the parent's; faults end the child as they would without a handler.
  for (const int fault : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL}) std::signal(fault, SIG_DFL);
}

}  // namespace

void rehearse(const std::filesystem::path& path, const std::function<void()>& read) {
  std::fflush(nullptr);  // or the child could write what the parent has not yet written
  // A file that another thread is writing would be open in the child, which ends the library.
  std::optional<Hdf5Turn> turn(std::in_place);
  const pid_t child = ::fork();
  if (child < 0) return;
  if (child == 0) {
    be_silent();
    try {
      read();
    } catch (...) {  // a refusal: the parent meets it again
    }
    // Damage that the reading did to the heap shows when blocks are given back, in the parent
    // perhaps much later.
    Hdf5File::end_library();
#if defined(__GLIBC__)
    ::malloc_trim(0);
#endif
    ::_exit(0);
  }
  turn.reset();
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return;  // somebody else waits for this program's children
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
  throw FileError(
      path, "",
      fmt::format("damaged: the HDF5 library breaks off when it reads this ({})",
                  WIFSIGNALED(status) ? fmt::format("signal {}", WTERMSIG(status))
                                      : fmt::format("exit code {}", WEXITSTATUS(status))));
}

}  // namespace bipot
