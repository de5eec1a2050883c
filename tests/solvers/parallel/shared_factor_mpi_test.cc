// Factorisations that all processes do together (ProcessGroup::run_on_root), and the solvers on
// them.

#include <Eigen/LU>

#include "core/base/triplets.h"
#include "solvers/parallel/distributed_solve.h"
#include "tests/solvers/parallel/mpi_group.h"
#include "tests/support/converged.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

const DistributedOptions kShared{.shared_factor_rows = 0};

/// Symmetric pattern, values not; `seed` draws the values, `reach` the pattern.
SparseMatrix banded(int size, int reach, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> value(-1, 1);
  Triplets entries;
  for (int i = 0; i < size; ++i) {
    for (int j = 0; j < size; ++j) {
      if (i == j || std::abs(i - j) == reach || std::abs(i - j) == 1) {
        entries.emplace_back(i, j, value(random));
      }
    }
  }
  return from_triplets(size, size, entries);
}

/// On the first process, for its factor.
void expect_solves(SystemFactor& factor, const SparseMatrix& A) {
  const Eigen::MatrixXd dense(A);
  const Vector b = Vector::LinSpaced(A.rows(), -1, 2);
  ASSERT_TRUE(factor.factor(A));
  Vector x;
  factor.solve(b, x);
  EXPECT_LT((dense * x - b).norm(), 1e-10 * (b.norm() + dense.norm() * x.norm()));
  EXPECT_EQ(factor.determinant_sign(), dense.determinant() < 0 ? -1 : 1);
}

TEST(SharedFactor, SolvesWithOneMatrixAfterTheOther) {
  int signs[2] = {0, 0};
  mpi_group().run_on_root([&](SystemFactor& factor) {
    for (const int size : {1, 2, 3, 40, 41}) {
      for (unsigned seed = 1; seed <= 4; ++seed) {  // the same pattern four times
        SCOPED_TRACE(size);
        const SparseMatrix A = banded(size, 5, seed);
        expect_solves(factor, A);
        ++signs[factor.determinant_sign() < 0 ? 0 : 1];
      }
    }
    expect_solves(factor, banded(41, 7, 1));  // as many entries, elsewhere
  });
  if (mpi_group().rank() == 0) {
    EXPECT_TRUE(signs[0] > 0 && signs[1] > 0) << "both signs must occur";
  }
}

TEST(SharedFactor, SaysWhatCannotBeFactoredAndGoesOn) {
  mpi_group().run_on_root([&](SystemFactor& factor) {
    SparseMatrix A = banded(30, 4, 2);
    const SparseMatrix good = A;
    for (SparseMatrix::InnerIterator it(A, 17); it; ++it) it.valueRef() = 0;
    EXPECT_FALSE(factor.factor(A)) << "a column of zeros";
    expect_solves(factor, good);
    A.coeffRef(29, 29) = kNaN;
    EXPECT_FALSE(factor.factor(A));
    expect_solves(factor, good);
  });
}

TEST(SharedFactor, AFailureOfTheWorkIsKnownToAll) {
  try {
    mpi_group().run_on_root([](SystemFactor& factor) {
      (void)factor.factor(banded(10, 3, 1));
      throw std::runtime_error("the work is too hard");
    });
    ADD_FAILURE() << "no process may go on";
  } catch (const CommonFailure& e) {
    EXPECT_EQ(std::string(e.what()), "the work is too hard");
  }
}

/// All together take as many iterations as one process, but for `slack`, as factors differ by
/// rounding; without the shared factor the bits are its own.
DistributedResult expect_shared(const std::string& solver, const ContactProblem& p,
                                const SolverOptions& options, int slack) {
  const SolveResult alone = converged(solve(solver, p, options));
  const DistributedResult all = distributed_solve(solver, p, options, mpi_group(), kShared);
  EXPECT_EQ(all.result.status, SolveStatus::kConverged) << all.result.message;
  EXPECT_NEAR(all.result.iterations, alone.iterations, slack);
  EXPECT_LT((all.result.u - alone.u).norm(), 1e-6 * p.u_free.norm());
  EXPECT_TRUE(says(all.result.message, "factored by all"));
  if (mpi_group().size() > 1) {
    const DistributedResult first = distributed_solve(solver, p, options, mpi_group());
    EXPECT_EQ(first.result.s, alone.s) << "the first process alone: its own bits";
    EXPECT_GT(all.counts.traffic.bytes, first.counts.traffic.bytes) << "matrices travel";
  }
  return all;
}

TEST(SharedFactor, TheInteriorPointTakesTheIterationsOfOneProcess) {
  const ContactProblem p = triangular_lattice(12, {.tilt = 0.1});
  SolverOptions options{.tol = 1e-9};
  const DistributedResult all = expect_shared("ipm", p, options, 1);
  // A start that is an answer but for a little is polished.
  options.s0 = all.result.s * (1 + 1e-7);
  const DistributedResult warm = distributed_solve("ipm", p, options, mpi_group(), kShared);
  EXPECT_EQ(warm.result.status, SolveStatus::kConverged) << warm.result.message;
  EXPECT_LT(warm.result.iterations, all.result.iterations / 2);
}

TEST(SharedFactor, TheInteriorPointKeepsToItsLimits) {
  const ContactProblem p = triangular_lattice(12, {.tilt = 0.1});
  SolverOptions options{.tol = 1e-15, .max_iterations = 3};
  EXPECT_EQ(distributed_solve("ipm", p, options, mpi_group()).result.status,
            SolveStatus::kIterationLimit);
  options = {};
  options.time_limit = 1e-9;
  EXPECT_EQ(distributed_solve("ipm", p, options, mpi_group()).result.status,
            SolveStatus::kTimeLimit);
  options = {};
  options.tol = 1e-15;
  options.cancelled = [] { return true; };
  EXPECT_EQ(distributed_solve("ipm", p, options, mpi_group()).result.status,
            SolveStatus::kInterrupted);
}

TEST(SharedFactor, NewtonTakesTheStepsOfOneProcess) {
  // The lattice is degenerate (W singular): agreement of velocities, not of impulses.
  const ContactProblem p = triangular_lattice(8, {.tilt = 0.1});
  SolverOptions options{.tol = 1e-9};
  for (const char* form : {"mixed", "contact"}) {
    SCOPED_TRACE(form);
    options.parameters = {{"form", form}, {"linear", "mumps"}};
    expect_shared("newton", p, options, 2);
  }
}

TEST(SharedFactor, NewtonFactorsOnTheFirstProcessWhereTheOthersCannot) {
  const ContactProblem p = triangular_lattice(3, {.dim = 1, .tilt = 0.1});
  for (const auto& [name, value] :
       {std::pair{"linear", "umfpack"}, std::pair{"residual", "snesvi"}}) {
    SolverOptions options{.parameters = {{name, value}}};
    const SolveResult alone = solve("newton", p, options);
    const SolveResult out = distributed_solve("newton", p, options, mpi_group(), kShared).result;
    EXPECT_EQ(out.status, alone.status) << out.message;
    EXPECT_EQ(out.s, alone.s) << name;
    EXPECT_TRUE(says(out.message, "on the root process"));
  }
}

TEST(SharedFactor, AutoTurnsToItWhereGradientsDoNotArrive) {
  const ContactProblem p = shipped_file("2d_triangular_12_mass1e6.hdf5");
  SolverOptions options{.tol = 1e-9};
  options.max_iterations = 3 * 512 + 60;  // a round, and some for factorisations
  const DistributedResult out = distributed_solve("auto", p, options, mpi_group());
  EXPECT_EQ(out.result.status, SolveStatus::kConverged) << out.result.message;
  EXPECT_LE(contact_error(p, out.result.s).guarded(), 1e-9);
  EXPECT_GT(out.result.iterations, 3 * 512) << "an easier problem than was meant";
}

}  // namespace
}  // namespace bipot
