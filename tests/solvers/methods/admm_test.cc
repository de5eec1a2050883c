#include "solvers/methods/admm.h"

#include "tests/support/converged.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/random_vector.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

SolveResult run_admm(const ContactProblem& p, std::map<std::string, std::string> parameters = {},
                     double tol = 1e-8, int max_iterations = 20000) {
  SolverOptions o{
      .tol = tol, .max_iterations = max_iterations, .parameters = std::move(parameters)};
  return solve("admm", p, o);
}

TEST(Admm, VelocityAndContactFormDoTheSameSteps) {
  const ContactProblem p = triangular_lattice(6);
  const ContactProblem local = local_form(p);
  const SolveResult a = run_admm(p, {{"rho", "0.1"}}, 1e-14, 30);
  const SolveResult b = run_admm(local, {{"rho", "0.1"}}, 1e-14, 30);
  // Factors in single precision are corrected by residuals, from one iteration to the next.
  EXPECT_LT((a.s - b.s).norm(), 1e-6 * a.s.norm());
}

/// Long enough for two changes of all penalties.
TEST(Admm, PenaltiesByStatusAreThoseOfBothForms) {
  const ContactProblem p = shipped_file("2d_pour14_200.hdf5");
  const SolveResult a = run_admm(p, {}, 1e-14, 160), b = run_admm(local_form(p), {}, 1e-14, 160);
  EXPECT_LT((a.s - b.s).norm(), 1e-6 * a.s.norm());
}

/// One penalty for all took 1729, 1531 and 1954 iterations.
TEST(Admm, PenaltiesByStatusSaveIterationsWhereContactsSlipAndOpen) {
  for (const auto& [name, one_for_all] :
       {std::pair("2d_compaction_flow.hdf5", 1729), std::pair("2d_pile_300_mu03.hdf5", 1531),
        std::pair("2d_strike12_450.hdf5", 1954)}) {
    const SolveResult by_status = converged(run_admm(shipped_file(name), {}, 1e-6), name);
    EXPECT_LT(1.5 * by_status.iterations, one_for_all) << name;
  }
}

/// Masses 10^6 apart: by status it stalls at 1e-2, balanced penalties arrive.
TEST(Admm, GoesOnWithBalancedPenaltiesWhereThoseByStatusFail) {
  converged(run_admm(shipped_file("2d_triangular_12_mass1e6.hdf5"), {}, 1e-3));
}

/// A multiplier that fits such a start would leave a self-stress of a thousand times its size.
TEST(Admm, ForgetsAStartFarFromTheAnswer) {
  for (const char* name : {"1d_square_20.hdf5", "2d_triangular_20_tilt10.hdf5"}) {
    const ContactProblem p = shipped_file(name);
    const SolverOptions cold{.tol = 1e-8, .max_iterations = 1000};
    const double size = solve("admm", p, cold).s.cwiseAbs().maxCoeff();
    SolverOptions o = cold;
    o.s0 = size * random_vector(p.num_rows(), 3);
    EXPECT_LT(converged(solve("admm", p, o), name).s.cwiseAbs().maxCoeff(), 20 * size) << name;
  }
}

TEST(Admm, AFewDozenIterationsSolveALattice) {
  for (const ContactProblem& p : {triangular_lattice(20, {.tilt = 0.17}), square_lattice(20)}) {
    EXPECT_LT(converged(run_admm(p)).iterations, 200);
  }
}

// An eigenvalue of -0.01 is more than the first penalty: that is raised until the factor exists.
TEST(Admm, RaisesThePenaltyOfAnIndefiniteOperator) {
  const Eigen::Matrix4d W{{1, 0, 1.01, 0}, {0, 1, 0, 0}, {1.01, 0, 1, 0}, {0, 0, 0, 1}};
  // The first contact alone: s_n = 1, u_n = 0.51 at the second.
  converged(run_admm(delassus_problem(2, W, vec({-1, 0, -0.5, 0}), vec({0.3, 0.3}))));
}

TEST(Admm, SolvesTheFreePyramid) { converged(run_admm(pyramid(10))); }

}  // namespace
}  // namespace bipot
