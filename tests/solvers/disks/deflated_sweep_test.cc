#include "solvers/disks/deflated_sweep.h"

#include "core/criterion/contact_error.h"
#include "core/problem/delassus.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/solve.h"
#include "tests/support/bit_hash.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

struct Deflatable {
  ContactProblem problem;
  ContactErrorEvaluator error{problem};
  ContactScaling scaling = equilibrated_scaling(problem, error.delassus().diagonal());
  const DiskStructure& disks() const { return *error.delassus().disks(); }
  SymmetricSweep<2> sweep(int sweeps, const Execution& execution) const {
    return {problem, disks(), scaling, 1.5, sweeps, execution};
  }
};

ContactProblem leaning_rows(int rows) {
  return triangular_lattice(rows, {.tilt = 0.2, .e_n = 0.2, .e_t = 0.7});
}

/// S(y) after so many iterations from s.
Vector deflated_from(const Deflatable& at, const Vector& s, int iterations,
                     const Execution& execution) {
  SymmetricSweep<2> sweep = at.sweep(4, execution);
  DeflatedSweep deflated(sweep, at.disks(), execution);
  EXPECT_TRUE(deflated.reset(s));
  for (int k = 0; k < iterations; ++k) EXPECT_TRUE(deflated.iterate());
  return deflated.impulse();
}

/// What `assor` has by the time its error is 0.5.
Vector settled(const Deflatable& at) {
  return solve("assor", at.problem, {.tol = 0.5, .max_iterations = 1000}).s;
}

TEST(DeflatedSweep, SameBitsForAllPathsAndThreads) {
  const Deflatable at{leaning_rows(90)};  // more batches than one thread takes at once
  const Vector start = settled(at),
               portable = deflated_from(at, start, 25, {1, SimdPath::kPortable});
  ASSERT_GT(portable.norm(), 0);
  for (const SimdPath path : {SimdPath::kPortable, SimdPath::kAvx2, SimdPath::kAvx512}) {
    if (!has_path(path)) continue;
    for (int threads = 1; threads <= 4; ++threads) {
      const Vector s = deflated_from(at, start, 25, {threads, path});
      EXPECT_TRUE(same_bits(s, portable)) << to_string(path) << ", threads " << threads;
    }
  }
}

TEST(DeflatedSweep, SameBitsForAnyNumberOfThreadsInAWidePacking) {
  const Deflatable at{leaning_rows(380)};  // whose order is cut into strips
  const Vector start = solve("assor", at.problem, {.tol = 0.5, .max_iterations = 40}).s,
               alone = deflated_from(at, start, 5, {});
  for (const int threads : {2, 4}) {
    EXPECT_TRUE(same_bits(deflated_from(at, start, 5, {threads, SimdPath::kAuto}), alone));
  }
}

// Four times the disks, and hardly more iterations.
TEST(DeflatedSweep, FindsTheSolutionInFewIterations) {
  for (const int rows : {50, 100}) {
    Deflatable at{leaning_rows(rows)};
    const Vector start = settled(at);
    ASSERT_GT(at.error(start).guarded(), 0.05);
    EXPECT_LT(at.error(deflated_from(at, start, 30, {})).guarded(), 1e-5) << rows;
  }
}

// A side wall that the force on it holds takes stresses like a fixed one; its motion is no part of
// the deflated operator, which costs iterations.
TEST(DeflatedSweep, StressesEndOnADrivenWall) {
  const ContactProblem fixed = leaning_rows(50);
  const Vec2 normal(-1, 0);
  const int wall = fixed.num_dofs();
  const ContactProblem light = with_driven_wall(fixed, normal, 1, 0);
  const double force = -light.H.row(wall).dot(solve("assor", fixed, {.tol = 1e-8}).s);
  ASSERT_GT(force, 0);
  Deflatable at{with_driven_wall(fixed, normal, 1, force)};
  ASSERT_EQ(at.disks().walls, 1);
  const Vector start = settled(at);
  ASSERT_GT(at.error(start).guarded(), 0.05);
  EXPECT_LT(at.error(deflated_from(at, start, 100, {})).guarded(), 1e-5);
}

// Forth and back from y are those of the accelerated iteration without momentum.
TEST(DeflatedSweep, BeginsWithTheSymmetricSweep) {
  const Deflatable at{leaning_rows(40)};
  SymmetricSweep<2> sweep = at.sweep(2, {}), other = at.sweep(2, {});
  Vector s = Vector::Zero(at.problem.num_rows());
  other.reset(s);
  for (int k = 0; k < 30; ++k) other.iterate(0);
  s = other.impulse();
  other.iterate(0);
  DeflatedSweep deflated(sweep, at.disks(), {});
  ASSERT_TRUE(deflated.reset(s));
  // From impulses that were scaled back and forth: to rounding.
  EXPECT_LT((deflated.impulse() - other.impulse()).norm(), 1e-12 * s.norm());
}

}  // namespace
}  // namespace bipot
