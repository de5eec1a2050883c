#include "solvers/methods/homotopy.h"

#include "solvers/homotopy/path_follower.h"
#include "solvers/solve_run.h"
#include "tests/support/converged.h"
#include "tests/support/manufactured.h"
#include "tests/support/naive_error.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

SolveResult homotopy(const ContactProblem& p, double tol = 1e-11,
                     std::map<std::string, std::string> parameters = {}) {
  return solve("homotopy", p, {.tol = tol, .parameters = std::move(parameters)});
}

/// Paths from s = 0 as it is: no help by apgd.
const std::map<std::string, std::string> kFromZero = {{"start_tol", "1"}};

/// A number of the message, "12 pivots on 3 paths": the one before `word`.
int counted(const SolveResult& r, const std::string& word) {
  const std::size_t at = r.message.find(" " + word);
  if (at == std::string::npos) return -1;
  return std::stoi(r.message.substr(r.message.rfind(' ', at - 1) == std::string::npos
                                        ? 0
                                        : r.message.find_last_of(" (", at - 1) + 1));
}

TEST(Homotopy, SolvesRandomNetworksFromZeroAndAgreesWithLemke) {
  int compared = 0;
  for (int dim = 1; dim <= 2; ++dim) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
      const Manufactured m = manufactured_problem(dim, 20, 24, seed);
      const SolveResult path = homotopy(m.problem, 1e-12, kFromZero);
      ASSERT_EQ(path.status, SolveStatus::kConverged) << dim << " " << seed << path.message;
      EXPECT_LE(naive_error(m.problem, path.s).guarded(), 1.01e-12);
      const SolveResult exact = solve("lemke", m.problem, {.tol = 1e-11});
      if (!is_success(exact.status)) continue;
      ++compared;
      EXPECT_LT((exact.u - path.u).norm(), 1e-8 * m.problem.u_free.norm())
          << "d = " << dim << ", seed " << seed;
    }
  }
  EXPECT_GE(compared, 36);
}

TEST(Homotopy, SolvesManufacturedProblemsBeyondTheReachOfLemke) {
  for (int dim = 1; dim <= 2; ++dim) {
    const Manufactured m = manufactured_problem(dim, 600, 900, 3);
    EXPECT_LE(contact_error(m.problem, converged(homotopy(m.problem, 1e-12)).s).guarded(), 1e-12);
  }
}

TEST(Homotopy, SolvesSquareLatticesWhoseSideContactsNeitherPushNorMove) {
  // Every cell of a side contact touches its state: ties everywhere.
  for (const double mu : {0.0, 0.3}) {
    const ContactProblem p = lattice_step(Lattice::kSquare, 30, mu, 0);
    const SolveResult r = converged(homotopy(p, 1e-8));
    EXPECT_LE(counted(r, "pivots"), p.num_contacts()) << r.message;
  }
}

TEST(Homotopy, SolvesMovingStepsToTwelveDigits) {
  for (const char* name : {"2d_pour300_273", "2d_pour300_392", "2d_tilt1000hi_182"}) {
    const ContactProblem p = shipped_file(std::string(name) + ".hdf5");
    EXPECT_LE(naive_error(p, converged(homotopy(p, 1e-12), name).s).guarded(), 1.01e-12) << name;
  }
}

TEST(Homotopy, AWarmStartNeedsFewerPivots) {
  const ContactProblem p = shipped_file("2d_pour300_392.hdf5");
  const SolveResult cold = converged(homotopy(p, 1e-10, kFromZero));
  SolverOptions options{.tol = 1e-10, .s0 = cold.s, .parameters = kFromZero};
  for (Eigen::Index i = 0; i < options.s0.size(); ++i) options.s0[i] *= i % 4 < 2 ? 0.99 : 1.01;
  const SolveResult warm = converged(solve("homotopy", p, options));
  EXPECT_LT(2 * counted(warm, "pivots"), counted(cold, "pivots"))
      << warm.message << "; cold: " << cold.message;
}

TEST(Homotopy, AnotherChainOfStartsArrivesWhereTheFirstStops) {
  // From a small delta all paths of the first chain fail, here after 42 of them.
  const ContactProblem p = shipped_file("2d_pyramid_10.hdf5");
  converged(homotopy(p, 1e-9, {{"start_tol", "1e-2"}, {"delta", "1e-6"}}));
}

/// Impulses are judged where a path arrived, and at the turning points of others: so many
/// iterations are neither pivots nor steps of apgd.
TEST(Homotopy, TurningPointsThatItGoesOnFromAreJudged) {
  const SolveResult r =
      converged(homotopy(shipped_file("2d_pyramid_20_mu05.hdf5"), 1e-8, kFromZero));
  const int judged = r.iterations - counted(r, "pivots") - counted(r, "of apgd");
  const int arrived = counted(r, "paths (") - counted(r, "paths failed");
  ASSERT_GT(arrived, 0);
  EXPECT_GT(judged, arrived) << r.message;
}

/// From a start that is no good: without its own chain, each seed's changes of it lead another way.
TEST(Homotopy, ShakenStartsArriveEachInItsOwnWay) {
  const ContactProblem p = shipped_file("2d_pour300_273.hdf5");
  std::set<int> pivots;
  std::set<std::string> said;
  for (const char* seed : {"1", "2", "3", "1"}) {
    auto parameters = kFromZero;
    parameters["shake"] = "first";
    parameters["seed"] = seed;
    SolverOptions options;
    options.tol = 1e-2;
    options.max_iterations = 300;
    options.s0 = solve("apgd", p, options).s;
    options.tol = 1e-10;
    options.max_iterations = 100000;
    options.parameters = parameters;
    const SolveResult r = converged(solve("homotopy", p, options));
    EXPECT_LE(naive_error(p, r.s).guarded(), 1e-10);
    pivots.insert(counted(r, "pivots"));
    said.insert(r.message);
  }
  EXPECT_EQ(said.size(), 3U);  // seed 1 twice the same
  EXPECT_EQ(pivots.size(), 3U);
}

TEST(Homotopy, EveryScheduleArrivesInItsOwnWay) {
  // From zero at a small delta paths fail: what follows is the schedule's.
  const ContactProblem p = shipped_file("2d_pour300_392.hdf5");
  std::set<int> iterations;
  for (const char* schedule : {"bold", "cautious", "steady"}) {
    const SolveResult r = converged(
        homotopy(p, 1e-9, {{"schedule", schedule}, {"start_tol", "1"}, {"delta", "1e-5"}}),
        schedule);
    iterations.insert(r.iterations);
  }
  EXPECT_EQ(iterations.size(), 3U);
}

TEST(Homotopy, StopsInsideAPath) {
  // From zero the path of this step has hundreds of pivots; the caller says stop after a few polls.
  const ContactProblem p = shipped_file("2d_tilt1000hi_182.hdf5");
  SolverOptions options{.parameters = kFromZero};
  int polls = 0;
  options.cancelled = [&] { return ++polls > 12; };
  const SolveResult r = ended(SolveStatus::kInterrupted, solve("homotopy", p, options));
  EXPECT_TRUE(says(r.message, "1 paths"));
  EXPECT_GE(counted(r, "pivots"), 16) << r.message;
  EXPECT_LE(polls, 20);
}

TEST(Homotopy, TakesTheSamePathInAnyUnitsAndTwice) {
  const ContactProblem p = lattice_step(Lattice::kTriangular, 5, 0.3, 10);
  const SolveResult si = homotopy(in_units(p, 1, 1, 1), 1e-9, kFromZero);
  const SolveResult small = homotopy(in_units(p, 1e3, 1e3, 1e3), 1e-9, kFromZero);
  ASSERT_EQ(si.status, SolveStatus::kConverged) << si.message;
  EXPECT_EQ(si.message, small.message);
  EXPECT_EQ(homotopy(p, 1e-9).s, homotopy(p, 1e-9).s);
}

/// One contact between cells: W = (2, 0; 0, 3) equilibrated to the identity, b = (-1, b_t).
class PathOfOneContact : public testing::Test {
 protected:
  LawProblem law(double slip) const {
    const ContactProblem p = one_contact_problem(2, 1, 1, 0.5, -1, Vector::Constant(1, slip));
    ContactProblem local = local_form(p);
    return {local, Vector(Vector::Ones(2))};
  }
};

TEST_F(PathOfOneContact, CrossesFromTakeOffThroughSlipToStick) {
  const LawProblem problem = law(0.2);
  PathFollower follower(problem, [] { return false; });
  // Open with u_n = 1, u_t = 1; the solution sticks: with u = 0, row by row (1 + D_i) s_i = -b_i.
  LawPoint point = nearest_point(problem, Vector::Zero(2), Vector::Ones(2));
  ASSERT_EQ(point.cell[0], Cell::kTakeOff);
  const Eigen::Vector2d proximal(1e-3, 3e-2);
  ASSERT_EQ(follower.follow(point, Vector::Zero(2), proximal, 10), PathFollower::kSolved);
  EXPECT_EQ(point.cell[0], Cell::kStick);
  EXPECT_EQ(follower.counts().pivots, 2);
  Vector s;
  point.impulse(problem, s);
  EXPECT_NEAR(s[0], 1 / (1 + proximal[0]), 1e-15);
  EXPECT_NEAR(s[1], -0.2 / (1 + proximal[1]), 1e-15);
}

TEST_F(PathOfOneContact, EndsWhereTheCallerStopsOrTheCountIsUsed) {
  const LawProblem problem = law(0.2);
  LawPoint point = nearest_point(problem, Vector::Zero(2), Vector::Ones(2));
  PathFollower counting(problem, [] { return false; });
  EXPECT_EQ(counting.follow(point, Vector::Zero(2), Vector::Constant(2, 1e-3), 1),
            PathFollower::kLong);
  EXPECT_EQ(counting.counts().failed, 1);
  PathFollower stopping(problem, [] { return true; });
  EXPECT_EQ(stopping.follow(point, Vector::Zero(2), Vector::Constant(2, 1e-3), 10),
            PathFollower::kStopped);
}

}  // namespace
}  // namespace bipot
