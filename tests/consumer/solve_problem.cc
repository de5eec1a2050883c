// Another project's program: reads a contact problem and solves it.
#include <cstdio>

#include "core/problem_files/problem_file.h"
#include "solvers/solve.h"

int main(int, char** arguments) {
  const bipot::SolveResult result = bipot::solve("auto", bipot::read_problem(arguments[1]).problem);
  std::printf("%s\n", result.message.c_str());
  return bipot::is_success(result.status) ? 0 : 1;
}
