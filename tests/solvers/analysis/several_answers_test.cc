#include "solvers/analysis/several_answers.h"

#include "core/problem_files/fclib_file.h"
#include "tests/support/converged.h"
#include "tests/support/several_problems.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

/// Index of the hand-made answer that s is; -1: none.
int known(const SeveralProblem& several, const Vector& s) {
  for (std::size_t k = 0; k < several.answers.size(); ++k) {
    if ((s - several.answers[k]).norm() <= 1e-8) return static_cast<int>(k);
  }
  return -1;
}

TEST(SeveralAnswers, FindsThoseOfAPainleveContact) {
  const SeveralProblem several = painleve_problem();
  const SeveralAnswers found = converged(find_several_answers(several.problem, {.starts = 16}));
  ASSERT_GE(found.answers.size(), 2u);
  for (const Answer& answer : found.answers) {
    EXPECT_GE(known(several, answer.impulse.s), 0);
    EXPECT_LE(answer.impulse.error.guarded(), 1e-11);
    EXPECT_FALSE(answer.starts.empty());
    EXPECT_NE(answer.kind, Answer::Kind::kFamily);
  }
  EXPECT_EQ(found.sets, static_cast<int>(found.answers.size()));
  // The nearest two are sqrt(3) apart, on a scale of at least 1.
  EXPECT_GT(found.spread.velocity, found.resolution);
  EXPECT_EQ(found.differing_contacts, std::vector<int>{0});
  EXPECT_TRUE(std::isnan(found.spread.kinetic));  // given by W: no bodies
  EXPECT_TRUE(std::isnan(found.spread.force));
}

TEST(SeveralAnswers, ShowsContactsAtRestAsSticking) {
  // Impulses of a packing at rest are not unique: those of `pgs` have contacts without force, and
  // some on the edge of the cone. None moves.
  const ContactProblem p = shipped_file("2d_triangular_lattice.hdf5");
  const SeveralAnswers found = find_several_answers(p, {.starts = 6});
  ASSERT_EQ(found.answers.size(), 1u);
  EXPECT_EQ(found.answers[0].stick, p.num_contacts());
  EXPECT_LE(found.answers[0].u.cwiseAbs().maxCoeff(), 1e-9 * p.u_free.cwiseAbs().maxCoeff());
}

TEST(SeveralAnswers, TellsAContinuousFamily) {
  const SeveralProblem several = two_frictions_problem();
  const SeveralAnswers found = find_several_answers(several.problem, {.starts = 12});
  ASSERT_GE(found.answers.size(), 2u);
  EXPECT_EQ(found.sets, 1);
  for (const Answer& answer : found.answers) {
    EXPECT_EQ(answer.kind, Answer::Kind::kFamily);
    EXPECT_NEAR(answer.impulse.s[0] + answer.impulse.s[2], 1, 1e-9);
  }
  // v_x differs by at most 0.4; ‖v - v_free‖ is at least |(0.2, 1)|.
  EXPECT_GT(found.spread.velocity, 1e-3);
  EXPECT_LE(found.spread.velocity, 0.4 / std::hypot(0.2, 1) + 1e-9);
  // One body: the resultant is (-(0.2 s_n1 + 0.6 s_n2), 1), the fastest body has v_x >= 4.4.
  EXPECT_LE(found.spread.body_velocity, 0.4 / 4.4 + 1e-9);
  EXPECT_GT(found.spread.force, 0);
  EXPECT_LE(found.spread.force, 0.4 / std::hypot(0.2, 1) + 1e-9);
}

TEST(SeveralAnswers, FindsOneWhereThereIsOne) {
  const ContactProblem p = lattice_step(Lattice::kTriangular, 5, 0.3, 10);
  const SeveralAnswers found = converged(find_several_answers(p, {.starts = 10}));
  ASSERT_EQ(found.answers.size(), 1u);
  EXPECT_EQ(found.answers[0].starts.size(), 10u);
  EXPECT_EQ(found.answers[0].kind, Answer::Kind::kIsolated);
  EXPECT_EQ(found.spread.velocity, 0);
  EXPECT_EQ(found.sets, 1);
  EXPECT_TRUE(found.differing_contacts.empty());
  // From zero, each solver of the list once.
  std::vector<std::string> solvers;
  for (const SeveralAnswers::Start& start : found.starts) solvers.push_back(start.solver);
  for (const char* name : {"pgs", "apgd", "ipm", "admm", "homotopy", "apgd, split", "convex"}) {
    EXPECT_TRUE(std::find(solvers.begin(), solvers.end(), name) != solvers.end()) << name;
  }
}

// Two answers. Starts that end at the same one differ by 1e-16.
TEST(SeveralAnswers, RoundingIsNoSecondAnswer) {
  Eigen::MatrixXd W(4, 4);
  W << 3, 1, 2, 0, 1, 1, 1, 0, 2, 1, 2, -1, 0, 0, -1, 2;
  const ContactProblem p =
      delassus_problem(2, W, Eigen::Vector4d(-2, -1, -1, -1), Eigen::Vector2d(0, 1));
  const SeveralAnswers found = find_several_answers(p, {.starts = 6});
  EXPECT_TRUE(found.complete);
  ASSERT_EQ(found.answers.size(), 2u);
  EXPECT_GT((found.answers[1].impulse.s - found.answers[0].impulse.s).norm(), 1e-6);
}

// The first answer is s = 0: nothing to measure the other's velocities by.
TEST(SeveralAnswers, ADistanceFromRestIsUndefined) {
  Eigen::Matrix2d W;
  W << 1, -1, -1, 1;
  const ContactProblem p = delassus_problem(2, W, Eigen::Vector2d(1, -1), Vector::Constant(1, 5));
  const SeveralAnswers found = find_several_answers(p, {.starts = 4});
  ASSERT_GE(found.answers.size(), 2u);
  EXPECT_EQ(found.answers[0].impulse.s.norm(), 0);
  EXPECT_TRUE(std::isnan(found.spread.velocity));
}

TEST(SeveralAnswers, ThreeIsolatedOnesOfATiltedPacking) {
  const ContactProblem p = shipped_file("2d_tilt1000hi_182.hdf5");
  const SeveralAnswers found = converged(find_several_answers(p, {.starts = 8}));
  EXPECT_GE(found.answers.size(), 3u);
  EXPECT_GE(found.sets, 3);
  EXPECT_GT(found.spread.velocity, 5e-2);
  EXPECT_GT(found.spread.body_velocity, 5e-2);
  EXPECT_GT(found.spread.force, 0.1);
  EXPECT_LT(found.spread.kinetic, 0.1 * found.spread.velocity);
  // What walls give in all differs as well, but by less than the force on one body.
  EXPECT_GT(found.spread.total, 0);
  EXPECT_LT(found.spread.total, found.spread.force);
  EXPECT_LT(found.resolution, 1e-3);
  EXPECT_GE(found.differing_contacts.size(), 2u);
}

TEST(SeveralAnswers, TheSameSeedGivesTheSameBits) {
  const SeveralProblem several = two_frictions_problem();
  SeveralAnswers::Options options{.starts = 14};
  const SeveralAnswers once = find_several_answers(several.problem, options);
  const SeveralAnswers again = find_several_answers(several.problem, options);
  options.seed = 2;
  const SeveralAnswers other = find_several_answers(several.problem, options);
  ASSERT_EQ(once.answers.size(), again.answers.size());
  bool differs = once.answers.size() != other.answers.size();
  for (std::size_t k = 0; k < once.answers.size(); ++k) {
    EXPECT_EQ(once.answers[k].impulse.s, again.answers[k].impulse.s);
    differs = differs || once.answers[k].impulse.s != other.answers[k].impulse.s;
  }
  EXPECT_TRUE(differs);
}

TEST(SeveralAnswers, BeginsAtTheGuessToo) {
  const SeveralProblem several = painleve_problem();
  SeveralAnswers::Options options{.starts = static_cast<int>(solver_names().size()),
                                  .guess = several.answers[1] * (1 + 1e-3)};
  const SeveralAnswers found = find_several_answers(several.problem, options);
  const auto from_guess =
      std::count_if(found.starts.begin(), found.starts.end(),
                    [](const SeveralAnswers::Start& s) { return s.from == "guess"; });
  EXPECT_EQ(from_guess, 2);
  // However few starts: they were asked to begin there.
  options.starts = 1;
  for (const char* solver : {"", "pgs"}) {
    options.solver = solver;
    const SeveralAnswers one = find_several_answers(several.problem, options);
    ASSERT_FALSE(one.starts.empty());
    EXPECT_EQ(one.starts[0].from, "guess");
  }
  options.guess = Vector::Zero(3);
  EXPECT_EQ(find_several_answers(several.problem, options).status, SolveStatus::kInvalidInput);
}

TEST(SeveralAnswers, StartsByOneSolverAlone) {
  const SeveralProblem several = two_frictions_problem();
  SeveralAnswers::Options options{.starts = 3, .solver = "apgd"};
  for (const SeveralAnswers::Start& start : find_several_answers(several.problem, options).starts) {
    EXPECT_EQ(start.solver, "apgd");
  }
  options.solver = "apgdd";
  EXPECT_EQ(find_several_answers(several.problem, options).status, SolveStatus::kInvalidInput);
  options.solver = "apgd";
  options.parameters = {{"no_such", "1"}};
  EXPECT_EQ(find_several_answers(several.problem, options).status, SolveStatus::kInvalidInput);
}

TEST(SeveralAnswers, StopsWhenAsked) {
  const ContactProblem p = lattice_step(Lattice::kTriangular, 12, 0.3, 10);
  SeveralAnswers::Options options{.starts = 1000, .time_limit = 0.05};
  const SeveralAnswers late = ended(SolveStatus::kTimeLimit, find_several_answers(p, options));
  EXPECT_LT(late.starts.size(), 1000u);
  EXPECT_LT(late.seconds, 5 * BIPOT_TEST_SLOWNESS);
  options.time_limit = kInfinity;
  int polls = 0;
  options.cancelled = [&] { return ++polls > 50; };
  const SeveralAnswers cut = ended(SolveStatus::kInterrupted, find_several_answers(p, options));
  EXPECT_LT(cut.starts.size(), 1000u);
  EXPECT_EQ(find_several_answers(p, {.starts = 0}).status, SolveStatus::kInvalidInput);
  EXPECT_EQ(find_several_answers(p, {.tol = 1e-6}).status, SolveStatus::kInvalidInput);
}

TEST(SeveralAnswers, WithoutContactsThereIsNothingToDo) {
  for (const int dim : {1, 2, 3}) {
    ended(SolveStatus::kNothingToDo, find_several_answers({.dim = dim}, {.starts = 3}));
  }
}

TEST(SeveralAnswers, NothingToDoIsOneAnswer) {
  ContactProblem p = one_contact_problem(2, 1, 1, 0.5, 1, Vector::Constant(1, 0.3));
  const SeveralAnswers found = converged(find_several_answers(p, {.starts = 3}));
  ASSERT_EQ(found.answers.size(), 1u);
  EXPECT_EQ(found.answers[0].impulse.s, Vector::Zero(2));
}

}  // namespace
}  // namespace bipot
