// What every first-order solver must do, in each of its variants: the analytic contacts, the stop
// tests and limits, starts, and independence of units and of the scene's direction.

#include <ostream>

#include "tests/support/converged.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/manufactured.h"
#include "tests/support/small_problems.h"
#include "tests/support/test_name.h"

namespace bipot {
namespace {

struct Variant {
  std::string solver;
  std::map<std::string, std::string> parameters;

  std::string name() const { return test_name(solver, parameters); }
};

std::vector<Variant> variants() {
  return {{"uzawa", {}},
          {"uzawa", {{"refresh", "gauss-seidel"}}},
          {"classical", {}},
          {"classical", {{"refresh", "gauss-seidel"}}},
          {"pgs", {}},
          {"pgs", {{"local", "exact"}}},
          {"pgs", {{"local", "exact"}, {"omega", "1.3"}}},
          {"pgs", {{"local_iterations", "5"}}},
          {"pgs", {{"order", "symmetric"}, {"omega", "1.4"}}},
          {"pgs", {{"order", "shuffled"}, {"seed", "7"}}},
          {"pgs", {{"operator", "explicit"}}},
          {"apgd", {}},
          {"apgd", {{"map", "followed"}}},
          {"apgd", {{"map", "followed"}, {"hold", "64"}}},
          {"apgd", {{"map", "split"}}},
          {"anderson", {}},
          {"anderson", {{"map", "gradient"}, {"memory", "4"}}},
          {"admm", {}},
          {"admm", {{"rho", "0.1"}}}};
}

void PrintTo(const Variant& variant, std::ostream* out) { *out << variant.name(); }

class FirstOrder : public testing::TestWithParam<Variant> {
 protected:
  SolverOptions options(double tol = 1e-8) const {
    return SolverOptions{.tol = tol, .max_iterations = 200000, .parameters = GetParam().parameters};
  }
  SolveResult run(const ContactProblem& p, const SolverOptions& o) const {
    return solve(GetParam().solver, p, o);
  }
};

// W = diag(2, 5), mu = 0.5: with b_n = -4 the normal impulse is 2, the edge of the cone 1.
TEST_P(FirstOrder, SolvesTheContactThatSticks) {
  for (int dim = 1; dim <= 3; ++dim) {
    Vector b_t(dim - 1);
    if (dim > 1) b_t.setConstant(3.0 / std::sqrt(dim - 1.0));  // |s_t| = 3/5 < 1
    const SolveResult r =
        converged(run(one_contact_problem(dim, 2, 5, 0.5, -4, b_t), options(1e-10)), dim);
    EXPECT_NEAR(r.s[0], 2, 1e-8);
    EXPECT_NEAR(r.s.tail(dim - 1).norm(), dim > 1 ? 0.6 : 0, 1e-8);
    EXPECT_LT(r.u.norm(), 1e-8);
  }
}

TEST_P(FirstOrder, SolvesTheContactThatSlips) {
  for (int dim = 2; dim <= 3; ++dim) {
    Vector b_t = Vector::Zero(dim - 1);
    b_t[dim - 2] = -20;  // sticking would need |s_t| = 4 > 1
    const SolveResult r =
        converged(run(one_contact_problem(dim, 2, 5, 0.5, -4, b_t), options(1e-10)), dim);
    EXPECT_NEAR(r.s[0], 2, 1e-8);
    EXPECT_NEAR(r.s[dim - 1], 1, 1e-8);
    EXPECT_NEAR(r.u[dim - 1], -15, 1e-7);
  }
}

// A second body's contact closes, the first opens: the solver itself has to find s = 0 there.
TEST_P(FirstOrder, LeavesTheContactThatOpensAlone) {
  SparseRows W(4, 4);
  for (int k = 0; k < 4; ++k) W.insert(k, k) = k % 2 == 0 ? 2 : 5;
  W.makeCompressed();
  ContactProblem p{.dim = 2, .W = W, .u_free = Vector(4), .mu = Vector::Constant(2, 0.5)};
  p.u_free << 1, 2, -4, 0;
  const SolveResult r = converged(run(p, options(1e-10)));
  EXPECT_EQ(r.s[0], 0);
  EXPECT_EQ(r.s[1], 0);
  EXPECT_NEAR(r.s[2], 2, 1e-8);
}

TEST_P(FirstOrder, FindsTheManufacturedVelocities) {
  for (int dim = 1; dim <= 3; ++dim) {
    const Manufactured m = manufactured_problem(dim, 20, 22, 11);
    const SolveResult r = converged(run(m.problem, options()), dim);
    EXPECT_LE(r.error.guarded(), 1e-8);
    EXPECT_LT((r.u - m.u).norm(), 1e-6 * m.u.norm()) << dim;
  }
}

TEST_P(FirstOrder, SolvesLatticesOfDisksAndSpheres) {
  LatticeOptions o{.tilt = 10 * std::numbers::pi / 180, .e_n = 0.1, .e_t = 1};
  for (const ContactProblem& p :
       {triangular_lattice(6, o), square_lattice(6), cubic_lattice(3, {.tilt = o.tilt})}) {
    ASSERT_EQ(validate(p), "");
    converged(run(p, options(1e-6)), p.dim);
  }
}

TEST_P(FirstOrder, SaysThatTheIterationLimitWasReached) {
  const ContactProblem p = triangular_lattice(8);
  SolverOptions o = options();
  o.max_iterations = 3;
  const SolveResult r = ended(SolveStatus::kIterationLimit, run(p, o));
  EXPECT_EQ(r.iterations, 3);
  EXPECT_TRUE(r.s.allFinite());
}

TEST_P(FirstOrder, SaysThatTimeIsUp) {
  const ContactProblem p = triangular_lattice(30);
  SolverOptions o = options(1e-14);
  o.time_limit = 1e-9;
  EXPECT_EQ(run(p, o).status, SolveStatus::kTimeLimit);
}

TEST_P(FirstOrder, NeedsFewerIterationsFromANearbyStart) {
  const ContactProblem p = triangular_lattice(8, {.tilt = 0.1});
  const SolveResult cold = converged(run(p, options(1e-7)));
  SolverOptions o = options(1e-7);
  o.s0 = cold.s;
  EXPECT_EQ(converged(run(p, o)).iterations, 0);
  o.tol = 1e-8;
  EXPECT_LT(converged(run(p, o)).iterations, cold.iterations);
}

TEST_P(FirstOrder, GivesTheSameBitsTwice) {
  const ContactProblem p = triangular_lattice(6);
  const SolveResult a = run(p, options(1e-6)), b = run(p, options(1e-6));
  EXPECT_EQ(a.iterations, b.iterations);
  EXPECT_TRUE((a.s.array() == b.s.array()).all());
}

TEST_P(FirstOrder, DoesNotDependOnUnits) {
  // m, kg, s against mm, g, ms: lengths, masses and times are 1000 times larger numbers.
  LatticeOptions si{.tilt = 0.1};
  LatticeOptions small = si;
  small.radius *= 1e3;
  small.mass *= 1e3;
  small.time_step *= 1e3;
  small.gravity *= 1e3 / 1e6;
  const SolveResult a = converged(run(triangular_lattice(6, si), options(1e-6)));
  const SolveResult b = converged(run(triangular_lattice(6, small), options(1e-6)));
  EXPECT_NEAR(a.iterations, b.iterations, 1);
  EXPECT_NEAR(a.error.guarded(), b.error.guarded(), 0.1 * a.error.guarded());
  for (int dim = 1; dim <= 3; ++dim) {
    const ContactProblem p = manufactured_problem(dim, 12, 13, 5).problem;
    const SolveResult c = run(p, options(1e-6));
    const SolveResult d = run(in_units(p, 1e3, 1e3, 1e3), options(1e-6));
    ASSERT_EQ(c.status, SolveStatus::kConverged) << dim << c.message;
    EXPECT_NEAR(c.iterations, d.iterations, 1) << dim;
  }
}

TEST_P(FirstOrder, DoesNotDependOnTheDirectionOfTheScene) {
  LatticeOptions upright{.tilt = 0.1};
  LatticeOptions turned = upright;
  turned.turn = 37 * std::numbers::pi / 180;
  const SolveResult a = run(triangular_lattice(6, upright), options(1e-6));
  const SolveResult b = run(triangular_lattice(6, turned), options(1e-6));
  ASSERT_EQ(a.status, SolveStatus::kConverged) << a.message;
  EXPECT_NEAR(a.iterations, b.iterations, 1);
}

INSTANTIATE_TEST_SUITE_P(, FirstOrder, testing::ValuesIn(variants()),
                         [](const auto& tested) { return tested.param.name(); });

TEST(FirstOrderSolvers, SolveAnUnsymmetricOperator) {
  const Manufactured m = manufactured_problem(3, 12, 10, 4);
  ContactProblem p = local_form(m.problem);
  const double scale = p.W.diagonal().maxCoeff();
  for (int k = 0; k < p.W.nonZeros(); ++k) p.W.valuePtr()[k] += 1e-3 * scale * std::sin(k + 1);
  p.u_free = m.u - Vector(p.W * m.s);
  for (const char* solver : {"apgd", "admm"}) {
    converged(solve(solver, p, {.max_iterations = 20000}), solver);
  }
}

}  // namespace
}  // namespace bipot
