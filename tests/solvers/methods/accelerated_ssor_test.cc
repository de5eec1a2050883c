#include "solvers/methods/accelerated_ssor.h"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <utility>

#include "core/problem/contact_error.h"
#include "solvers/solve.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

int needed(const std::string& solver, const ContactProblem& p,
           std::map<std::string, std::string> parameters = {}) {
  SolverOptions options{.tol = 1e-6, .max_iterations = 100000};
  options.parameters = std::move(parameters);
  const SolveResult result = solve(solver, p, options);
  EXPECT_EQ(result.status, SolveStatus::kConverged) << solver << ": " << result.message;
  return result.iterations;
}

// Why it is there: an iteration is four sweeps, some five steps of the accelerated gradient, and what
// that one needs on lattices grows as the root of the number of disks.
TEST(AcceleratedSsor, NeedsASeventhOfTheIterationsOfTheGradientOnLattices) {
  for (const Lattice lattice : {Lattice::kTriangular, Lattice::kSquare}) {
    const ContactProblem p = lattice_step(lattice, 60, 0.3, 10);
    const int ssor = needed("assor", p), gradient = needed("apgd", p);
    EXPECT_LT(7 * ssor, gradient);
    // Over-relaxation is a part of it.
    EXPECT_LT(1.2 * ssor, needed("assor", p, {{"omega", "1"}}));
    // So is the second sweep each way, which is not just the work of two iterations.
    const int one = needed("assor", p, {{"sweeps", "1"}});
    EXPECT_LT(1.3 * ssor, one);
    EXPECT_LT(one, 2.5 * ssor);
  }
}

// From 20 to 80 rows, 16 times as many disks: O(N^1/4) would be 2, O(N^1/2) 4. From 40 to 120, all of
// them along the rows, 9 times as many: 1.7 and 3.
TEST(AcceleratedSsor, IterationsGrowSlowerThanTheRootOfTheDisks) {
  const auto iterations = [](int rows) {
    return needed("assor", lattice_step(Lattice::kTriangular, rows, 0.3, 10));
  };
  EXPECT_LT(iterations(80), 3.2 * iterations(20));
  EXPECT_LT(iterations(120), 2.5 * iterations(40));
}

// Smooth stresses are what takes longer on larger packings: taken out, a third of the iterations does,
// and what the last six digits need hardly grows.
TEST(AcceleratedSsor, StressesTakenOutSaveMostOfTheIterations) {
  const std::map<std::string, std::string> out{{"stresses_from", "1000"}},
      in{{"stresses_from", "2000000000"}};
  const auto iterations = [](int rows, const std::map<std::string, std::string>& parameters) {
    return needed("assor", lattice_step(Lattice::kTriangular, rows, 0.3, 10), parameters);
  };
  const int small = iterations(50, out), large = iterations(120, out);
  EXPECT_LT(1.3 * small, iterations(50, in));
  EXPECT_LT(2 * large, iterations(120, in));
  // It is so from 20 000 contacts on without being asked for: 42 500 here.
  EXPECT_EQ(large, needed("assor", lattice_step(Lattice::kTriangular, 120, 0.3, 10)));
}

// Where they cannot be taken out, as contacts slip and open in between, the iteration goes on as
// without: some 600 disks of an isotropic compression, and a step that stood still there.
TEST(AcceleratedSsor, GoesOnWhereStressesDoNotHelp) {
  for (const char* name : {"2d_isotropic_compression.hdf5", "2d_tilt1000hi_182.hdf5"}) {
    const ContactProblem p = shipped_file(name);
    SolverOptions options{.tol = 1e-3, .max_iterations = 20000};
    options.parameters = {{"stresses_from", "1"}};
    const SolveResult result = solve("assor", p, options);
    EXPECT_EQ(result.status, SolveStatus::kConverged) << name << ": " << result.message;
    EXPECT_LE(contact_error(p, result.s).guarded(), 1e-3) << name;
  }
}

// The limit is kept to where it falls into that part.
TEST(AcceleratedSsor, StopsAtItsLimitWhileStressesAreTakenOut) {
  SolverOptions options{.tol = 1e-9, .max_iterations = 57};
  options.parameters = {{"stresses_from", "1"}};
  const SolveResult result =
      solve("assor", lattice_step(Lattice::kTriangular, 40, 0.3, 10), options);
  EXPECT_EQ(result.status, SolveStatus::kIterationLimit);
  EXPECT_EQ(result.iterations, 57);
}

// The contacts of a problem that is given by W alone are visited one by one as they stand, which is
// the order along the rows on this lattice, which is large enough for it to fill the vectors.
TEST(AcceleratedSsor, ContactAfterContactIsTheSameIteration) {
  const ContactProblem p = lattice_step(Lattice::kTriangular, 40, 0.3, 10);
  SolverOptions options{.tol = 1e-300, .max_iterations = 12};
  const SolveResult disks = solve("assor", p, options);
  const SolveResult one_by_one = solve("assor", local_form(p), options);
  EXPECT_EQ(disks.status, SolveStatus::kIterationLimit);
  EXPECT_LT((disks.s - one_by_one.s).norm(), 1e-10 * disks.s.norm());
}

// Sliding pyramids without walls: the hardest lattice for momentum.
TEST(AcceleratedSsor, SolvesTheFreePyramidOfTenRows) {
  needed("assor", lattice_step(Lattice::kPyramid, 10, 0.5, 0));
}

// Of twenty rows, where the error of two sweeps each way stands.
TEST(AcceleratedSsor, MoreSweepsSolveWhereFewStandStill) {
  const ContactProblem p = lattice_step(Lattice::kPyramid, 20, 0.5, 0);
  SolverOptions options{.tol = 1e-4, .max_iterations = 4000};
  const SolveResult growing = solve("assor", p, options);
  EXPECT_EQ(growing.status, SolveStatus::kConverged) << growing.message;
  options.parameters = {{"most_sweeps", "2"}};
  const SolveResult two = solve("assor", p, options);
  EXPECT_EQ(two.status, SolveStatus::kIterationLimit) << two.message;
}

}  // namespace
}  // namespace bipot
