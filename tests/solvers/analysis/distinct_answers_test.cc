#include "solvers/analysis/distinct_answers.h"

#include "core/base/portable_random.h"
#include "core/motion/time_stepping.h"
#include "core/scene/scene_family.h"
#include "solvers/solve.h"
#include "tests/support/several_problems.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

Vector solved(std::string_view solver, const ContactProblem& p, double tol, double limit = 20) {
  return solve(solver, p, {.tol = tol, .time_limit = limit * BIPOT_TEST_SLOWNESS}).s;
}

TEST(DistinctAnswers, TellsThreeAnswersKnownByHand) {
  const SeveralProblem several = painleve_problem();
  DistinctAnswers distinct(several.problem);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(distinct.add(several.answers[to_size(k)], "hand"), k);
  // Found again, with rounding.
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(distinct.add(several.answers[to_size(k)] * (1 + 1e-13), "again"), k);
  }
  ASSERT_EQ(distinct.answers().size(), 3u);
  EXPECT_EQ(distinct.answers()[1].found_by, "hand");
  // Farthest apart: slip and stick, d = (4, -4), dᵀ W d = 16 (1 - 2 + 3/2) = 8; take-off and stick,
  // d = (5, -6), 25 - 60 + 54 = 19; take-off and slip, d = (1, -2), 1 - 4 + 6 = 3. Scale: take-off,
  // where the second contact alone acts, sᵀ W s = 1.
  EXPECT_NEAR(distinct.spread(), std::sqrt(19.0), 1e-12);
  EXPECT_EQ(distinct.nearest(several.answers[2] * 0.99, [](const auto&) { return true; }), 2);
}

TEST(DistinctAnswers, BelievesNothingAboveItsTrust) {
  const SeveralProblem several = painleve_problem();
  DistinctAnswers distinct(several.problem);
  EXPECT_EQ(distinct.add(several.answers[1] * (1 + 1e-6), "loose"), -1);
  EXPECT_EQ(distinct.add(Vector::Constant(4, kNaN), "broken"), -1);
  EXPECT_EQ(distinct.add(Vector::Zero(2), "of another problem"), -1);
  EXPECT_TRUE(distinct.answers().empty());
  EXPECT_TRUE(std::isnan(distinct.spread()));
}

// Without friction the answer is unique in velocity, and the distance of any impulse near it is
// bounded by what its error explains: the derivation in the header.
TEST(DistinctAnswers, AnErrorExplainsItsDistanceWithoutFriction) {
  const ContactProblem p = lattice_step(Lattice::kTriangular, 6, 0, 20);
  ASSERT_EQ(p.dim, 1);
  const Vector exact = solved("homotopy", p, 1e-14);
  DistinctAnswers distinct(p);
  ASSERT_EQ(distinct.add(exact, "exact"), 0);
  PortableRandom draw(7);
  double closest = kInfinity;
  for (const double size : {0.5, 1e-2, 1e-4, 1e-6, 1e-8}) {
    for (int k = 0; k < 20; ++k) {
      Vector s = exact;
      for (double& x : s) x *= 1 + size * draw.symmetric();
      const VerifiedAnswer wrong = distinct.judge(s, "");
      const double apart = distinct.distance(wrong.s, exact);
      EXPECT_LE(apart, wrong.explained) << size;
      closest = std::min(closest, wrong.explained / apart);
    }
  }
  EXPECT_LT(closest, 1e4);  // and it is no empty bound
}

// The saboteur: answers that are merely inaccurate, on problems with one answer and bad
// conditioning.
TEST(DistinctAnswers, InaccurateAnswersAreNotSeveral) {
  int believed = 0;
  for (const double ratio : {1.0, 1e4}) {
    const Scene<2> scene =
        make_family_scene("triangular", 8, {.mu = 0.3, .tilt_degrees = 5, .mass_ratio = ratio});
    const ContactProblem p = step_problem(scene, initial_state(scene));
    DistinctAnswers distinct(p);
    ASSERT_EQ(distinct.add(solved("ipm", p, 1e-12), "ipm"), 0) << ratio;
    const Vector exact = distinct.answers()[0].s;
    for (const char* solver : {"pgs", "apgd", "admm", "newton", "homotopy"}) {
      for (const double tol : {9e-10, 1e-12}) {
        EXPECT_LE(distinct.add(solved(solver, p, tol, 0.3), solver), 0) << solver << tol << ratio;
      }
    }
    // Off by just as much as the trust allows, in random directions.
    PortableRandom draw(3);
    for (int k = 0; k < 200; ++k) {
      Vector s = exact;
      const double size = std::pow(10.0, -8 - 7 * draw.uniform());
      for (int c = 0; c < p.num_contacts(); ++c) s.segment(2 * c, 2) *= 1 + size * draw.symmetric();
      const int answer = distinct.add(s, "saboteur");
      EXPECT_LE(answer, 0);
      believed += answer == 0 ? 1 : 0;
    }
    EXPECT_EQ(distinct.answers().size(), 1u);
  }
  EXPECT_GT(believed, 50);  // the test had something to tell apart
}

}  // namespace
}  // namespace bipot
