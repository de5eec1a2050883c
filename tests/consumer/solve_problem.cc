// Another project's program: reads a contact problem and solves it.
#include <cstdio>

#include "core/problem_files/problem_file.h"
#include "solvers/solve.h"

// Whatever the flags of this project are, matrices are those of the library.
static_assert(EIGEN_MAX_ALIGN_BYTES == 16 && EIGEN_MALLOC_ALREADY_ALIGNED == 1);

int main(int, char** arguments) {
  const bipot::SolveResult result = bipot::solve("auto", bipot::read_problem(arguments[1]).problem);
  std::printf("%s\n", result.message.c_str());
  return bipot::is_success(result.status) ? 0 : 1;
}
