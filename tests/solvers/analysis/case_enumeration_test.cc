#include "solvers/analysis/case_enumeration.h"

#include "solvers/analysis/several_answers.h"
#include "tests/support/several_problems.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// A rod of 2 m at 45 degrees slides on its end and opens. W = (5/2 3/2; 3/2 5/2), u_free = (1/10,
/// 3), mu = 2. Three answers: open, s = 0; stick, s = -W⁻¹ u = (1.0625, -1.8375), within the cone;
/// slip, u_n = 0: s_n = -0.1/(2.5 - 2 x 1.5) = 0.2, s_t = -0.4, u_t = 3 + 0.3 - 1 = 2.3 > 0.
ContactProblem rod_alone() {
  ContactProblem p{.dim = 2,
                   .W = Eigen::MatrixXd(Eigen::Matrix2d{{2.5, 1.5}, {1.5, 2.5}}).sparseView()};
  p.W.makeCompressed();
  p.u_free = Eigen::Vector2d(0.1, 3);
  p.mu = Vector::Constant(1, 2);
  return p;
}

bool never() { return false; }

TEST(CaseEnumeration, FindsTheThreeAnswersOfARodOnItsEnd) {
  const EnumeratedCases found = enumerate_cases(rod_alone(), never);
  EXPECT_EQ(found.cases, 4);
  EXPECT_EQ(found.undecided, 0);
  ASSERT_EQ(found.candidates.size(), 3u);
  EXPECT_EQ(found.candidates[0], Vector::Zero(2));
  EXPECT_NEAR((found.candidates[1] - Eigen::Vector2d(1.0625, -1.8375)).norm(), 0, 1e-12);
  EXPECT_NEAR((found.candidates[2] - Eigen::Vector2d(0.2, -0.4)).norm(), 0, 1e-12);
}

TEST(CaseEnumeration, SeveralAnswersAreThenAllOfThem) {
  const SeveralAnswers found = find_several_answers(rod_alone(), {});
  ASSERT_EQ(found.answers.size(), 3u);
  EXPECT_EQ(found.sets, 3);
  EXPECT_TRUE(says(found.message, "all 4 cases"));
  EXPECT_TRUE(says(found.message, "no others"));
  int open = 0, stick = 0, slip = 0;
  for (const Answer& answer : found.answers) {
    open += answer.take_off;
    stick += answer.stick;
    slip += answer.slip;
  }
  EXPECT_EQ(open, 1);
  EXPECT_EQ(stick, 1);
  EXPECT_EQ(slip, 1);
}

TEST(CaseEnumeration, BesideAnOrdinaryContactThereAreThreeToo) {
  const SeveralProblem several = painleve_problem();
  const SeveralAnswers found = find_several_answers(several.problem, {});
  EXPECT_EQ(found.answers.size(), several.answers.size());
  EXPECT_TRUE(says(found.message, "all 16 cases"));
}

// Only the sum of the normal impulses is determined: that is said.
TEST(CaseEnumeration, AContinuumIsSaid) {
  const EnumeratedCases found = enumerate_cases(two_frictions_problem().problem, never);
  EXPECT_EQ(found.cases, 16);
  EXPECT_GT(found.continua + found.undecided, 0);
}

TEST(CaseEnumeration, ManyContactsAreLeftToTheStarts) {
  ContactProblem p = rod_alone();
  Eigen::MatrixXd w = Eigen::MatrixXd::Identity(16, 16);
  p.W = w.sparseView();
  p.W.makeCompressed();
  p.u_free = Vector::Zero(16);
  p.mu = Vector::Constant(8, 0.5);
  EXPECT_EQ(enumerate_cases(p, never).cases, 0);
}

// A lattice at rest: most contacts stick.
TEST(SeveralAnswers, StatusesAreCounted) {
  const ContactProblem p = shipped_file("2d_triangular_lattice.hdf5");
  const SeveralAnswers found = find_several_answers(p, {.starts = 1});
  ASSERT_FALSE(found.answers.empty());
  const auto& answer = found.answers[0];
  EXPECT_EQ(std::ranges::count(answer.status, ContactStatus::kStick), answer.stick);
  EXPECT_EQ(std::ranges::count(answer.status, ContactStatus::kSlip), answer.slip);
  EXPECT_EQ(std::ranges::count(answer.status, ContactStatus::kTakeOff), answer.take_off);
  EXPECT_GT(answer.stick, 200);
}

}  // namespace
}  // namespace bipot
