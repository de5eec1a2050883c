// The `bipot` command.

#include <fcntl.h>
#include <unistd.h>

#include "bench/command/bipot_command.h"
#include "bench/command/blas_kernels.h"
#include "bench/command/exit_code.h"

namespace {

/// A file that is opened later must not take the place of a closed standard stream.
bool hold_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) != -1) continue;
    const int wrong_way = stream == STDIN_FILENO ? O_WRONLY : O_RDONLY;  // its use fails as before
    if (open("/dev/null", wrong_way) != stream) return false;
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  if (!hold_standard_streams()) return bipot::kExitIo;
  bipot::take_kernels_of_this_processor(argv);
  return bipot::bipot_command(argc, argv);
}
