// Tests that every process of an mpirun runs together: all call the same, each checks what it has.

#include <cstdio>

#include "solvers/parallel/petsc_group.h"
#include "tests/solvers/parallel/mpi_group.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

std::unique_ptr<ProcessGroup>& the_group() {
  static std::unique_ptr<ProcessGroup> group;
  return group;
}

/// What the other ranks say: failures alone.
class FailuresOnly : public testing::EmptyTestEventListener {
  void OnTestPartResult(const testing::TestPartResult& result) override {
    if (!result.failed()) return;
    std::fprintf(stderr, "rank %d: %s:%d: %s\n", the_group()->rank(), result.file_name(),
                 result.line_number(), result.message());
  }
};

}  // namespace

ProcessGroup& mpi_group() { return *the_group(); }

}  // namespace bipot

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  bipot::the_group() = bipot::petsc_group();
  auto& listeners = testing::UnitTest::GetInstance()->listeners();
  if (bipot::mpi_group().rank() != 0) {
    delete listeners.Release(listeners.default_result_printer());
    listeners.Append(new bipot::FailuresOnly);
  }
  const bool failed = RUN_ALL_TESTS() != 0;
  const bool any = bipot::mpi_group().any(failed);
  // mpirun kills the others where one ends with a failure: the first one alone does, as the last
  // word.
  const bool speaks = bipot::mpi_group().rank() == 0;
  bipot::the_group().reset();
  return any && speaks ? 1 : 0;
}
