#include "solvers/analysis/case_exclusion.h"

#include "solvers/solve.h"
#include "tests/support/manufactured.h"
#include "tests/support/random_vector.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// One mass of 1 kg between two walls, W alone: u_1 + u_2 = w_1 + w_2 whatever the impulses.
ContactProblem between_walls(double w_1, double w_2) {
  return delassus_problem(1, Eigen::Matrix2d{{1, -1}, {-1, 1}}, Eigen::Vector2d(w_1, w_2),
                          Vector::Zero(2));
}

bool not_stopped() { return false; }

// y = (1, 1): y·W = 0, y·w = -3. No case has to be told from another; what reaches is beyond the
// rounding of y·W.
TEST(CaseExclusion, WallsDrivenTogetherAreOneCase) {
  const CaseExclusion none = exclude_cases(between_walls(-1, -2), &not_stopped);
  ASSERT_TRUE(none.complete) << none.message;
  EXPECT_EQ(none.cases.size(), 1u);
  EXPECT_GT(none.reach, 1e16);
  EXPECT_FALSE(exclude_cases(between_walls(-1, 2), &not_stopped).complete);
}

// W = [[1, -2], [-1, 1]] is the W of no body. Both closed: s = -W⁻¹ w with W⁻¹ = [[-1, -2], [-1,
// -1]], w = (-1, -1): s = (-3, -2). The first closed alone: s_1 = 1, u_2 = -2; the second alone:
// s_2 = 1, u_1 = -3; none: u = w. So none of the four.
TEST(CaseExclusion, DecidesDataThatNoTheoryCovers) {
  ContactProblem p = between_walls(-1, -1);
  p.W.coeffRef(0, 1) = -2;
  const CaseExclusion none = exclude_cases(p, &not_stopped);
  EXPECT_TRUE(none.complete) << none.message;
  // u = W s + (-1, 3): the first closed alone, s_1 = 1, u_2 = 2.
  p.u_free[1] = 3;
  EXPECT_FALSE(exclude_cases(p, &not_stopped).complete);
}

TEST(CaseExclusion, NeverExcludesAPlantedSolution) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    for (const int dim : {1, 2}) {
      for (const double mu : {0.0, 0.5, 20.0}) {
        const int bodies = 1 + static_cast<int>(seed % 3),
                  contacts = 1 + static_cast<int>(seed % 6);
        ContactProblem p = manufactured_problem(dim, bodies, contacts, seed, mu).problem;
        if (seed % 2 == 0) p = local_form(p);
        EXPECT_FALSE(exclude_cases(p, &not_stopped).complete)
            << "d = " << dim << ", mu = " << mu << ", seed " << seed;
      }
    }
  }
}

TEST(CaseExclusion, NoSolverFindsWhatIsExcluded) {
  int none = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    ContactProblem p = manufactured_problem(2, 1, 3, seed, 0.8).problem;
    p.u_free = random_vector(p.u_free.size(), seed);
    if (!exclude_cases(p, &not_stopped).complete) continue;
    ++none;
    for (const char* solver : {"lemke", "multistart", "homotopy"}) {
      EXPECT_FALSE(is_success(solve(solver, p, {.tol = 1e-9}).status)) << solver << ", " << seed;
    }
  }
  EXPECT_GT(none, 3);
}

TEST(CaseExclusion, TheCheckRefusesWhatDoesNotHold) {
  const ContactProblem p = between_walls(-1, -2);
  const std::vector<CaseExclusion::Status> any(2, CaseExclusion::kAny);
  EXPECT_GT(reach_of_exclusion(p, {any, Eigen::Vector2d(1, 1)}), 1e16);
  // u_n >= 0 says nothing of -u_n; where u_n = 0 it does, but y·W e = -2 leaves y·w = 1 > 0.
  EXPECT_EQ(reach_of_exclusion(p, {any, Eigen::Vector2d(-1, 1)}), 0);
  EXPECT_EQ(
      reach_of_exclusion(p, {{CaseExclusion::kRight, CaseExclusion::kAny}, Eigen::Vector2d(1, -1)}),
      0);
  // y = (1, 0): the rates are 1 and -1, y·w = -1, |w| = sqrt(5): s_1 >= 1 solves what y sees.
  EXPECT_NEAR(reach_of_exclusion(p, {any, Eigen::Vector2d(1, 0)}), 1 / std::sqrt(5.0), 1e-12);
  EXPECT_EQ(reach_of_exclusion(p, {any, Eigen::Vector2d(kNaN, 0)}), 0);
  EXPECT_EQ(reach_of_exclusion(p, {any, Vector::Ones(3)}), 0);
  // The tangent of an open contact is free: no multiplier may stand there; of one that slips to the
  // right u_t >= 0.
  const ContactProblem q = manufactured_problem(2, 1, 1, 1, 0.5).problem;
  const double sign = q.u_free[1] < 0 ? 1 : -1;
  const Vector y = Eigen::Vector2d(0, sign);
  EXPECT_EQ(reach_of_exclusion(q, {{CaseExclusion::kOpen}, y}), 0);
  EXPECT_EQ(reach_of_exclusion(q, {{sign > 0 ? CaseExclusion::kLeft : CaseExclusion::kRight}, y}),
            0);
}

}  // namespace
}  // namespace bipot
