#include "solvers/methods/convex.h"

#include "tests/support/converged.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

// W = 1, b = (-1, -4), mu = 1/2. s minimises |s + b|²: the point of the cone nearest to (1, 4) is on
// its edge, s_n = (1 + 4/2)/(1 + 1/4) = 2.4, s_t = 1.2. Hence u = (1.4, -2.8): the block lifts with
// mu |u_t|. Coulomb's law has s_n = 1.
TEST(Convex, ASlidingBlockLiftsWithMuTimesItsVelocity) {
  for (const int dim : {2, 3}) {
    Vector b_t = Vector::Zero(dim - 1);
    b_t[0] = -4;
    const ContactProblem p = one_contact_problem(dim, 1, 1, 0.5, -1, b_t);
    const SolveResult r = ended(SolveStatus::kStalled, solve("convex", p, {.tol = 1e-10}));
    EXPECT_TRUE(says(r.message, "another law: the associated one holds"));
    EXPECT_TRUE(says(r.message, "1 of 1 contacts slide, and open with mu |u_t| up to 1.4 m/s"));
    ended(SolveStatus::kInvalidInput, solve("convex", p, {.stop = StopTest::kImpulse}));
    EXPECT_NEAR(r.s[0], 2.4, 1e-9);
    EXPECT_NEAR(r.u[0], 1.4, 1e-9);
    EXPECT_NEAR(r.u[0], 0.5 * r.u.tail(dim - 1).norm(), 1e-9);
    EXPECT_GT(r.error.guarded(), 0.1);
  }
}

// At rest the two laws are one.
TEST(Convex, AgreesWithCoulombWhereThePackingCanBeHeld) {
  for (const Lattice shape : {Lattice::kSquare, Lattice::kTriangular}) {
    const ContactProblem p = lattice_step(shape, 6, 0.3, 0);
    EXPECT_LT(converged(solve("convex", p, {.tol = 1e-8})).u.norm(), 1e-6 * p.u_free.norm());
  }
}

TEST(Convex, IsInNoTableOfCoulombsLaw) {
  const auto names = solver_names();
  EXPECT_EQ(std::count(names.begin(), names.end(), "convex"), 0);
  EXPECT_NE(find_solver("convex"), nullptr);
}

}  // namespace
}  // namespace bipot
