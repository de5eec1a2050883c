#include "solvers/methods/gauss_seidel.h"

#include "tests/support/converged.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/manufactured.h"

namespace bipot {
namespace {

SolveResult run_pgs(const ContactProblem& p, std::map<std::string, std::string> parameters,
                    int max_iterations, double tol = 1e-8) {
  SolverOptions o{
      .tol = tol, .max_iterations = max_iterations, .parameters = std::move(parameters)};
  return solve("pgs", p, o);
}

TEST(GaussSeidel, DisksAndExplicitOperatorDoTheSameSweeps) {
  const ContactProblem p = triangular_lattice(8);
  for (const std::string order : {"forward", "symmetric", "shuffled"}) {
    const SolveResult disks = run_pgs(p, {{"order", order}}, 50, 1e-14);
    const SolveResult whole = run_pgs(p, {{"order", order}, {"operator", "explicit"}}, 50, 1e-14);
    EXPECT_LT((disks.s - whole.s).norm(), 1e-11 * whole.s.norm()) << order;
  }
}

TEST(GaussSeidel, OrdersAreDifferentAndSeedsMatter) {
  const ContactProblem p = triangular_lattice(8);
  const Vector forward = run_pgs(p, {}, 5).s;
  const Vector symmetric = run_pgs(p, {{"order", "symmetric"}}, 5).s;
  const Vector first = run_pgs(p, {{"order", "shuffled"}, {"seed", "1"}}, 5).s;
  const Vector again = run_pgs(p, {{"order", "shuffled"}, {"seed", "1"}}, 5).s;
  const Vector second = run_pgs(p, {{"order", "shuffled"}, {"seed", "2"}}, 5).s;
  EXPECT_GT((forward - symmetric).norm(), 1e-3 * forward.norm());
  EXPECT_GT((forward - first).norm(), 1e-3 * forward.norm());
  EXPECT_GT((first - second).norm(), 1e-3 * forward.norm());
  EXPECT_EQ((first - again).norm(), 0);
}

TEST(GaussSeidel, OverRelaxationPaysOnALattice) {
  const ContactProblem p = square_lattice(12);
  const SolveResult plain = converged(run_pgs(p, {}, 100000)),
                    relaxed = converged(run_pgs(p, {{"omega", "1.7"}}, 100000));
  EXPECT_LT(3 * relaxed.iterations, plain.iterations);
}

// Disks: the local block is diagonal and both local solvers are the same.
TEST(GaussSeidel, ProjectionIsExactForDisks) {
  const ContactProblem p = triangular_lattice(6);
  const Vector projected = run_pgs(p, {}, 30).s;
  const Vector exact = run_pgs(p, {{"local", "exact"}, {"operator", "explicit"}}, 30).s;
  EXPECT_LT((projected - exact).norm(), 1e-10 * exact.norm());
}

// Relaxed they differ: either operator does what is asked for.
TEST(GaussSeidel, RelaxedLocalSolutionsDoNotDependOnTheOperator) {
  const ContactProblem p = triangular_lattice(6, {.tilt = 0.3});
  using Choice = std::map<std::string, std::string>;
  const Vector plain = run_pgs(p, {{"omega", "1.5"}}, 7).s;
  for (const Choice& local : {Choice{{"local", "exact"}}, Choice{{"local_iterations", "50"}}}) {
    Choice choice = local;
    choice["omega"] = "1.5";
    const Vector bodies = run_pgs(p, choice, 7).s;
    EXPECT_GT((bodies - plain).norm(), 1e-4 * plain.norm()) << choice.begin()->first;
    choice["operator"] = "explicit";
    EXPECT_LT((bodies - run_pgs(p, choice, 7).s).norm(), 1e-10 * plain.norm());
    choice.erase("operator");
    choice["order"] = "tiled";
    const SolveResult as_they_stand = run_pgs(p, choice, 7);
    EXPECT_LT((bodies - as_they_stand.s).norm(), 1e-10 * plain.norm());
    EXPECT_TRUE(says(as_they_stand.message, "contacts as they stand, not tiled"));
  }
  const SolveResult as_a_matrix = run_pgs(p, {{"order", "tiled"}, {"operator", "explicit"}}, 7);
  EXPECT_TRUE(says(as_a_matrix.message, "not tiled"));
}

TEST(GaussSeidel, OneContactTakesOneExactSweep) {
  for (int dim = 2; dim <= 3; ++dim) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
      const ContactProblem p = manufactured_problem(dim, 1, 1, seed).problem;
      const SolveResult r = run_pgs(p, {{"local", "exact"}}, 2, 1e-10);
      EXPECT_TRUE(is_success(r.status)) << dim << " " << seed << r.message;
      EXPECT_LE(r.iterations, 1);
    }
  }
}

// A ring of disks that jammed in an impact and has come to rest: its free velocity is rounding, and
// the impulses that it starts from are those of the impact, 1e25 times the energy. They say
// nothing, and are no divergence.
TEST(GaussSeidel, AStartBeyondAllMeasureIsDroppedAndNotCalledDivergence) {
  ContactProblem p = triangular_lattice(6);
  p.v_free *= 1e-13;
  p.u_free *= 1e-13;
  const SolveResult cold = converged(run_pgs(p, {}, 100000));
  SolverOptions options{.tol = 1e-8, .s0 = Vector::Ones(p.num_rows())};
  for (const char* solver : {"pgs", "apgd", "auto", "uzawa"}) {
    converged(solve(solver, p, options), solver);
  }
  // A start that can be compared is kept: 1e3 times the answer is 1e6 times its energy.
  options.s0 = 1e3 * cold.s;
  options.max_iterations = 1;
  const SolveResult from_there = solve("pgs", p, options);
  options.s0 = Vector();
  EXPECT_NE(from_there.s, solve("pgs", p, options).s);
}

}  // namespace
}  // namespace bipot
