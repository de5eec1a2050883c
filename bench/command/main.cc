// The `bipot` command.

#include "bench/command/bipot_command.h"
#include "bench/command/blas_kernels.h"

int main(int argc, char** argv) {
  bipot::take_kernels_of_this_processor(argv);
  return bipot::bipot_command(argc, argv);
}
