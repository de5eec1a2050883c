#include "bench/experiments/experiment_scene.h"
#include "bench/experiments/force_range.h"
#include "bench/experiments/validation_report.h"
#include "bench/experiments/validation_row.h"
#include "core/scene/scene_family.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

ValidationRow judged(const Expectation& range, double allowed,
                     std::vector<ValidationRow::Point> points) {
  ValidationRow row;
  row.claim.name = "row";
  row.range = range;
  row.allowed = allowed;
  row.points = std::move(points);
  judge(row);
  return row;
}

ValidationRow::Point point(double tol, double value, double bar = 0, long unsolved = 0) {
  return ValidationRow::Point{.tol = tol, .seen = {value, bar}, .steps = 100, .unsolved = unsolved};
}

TEST(Validate, ErrorsAreDistancesFromWhatIsExpected) {
  EXPECT_DOUBLE_EQ(Expectation::equal(4).error(5), 0.25);
  EXPECT_DOUBLE_EQ(Expectation::equal(0).error(-0.5), 0.5);
  EXPECT_EQ(Expectation::at_most(1, 2).error(0.5), 0);
  EXPECT_DOUBLE_EQ(Expectation::at_most(1, 2).error(2), 0.5);
  EXPECT_DOUBLE_EQ(Expectation::at_least(1, 2).error(0), 0.5);
  EXPECT_DOUBLE_EQ(Expectation::between(1, 2, 1).error(2.25), 0.25);
  EXPECT_TRUE(std::isnan(Expectation::equal(1).error(kNaN)));
}

// Errors 0.5, 0.005, 0.3, 0.004, 1e-9 at falling tolerances: right to 1 % from the fourth on, as
// the third is not right.
TEST(Validate, TheLoosestToleranceIsThatFromWhichAllTighterOnesAreRight) {
  const std::vector<ValidationRow::Point> points = {point(1, 1.5), point(0.1, 1.005),
                                                    point(0.01, 1.3), point(1e-3, 1.004),
                                                    point(1e-4, 1 + 1e-9)};
  const ValidationRow verdict = judged(Expectation::equal(1), 1e-6, points);
  EXPECT_TRUE(verdict.holds());
  EXPECT_EQ(verdict.best, 4);
  EXPECT_EQ(verdict.loosest, 1e-3);
  // The verdict is that of the tightest one, to what the row allows and not to 1 %.
  const ValidationRow strict = judged(Expectation::equal(1 + 1e-5), 1e-6, points);
  EXPECT_FALSE(strict.holds());
  EXPECT_TRUE(says(strict.claim.reason, "off by 1.0e-5"));
  EXPECT_EQ(strict.loosest, 1e-3);
}

TEST(Validate, ARunThatMissesItsToleranceDoesNotCount) {
  const ValidationRow verdict =
      judged(Expectation::equal(1), 1e-3, {point(0.1, 1), point(0.01, 3, 0, 2)});
  EXPECT_TRUE(verdict.holds());
  EXPECT_EQ(verdict.best, 0);
  const ValidationRow none =
      judged(Expectation::equal(1), 1e-3, {point(0.1, kNaN), point(0.01, 1, 0, 2)});
  EXPECT_FALSE(none.holds());
  EXPECT_TRUE(std::isnan(none.loosest));
  EXPECT_TRUE(says(none.claim.reason, "undefined"));
}

TEST(Validate, ABarWidensWhatIsAllowed) {
  EXPECT_FALSE(judged(Expectation::equal(1), 0, {point(0.1, 1.2)}).holds());
  EXPECT_TRUE(judged(Expectation::equal(1), 0, {point(0.1, 1.2, 0.3)}).holds());
  // Between one and two bars chance may lead there; beyond two it does not, whatever their width.
  const ValidationRow between = judged(Expectation::equal(1), 0, {point(0.1, 1.2, 0.15)});
  EXPECT_TRUE(between.undecided());
  EXPECT_TRUE(says(between.claim.reason, "off by 2.0e-1"));
  EXPECT_TRUE(says(between.claim.reason, "3.0e-1 with a second error bar: too few samples"));
  const ValidationRow refuted = judged(Expectation::equal(1), 0, {point(0.1, 1.2, 0.09)});
  EXPECT_FALSE(refuted.holds() || refuted.undecided());
  const ValidationRow far = judged(Expectation::equal(1), 0, {point(0.1, 3, 0.9)});
  EXPECT_FALSE(far.holds() || far.undecided());
  // What is allowed is part of the bar that is shown: 0.1 of the scale 2 and 0.3.
  EXPECT_DOUBLE_EQ(judged(Expectation::equal(2), 0.1, {point(0.1, 2.2, 0.3)}).claim.bar, 0.5);
  // A bar that nobody knows decides nothing.
  EXPECT_TRUE(judged(Expectation::equal(1), 0, {point(0.1, 1, kNaN)}).undecided());
  // But one that is wider than half the scale says nothing, and nothing is right for its sake.
  const ValidationRow wide = judged(Expectation::equal(1), 0, {point(0.1, 1.2, 0.6)});
  EXPECT_FALSE(wide.holds());
  EXPECT_TRUE(wide.undecided());
  EXPECT_TRUE(std::isnan(wide.loosest));
  EXPECT_TRUE(says(wide.claim.reason, "error bar at 0.1 is 6.0e-1 of its scale: too few samples"));
}

TEST(Validate, WhatAnExperimentThrowsIsTheReason) {
  Experiment broken;
  broken.rows.resize(2);
  broken.tols = broken.quick_tols = {0.1};
  broken.run = [](Experiment::Trial&) { throw std::runtime_error("no disks at all"); };
  const Experiment::Result result = run_experiment(broken, {});
  ASSERT_EQ(result.rows.size(), 2u);
  EXPECT_FALSE(result.rows[1].holds());
  EXPECT_TRUE(says(result.rows[1].claim.reason, "no disks at all"));
  // One observation for two rows is a fault of the experiment.
  broken.run = [](Experiment::Trial& trial) { trial.seen = {{1}}; };
  EXPECT_TRUE(says(run_experiment(broken, {}).rows[0].claim.reason, "1 observations for 2 rows"));
}

TEST(Validate, AThresholdIsFoundAndItsLackIsNotHidden) {
  const Observation found = find_threshold(0, 1, [](double x) { return x >= 0.3; });
  EXPECT_NEAR(found.value, 0.3, 1e-4);
  EXPECT_TRUE(found.note.empty());
  const Observation always = find_threshold(0.2, 1, [](double) { return true; });
  EXPECT_EQ(always.value, 0.2);
  EXPECT_FALSE(always.note.empty());
  const Observation never = find_threshold(0, 1, [](double) { return false; });
  EXPECT_EQ(never.value, 1);
  EXPECT_FALSE(never.note.empty());
}

TEST(Validate, EveryRowSaysWhatItIs) {
  std::set<std::string> names;
  for (const Experiment& e : validation_experiments()) {
    for (const ValidationRow& row : e.rows) {
      EXPECT_TRUE(names.insert(row.claim.name).second) << row.claim.name;
      for (const std::string* text : {&row.group, &row.claim.quantity, &row.claim.source,
                                      &row.claim.expected, &row.allowed_why, &row.claim.bar_is}) {
        EXPECT_FALSE(text->empty()) << row.claim.name;
      }
      EXPECT_GT(row.range.scale, 0) << row.claim.name;
      EXPECT_TRUE(std::isfinite(row.range.low) || std::isfinite(row.range.high)) << row.claim.name;
    }
    for (const auto* tols : {&e.tols, &e.quick_tols}) {
      if (tols == &e.quick_tols && tols->empty()) continue;  // left out there
      EXPECT_GE(tols->size(), e.rows[0].takes_tolerance ? 2u : 1u) << e.rows[0].claim.name;
      EXPECT_TRUE(std::is_sorted(tols->rbegin(), tols->rend())) << e.rows[0].claim.name;
    }
  }
  EXPECT_GE(names.size(), 70u);
}

struct NamedExperiments {
  const char* name;
  std::vector<Experiment> (*make)();
};
void PrintTo(const NamedExperiments& e, std::ostream* out) { *out << e.name; }

/// Rows whose answer is known by hand hold at the tightest tolerance; with an expected value that
/// is 20 % off (or a bound that is moved by a tenth of its scale past what was measured) each of
/// them does not.
class ExactRows : public testing::TestWithParam<NamedExperiments> {};

TEST_P(ExactRows, HoldAndWouldNotHoldWithAnotherValue) {
  Experiment::Context context{.quick = true};
  for (Experiment e : GetParam().make()) {
    e.quick_tols = {e.quick_tols.back()};
    for (ValidationRow& v : run_experiment(e, context).rows) {
      EXPECT_TRUE(v.holds()) << v.claim.name << ": " << v.claim.reason;
      ASSERT_NE(v.measured(), nullptr) << v.claim.name;
      const Observation seen = v.measured()->seen;
      const double moved = 0.1 * v.range.scale + 2 * seen.bar;
      v.range = v.range.low == v.range.high && v.range.low != 0
                    ? Expectation::equal(1.2 * v.range.low + 2 * seen.bar)
                    : Expectation::at_least(seen.value + moved, v.range.scale);
      judge(v);
      EXPECT_FALSE(v.holds()) << v.claim.name;
      EXPECT_FALSE(v.claim.reason.empty()) << v.claim.name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Validate, ExactRows,
                         testing::ValuesIn(std::vector<NamedExperiments>{
                             {"slope", &slope_experiments},
                             {"standing", &standing_experiments},
                             {"impact", &impact_experiments},
                             {"collision", &collision_experiments},
                             {"mfix", &mfix_experiments},
                             {"cohesion", &cohesion_experiments},
                             {"chain", &chain_experiments},
                             {"indeterminacy", &indeterminacy_experiments}}));

// A solver that may not iterate reaches no tolerance, and no row holds by luck.
TEST(Validate, WithoutIterationsNothingThatNeedsThemHolds) {
  Experiment::Context context{.quick = true, .max_iterations = 1};
  for (Experiment e : standing_experiments()) {
    e.quick_tols = {1e-8};
    for (const ValidationRow& v : run_experiment(e, context).rows) {
      EXPECT_FALSE(v.holds()) << v.claim.name;
      EXPECT_TRUE(says(v.claim.reason, "did not reach"));
    }
  }
}

/// All rows at one tolerance, as --quick measures them.
ValidationPage small_page() {
  Experiment::Context context{.quick = true};
  ValidationPage page{.command = "bipot validate --quick", .solver = context.solver, .quick = true};
  for (Experiment e : validation_experiments()) {
    e.quick_tols = {1e-1};
    page.add(run_experiment(e, context));
  }
  return page;
}

TEST(Validate, TheQuickPageHasEveryRowAndNoNaN) {
  const ValidationPage page = small_page();
  const ClaimReport report = to_report(page);
  const TemporaryFolder folder;
  write_figures(folder.path(), to_document(report));
  const std::string html = to_html(to_document(report)), text = to_text(page),
                    csv = to_csv(points_table(page)), verdicts = to_csv(verdicts_table(page));
  std::size_t rows = 0;
  for (const Experiment& e : validation_experiments()) {
    for (const ValidationRow& row : e.rows) {
      ++rows;
      EXPECT_TRUE(says(html, "." + row.claim.name + "\">")) << row.claim.name;
      EXPECT_TRUE(says(text, row.claim.name + " ")) << row.claim.name;
      EXPECT_TRUE(says(csv, "," + row.claim.name + ",")) << row.claim.name;
    }
  }
  EXPECT_EQ(page.rows.size(), rows);
  for (const ValidationRow& v : page.rows) {
    ASSERT_EQ(v.points.size(), 1u);
    EXPECT_TRUE(v.points[0].failure.empty()) << v.claim.name << ": " << v.points[0].failure;
    EXPECT_TRUE(std::isfinite(v.points[0].seen.value)) << v.claim.name;
    EXPECT_TRUE(std::isfinite(v.points[0].seen.bar)) << v.claim.name;
    EXPECT_GT(v.points[0].steps, 0) << v.claim.name;
  }
  for (const std::string* all : {&html, &text, &csv, &verdicts}) EXPECT_FALSE(says(*all, "nan"));
  EXPECT_EQ(std::count(verdicts.begin(), verdicts.end(), '\n'), static_cast<long>(rows) + 1);
  EXPECT_EQ(report.items.size(), groups_of(page).size());
  for (const std::string& group : groups_of(page)) {
    EXPECT_FALSE(error_chart(page, group).series.empty()) << group;
  }
}

/// As --quick measures it: every row has an error bar and none is refuted. A planted value does not
/// pass: an equality is moved to twice what is expected, a bound to beyond what was measured.
TEST(Validate, QuickRowsHaveBarsAndRefutePlantedValues) {
  Experiment::Context context{.quick = true};
  for (const Experiment& e : flow_experiments()) {
    for (ValidationRow& row : run_experiment(e, context).rows) {
      EXPECT_GT(row.claim.bar, 0) << row.claim.name;
      EXPECT_TRUE(row.holds() || row.undecided()) << row.claim.name << ": " << row.claim.reason;
      ASSERT_NE(row.measured(), nullptr);
      const Observation seen = row.measured()->seen;
      row.range = std::isfinite(row.range.low) && std::isfinite(row.range.high)
                      ? Expectation::equal(3 * row.range.high)
                      : Expectation::at_least(seen.value + 3 * seen.bar, row.range.scale);
      judge(row);
      EXPECT_FALSE(row.holds() || row.undecided()) << row.claim.name << ": " << row.claim.reason;
    }
  }
}

ContactProblem three_disks(double mu) {
  const Scene<2> scene = make_family_scene("pyramid", 2, {.mu = mu});
  return step_problem(scene, initial_state(scene));
}

// Three disks stand iff mu >= tan 15° = 0.268. At that mu the force between the top disk and a
// lower one is on the cone's edge: the interval is one point, w/2 over cos(30° - 15°), its normal
// part w/2.
TEST(AdmissibleForces, OfThreeDisksAreNoneThenOneThenMany) {
  const double tan15 = 2 - std::sqrt(3.0), weight = 9.81 * 0.01;
  EXPECT_TRUE(admissible_forces(three_disks(tan15 * (1 - 1e-3))).empty());
  const std::vector<ForceRange> one = admissible_forces(three_disks(tan15 * (1 + 1e-9)));
  ASSERT_FALSE(one.empty());
  const std::vector<ForceRange> many = admissible_forces(three_disks(0.6));
  ASSERT_EQ(one.size(), many.size());
  double least = kInfinity;
  for (std::size_t k = 0; k < one.size(); ++k) {
    EXPECT_GE(one[k].low, many[k].low - 1e-9 * weight);
    EXPECT_LE(one[k].high, many[k].high + 1e-9 * weight);
    if (one[k].high > 0.1 * weight) least = std::min(least, one[k].high / weight);
  }
  EXPECT_NEAR(least, 0.5, 1e-5);
  EXPECT_LE(force_spread(one), 1e-4);
  EXPECT_GT(force_spread(many), 0.01);
}

TEST(AdmissibleForces, AreRefusedForAnotherForm) {
  ContactProblem problem = three_disks(0.5);
  problem.row_scale = Vector::Constant(problem.num_rows(), 1.2);
  EXPECT_THROW(admissible_forces(problem), std::invalid_argument);
}

}  // namespace
}  // namespace bipot
