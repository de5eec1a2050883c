#include "solvers/methods/newton_snes.h"

#include <unistd.h>

#include <csignal>

#include "core/linear/sparse_factor.h"
#include "core/linear/system_factor.h"
#include "solvers/solve_run.h"
#include "tests/support/converged.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

using ParameterMap = std::map<std::string, std::string>;

SolveResult newton(const ContactProblem& p, ParameterMap parameters = {}, double tol = 1e-8) {
  SolverOptions options{.tol = tol};
  parameters.emplace("start_sweeps", "0");
  options.parameters = std::move(parameters);
  return solve("newton", p, options);
}

TEST(Newton, ContactAndMixedFormsAgree) {
  const ContactProblem p = lattice_step(Lattice::kTriangular, 5, 0.3, 10);
  for (const char* residual : {"alart-curnier", "fischer-burmeister"}) {
    const SolveResult contact =
        converged(newton(p, {{"form", "contact"}, {"residual", residual}}, 1e-10), residual);
    const SolveResult mixed =
        converged(newton(p, {{"form", "mixed"}, {"residual", residual}}, 1e-10), residual);
    EXPECT_EQ(contact.iterations, mixed.iterations) << residual;
    EXPECT_LT((contact.u - mixed.u).norm(), 1e-7 * p.u_free.norm()) << residual;
  }
}

TEST(Newton, EveryLinearSolverSolvesAHyperstaticLattice) {
  for (const double mu : {0.0, 0.3}) {  // d = 1 and d = 2
    const ContactProblem p = lattice_step(Lattice::kTriangular, 8, mu, 10);
    for (const char* linear : {"umfpack", "mumps", "petsc", "gmres"}) {
      const SolveResult r =
          converged(newton(p, {{"linear", linear}, {"start_sweeps", "50"}}), linear);
      EXPECT_LE(r.error.guarded(), 1e-8) << linear;
      EXPECT_TRUE(says(r.message, linear));
      EXPECT_TRUE(says(r.message, "last kappa"));
    }
  }
}

TEST(Newton, EveryLineSearchSolvesASquareLattice) {
  for (const char* search : {"basic", "bt", "l2", "cp"}) {
    converged(newton(lattice_step(Lattice::kSquare, 8, 0.3, 0), {{"line_search", search}}), search);
  }
}

TEST(Newton, SolvesFrictionlessProblemsAsVariationalInequalities) {
  for (const Lattice lattice : {Lattice::kSquare, Lattice::kTriangular}) {
    const ContactProblem p = lattice_step(lattice, 8, 0, 0);
    ASSERT_EQ(p.dim, 1);
    converged(newton(p, {{"residual", "snesvi"}}));
  }
  const SolveResult refused =
      ended(SolveStatus::kInvalidInput,
            newton(lattice_step(Lattice::kSquare, 3, 0.3, 0), {{"residual", "snesvi"}}));
  EXPECT_TRUE(says(refused.message, "dimension 1"));
}

TEST(Newton, SolvesTheFreePyramidWithTheDefaults) {
  for (const double mu : {0.3, 0.5}) {
    converged(solve("newton", lattice_step(Lattice::kPyramid, 10, mu, 0)));
  }
}

TEST(Newton, StallsAtRoundOffAndSaysSo) {
  const ContactProblem p = lattice_step(Lattice::kTriangular, 5, 0.3, 10);
  const SolveResult r = ended(SolveStatus::kStalled, newton(p, {}, 1e-19));
  EXPECT_LT(r.error.guarded(), 1e-10);
  EXPECT_TRUE(says(r.message, "round-off"));
}

TEST(Newton, HandsOptionsToPetscAndNamesTheUnusedOnes) {
  const ContactProblem p = lattice_step(Lattice::kSquare, 3, 0.3, 0);
  const SolveResult r = converged(newton(
      p, {{"petsc", "-snes_linesearch_type bt -bipot_newton_ksp_type preonly -nonsense 1"}}));
  EXPECT_TRUE(says(r.message, "did not use the options -nonsense"));
  const SolveResult clean = newton(p);  // nothing is left behind in PETSc's database
  EXPECT_FALSE(says(clean.message, "nonsense")) << clean.message;
  const SolveResult refused =
      ended(SolveStatus::kInvalidInput, newton(p, {{"petsc", "bt -snes_view"}}));
  EXPECT_TRUE(says(refused.message, "'bt'"));
}

TEST(Newton, APetscErrorBecomesAStatusWithText) {
  const ContactProblem p = lattice_step(Lattice::kSquare, 3, 0.3, 0);
  const SolveResult r = ended(SolveStatus::kNumericalFailure,
                              newton(p, {{"petsc", "-pc_type no_such_preconditioner"}}));
  EXPECT_TRUE(says(r.message, "PETSc"));
  EXPECT_EQ(newton(p).status, SolveStatus::kConverged);  // and the next solve is not affected
}

/// UMFPACK's LU in another's place; may refuse every matrix from the nth on, or throw there.
class OthersFactor final : public SystemFactor {
 public:
  enum class Then { kRefuse, kThrow };
  explicit OthersFactor(int good = 1 << 30, Then then = Then::kRefuse) : good_(good), then_(then) {}

  [[nodiscard]] bool factor(const SparseMatrix& A) override {
    if (++factored >= good_) {
      if (then_ == Then::kThrow) throw std::runtime_error("nobody is there");
      return false;
    }
    return lu_.factor(A);
  }
  void solve(const Vector& b, Vector& x) override { x = lu_.solve(b); }
  int determinant_sign() const override { return lu_.determinant_sign(); }

  int factored = 0;

 private:
  SparseLU lu_;
  int good_;
  Then then_;
};

SolveResult with_factor(const ContactProblem& p, const SolverOptions& options,
                        SystemFactor* factor) {
  WholeSpace space(p);
  return run_solver(require_solver("newton"), space, options, {}, factor);
}

TEST(Newton, SystemsMayBeFactoredElsewhere) {
  const ContactProblem p = lattice_step(Lattice::kTriangular, 6, 0.3, 10);
  SolverOptions options{.parameters = {{"start_sweeps", "0"}}};
  OthersFactor others;
  const SolveResult r = converged(with_factor(p, options, &others));
  const SolveResult own = newton(p, {{"linear", "umfpack"}});
  EXPECT_NEAR(r.iterations, own.iterations, 2) << "factors differ by rounding";
  EXPECT_LE(contact_error(p, r.s).guarded(), 1e-8);
  EXPECT_GE(others.factored, r.iterations);
}

TEST(Newton, AFactorElsewhereThatRefusesOrThrowsIsSaid) {
  const ContactProblem p = lattice_step(Lattice::kTriangular, 6, 0.3, 10);
  SolverOptions options{.parameters = {{"start_sweeps", "0"}}};
  OthersFactor refuses(3);
  const SolveResult r = with_factor(p, options, &refuses);
  EXPECT_FALSE(is_success(r.status)) << r.message;
  EXPECT_TRUE(r.s.allFinite());
  EXPECT_TRUE(says(r.message, "failed"));
  OthersFactor throws(3, OthersFactor::Then::kThrow);
  EXPECT_THROW((void)with_factor(p, options, &throws), std::runtime_error);
  EXPECT_EQ(newton(p).status, SolveStatus::kConverged);  // PETSc is as it was
}

TEST(Newton, LeavesSignalHandlersAlone) {
  struct sigaction before[3], after[3];
  const int signals[3] = {SIGSEGV, SIGFPE, SIGTERM};
  for (int k = 0; k < 3; ++k) sigaction(signals[k], nullptr, &before[k]);
  ASSERT_EQ(newton(lattice_step(Lattice::kSquare, 3, 0.3, 0)).status, SolveStatus::kConverged);
  for (int k = 0; k < 3; ++k) {
    sigaction(signals[k], nullptr, &after[k]);
    EXPECT_EQ(before[k].sa_handler, after[k].sa_handler) << "signal " << signals[k];
  }
}

/// Names of the processes that `parent` started and that are still there.
std::vector<std::string> children_of(pid_t parent) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    std::ifstream stat(entry.path() / "stat");  // pid (name) state parent ...
    std::string line;
    if (!std::getline(stat, line)) continue;
    const std::size_t open = line.find('('), close = line.rfind(')');
    std::istringstream rest(line.substr(close + 1));
    char state = 0;
    pid_t of = 0;
    if (rest >> state >> of && of == parent) {
      names.push_back(line.substr(open + 1, close - open - 1));
    }
  }
  return names;
}

TEST(Newton, StartsMpiWithoutADaemon) {
  ASSERT_EQ(newton(lattice_step(Lattice::kTriangular, 3, 0.3, 10)).status, SolveStatus::kConverged);
  EXPECT_EQ(children_of(getpid()), std::vector<std::string>{});
}

}  // namespace
}  // namespace bipot
