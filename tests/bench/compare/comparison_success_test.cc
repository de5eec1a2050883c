#include "bench/compare/comparison_success.h"

#include "bench/compare/comparison_charts.h"
#include "core/base/types.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

void add_problem(Comparison& c, const std::string& name, int contacts) {
  c.problems.push_back({.name = name, .contacts = contacts});
}

void add_row(Comparison& c, const std::string& problem, const std::string& solver, double tol,
             double guarded) {
  c.rows.push_back({.problem = problem, .solver = solver, .tol = tol, .guarded = guarded});
}

/// Three small problems, one without contacts, one large.
Comparison table() {
  Comparison c;
  add_problem(c, "small", 1);
  add_row(c, "small", "a", 1e-4, 5e-5);
  add_row(c, "small", "a", 1e-6, 5e-7);
  add_row(c, "small", "b", 1e-4, 5e-5);
  add_row(c, "small", "b", 1e-6, kNaN);  // refused
  add_problem(c, "edge", 100);
  add_row(c, "edge", "a", 1e-4, 2e-6);
  add_row(c, "edge", "a", 1e-6, 4e-6);  // out of time
  add_row(c, "edge", "b", 1e-4, 1);
  add_row(c, "edge", "b", 1e-6, 1e-7);  // exact on the way to a tighter tolerance
  add_problem(c, "empty", 0);
  add_row(c, "empty", "a", 1e-4, 0);
  add_problem(c, "large", 1001);
  add_row(c, "large", "a", 1e-4, 1e-4);  // on the tolerance: solved
  return c;
}

int solved(const SuccessCurve& curve, double tol) {
  for (const SuccessCurve::Point& p : curve.points) {
    if (p.tol == tol) return p.solved;
  }
  return -1;
}

TEST(ComparisonSuccess, CountsWhatARowOfTheSolverReached) {
  const auto curves = success_curves(table());
  ASSERT_EQ(curves.size(), 4u);  // two sizes have problems, two solvers
  const SuccessCurve &a = curves[0], &b = curves[1];
  EXPECT_EQ(a.size, "up to 100 contacts");
  EXPECT_EQ(a.solver, "a");
  EXPECT_EQ(b.solver, "b");
  EXPECT_EQ(a.problems, 2);  // not the one without contacts
  EXPECT_EQ(solved(a, 1e-3), 2);
  EXPECT_EQ(solved(a, 1e-5), 2);  // by the looser row too
  EXPECT_EQ(solved(a, 1e-6), 1);
  EXPECT_EQ(solved(b, 1e-4), 2);
  EXPECT_EQ(solved(b, 1e-5), 1);
  EXPECT_EQ(solved(b, 1e-6), 1);
  EXPECT_DOUBLE_EQ(a.share(a.points.back()), 0.5);
  EXPECT_EQ(curves[2].size, "more than 1000 contacts");
  EXPECT_EQ(solved(curves[2], 1e-4), 1);
  EXPECT_EQ(solved(curves[2], 1e-5), 0);
  EXPECT_EQ(solved(curves[3], 1e-3), 0);  // no row at all
}

TEST(ComparisonSuccess, EndsAtTheTightestToleranceThatWasAsked) {
  Comparison c = table();
  EXPECT_EQ(success_curves(c)[0].points.size(), 4u);  // 1e-3 to 1e-6
  EXPECT_EQ(solved(success_curves(c)[0], 1e-7), -1);
  add_row(c, "small", "a", 1e-12, 1e-13);
  const auto curves = success_curves(c);
  ASSERT_EQ(curves[0].points.size(), 10u);
  EXPECT_EQ(solved(curves[0], 1e-12), 1);
  // Nobody who was asked for 1e-2 alone has failed at 1e-3.
  c.rows.clear();
  add_row(c, "small", "a", 1e-2, 5e-3);
  EXPECT_TRUE(success_curves(c).empty());
}

TEST(ComparisonSuccess, NeverGrowsTowardsTighterTolerances) {
  Comparison c = table();
  add_row(c, "small", "b", 1e-12, 1e-9);
  for (const SuccessCurve& curve : success_curves(c)) {
    for (std::size_t k = 1; k < curve.points.size(); ++k) {
      EXPECT_LT(curve.points[k].tol, curve.points[k - 1].tol);
      EXPECT_LE(curve.points[k].solved, curve.points[k - 1].solved);
    }
  }
}

TEST(ComparisonSuccess, EveryContactCountHasOneSize) {
  for (const int contacts : {1, 100, 101, 1000, 1001, 1000000}) {
    const auto sizes = size_classes();
    EXPECT_EQ(
        std::count_if(sizes.begin(), sizes.end(),
                      [&](const SuccessCurve::SizeClass& size) { return size.has(contacts); }),
        1)
        << contacts;
  }
}

TEST(ComparisonSuccess, TableAndChartShowTheCurves) {
  const auto curves = success_curves(table());
  const std::string csv = to_csv(success_table(curves));
  EXPECT_EQ(csv.substr(0, csv.find('\n')), "size,solver,tol,problems,solved,share");
  EXPECT_TRUE(says(csv, "\"up to 100 contacts\",a,1e-06,2,1,0.5\n"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 4 * 4);
  const Chart chart = success_chart(curves, "up to 100 contacts");
  ASSERT_EQ(chart.series.size(), 2u);
  EXPECT_EQ(chart.series[0].name, "a");
  ASSERT_EQ(chart.series[0].points.size(), 4u);
  EXPECT_DOUBLE_EQ(chart.series[0].points.back().x, 1e-6);
  EXPECT_DOUBLE_EQ(chart.series[0].points.back().y, 0.5);
}

}  // namespace
}  // namespace bipot
