#include "solvers/methods/load_path.h"

#include "solvers/simulation/step_solver.h"
#include "tests/support/converged.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/naive_error.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

constexpr double kTilt = 10 * std::numbers::pi / 180;

SolveResult held(const ContactProblem& p, double tol = 1e-9) {
  return solve("load_path", p, {.tol = tol});
}

// Three disks of mass m on each other carry m g h, 2 m g h and 3 m g h.
TEST(LoadPath, AColumnCarriesItsWeights) {
  const ContactProblem p = square_lattice(3, {.mass = 2, .gravity = 10, .time_step = 0.01});
  const SolveResult r = converged(held(p));
  EXPECT_EQ(r.iterations, 1);
  int seen[4] = {};
  for (int c = 0; c < p.num_contacts(); ++c) {
    const double weights = r.s[2 * c] / (2 * 10 * 0.01);
    const long level = std::lround(weights);
    ASSERT_TRUE(level >= 0 && level <= 3) << weights;
    EXPECT_NEAR(weights, static_cast<double>(level), 1e-9);
    EXPECT_NEAR(r.s[2 * c + 1], 0, 1e-12);
    ++seen[level];
  }
  for (const int level : {1, 2, 3}) EXPECT_EQ(seen[level], 3);
}

TEST(LoadPath, HoldsLattices) {
  for (const ContactProblem& p :
       {square_lattice(30, {.tilt = kTilt}), square_lattice(30, {.tilt = kTilt, .turn = 0.7}),
        square_lattice(12, {.dim = 1, .tilt = kTilt}), triangular_lattice(30, {.tilt = kTilt}),
        triangular_lattice(30, {.mu = 0.1, .tilt = kTilt}), triangular_lattice(9, {.e_n = 0.5}),
        triangular_lattice(30), square_lattice(30), cubic_lattice(6, {.dim = 3}),
        cubic_lattice(8, {.dim = 3, .tilt = kTilt})}) {
    const SolveResult r = converged(held(p));
    EXPECT_LE(naive_error(p, r.s).guarded(), 1e-9);
    // Nothing moves, as by other solvers.
    EXPECT_LE((r.u - solve("assor", p, {.tol = 1e-9}).u).norm(), 1e-7 * p.u_free.norm());
  }
}

TEST(LoadPath, HasTheSameBitsForAnyNumberOfThreads) {
  // Some hundred bodies are due at the same time: several tasks.
  for (const ContactProblem& p :
       {triangular_lattice(150, {.tilt = kTilt}), cubic_lattice(16, {.dim = 3, .tilt = kTilt})}) {
    const SolveResult alone = converged(held(p));
    for (const int threads : {2, 3, 4}) {
      const SolveResult r =
          solve("load_path", p, {.tol = 1e-9, .execution = {threads, SimdPath::kAuto}});
      EXPECT_EQ(r.s, alone.s) << threads;
    }
  }
}

/// The message of a solve that has to give up: it has not converged, and its impulse is 0.
std::string refused(const ContactProblem& p) {
  const SolveResult r = ended(SolveStatus::kStalled, held(p, 1e-2));
  EXPECT_EQ(r.s, Vector::Zero(p.num_rows()));
  return r.message;
}

TEST(LoadPath, SaysWhyItGivesUp) {
  // The lower disks of a pyramid would roll away without friction from above.
  EXPECT_TRUE(says(refused(pyramid(3)), "body 0 is not held from below"));
  EXPECT_TRUE(says(refused(shipped_file("2d_pile_300_mu03.hdf5")), "is not held"));
  ContactProblem arriving = square_lattice(3);  // a rebound from before the step
  arriving.u_free[0] -= 0.1;
  EXPECT_TRUE(says(refused(arriving), "velocities before"));
  EXPECT_TRUE(says(refused(local_form(square_lattice(3))), "no disks or spheres"));
  const ContactProblem pressed = with_driven_wall(square_lattice(3), Vec2(0, 1), 1, 0);
  EXPECT_TRUE(says(refused(pressed), "on fixed walls"));
  ContactProblem upwards = square_lattice(2);  // a row falls up as quickly as the other one down
  upwards.v_free.head(6) *= -1;
  upwards.u_free = upwards.H.transpose() * upwards.v_free;
  EXPECT_TRUE(says(refused(upwards), "no common direction"));
}

TEST(LoadPath, ServesAutoButNotRuns) {
  const ContactProblem p = cubic_lattice(6, {.dim = 3, .tilt = kTilt});
  const SolveResult any = solve("auto", p, {.tol = 1e-6});
  EXPECT_EQ(any.iterations, 1) << any.message;
  EXPECT_GT(solve("auto", p, {.tol = 1e-6, .parameters = {{"forces", "spread"}}}).iterations, 1);
  const StepSolver in_a_run = make_step_solver(require_solver("auto"), {.tol = 1e-6});
  EXPECT_GT(in_a_run(p, Vector::Zero(p.num_rows())).iterations, 1);
}

}  // namespace
}  // namespace bipot
