#include "solvers/methods/accelerated_gradient.h"

#include "core/problem/delassus.h"
#include "solvers/kernels/spectral_estimate.h"
#include "tests/support/converged.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

SolveResult run_apgd(const ContactProblem& p, const std::string& map, double tol = 1e-8,
                     int max_iterations = 100000) {
  SolverOptions o{.tol = tol, .max_iterations = max_iterations, .parameters = {{"map", map}}};
  return solve("apgd", p, o);
}

TEST(AcceleratedGradient, DiskKernelAndOperatorDoTheSameSteps) {
  LatticeOptions o{.e_n = 0.1, .e_t = 1};
  for (o.dim = 1; o.dim <= 2; ++o.dim) {
    if (o.dim == 1) o.e_t = 0;
    const ContactProblem p = triangular_lattice(8, o);
    for (const std::string map : {"split", "followed"}) {
      const SolveResult disks = run_apgd(p, map, 1e-14, 40);
      const SolveResult whole = run_apgd(local_form(p), map, 1e-14, 40);
      EXPECT_LT((disks.s - whole.s).norm(), 1e-9 * whole.s.norm()) << o.dim << map;
    }
    o.e_t = 1;
  }
}

TEST(AcceleratedGradient, IterationsGrowWithTheSideOfALatticeNotWithItsArea) {
  const SolveResult small = converged(run_apgd(square_lattice(8), "auto")),
                    large = converged(run_apgd(square_lattice(24), "auto"));
  EXPECT_LT(large.iterations, 5 * small.iterations);  // three times the side, nine times the area
}

// The split map cycles on the free pyramid, the followed one does not, and auto finds that out.
TEST(AcceleratedGradient, AutoSolvesThePyramidThatSplitDoesNot) {
  const ContactProblem p = pyramid(10);
  EXPECT_EQ(run_apgd(p, "split", 1e-8, 20000).status, SolveStatus::kIterationLimit);
  EXPECT_EQ(run_apgd(p, "followed", 1e-8, 20000).status, SolveStatus::kConverged);
  EXPECT_EQ(run_apgd(p, "auto", 1e-8, 20000).status, SolveStatus::kConverged);
}

// w_n = 2, w_t = 3, mu = 0.4, b = (-1, 3) slides: s = (1/2, -1/5), u = (0, 2.4), sigma = 0.96. While
// sigma stays 0, friction is associated: 2.48 s_n = 2.2, and the contact opens with u_n = 0.77. From
// an impulse that is 1e-2 larger sigma is at once right to 3e-3.
TEST(AcceleratedGradient, HeldTermIsThatOfTheStart) {
  const ContactProblem p = one_contact_problem(2, 2, 3, 0.4, -1, Vector::Constant(1, 3));
  SolverOptions o{
      .tol = 5e-3, .max_iterations = 1000, .parameters = {{"map", "followed"}, {"hold", "100000"}}};
  EXPECT_EQ(solve("apgd", p, o).status, SolveStatus::kIterationLimit);
  o.s0 = Vector(2);
  o.s0 << 0.505, -0.202;
  EXPECT_GT(converged(solve("apgd", p, o)).iterations, 0);
  o = {.tol = 1e-10, .parameters = {{"map", "followed"}, {"hold", "64"}}};
  const SolveResult followed = converged(solve("apgd", p, o));
  EXPECT_NEAR(followed.s[0], 0.5, 1e-8);
  EXPECT_NEAR(followed.s[1], -0.2, 1e-8);
}

TEST(SpectralEstimate, LiesBetweenTheTrueEigenvalueAndTheBound) {
  const ContactProblem p = triangular_lattice(6);
  WholeSpace space(p);
  const Vector scale = space.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd dense =
      scale.asDiagonal() * Eigen::MatrixXd(assemble_delassus(p.A, p.H, p.dim)) * scale.asDiagonal();
  Vector x = Vector::Ones(p.num_rows());
  for (int k = 0; k < 20000; ++k) x = (dense * x).normalized();
  const double largest = x.dot(dense * x);
  EXPECT_LE(spectral_estimate(space, scale, 30), largest * (1 + 1e-12));
  EXPECT_GE(spectral_estimate(space, scale, 30), 0.9 * largest);
  EXPECT_GE(space.norm_bound(scale), largest);
}

TEST(SpectralBound, DoesNotDependOnTheDirectionOfTheScene) {
  const ContactProblem a = triangular_lattice(4), b = triangular_lattice(4, {.turn = 0.6});
  const Vector ones = Vector::Ones(a.num_rows());
  const double bound = WholeSpace(a).norm_bound(ones);
  EXPECT_NEAR(bound, WholeSpace(b).norm_bound(ones), 1e-12 * bound);
}

}  // namespace
}  // namespace bipot
