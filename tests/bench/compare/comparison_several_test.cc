#include "bench/compare/comparison_several.h"

#include <nlohmann/json.hpp>

#include "bench/compare/comparison_measures.h"
#include "bench/compare/comparison_report.h"
#include "bench/measure/true_error.h"
#include "solvers/registry.h"
#include "tests/bench/compare/quick_comparison.h"
#include "tests/support/several_problems.h"
#include "tests/support/source_folder.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

ProblemSource source_without_scales(const std::string& name, const ContactProblem& problem) {
  return {name, name, [problem] { return TestProblem{.origin = "test", .problem = problem}; }};
}

TEST(SeveralAnswersInACompare, AreProvedByTwoVerifiedRows) {
  // Sweeps give the first contact all of the load, gradients divide it: v_x differs by 0.2.
  const SeveralProblem several = two_frictions_problem();
  const Comparison c = compare({source_without_scales("two", several.problem)},
                               quick({"pgs", "apgd", "uzawa"}, {1e-2, 1e-11}));
  ASSERT_EQ(c.problems.size(), 1u);
  const Comparison::Problem& p = c.problems[0];
  EXPECT_TRUE(p.several_velocities());
  EXPECT_GE(p.answers, 2);
  // At most the whole family, v_x from 4.4 to 4.8 and |(0.2, 1)| <= ‖v - v_free‖.
  EXPECT_GT(p.reference.spread.velocity, 1e-2);
  EXPECT_LE(p.reference.spread.velocity, 0.4 / std::hypot(0.2, 1) + 1e-9);
  EXPECT_GT(p.reference.spread.force, 1e-2);
  for (const Comparison::Row& row : c.rows) {
    if (row.tol != 1e-11) continue;
    EXPECT_LE(row.guarded, 1e-11) << row.solver;
    // Whatever a solver chose, its answer is one that is known, also when it was found later.
    EXPECT_LE(row.velocity_error, 1e-6) << row.solver;
    EXPECT_LE(row.force_error, 1e-6) << row.solver;
    EXPECT_GE(row.answer, 1);
    EXPECT_LE(row.answer, p.answers);
  }
  const auto shares = several_shares(c);
  ASSERT_EQ(shares.size(), 2u);  // its size, and all
  EXPECT_EQ(shares.back().problems, 1);
  EXPECT_EQ(shares.back().several, 1);
  EXPECT_EQ(shares.back().largest_velocity, p.reference.spread.velocity);
  EXPECT_TRUE(says(to_csv(several_problems_table(c)), "two,2,"));
  EXPECT_TRUE(says(to_text(c), "1 of 1 problems with a reference have several"));
  const Json json = to_json(c, {});
  const Json& table = json["several"];
  EXPECT_EQ(table[table.size() - 1]["share"], 1.0);
  EXPECT_EQ(json["problems"][0]["reference"]["answers"], p.answers);
}

TEST(SeveralAnswersInACompare, AUniqueAnswerIsNotMarked) {
  // Loose rows are inaccurate, not different; the masses make the problem badly conditioned.
  std::vector<std::string> solvers = {"pgs", "apgd", "admm"};
  if (find_solver("newton") != nullptr) solvers.push_back("newton");  // needs PETSc
  const Comparison c = compare(expand_targets({"triangular:6:tilt=10:ratio=1e4"}),
                               quick(solvers, {1e-2, 1e-6, 9e-10, 1e-12}));
  ASSERT_EQ(c.problems.size(), 1u);
  EXPECT_FALSE(c.problems[0].several_velocities());
  EXPECT_EQ(c.problems[0].answers, 1);
  EXPECT_TRUE(std::isnan(c.problems[0].reference.spread.velocity));
  EXPECT_EQ(several_shares(c).back().several, 0);
  EXPECT_EQ(several_text(c), "");
}

TEST(SeveralAnswersInACompare, AreKeptWithTheReference) {
  const TemporaryFolder folder;
  const SeveralProblem several = two_frictions_problem();
  Comparison::Options options = quick({"pgs", "apgd"}, {1e-11}, folder / "table");
  const auto source = source_without_scales("two", several.problem);
  const Comparison first = compare({source}, options);
  const Comparison again = compare({source}, options);
  EXPECT_EQ(again.rows_kept, 2);
  EXPECT_EQ(again.problems[0].answers, first.problems[0].answers);
  EXPECT_EQ(again.problems[0].reference.spread.velocity,
            first.problems[0].reference.spread.velocity);
  for (std::size_t k = 0; k < first.rows.size(); ++k) {
    EXPECT_EQ(again.rows[k].velocity_error, first.rows[k].velocity_error);
    EXPECT_EQ(again.rows[k].answer, first.rows[k].answer);
  }
}

TEST(SeveralAnswersInACompare, OfATiltedPackingAreTwo) {
  // pgs ends 0.1 and more from where apgd and ipm end.
  const Comparison c =
      compare(expand_targets({source_folder().string() + "/data/problems/2d_tilt1000hi_182.hdf5"}),
              quick({"pgs", "apgd", "ipm"}, {1e-10}));
  ASSERT_EQ(c.problems.size(), 1u);
  EXPECT_GE(c.problems[0].answers, 2);
  EXPECT_GT(c.problems[0].reference.spread.velocity, 5e-2);
  EXPECT_LT(c.problems[0].reference.spread.energy, c.problems[0].reference.spread.velocity);
  for (const Comparison::Row& row : c.rows) EXPECT_LT(row.velocity_error, 1e-4) << row.solver;
}

TEST(ReferenceSolution, LearnsOnlyWhatIsExactAndElsewhere) {
  const SeveralProblem several = painleve_problem();
  TestProblem given{.problem = several.problem};
  ReferenceSolution reference;
  reference.s = several.answers[0];
  reference.error = contact_error(given.problem, reference.s);
  const auto learn = [&](const Vector& s) {
    return learn_answer(given.problem, s, 5, {}, reference);
  };
  EXPECT_FALSE(learn(several.answers[0]));
  EXPECT_FALSE(learn(several.answers[1] * 1.01));  // too far off to be taken for an answer
  EXPECT_TRUE(learn(several.answers[1]));
  EXPECT_FALSE(learn(several.answers[1]));
  // Nearly exact and far from the others: solved on from there.
  EXPECT_TRUE(learn(several.answers[2] * (1 + 1e-8)));
  ASSERT_EQ(reference.others.size(), 2u);
  EXPECT_LE((reference.others[1] - several.answers[2]).norm(), 1e-9);
  const TrueErrorEvaluator errors(given, reference);
  EXPECT_EQ(errors(several.answers[2]).nearest, 2);
  EXPECT_LE(errors(several.answers[2]).velocity, 1e-8);
  // sqrt(19): tests/solvers/analysis/distinct_answers_test.cc
  EXPECT_NEAR(errors.spread().velocity, std::sqrt(19.0), 1e-7);
}

}  // namespace
}  // namespace bipot
