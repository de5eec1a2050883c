#include "solvers/methods/siconos.h"

#include "core/problem/delassus.h"
#include "tests/support/converged.h"
#include "tests/support/manufactured.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

class Siconos : public testing::TestWithParam<const char*> {
 protected:
  static SolveResult run(const ContactProblem& p, double tol = 1e-8) {
    return solve(GetParam(), p, {.tol = tol});
  }
  static int max_dim() { return find_solver(GetParam())->max_dim; }
};

TEST_P(Siconos, OneContactTakesOffSticksAndSlipsInEveryDimension) {
  for (int dim = 1; dim <= max_dim(); ++dim) {
    Vector pull = Vector::Zero(dim - 1);
    // w_n = 2, w_t = 3, mu = 0.4, b_n = -1: s_n = 1/2, friction bound 0.2.
    if (dim > 1) pull[dim - 2] = 0.3;
    SolveResult r =
        converged(run(one_contact_problem(dim, 2, 3, dim > 1 ? 0.4 : 0, -1, pull), 1e-9), dim);
    EXPECT_NEAR(r.s[0], 0.5, 1e-7);
    if (dim > 1) {
      EXPECT_NEAR(r.s[dim - 1], -0.1, 1e-7);
      pull[dim - 2] = 3;
      r = converged(run(one_contact_problem(dim, 2, 3, 0.4, -1, pull), 1e-9), dim);
      EXPECT_NEAR(r.s[dim - 1], -0.2, 1e-7);
      EXPECT_NEAR(r.u[dim - 1], 2.4, 1e-6);
    }
    EXPECT_EQ(run(one_contact_problem(dim, 2, 3, 0.4, 1, pull)).status, SolveStatus::kNothingToDo);
  }
}

TEST_P(Siconos, FindsManufacturedSolutions) {
  for (int dim = 1; dim <= max_dim(); ++dim) {
    const Manufactured m = manufactured_problem(dim, 12, 12, 7);
    EXPECT_LT((converged(run(m.problem), dim).u - m.u).norm(), 1e-6 * m.u.norm()) << dim;
  }
}

TEST_P(Siconos, IsJudgedByThisProjectsMeasure) {
  // Whatever Siconos claims, the status follows the guarded error.
  const SolveResult r = run(lattice_step(Lattice::kSquare, 6, 0.3, 0));
  EXPECT_EQ(is_success(r.status), r.error.guarded() <= 1e-8) << r.message;
  EXPECT_TRUE(says(r.message, "Siconos"));
}

TEST_P(Siconos, StopsAtItsIterationLimit) {
  const SolveResult r =
      solve(GetParam(), lattice_step(Lattice::kTriangular, 6, 0.3, 10), {.max_iterations = 1});
  EXPECT_TRUE(r.status == SolveStatus::kIterationLimit || is_success(r.status)) << r.message;
}

TEST(SiconosCall, SolvesOnceToItsOwnResidualWithEveryAlgorithm) {
  // w_n = 2, w_t = 3, mu = 0.4, b = (-1, 3): slides, s = (1/2, -0.2). (The quartic one of 4.4
  // returns NaN here.)
  ContactProblem p = one_contact_problem(2, 2, 3, 0.4, -1, Vector::Constant(1, 3));
  p.W = assemble_delassus(p.A, p.H, p.dim);
  using Algorithm = SiconosCall::Algorithm;
  for (const Algorithm algorithm :
       {Algorithm::kPlanar, Algorithm::kNewton, Algorithm::kNewtonAndProjection,
        Algorithm::kProjection, Algorithm::kAlartCurnier, Algorithm::kAdmm}) {
    for (const int freezing : {0, 10}) {
      SiconosCall call(p, algorithm, freezing);
      EXPECT_TRUE(call.run(1e-10, 100000)) << static_cast<int>(algorithm);
      EXPECT_LE(call.residual(), 1e-10);
      EXPECT_GE(call.iterations(), 1);
      EXPECT_NEAR(call.impulse()[0], 0.5, 1e-8) << static_cast<int>(algorithm);
      EXPECT_NEAR(call.impulse()[1], -0.2, 1e-8) << static_cast<int>(algorithm);
    }
  }
}

TEST(SiconosCall, SaysThatItsSweepsDidNotSuffice) {
  ContactProblem p = lattice_step(Lattice::kSquare, 6, 0.3, 0);
  p.W = assemble_delassus(p.A, p.H, p.dim);
  SiconosCall call(p, SiconosCall::Algorithm::kPlanar, 0);
  EXPECT_FALSE(call.run(1e-10, 3));
  EXPECT_EQ(call.iterations(), 3);
  EXPECT_GT(call.residual(), 1e-10);
  // Each run begins at s = 0.
  EXPECT_FALSE(call.run(1e-10, 3));
  EXPECT_EQ(call.iterations(), 3);
  const ContactProblem space = one_contact_problem(3, 2, 3, 0.4, -1, Vector::Zero(2));
  EXPECT_THROW(SiconosCall(space, SiconosCall::Algorithm::kPlanar, 0), std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(All, Siconos,
                         testing::Values("siconos:nsgs", "siconos:nsn_ac", "siconos:admm",
                                         "siconos:prox", "siconos:lemke"),
                         [](const auto& instance) { return std::string(instance.param + 8); });

}  // namespace
}  // namespace bipot
