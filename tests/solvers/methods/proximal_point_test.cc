#include "solvers/methods/proximal_point.h"

#include "tests/support/converged.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

SolveResult ppa(const ContactProblem& p, std::map<std::string, std::string> parameters = {},
                double tol = 1e-8) {
  return solve("ppa", p, {.tol = tol, .max_iterations = 1000, .parameters = std::move(parameters)});
}

TEST(ProximalPoint, IsExactAtTheFixedPointOfASingularProblem) {
  const ContactProblem p = lattice_step(Lattice::kTriangular, 6, 0.3, 10);
  const SolveResult r = converged(ppa(p, {{"kappa_max", "10"}}, 1e-9));
  EXPECT_LE(r.error.guarded(), 1e-9);  // judged without the term
}

TEST(ProximalPoint, TakesAnyOtherSolverInside) {
  const ContactProblem p = lattice_step(Lattice::kSquare, 4, 0.3, 0);
  const SolveResult r = converged(ppa(p, {{"inner", "pgs"}, {"inner_parameters", "omega=1.5"}}));
  EXPECT_TRUE(says(r.message, "of pgs"));
  EXPECT_TRUE(says(converged(ppa(p, {{"inner", "uzawa"}})).message, "of uzawa"));
}

// Here the iterate within 1e-6 is one that a run judges only if it judges all; the inner solver then
// leaves it as it is.
TEST(ProximalPoint, SeesEachIterate) {
  Eigen::MatrixXd W(4, 4);
  W << 5, 1, 0, 2, 1, 5, 4, -2, 0, 4, 4, -2, 2, -2, -2, 6;
  const ContactProblem p =
      delassus_problem(2, W, Eigen::Vector4d(-3, 1, -2, 0), Eigen::Vector2d(1, 0));
  EXPECT_LE(converged(ppa(p, {}, 1e-6)).error.guarded(), 1e-6);
}

TEST(ProximalPoint, RefusesItselfUnknownSolversAndBadParameters) {
  const ContactProblem p = lattice_step(Lattice::kSquare, 3, 0.3, 0);
  EXPECT_EQ(ppa(p, {{"inner", "ppa"}}).status, SolveStatus::kInvalidInput);
  EXPECT_EQ(ppa(p, {{"inner", "nobody"}}).status, SolveStatus::kInvalidInput);
  EXPECT_EQ(ppa(p, {{"inner_parameters", "omega"}}).status, SolveStatus::kInvalidInput);
  EXPECT_EQ(ppa(p, {{"inner_parameters", "omega=7"}}).status, SolveStatus::kInvalidInput);
  EXPECT_EQ(ppa(p, {{"inner_parameters", "omicron=1"}}).status, SolveStatus::kInvalidInput);
}

// An inner solver that is never given enough iterations: kappa falls below its minimum.
TEST(ProximalPoint, SaysThatItsInnerSolverDidNotSuffice) {
  const ContactProblem p = lattice_step(Lattice::kTriangular, 8, 0.3, 10);
  const SolveResult starved =
      ended(SolveStatus::kStalled,
            solve("ppa", p,
                  {.tol = 1e-13,
                   .max_iterations = 100000,
                   .parameters = {{"inner_iterations", "1"}, {"inner", "uzawa"}}}));
  EXPECT_TRUE(says(starved.message, "not solved even at kappa"));
}

}  // namespace
}  // namespace bipot
