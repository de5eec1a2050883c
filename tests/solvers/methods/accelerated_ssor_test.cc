#include "solvers/methods/accelerated_ssor.h"

#include "tests/support/converged.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

int needed(const std::string& solver, const ContactProblem& p,
           std::map<std::string, std::string> parameters = {}) {
  SolverOptions options{.tol = 1e-6, .max_iterations = 100000, .parameters = std::move(parameters)};
  return converged(solve(solver, p, options), solver).iterations;
}

// Why it is there: an iteration is four sweeps, some five steps of the accelerated gradient, and
// what that one needs on lattices grows as the root of the number of disks.
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

// From 20 to 80 rows, 16 times as many disks: O(N^1/4) would be 2, O(N^1/2) 4. From 40 to 120, all
// of them along the rows, 9 times as many: 1.7 and 3.
TEST(AcceleratedSsor, IterationsGrowSlowerThanTheRootOfTheDisks) {
  const auto iterations = [](int rows) {
    return needed("assor", lattice_step(Lattice::kTriangular, rows, 0.3, 10));
  };
  EXPECT_LT(iterations(80), 3.2 * iterations(20));
  EXPECT_LT(iterations(120), 2.5 * iterations(40));
}

// Smooth stresses are what takes longer on larger packings: taken out, a third of the iterations
// does, and what the last six digits need hardly grows.
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
// without: 900 disks that move at random, up to 64 times as fast as gravity makes them in a step.
TEST(AcceleratedSsor, GoesOnWhereStressesDoNotHelp) {
  int given_up = 0;
  for (const int faster : {16, 32, 64}) {
    ContactProblem p = lattice_step(Lattice::kTriangular, 30, 0.3, 10);
    Vector change(p.num_dofs());
    unsigned state = 1;
    for (double& v : change) {
      state = state * 1664525u + 1013904223u;  // Numerical Recipes
      v = faster * p.v_free.lpNorm<Eigen::Infinity>() * (state / 4294967296.0 - 0.5);
    }
    p.v_free += change;
    p.u_free += p.H.transpose() * change;

    SolverOptions options{.tol = 1e-3, .max_iterations = 20000};
    // Another omega than that of the part with stresses, so that the history tells them apart.
    options.parameters = {{"stresses_from", "1"}, {"omega", "1.2"}};
    std::vector<bool> taken_out;
    options.on_iteration = [&](const IterationRecord& at) {
      if (taken_out.empty() || taken_out.back() != (at.step == 1.5)) {
        taken_out.push_back(at.step == 1.5);
      }
    };
    const SolveResult result = converged(solve("assor", p, options), faster);
    EXPECT_LE(contact_error(p, result.s).guarded(), 1e-3) << faster;
    given_up += taken_out == std::vector<bool>({false, true, false}) ? 1 : 0;
  }
  EXPECT_GT(given_up, 0);
}

// The limit is kept to where it falls into that part.
TEST(AcceleratedSsor, StopsAtItsLimitWhileStressesAreTakenOut) {
  SolverOptions options{
      .tol = 1e-9, .max_iterations = 57, .parameters = {{"stresses_from", "1"}, {"omega", "1.2"}}};
  double last = 0;
  options.on_iteration = [&](const IterationRecord& at) { last = at.step; };
  const SolveResult result =
      ended(SolveStatus::kIterationLimit,
            solve("assor", lattice_step(Lattice::kTriangular, 40, 0.3, 10), options));
  EXPECT_EQ(result.iterations, 57);
  EXPECT_EQ(last, 1.5);  // the omega of that part
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
  converged(solve("assor", p, options));
  options.parameters = {{"most_sweeps", "2"}};
  ended(SolveStatus::kIterationLimit, solve("assor", p, options));
}

}  // namespace
}  // namespace bipot
