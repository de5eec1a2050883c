#include "solvers/methods/proximal_point.h"

#include <gtest/gtest.h>

#include "solvers/solve.h"
#include "tests/support/manufactured.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

SolveResult ppa(const ContactProblem& p, std::map<std::string, std::string> parameters = {},
                double tol = 1e-8) {
  SolverOptions options{.tol = tol, .max_iterations = 1000, .parameters = std::move(parameters)};
  return solve("ppa", p, options);
}

TEST(ProximalPoint, OneContactTakesOffSticksAndSlips) {
  const Vector gentle = Vector::Constant(1, 0.3), strong = Vector::Constant(1, 3.0);
  // w_n = 2, w_t = 3, mu = 0.4, b_n = -1: s_n = 1/2, friction bound 0.2.
  SolveResult r = ppa(one_contact_problem(2, 2, 3, 0.4, -1, gentle), {}, 1e-10);
  ASSERT_EQ(r.status, SolveStatus::kConverged) << r.message;
  EXPECT_NEAR(r.s[0], 0.5, 1e-9);
  EXPECT_NEAR(r.s[1], -0.1, 1e-9);
  r = ppa(one_contact_problem(2, 2, 3, 0.4, -1, strong), {}, 1e-10);
  ASSERT_EQ(r.status, SolveStatus::kConverged) << r.message;
  EXPECT_NEAR(r.s[1], -0.2, 1e-9);
  EXPECT_NEAR(r.u[1], 2.4, 1e-9);
  r = ppa(one_contact_problem(2, 2, 3, 0, -1, strong), {}, 1e-10);
  ASSERT_EQ(r.status, SolveStatus::kConverged) << r.message;
  EXPECT_EQ(r.s[1], 0);
  EXPECT_EQ(ppa(one_contact_problem(2, 2, 3, 0.4, 1, strong)).status, SolveStatus::kNothingToDo);
}

TEST(ProximalPoint, FindsManufacturedSolutions) {
  for (int dim = 1; dim <= 3; ++dim) {
    const Manufactured m = manufactured_problem(dim, 20, 24, 7);
    const SolveResult r = ppa(m.problem);
    ASSERT_EQ(r.status, SolveStatus::kConverged) << dim << r.message;
    EXPECT_LT((r.u - m.u).norm(), 1e-6 * m.u.norm()) << dim;
  }
}

TEST(ProximalPoint, IsExactAtTheFixedPointOfASingularProblem) {
  const ContactProblem p = lattice_step(Lattice::kTriangular, 6, 0.3, 10);
  const SolveResult r = ppa(p, {{"kappa_max", "10"}}, 1e-9);
  EXPECT_EQ(r.status, SolveStatus::kConverged) << r.message;
  EXPECT_LE(r.error.guarded(), 1e-9);  // judged without the term
}

TEST(ProximalPoint, TakesAnyOtherSolverInside) {
  const ContactProblem p = lattice_step(Lattice::kSquare, 4, 0.3, 0);
  const SolveResult r = ppa(p, {{"inner", "pgs"}, {"inner_parameters", "omega=1.5"}});
  EXPECT_EQ(r.status, SolveStatus::kConverged) << r.message;
  EXPECT_NE(r.message.find("of pgs"), std::string::npos) << r.message;
  const SolveResult uzawa = ppa(p, {{"inner", "uzawa"}});
  EXPECT_EQ(uzawa.status, SolveStatus::kConverged) << uzawa.message;
  EXPECT_NE(uzawa.message.find("of uzawa"), std::string::npos) << uzawa.message;
}

TEST(ProximalPoint, RefusesItselfUnknownSolversAndBadParameters) {
  const ContactProblem p = lattice_step(Lattice::kSquare, 3, 0.3, 0);
  EXPECT_EQ(ppa(p, {{"inner", "ppa"}}).status, SolveStatus::kInvalidInput);
  EXPECT_EQ(ppa(p, {{"inner", "nobody"}}).status, SolveStatus::kInvalidInput);
  EXPECT_EQ(ppa(p, {{"inner_parameters", "omega"}}).status, SolveStatus::kInvalidInput);
  EXPECT_EQ(ppa(p, {{"inner_parameters", "omega=7"}}).status, SolveStatus::kInvalidInput);
  EXPECT_EQ(ppa(p, {{"inner_parameters", "omicron=1"}}).status, SolveStatus::kInvalidInput);
}

TEST(ProximalPoint, StopsAtItsLimitsAndSaysSo) {
  const ContactProblem p = lattice_step(Lattice::kTriangular, 8, 0.3, 10);
  SolverOptions options{.max_iterations = 2};
  const SolveResult few = solve("ppa", p, options);
  EXPECT_EQ(few.status, SolveStatus::kIterationLimit) << few.message;
  EXPECT_EQ(few.iterations, 2);
  options = {};
  options.time_limit = 1e-6;
  const SolveResult late = solve("ppa", p, options);
  EXPECT_EQ(late.status, SolveStatus::kTimeLimit) << late.message;
  // An inner solver that is never given enough iterations: kappa falls below its minimum.
  options = {};
  options.parameters = {{"inner_iterations", "1"}, {"inner", "uzawa"}};
  options.tol = 1e-13;
  options.max_iterations = 100000;
  const SolveResult starved = solve("ppa", p, options);
  EXPECT_EQ(starved.status, SolveStatus::kStalled) << starved.message;
  EXPECT_NE(starved.message.find("not solved even at kappa"), std::string::npos) << starved.message;
}

TEST(ProximalPoint, TakesTheSameStepsInAnyUnits) {
  const ContactProblem p = lattice_step(Lattice::kTriangular, 6, 0.3, 10);
  const SolveResult si = ppa(in_units(p, 1, 1, 1));
  const SolveResult small = ppa(in_units(p, 1e3, 1e3, 1e3));
  ASSERT_EQ(si.status, SolveStatus::kConverged) << si.message;
  ASSERT_EQ(small.status, SolveStatus::kConverged) << small.message;
  EXPECT_NEAR(si.iterations, small.iterations, 1);
}

}  // namespace
}  // namespace bipot
