#include "bench/compare/comparison_measures.h"

#include "bench/compare/comparison_charts.h"
#include "core/base/types.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// A table by hand: times in seconds, velocity errors; `guarded` decides what is solved.
class RunTable {
 public:
  RunTable& problem(const std::string& name, int dofs = 30, const std::string& series = "") {
    made.problems.push_back(
        {.name = name, .series = series, .contacts = 10, .dim = 2, .dofs = dofs});
    return *this;
  }
  RunTable& row(const std::string& solver, double tol, double time, int iterations, double guarded,
                double error) {
    Comparison::Row r{
        .problem = made.problems.back().name, .solver = solver, .tol = tol, .cpu_min = time};
    r.total_min = kNaN;  // must not matter
    r.iterations = iterations;
    r.guarded = guarded;
    r.velocity_error = error;
    made.rows.push_back(r);
    return *this;
  }
  Comparison made;
};

/// Two problems, three solvers, two tolerances.
Comparison small_table() {
  RunTable t;
  t.problem("p")
      .row("a", 1e-2, 1, 10, 1e-3, 1e-1)
      .row("a", 1e-4, 4, 40, 1e-5, 1e-3)
      .row("b", 1e-2, 2, 5, 1e-3, 1e-3)
      .row("b", 1e-4, 3, 0, 1e-5, 1e-6)
      .row("auto", 1e-2, 1.5, 10, 1e-3, 1e-1)
      .row("auto", 1e-4, 6, 40, 1e-5, 1e-3);
  t.problem("q")
      .row("a", 1e-2, 8, 80, 1e-3, 1e-2)
      .row("a", 1e-4, 9, 90, 1e-3, 1e-2)  // out of time
      .row("b", 1e-2, 2, 20, 1e-3, 5e-2)
      .row("b", 1e-4, 10, 100, kNaN, kNaN)  // refused
      .row("auto", 1e-2, 3, 30, 1, 2)       // did not get there
      .row("auto", 1e-4, 5, 50, 1e-5, 1e-5);
  return t.made;
}

/// Of a, b and auto.
using Lists = std::vector<std::vector<double>>;
Lists ratios(const Comparison& c, const CostOf& cost) {
  Lists all;
  for (const PerformanceProfile& p : performance_profiles(c, cost)) all.push_back(p.ratios);
  return all;
}

TEST(ComparisonMeasures, ProfilesAreThoseOfTheTable) {
  const Comparison c = small_table();
  EXPECT_EQ(performance_profiles(c, time_at(c, 1e-2))[0].solver, "a");
  EXPECT_EQ(performance_profiles(c, time_at(c, 1e-2))[2].problems, 2);
  // At 1e-2: p is solved in 1, 2, 1.5 s, q in 8 and 2 s and not by auto.
  EXPECT_EQ(ratios(c, time_at(c, 1e-2)), (Lists{{1, 4}, {1, 2}, {1.5}}));
  // At 1e-4: p takes 40, none, 40 iterations; q only auto's 50. None count as one.
  EXPECT_EQ(ratios(c, iterations_at(c, 1e-4)), (Lists{{40}, {1}, {1, 40}}));
  // To 1e-2, the cheapest rows: p by a at 1e-4 (4 s), by b at 1e-2 already (2 s), by auto at 1e-4
  // (6 s); q by a (8 s), not by b, by auto (5 s).
  EXPECT_EQ(ratios(c, time_to(c, 1e-2)), (Lists{{1.6, 2}, {1}, {1, 3}}));
  EXPECT_EQ(fastest_to(c.problems[0], c.rows, 1e-2, "a")->tol, 1e-4);
  EXPECT_EQ(fastest_to(c.problems[0], c.rows, 1e-9), nullptr);
}

TEST(ComparisonMeasures, AProblemWithoutContactsIsNoRace) {
  RunTable t;
  t.problem("p").row("a", 1e-2, 1, 10, 1e-3, 1e-3);
  t.problem("free").row("a", 1e-2, 1e-6, 0, 0, 0);
  t.made.problems.back().contacts = 0;
  const auto profiles = performance_profiles(t.made, time_at(t.made, 1e-2));
  EXPECT_EQ(profiles[0].problems, 1);
  EXPECT_EQ(profiles[0].ratios, std::vector<double>{1});
  EXPECT_EQ(fastest_to(t.made.problems[1], t.made.rows, 1e-2), nullptr);
}

TEST(ComparisonMeasures, ErrorsWithinATimeAreTheLeastOfTheRowsThatFit) {
  // Within 3 s: a has 1e-1 on p and nothing on q; b 1e-6 and 5e-2; auto 1e-1, and on q an error
  // worse than none at all.
  const Comparison c = small_table();
  Lists errors;
  for (const BudgetErrors& e : errors_within(c, 3)) errors.push_back(e.errors);
  EXPECT_EQ(errors, (Lists{{1e-1, 1}, {1e-6, 5e-2}, {1e-1, 1}}));
  EXPECT_EQ(errors_within(c, 0.5)[1].errors, (std::vector<double>{1, 1}));
}

TEST(ComparisonMeasures, ProblemsWithoutATrustedReferenceAreRankedByTheGuardedError) {
  Comparison c = small_table();
  EXPECT_EQ(ranking(c.problems[0], c.rows).measure, Ranking::Measure::kVelocity);
  c.problems[0].reference.error = {.epsilon = 1e-8, .eta = 1e-8};
  EXPECT_EQ(ranking(c.problems[0], c.rows).measure, Ranking::Measure::kGuarded);
  c.problems[0].reference.error = {.epsilon = 1e-10, .eta = 1e-10};
  EXPECT_EQ(ranking(c.problems[0], c.rows).measure, Ranking::Measure::kVelocity);
}

TEST(ComparisonMeasures, FastestRowIsTheLoosestOfThoseThatTakeTheSameTime) {
  // The same work at three tolerances; the clock says 1, 0.97 and 0.96 s. A fourth is slower.
  RunTable t;
  t.problem("p")
      .row("a", 1e-1, 1.2, 1, 1e-9, 1e-9)
      .row("a", 1e-2, 1, 1, 1e-9, 1e-9)
      .row("a", 1e-4, 0.97, 1, 1e-9, 1e-9)
      .row("a", 1e-8, 0.96, 1, 1e-9, 1e-9);
  EXPECT_EQ(fastest_to(t.made.problems[0], t.made.rows, 1e-3)->tol, 1e-2);
}

TEST(ComparisonMeasures, MeaningOfAToleranceIsInTheRowsThatMetIt) {
  // At 1e-2 on p: 1e-1, 1e-3, 1e-1; on q: 1e-2, 5e-2, and 2 of a row that did not meet it.
  Comparison c = small_table();
  const auto all = tolerance_meaning(c);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].tol, 1e-2);
  EXPECT_EQ(all[0].rows, 5);
  EXPECT_EQ(all[0].median, 5e-2);
  EXPECT_EQ(all[0].ninth_decile, 1e-1);
  EXPECT_EQ(all[0].worst, 1e-1);
  EXPECT_EQ(all[0].worst_problem, "p");
  EXPECT_EQ(all[0].worst_solver, "a");
  // At 1e-4 on p: 1e-3, 1e-6, 1e-3; on q: 1e-5. Errors of several answers are distances to the
  // nearest and count. Without a trusted reference of p, q is left.
  EXPECT_EQ(all[1].rows, 4);
  c.problems[0].answers = 2;
  EXPECT_EQ(tolerance_meaning(c)[1].rows, 4);
  c.problems[0].reference.error = {.epsilon = 1e-6, .eta = 1e-6};
  EXPECT_EQ(tolerance_meaning(c)[1].rows, 1);
  EXPECT_EQ(tolerance_meaning(c)[1].worst, 1e-5);
}

TEST(ComparisonMeasures, RegretIsOverTheBestOfTheOthers) {
  // p: 1.5/1 and 6/3; q at 1e-2: not solved while b was; q at 1e-4: auto alone.
  // r needs no impulse: no case.
  Comparison c = small_table();
  for (const char* solver : {"a", "auto"}) {
    c.rows.push_back({.problem = "r", .solver = solver, .tol = 1e-2, .cpu_min = 1});
    c.rows.back().status = to_string(SolveStatus::kNothingToDo);
    c.rows.back().guarded = 0;
  }
  const Regret regret = regret_of(c, "auto");
  ASSERT_EQ(regret.entries.size(), 3u);
  EXPECT_EQ(regret.failed, 1);
  EXPECT_EQ(regret.alone, 1);
  EXPECT_EQ(regret.entries[0].problem, "q");
  EXPECT_EQ(regret.entries[0].best, "b");
  EXPECT_EQ(regret.worst, kInfinity);
  EXPECT_EQ(regret.entries[1].ratio, 2);
  EXPECT_EQ(regret.median, 2);
  EXPECT_EQ(regret.entries[2].ratio, 1.5);
  // Only where the best of the others took two seconds or more: 6/3 and the failure.
  EXPECT_EQ(regret_of(c, "auto", 2).entries.size(), 2u);
  EXPECT_TRUE(std::isnan(regret_of(c, "nobody").median));
}

TEST(ComparisonMeasures, QuantilesAreRanks) {
  // Ten cases with the ratios 1 to 10: the median lies between the middle ones, nine tenths is the
  // ninth.
  RunTable t;
  for (int k = 1; k <= 10; ++k) {
    t.problem(fmt::format("p{}", k));
    t.row("auto", 1e-2, k, 1, 1e-3, 1e-3).row("a", 1e-2, 1, 1, 1e-3, 1e-3);
  }
  const Regret regret = regret_of(t.made, "auto");
  EXPECT_EQ(regret.median, 5.5);
  EXPECT_EQ(regret.ninth_decile, 9);
  EXPECT_EQ(regret.worst, 10);
  EXPECT_EQ(regret.entries[0].problem, "p10");
}

TEST(ComparisonMeasures, GrowthIsFittedToTheSolvedSizes) {
  // Iterations 2 N^(1/2), time N^(3/2) 1e-4 s for N = 100, 400, 1600 degrees of
  // freedom; the largest was not solved.
  RunTable t;
  for (int n : {100, 400, 1600, 6400}) {
    t.problem(fmt::format("square:{}", n), n, "square");
    t.row("a", 1e-4, 1e-4 * std::pow(n, 1.5), static_cast<int>(2 * std::sqrt(n)),
          n == 6400 ? 1 : 1e-5, 1e-5);
  }
  t.problem("alone").row("a", 1e-4, 1, 1, 1e-5, 1e-5);
  const auto all = growth(t.made);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].series, "square");
  EXPECT_EQ(all[0].points.size(), 4u);
  EXPECT_FALSE(all[0].points[3].solved);
  EXPECT_EQ(all[0].time.points, 3);
  EXPECT_NEAR(all[0].iterations.exponent, 0.5, 1e-12);
  EXPECT_NEAR(all[0].time.exponent, 1.5, 1e-12);
  EXPECT_NEAR(all[0].time.prefactor, 1e-4, 1e-14);
  const Chart chart = growth_chart(all, "square", 1e-4, Growth::Measure::kTime);
  ASSERT_EQ(chart.series.size(), 2u);  // points, fit
  EXPECT_TRUE(chart.series[0].points[3].hollow);
  EXPECT_EQ(chart.series[1].points.back().x, 1600);
  EXPECT_NEAR(chart.series[1].points.back().y, 6.4, 1e-12);  // 1600^(3/2) = 64 000
}

TEST(ComparisonCharts, ProfileStepsFromTheShareOfWinsToTheShareSolved) {
  const Comparison c = small_table();
  const Chart chart = profile_chart(performance_profiles(c, time_at(c, 1e-2)), "time", "profile");
  const auto& a = chart.series[0].points;  // ratios 1 and 4 of two problems
  ASSERT_EQ(a.size(), 4u);
  EXPECT_EQ(a[0].y, 0);
  EXPECT_EQ(a[1].x, 1);
  EXPECT_EQ(a[1].y, 0.5);
  EXPECT_EQ(a[2].x, 4);
  EXPECT_EQ(a[2].y, 1);
  EXPECT_EQ(a[3].x, *chart.x.high);
  EXPECT_EQ(chart.series[2].points.back().y, 0.5);
}

TEST(ComparisonCharts, FrontOfTheWorkPrecisionDiagramIsThatOfTheRows) {
  // On p: a at 1 s with 1e-1, b at 2 s with 1e-3, b at 3 s with 1e-6; all others are beaten.
  const Comparison c = small_table();
  const Chart chart = work_precision_chart(c, c.problems[0]);
  ASSERT_EQ(chart.series.size(), 4u);
  const Chart::Series& front = chart.series.back();
  EXPECT_TRUE(front.background);
  ASSERT_EQ(front.points.size(), 3u);
  EXPECT_EQ(front.points[1].x, 2);
  EXPECT_EQ(front.points[2].y, 1e-6);
}

}  // namespace
}  // namespace bipot
