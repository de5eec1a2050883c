// What every solver of single exact steps must do: the contacts known by hand, networks with a known
// solution, hyperstatic scenes, limits, units, and the same bits twice.

#include <ostream>

#include "tests/support/converged.h"
#include "tests/support/manufactured.h"
#include "tests/support/small_problems.h"
#include "tests/support/test_name.h"

namespace bipot {
namespace {

struct ExactVariant {
  std::string solver;
  std::map<std::string, std::string> parameters;
  double tol, accuracy;  ///< of one contact: of the solve; of impulses [N s], velocities [m/s]
  int limit;             ///< iterations that the lattice below needs more than
  double units;          ///< largest difference of iterations in other units
  int max_dim = 3;

  std::string name() const { return test_name(solver, parameters); }
};

std::vector<ExactVariant> exact_variants() {
  std::vector<ExactVariant> variants = {
      {"lemke", {}, 1e-11, 1e-14, 3, 0, 2},
      {"homotopy", {}, 1e-14, 1e-14, 3, 0, 2},
      {"homotopy", {{"start_tol", "1"}}, 1e-14, 1e-14, 3, 0, 2},
      {"multistart", {}, 1e-11, 1e-9, 1, 0},
      {"ppa", {}, 1e-10, 1e-9, 2, 1},
      {"newton", {{"residual", "alart-curnier"}, {"start_sweeps", "0"}}, 1e-12, 1e-12, 2, 0},
      {"newton", {{"residual", "fischer-burmeister"}, {"start_sweeps", "0"}}, 1e-12, 1e-12, 2, 0}};
  std::erase_if(variants, [](const ExactVariant& v) { return find_solver(v.solver) == nullptr; });
  return variants;
}

void PrintTo(const ExactVariant& variant, std::ostream* out) { *out << variant.name(); }

class ExactSolver : public testing::TestWithParam<ExactVariant> {
 protected:
  SolveResult run(const ContactProblem& p, double tol) const {
    return solve(GetParam().solver, p, {.tol = tol, .parameters = GetParam().parameters});
  }
};

// w_n = 2, w_t = 3, mu = 0.4, b_n = -1: s_n = 1/2, friction bound 0.2. A pull of 0.3 needs 0.1 and
// sticks; one of 3 would need 1 and slips with 3 - 3 · 0.2.
TEST_P(ExactSolver, OneContactTakesOffSticksAndSlips) {
  const auto& [solver, parameters, tol, accuracy, limit, units, max_dim] = GetParam();
  for (int dim = 1; dim <= max_dim; ++dim) {
    Vector pull = Vector::Zero(dim - 1);
    for (const double b_t : {0.3, 3.0, -3.0}) {
      if (dim > 1) pull[dim - 2] = b_t;
      SolveResult r = converged(run(one_contact_problem(dim, 2, 3, 0.4, -1, pull), tol), dim);
      EXPECT_NEAR(r.s[0], 0.5, accuracy);
      EXPECT_NEAR(r.u[0], 0, accuracy);
      const double s_t = std::clamp(-b_t / 3, -0.2, 0.2);
      if (dim > 1) {
        EXPECT_NEAR(r.s[dim - 1], s_t, accuracy);
        EXPECT_NEAR(r.u[dim - 1], b_t + 3 * s_t, 3 * accuracy);
      }
      r = converged(run(one_contact_problem(dim, 2, 3, 0, -1, pull), tol), dim);
      EXPECT_NEAR(r.s[0], 0.5, accuracy);
      EXPECT_EQ(r.s.tail(dim - 1).norm(), 0);
      r = ended(SolveStatus::kNothingToDo, run(one_contact_problem(dim, 2, 3, 0.4, 1, pull), tol));
      EXPECT_EQ(r.s.norm(), 0);
    }
  }
}

TEST_P(ExactSolver, FindsManufacturedSolutions) {
  for (int dim = 1; dim <= GetParam().max_dim; ++dim) {
    const Manufactured m = manufactured_problem(dim, 20, 24, 7);
    EXPECT_LT((converged(run(m.problem, 1e-10), dim).u - m.u).norm(), 1e-7 * m.u.norm()) << dim;
  }
}

TEST_P(ExactSolver, SaysThatALimitWasReached) {
  const ContactProblem p = lattice_step(Lattice::kTriangular, 6, 0.3, 10);
  SolverOptions options{.max_iterations = GetParam().limit, .parameters = GetParam().parameters};
  const SolveResult few = ended(SolveStatus::kIterationLimit, solve(GetParam().solver, p, options));
  EXPECT_EQ(few.iterations, GetParam().limit);
  EXPECT_TRUE(few.s.allFinite());
  options.max_iterations = 1000000;
  options.time_limit = 1e-9;
  EXPECT_EQ(solve(GetParam().solver, p, options).status, SolveStatus::kTimeLimit);
}

TEST_P(ExactSolver, TakesTheSameStepsInAnyUnitsAndTwice) {
  const ContactProblem p = GetParam().solver == "multistart"
                               ? manufactured_problem(2, 8, 10, 3).problem
                               : lattice_step(Lattice::kTriangular, 5, 0.3, 10);
  const SolveResult si = run(in_units(p, 1, 1, 1), 1e-9);
  const SolveResult small = run(in_units(p, 1e3, 1e3, 1e3), 1e-9);  // g, mm, ms
  ASSERT_EQ(si.status, SolveStatus::kConverged) << si.message;
  ASSERT_EQ(small.status, SolveStatus::kConverged) << small.message;
  EXPECT_NEAR(si.iterations, small.iterations, GetParam().units);
  EXPECT_EQ(run(p, 1e-9).s, run(p, 1e-9).s);
}

INSTANTIATE_TEST_SUITE_P(, ExactSolver, testing::ValuesIn(exact_variants()),
                         [](const auto& tested) { return tested.param.name(); });

/// Solvers whose answers are exact to rounding, and the dimensions that they take.
using Exact = std::pair<const char*, int>;
const Exact kExact[] = {{"lemke", 2}, {"homotopy", 2}, {"multistart", 3}};

TEST(ExactSolvers, AgreeOnRandomNetworksWithGaussSeidel) {
  for (const auto& [solver, max_dim] : kExact) {
    int compared = 0;
    for (int dim = 1; dim <= max_dim; ++dim) {
      for (unsigned seed = 1; seed <= 12; ++seed) {
        const Manufactured m = manufactured_problem(dim, 8, 10, seed);
        const SolveResult exact = solve(solver, m.problem, {.tol = 1e-11});
        ASSERT_EQ(exact.status, SolveStatus::kConverged) << solver << dim << seed << exact.message;
        EXPECT_LE(contact_error(m.problem, exact.s).guarded(), 1e-11);
        const SolveResult swept = solve("pgs", m.problem, {.tol = 1e-10});
        if (!is_success(swept.status)) continue;
        ++compared;
        EXPECT_LT((swept.u - exact.u).norm(), 1e-6 * m.problem.u_free.norm())
            << solver << ", d = " << dim << ", seed " << seed;
      }
    }
    EXPECT_GE(compared, 10 * max_dim) << solver;
  }
}

// In space the direction of sliding must be found as well: b_t = (3, 4), W = 1, so that s_t = -mu
// (0.6, 0.8), whatever the start.
TEST(ExactSolvers, FindTheDirectionOfSliding) {
  const ContactProblem p = one_contact_problem(3, 1, 1, 0.5, -1, Vector{{3, 4}});
  for (const char* solver : {"pdas", "ptc"}) {
    const SolveResult r =
        converged(solve(solver, p, {.tol = 1e-10, .s0 = Vector{{1, 0.3, -0.2}}}), solver);
    EXPECT_NEAR(r.s[1], -0.3, 1e-9) << solver;
    EXPECT_NEAR(r.s[2], -0.4, 1e-9) << solver;
  }
}

// W is singular and every vertex of the pyramid's path is degenerate; Siconos' Lemke goes wrong
// from 55 contacts (square lattice of 5 rows).
TEST(ExactSolvers, SolveHyperstaticAndSymmetricScenes) {
  std::vector<ContactProblem> problems = {lattice_step(Lattice::kSquare, 5, 0.3, 0),
                                          lattice_step(Lattice::kTriangular, 5, 0.3, 10),
                                          lattice_step(Lattice::kPyramid, 5, 0.5, 0)};
  const auto expect_solved = [&](const char* solver) {
    for (const ContactProblem& p : problems) {
      const SolveResult r = solve(solver, p, {.tol = 1e-11});
      EXPECT_EQ(r.status, SolveStatus::kConverged) << solver << p.num_contacts() << r.message;
    }
  };
  expect_solved("multistart");
  problems.push_back(lattice_step(Lattice::kTriangular, 6, 0, 0));
  problems.push_back(lattice_step(Lattice::kPyramid, 7, 0.3, 0));
  expect_solved("lemke");
  problems.push_back(lattice_step(Lattice::kPyramid, 10, 0.3, 0));
  expect_solved("homotopy");
}

TEST(ExactSolvers, TakeAnUnsymmetricOperatorAsItIs) {
  const Manufactured m = manufactured_problem(2, 8, 8, 5);
  ContactProblem p = local_form(m.problem);
  for (int k = 0; k < p.W.nonZeros(); ++k) p.W.valuePtr()[k] *= 1 + 1e-3 * (k % 7);
  p.u_free = m.u - p.W * m.s;
  for (const char* solver : {"lemke", "homotopy"}) {
    converged(solve(solver, p, {.tol = 1e-11}), solver);
  }
}

// A body between two walls that close in on it from both sides: u_1 + u_2 = -2 whatever s is.
TEST(ExactSolvers, NeverClaimASolutionWhereNoneExists) {
  const ContactProblem p{.dim = 1,
                         .A = Eigen::MatrixXd::Ones(1, 1).sparseView(),
                         .H = Eigen::MatrixXd{{1, -1}}.sparseView(),
                         .v_free = Vector::Zero(1),
                         .u_free = Vector::Constant(2, -1),
                         .mu = Vector::Zero(2)};
  ASSERT_EQ(validate(p), "");
  const SolveResult ray = ended(SolveStatus::kNumericalFailure, solve("lemke", p, {.tol = 1e-11}));
  EXPECT_TRUE(says(ray.message, "a ray"));
  for (const char* solver : {"homotopy", "ipm"}) {
    const SolveResult r = solve(solver, p);
    EXPECT_TRUE(r.status == SolveStatus::kStalled || r.status == SolveStatus::kDiverged)
        << to_string(r.status) << ": " << r.message;
    EXPECT_GT(r.error.guarded(), 1e-3);
    EXPECT_TRUE(r.s.allFinite());
  }
}

TEST(ExactSolvers, RefuseProblemsBeyondTheirSizeOrDimension) {
  const auto status = [](const char* solver, const ContactProblem& p) {
    return solve(solver, p).status;
  };
  const ContactProblem space = manufactured_problem(3, 3, 4, 1).problem;
  EXPECT_EQ(status("lemke", lattice_step(Lattice::kSquare, 13, 0.3, 0)),
            SolveStatus::kInvalidInput);
  EXPECT_EQ(status("lemke", space), SolveStatus::kInvalidInput);
  EXPECT_EQ(status("homotopy", space), SolveStatus::kInvalidInput);
  EXPECT_EQ(status("multistart", lattice_step(Lattice::kSquare, 9, 0.3, 0)),
            SolveStatus::kInvalidInput);
}

}  // namespace
}  // namespace bipot
