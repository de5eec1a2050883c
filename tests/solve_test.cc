#include "solvers/solve.h"

#include <gtest/gtest.h>

#include "solvers/registry.h"
#include "tests/manufactured.h"

namespace bipot {
namespace {

TEST(Solve, ManufacturedSmoke) {
  for (int dim = 1; dim <= 3; ++dim) {
    const Manufactured m = manufactured_problem(dim, 20, 24, 7);
    ASSERT_EQ(validate(m.problem), "");
    EXPECT_LT(contact_error(m.problem, m.s).guarded(), 1e-13);
    for (const auto& entry : solver_table()) {
      if (dim > entry.max_dim) continue;
      SolverOptions o;
      o.max_iterations = 100000;
      const SolveResult r = solve(entry, m.problem, o);
      EXPECT_EQ(r.status, SolveStatus::kConverged) << entry.name << dim << r.message;
      EXPECT_LT((r.u - m.u).norm(), 1e-6 * m.u.norm()) << entry.name << dim;
      std::printf("%s d=%d it=%d eps=%g\n", entry.name.data(), dim, r.iterations,
                  r.error.guarded());
    }
  }
}

}  // namespace
}  // namespace bipot
