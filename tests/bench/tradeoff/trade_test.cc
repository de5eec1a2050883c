#include "bench/tradeoff/trade.h"

#include <nlohmann/json.hpp>

#include "bench/tradeoff/trade_analysis.h"
#include "bench/tradeoff/trade_charts.h"
#include "bench/tradeoff/trade_report.h"
#include "core/base/types.h"
#include "core/motion/spring_dashpot.h"
#include "tests/support/markup_defect.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

const char* kColumns = R"(
title = "Two columns"
contact = {mu = 0.0}
disks = [{arrangement = "rectangular", columns = 2, rows = 3, radius = 0.01, density = 2000.0}]
walls = [{point = [0.0, 0.0], normal = [0.0, 1.0]}, {point = [0.0, 0.0], normal = [1.0, 0.0]},
  {point = [0.04, 0.0], normal = [-1.0, 0.0]}]
time = {step = 1e-3, steps = 60}
)";

const char* kFalling = R"(
title = "Falling disks"
contact = {mu = 0.2, e_n = 0.2}
disks = [
  {arrangement = "random", count = 8, radii = [0.01, 0.008], width = 0.06, density = 2000.0}]
walls = [{point = [0.0, 0.0], normal = [0.0, 1.0]}, {point = [0.0, 0.0], normal = [1.0, 0.0]},
  {point = [0.06, 0.0], normal = [-1.0, 0.0]}]
time = {step = 1e-3, steps = 80}
)";

std::string scene_file(const TemporaryFolder& folder, const std::string& name,
                       const std::string& text) {
  const fs::path path = folder / (name + ".toml");
  std::ofstream(path) << text;
  return path.string();
}

std::size_t index_of(const std::vector<TradeQuantity>& quantities, const std::string& name) {
  for (std::size_t q = 0; q < quantities.size(); ++q) {
    if (quantities[q].name == name) return q;
  }
  ADD_FAILURE() << "no quantity " << name;
  return 0;
}

/// A trade of one scene whose outcomes come from a formula instead of a run.
template <class Value>
Trade manufactured(int replicas, double negligible, Value&& value) {
  Trade trade{.negligible = negligible, .complete = true};
  Trade::Scene scene{.name = "made", .step = 1e-3, .replicas = replicas};
  scene.num_steps = scene.whole_steps = 100;
  scene.quantities = {{.name = "q", .unit = "m", .meaning = "manufactured"}};
  trade.scenes = {scene};
  const auto add = [&](double tol, double factor) {
    for (int r = 0; r < replicas; ++r) {
      Trade::Row row;
      row.scene = "made";
      row.setting = {.solver = "auto", .tol = tol, .step_factor = factor};
      row.replica = r;
      row.status = "completed";
      row.steps = row.steps_planned = row.steps_converged = 100;
      row.simulated = 0.1;
      row.cpu = 1e-3 / (factor * tol);
      row.values = {value(tol, factor, r)};
      trade.rows.push_back(row);
    }
  };
  for (const double tol : {1e-1, 1e-2, 1e-3, 1e-6}) add(tol, 1);
  for (const double factor : {2.0, 0.5, 0.25}) add(1e-6, factor);
  return trade;
}

/// Outcomes whose error is the solver's alone, and with one of the time step.
double by_solver(double tol, double /*factor*/, int /*replica*/) { return 1 + 0.5 * tol; }
double by_solver_and_step(double tol, double factor, int /*replica*/) {
  return 1 + 0.01 * factor + 0.5 * tol;
}
/// By the solver, in two replicas that lie 0.06 apart.
double by_replica(double tol, double factor, int replica) {
  return by_solver(tol, factor, replica) + (replica == 0 ? 0.03 : -0.03);
}

TEST(TradeAnalysis, SeparatesTheSolverFromTheTimeStep) {
  // q = 1 + 0.01 (h/h0) + 0.5 tol: the step's own error is 0.01 of 1.0025 (the reference, at h/4),
  // the solver's 0.05, 0.005, 5e-4, 0: tolerance 1e-2 is enough.
  const Trade trade = manufactured(1, 0, by_solver_and_step);
  const SceneTrade s = analyse_trade(trade).at(0);
  const SceneTrade::Errors& e = s.quantities.at(0);
  const double reference = 1.0025 + 0.5e-6;
  EXPECT_NEAR(e.reference, reference, 1e-15);
  EXPECT_NEAR(e.step_error, 0.01 / reference, 1e-12);
  EXPECT_EQ(e.step_error_kind, "Richardson, order 1.0");
  ASSERT_EQ(e.solver_error.size(), 4u);
  EXPECT_NEAR(e.solver_error[0], (0.05 - 0.5e-6) / reference, 1e-12);
  EXPECT_NEAR(e.solver_error[1], (0.005 - 0.5e-6) / reference, 1e-12);
  EXPECT_EQ(e.solver_error[3], 0);
  EXPECT_EQ(e.noise, 0);
  ASSERT_TRUE(s.sufficient_tol.has_value());
  EXPECT_EQ(*s.sufficient_tol, 1e-2);
  EXPECT_EQ(s.decided_by, "q");
  EXPECT_NEAR(s.cpu_tightest / s.cpu_sufficient, 1e4, 1e-6);
  EXPECT_TRUE(says(s.answer(), "Tolerance 0.01 is enough"));
}

TEST(TradeAnalysis, ATightToleranceIsNeededWhereTheTimeStepIsExact) {
  Trade trade = manufactured(1, 0, by_solver);
  const SceneTrade exact = analyse_trade(trade).at(0);
  EXPECT_EQ(exact.quantities[0].step_error, 0);
  EXPECT_EQ(*exact.sufficient_tol, 1e-6);
  // Unless nobody looks that closely.
  trade = manufactured(1, 1e-2, by_solver);
  const SceneTrade good = analyse_trade(trade).at(0);
  EXPECT_EQ(*good.sufficient_tol, 1e-2);
}

TEST(TradeAnalysis, NearbyRunsHideWhatIsSmallerThanTheirSpread) {
  // Two replicas at ±0.03: standard deviation 0.03 √2, twice the standard error of a difference of
  // two means of two: 2 x 0.03 √2 = 0.085. The solver's 0.05 at 1e-1 cannot be seen.
  const Trade trade = manufactured(2, 0, by_replica);
  const SceneTrade s = analyse_trade(trade).at(0);
  EXPECT_NEAR(s.quantities[0].noise, 0.06 * std::sqrt(2), 1e-6);
  EXPECT_EQ(*s.sufficient_tol, 1e-1);
}

/// The trade with one more solver at the tightest tolerance.
Trade with_witness(Trade trade, double value) {
  Trade::Row row = trade.rows.front();
  row.setting = {.solver = "apgd", .tol = 1e-6};
  row.values = {value};
  trade.rows.push_back(row);
  return trade;
}

TEST(TradeAnalysis, WhatOtherExactAnswersDoIsAFloor) {
  // The step is exact and the solver's error 0.5 tol: alone, 1e-6 is needed. Another solver ends
  // 0.02 away at the same tolerance: then the 0.005 of 1e-2 are nobody's digits.
  const Trade alone = manufactured(1, 0, by_solver);
  EXPECT_EQ(*analyse_trade(alone).at(0).sufficient_tol, 1e-6);
  const Trade trade = with_witness(alone, 1.02);
  const SceneTrade s = analyse_trade(trade).at(0);
  EXPECT_NEAR(s.quantities[0].choice, 0.02, 1e-5);
  EXPECT_EQ(s.quantities[0].other_solver, "apgd");
  EXPECT_EQ(*s.sufficient_tol, 1e-2);
  EXPECT_TRUE(says(s.answer(), "several exact answers"));
  EXPECT_TRUE(says(s.answer(), "below what solvers differ by"));
  EXPECT_TRUE(says(s.answer(), "No digits below that are paid for"));
}

TEST(TradeAnalysis, ADifferenceBelowThatOfNearbyRunsIsNoOtherAnswer) {
  // Replicas at ±0.03 and the witness's at ±0.03 + 0.02: less than 0.085.
  Trade trade = with_witness(with_witness(manufactured(2, 0, by_replica), 1.05), 0.99);
  trade.rows.back().replica = 1;
  const SceneTrade s = analyse_trade(trade).at(0);
  EXPECT_NEAR(s.quantities[0].choice, 0.02, 1e-5);
  EXPECT_FALSE(says(s.answer(), "apgd")) << s.answer();
  EXPECT_FALSE(says(s.answer(), "solvers differ")) << s.answer();
}

TEST(TradeAnalysis, EachOutcomeNamesTheSolverThatEndsFurthestAwayInIt) {
  // Of two outcomes, apgd is 0.1 away in the first and ipm 0.02 in the second.
  Trade trade = with_witness(with_witness(manufactured(1, 0, by_solver), 1.1), 1.0);
  trade.rows.back().setting.solver = "ipm";
  trade.scenes[0].quantities.push_back({.name = "r", .unit = "m", .meaning = "manufactured"});
  for (Trade::Row& row : trade.rows) row.values.push_back(1);
  trade.rows.back().values[1] = 1.02;
  const SceneTrade s = analyse_trade(trade).at(0);
  EXPECT_EQ(s.quantities[0].other_solver, "apgd");
  EXPECT_EQ(s.quantities[1].other_solver, "ipm");
  EXPECT_TRUE(says(s.answer(), "apgd ends 10 % away in 'q'")) << s.answer();
}

TEST(TradeAnalysis, AWitnessThatAgreesChangesNothing) {
  const Trade alone = manufactured(1, 0, by_solver);
  const Trade agreeing = with_witness(alone, 1 + 0.5e-6);
  const SceneTrade s = analyse_trade(agreeing).at(0);
  EXPECT_EQ(s.quantities[0].choice, 0);
  EXPECT_EQ(*s.sufficient_tol, 1e-6);
  EXPECT_FALSE(says(s.answer(), "several exact answers")) << s.answer();
  // Nor one that did not get there.
  Trade failed = with_witness(alone, kNaN);
  failed.rows.back().status = "time limit";
  EXPECT_TRUE(std::isnan(analyse_trade(failed).at(0).quantities[0].choice));
  EXPECT_TRUE(std::isnan(analyse_trade(alone).at(0).quantities[0].choice));
}

TEST(TradeAnalysis, RunsThatWereNotCompletedSayNothing) {
  Trade trade = manufactured(2, 0, by_solver_and_step);
  for (Trade::Row& row : trade.rows) {
    const bool tight = row.setting.tol == 1e-6 && row.setting.step_factor == 1;
    const bool other_step = row.setting.step_factor != 1;
    if (tight && row.replica == 1) {
      row.status = "time limit";
      row.values = {kNaN};
    }
    if (other_step) row.setting.tol = 1e-3;
    if (other_step && row.setting.step_factor < 1) {
      row.status = "failed";
      row.values = {kNaN};
    }
  }
  const SceneTrade s = analyse_trade(trade).at(0);
  EXPECT_EQ(s.tols, (std::vector<double>{1e-1, 1e-2, 1e-3}));
  EXPECT_EQ(s.quantities[0].step_error_kind, "difference to twice the step");
  const SceneTrade::Cell* tight = s.find({.solver = "auto", .tol = 1e-6});
  EXPECT_FALSE(tight->done());
  EXPECT_EQ(tight->status, "time limit");
  EXPECT_TRUE(std::isnan(s.worst_error(*tight)));
  // Without any other step nothing is known of the step's error.
  std::erase_if(trade.rows, [](const Trade::Row& r) { return r.setting.step_factor != 1; });
  EXPECT_FALSE(analyse_trade(trade).at(0).sufficient_tol.has_value());
}

struct TradeRun : testing::Test {
  const TemporaryFolder folder;

  /// Of one target, of equal steps those of its own length alone, with rigid contacts.
  static Trade::Options options_of(const std::string& target, const std::vector<double>& tols) {
    return {.targets = {target}, .tols = tols, .step_factors = {1}, .overlaps = {}, .replicas = 1};
  }
};

TEST_F(TradeRun, ColumnsLoadEachContactWithTheWeightAbove) {
  Trade::Options options{.targets = {scene_file(folder, "columns", kColumns)},
                         .solvers = {"auto", "pgs"},
                         .tols = {1e-2, 1e-8},
                         .step_factors = {1, 0.5},
                         .accuracies = {},
                         .overlaps = {1e-3, 1e-2}};
  const Trade trade = run_trade(options);
  ASSERT_TRUE(trade.complete);
  ASSERT_EQ(trade.scenes.size(), 1u);
  EXPECT_EQ(trade.scenes[0].replicas, 1);  // nothing flies
  EXPECT_EQ(trade.rows.size(), 2u * 2 + 1 + 2);
  const auto& quantities = trade.scenes[0].quantities;
  const std::size_t column = index_of(quantities, "column force");
  const std::size_t floor = index_of(quantities, "floor load");
  const std::size_t pressure = index_of(quantities, "pressure");
  // σ_yy V = Σ m g x (distance from the floor to the centre) by Love's formula, σ_xx = 0, and the
  // pressure is half of their sum. V: the disks' hull, 0.04 m x 0.06 m with rounded corners.
  const double weight = 2000 * M_PI * 1e-4 * 9.81;
  const double area = 0.04 * 0.06 - (4 - M_PI) * 1e-4;
  const double expected = 0.5 * 2 * weight * (0.01 + 0.03 + 0.05) / area;
  for (const Trade::Row& row : trade.rows) {
    EXPECT_EQ(row.status, "completed") << row.setting.label() << ": " << row.message;
    EXPECT_GT(row.cpu, 0);
    const bool tight = row.setting.dem() || row.setting.tol == 1e-8;
    if (!tight) continue;
    const double accuracy = row.setting.dem() ? 1e-2 : 1e-6;
    EXPECT_LT(row.values[column], accuracy) << row.setting.label();
    EXPECT_NEAR(row.values[floor], 1, accuracy) << row.setting.label();
    EXPECT_NEAR(row.values[pressure] / expected, 1, row.setting.dem() ? 3e-2 : 1e-3);
  }
  // Springs: soft ones first, overlap as aimed at, three disks on the floor of each column.
  const Trade::Row &soft = trade.rows[5], &stiff = trade.rows[6];
  EXPECT_EQ(soft.setting.overlap, 1e-2);
  EXPECT_NEAR(soft.penetration / 1e-2, 1, 0.7);
  EXPECT_NEAR(stiff.stiffness / soft.stiffness, 10, 1e-9);
  EXPECT_NEAR(soft.penetration / stiff.penetration, 10, 1);
  const SceneTrade s = analyse_trade(trade).at(0);
  EXPECT_EQ(s.solver, "auto");
  EXPECT_EQ(s.step_tol, 1e-8);
}

TEST_F(TradeRun, FallingDisksAreRunAsNearbyReplicas) {
  Trade::Options options{.targets = {scene_file(folder, "falling", kFalling) + ":steps=90"},
                         .tols = {1e-1, 1e-6},
                         .step_factors = {1},
                         .accuracies = {},
                         .overlaps = {1e-2}};
  const Trade first = run_trade(options), second = run_trade(options);
  EXPECT_EQ(first.scenes[0].replicas, 3);
  ASSERT_EQ(first.rows.size(), 9u);
  for (std::size_t k = 0; k < first.rows.size(); ++k) {
    EXPECT_EQ(first.rows[k].steps, 90);
    EXPECT_EQ(first.rows[k].values, second.rows[k].values);  // the same bits
  }
  // Replicas differ, and settings of one replica start alike.
  EXPECT_NE(first.rows[3].values, first.rows[4].values);
  EXPECT_NE(first.rows[4].values, first.rows[5].values);
  const std::size_t lost = index_of(first.scenes[0].quantities, "energy lost");
  EXPECT_NEAR(first.rows[3].values[lost] / first.rows[5].values[lost], 1, 0.2);
}

/// A value that is given twice is run once: it is no further replica.
TEST_F(TradeRun, RepeatedValuesCountOnce) {
  Trade::Options options =
      options_of(scene_file(folder, "columns", kColumns) + ":steps=4", {1e-2, 1e-4, 1e-2});
  options.accuracies = {};
  EXPECT_EQ(run_trade(options).rows.size(), 2u);
  options.solvers = {"auto", "auto"};
  EXPECT_THROW(run_trade(options), std::invalid_argument);
}

TEST_F(TradeRun, AccuraciesCutStepsOfOneFrame) {
  Trade::Options options = options_of(scene_file(folder, "falling", kFalling), {1e-2, 1e-6});
  options.step_factors = {1, 0.5};
  options.accuracies = {0.1, 0.01};
  const Trade trade = run_trade(options);
  ASSERT_EQ(trade.rows.size(), 5u);
  const Trade::Row& equal = trade.rows[1];
  const int factor = longest_cut_step(std::get<Scene<2>>(trade.scenes[0].scene), equal.steps);
  EXPECT_GT(factor, 1);
  EXPECT_EQ(equal.steps % factor, 0);
  for (const std::size_t k : {3u, 4u}) {
    const Trade::Row& row = trade.rows[k];
    ASSERT_EQ(row.status, "completed") << row.message;
    EXPECT_DOUBLE_EQ(row.step, factor * equal.step);
    EXPECT_LE(row.penetration, 3.5 * row.setting.accuracy);
    EXPECT_NEAR(row.simulated, equal.simulated, 1e-12);
  }
  EXPECT_LT(trade.rows[4].penetration, equal.penetration);
  const SceneTrade s = analyse_trade(trade).at(0);
  EXPECT_EQ(s.step_tol, trade.rows[4].setting.tol);
  EXPECT_TRUE(says(s.answer(), "--accuracy 0.01"));
}

// Free flight is exact with any step. Over the last tenth the mean of v² = (g t)² is
// g² (1 - 0.9³)/0.3 times the end's t², however few steps it is seen in. With accuracies these are
// 20 or 6. The last of 6 is longer than a tenth.
TEST_F(TradeRun, MeansOverTheLastTenthDoNotDependOnTheSteps) {
  for (const auto& [steps, bound] : {std::pair(1000, 1e-3), {60, 4e-3}}) {
    Trade::Options options = options_of(
        scene_file(folder, "thrown",
                   fmt::format("disks = [{{position = [0, 10], radius = 0.1, mass = 1}},\n"
                               "{{position = [1, 10], radius = 0.1, mass = 1}}]\n"
                               "time = {{step = {}, steps = {}}}\noutput = {{every = 10}}\n",
                               1.0 / steps, steps)),
        {1e-2});
    options.accuracies = {0.1};
    const Trade trade = run_trade(options);
    const std::size_t k = index_of(trade.scenes[0].quantities, "speed");
    const double equal = trade.rows[0].values.at(k), cut = trade.rows[1].values.at(k);
    EXPECT_NEAR(cut / equal, 1, bound);
    // In units of √(g r) at t = 1 s.
    EXPECT_NEAR(equal, std::sqrt(9.81 / 0.1 * (1 - 0.9 * 0.9 * 0.9) / 0.3), bound * equal);
  }
}

TEST_F(TradeRun, FailuresAndTimeOutsStayInTheTable) {
  Trade::Options options{.targets = {scene_file(folder, "falling", kFalling)},
                         .tols = {1e-1, 1e-6},
                         .step_factors = {1, 0.5},
                         .accuracies = {},
                         .stiffness = {10, 1e5},
                         .time_limit = 1e-9};
  Trade trade = run_trade(options);
  EXPECT_TRUE(trade.complete);
  ASSERT_EQ(trade.rows.size(), (2u + 1 + 2) * 3);
  EXPECT_EQ(trade.rows[0].status, "time limit");
  EXPECT_LT(trade.rows[0].steps, 80);
  EXPECT_TRUE(std::isnan(trade.rows[0].values[0]));
  EXPECT_EQ(trade.rows[1].status, "not run");  // further replicas, tighter tolerances
  EXPECT_EQ(trade.rows[3].status, "not run");
  EXPECT_EQ(trade.rows[3].message, "a looser tolerance was not completed");
  EXPECT_EQ(trade.rows[6].message, "no tolerance was completed at the scene's step");
  EXPECT_FALSE(analyse_trade(trade).at(0).answer().empty());
  options.time_limit = 20;
  options.step_factors = {1};
  trade = run_trade(options);
  ASSERT_EQ(trade.rows.size(), (2u + 2) * 3);
  const Trade::Row& soft = trade.rows[6];  // 10 N/m under disks of half a kilogram
  EXPECT_EQ(soft.status, "failed");
  EXPECT_TRUE(says(soft.message, "too low for this load"));
  EXPECT_EQ(trade.rows[9].status, "completed");
  options.targets.push_back(options.targets[0]);
  EXPECT_THROW(run_trade(options), std::invalid_argument);  // two scenes of one name
}

TEST(TradeAnalysis, WhereStepAndToleranceAddNothingThatIsSaid) {
  const auto answer = [](double slope, double negligible) {
    const auto value = [slope](double, double factor, int) { return 1 + slope * factor; };
    const Trade trade = manufactured(1, negligible, value);
    return analyse_trade(trade).at(0).answer();
  };
  EXPECT_TRUE(says(answer(0.01, 1e-4), "Only the time step matters"));
  EXPECT_TRUE(says(answer(1e-14, 0), "The time step adds less than 1e-12")) << answer(1e-14, 0);
  EXPECT_FALSE(says(answer(1e-5, 1e-4), "Only the time step matters"));
}

TEST(TradeAnalysis, ChartsKeepRunsWithoutError) {
  // Only the loosest tolerance errs, and there is no overlap.
  Trade trade = manufactured(1, 0, [](double tol, double, int) { return tol > 0.05 ? 1.5 : 1; });
  for (Trade::Row& row : trade.rows) row.penetration = 0;
  const std::vector<SceneTrade> scenes = analyse_trade(trade);
  const std::vector<Figure> charts = trade_charts(scenes.at(0));
  ASSERT_EQ(charts.size(), 2u);  // with no other error there is nothing to compare with
  EXPECT_EQ(charts[0].chart->series.at(0).points.size(), 4u);
  EXPECT_EQ(charts[1].chart->series.at(0).points.size(), 4u);
}

TEST(TradeAnalysis, OneCompletedToleranceDecidesNothing) {
  // The drum of a visitor: at 0.1 it was completed, at the others a fifth of 100 steps in 5 s.
  Trade trade = manufactured(1, 0, by_solver_and_step);
  for (Trade::Row& row : trade.rows) {
    if (row.setting.step_factor == 1 && row.setting.tol < 1e-1) {
      row.status = "time limit";
      row.values = {kNaN};
      row.cpu = 5;
      row.steps = 20;
    } else {
      row.setting.tol = 1e-1;
    }
  }
  const SceneTrade s = analyse_trade(trade).at(0);
  EXPECT_EQ(s.tols, std::vector<double>{1e-1});
  EXPECT_FALSE(s.sufficient_tol.has_value());
  EXPECT_FALSE(s.quantities[0].sufficient_tol.has_value());
  // 25 s are needed; twice that, to one digit.
  EXPECT_TRUE(says(s.answer(), "Undecided"));
  EXPECT_TRUE(says(s.answer(), "--time-limit 50"));
  FinishedTrade finished(trade);
  finished.command_of_scene = "bipot trade {}";
  const std::string text = to_text(trade_document(finished));
  EXPECT_TRUE(says(text, "undecided"));
  EXPECT_FALSE(says(text, "Tolerance 0.1 is enough")) << text;
}

TEST(TradeReport, TheTableOfAnswersFitsInOneBlock) {
  Trade trade = manufactured(1, 0, [](double tol, double, int) { return 1 + tol; });
  trade.scenes[0].name = "isotropic_compression";  // the longest of the shipped ones
  trade.scenes[0].quantities[0].name = "column force";
  for (Trade::Row& row : trade.rows) row.scene = trade.scenes[0].name;
  const std::string text = to_text(trade_document(FinishedTrade(trade)));
  const std::size_t head = text.find("scene  "), end = text.find('\n', head);
  EXPECT_TRUE(says(text.substr(head, end - head), "at tol")) << text;
}

TEST(TradeReport, CostAndOverlapOfASettingStandInOneBlock) {
  Trade trade = manufactured(1, 0, by_solver_and_step);
  trade.rows[0].setting = {.model = Model::kSpringDashpot, .overlap = 1e-3};
  trade.rows[0].stiffness = 3.72e7;
  const std::string text = to_text(trade_document(FinishedTrade(trade)));
  const std::size_t head = text.find("setting  "), end = text.find('\n', head);
  EXPECT_TRUE(says(text.substr(head, end - head), "overlap / radius")) << text;
}

TEST_F(TradeRun, TakesScenesWhoseBodiesComeAndGo) {
  // Disks of 1 kg fall through an outlet: all 4 are gone at the end.
  const std::string leak = scene_file(folder, "leak", R"(
disks = [{arrangement = "rectangular", columns = 2, rows = 2, radius = 0.1, mass = 1}]
walls = [{point = [0, -5], normal = [0, 1]}]
outlets = [{point = [0, -1], normal = [0, 1]}]
time = {step = 1e-3, steps = 700}
)");
  const Trade trade = run_trade(options_of(leak, {1e-2, 1e-6}));
  const Trade::Row& run = trade.rows.at(0);
  ASSERT_EQ(run.status, "completed") << run.message;
  EXPECT_EQ(trade.scenes[0].bodies, 4);
}

TEST_F(TradeRun, TakesSpheres) {
  Trade::Options options{.targets = {"four_spheres:steps=20"},
                         .tols = {1e-3, 1e-6},
                         .step_factors = {1},
                         .replicas = 1};
  const Trade trade = run_trade(options);
  const std::size_t floor = index_of(trade.scenes[0].quantities, "floor load");
  // At rest the floor carries the weight.
  ASSERT_EQ(trade.rows.at(0).status, "completed") << trade.rows[0].message;
  EXPECT_NEAR(trade.rows[0].values[floor], 1, 1e-2);
  EXPECT_NEAR(trade.rows[1].values[floor], 1, 1e-5);
  const Trade::Row& springs = trade.rows.back();
  ASSERT_TRUE(springs.setting.dem());
  EXPECT_EQ(springs.status, "completed") << springs.message;
  EXPECT_NEAR(springs.values[floor], 1, 1e-1);
  EXPECT_GT(springs.iterations, 10);
}

TEST_F(TradeRun, QuickShortensTheScene) {
  // A limit of CPU time that the whole scene does not fit: fewer steps, not fewer tolerances.
  Trade::Options options{.targets = {scene_file(folder, "falling", kFalling) + ":steps=80"},
                         .tols = {1e-1, 1e-3},
                         .step_factors = {1},
                         .overlaps = {},
                         .shorten = true};
  EXPECT_EQ(run_trade(options).scenes[0].num_steps, 80);  // a length that was asked for stays
  std::string text = kFalling;
  text.replace(text.find("steps = 80"), 10, "steps = 400000");
  options.targets = {scene_file(folder, "long", text)};
  options.time_limit = 1;
  options.step_factors = {8, 1, 0.5};
  const Trade trade = run_trade(options);
  EXPECT_LT(trade.scenes[0].num_steps, 400000);
  EXPECT_EQ(trade.scenes[0].num_steps % 8, 0);
  EXPECT_EQ(trade.scenes[0].whole_steps, 400000);
}

TEST_F(TradeRun, AClusterIsOneBody) {
  // A dumbbell of 3 kg falls flat on a floor 5 mm below, without restitution: it loses m g h, lies
  // with its centre of mass a radius above its lowest point, and the floor carries it. Springs have
  // no clusters.
  Trade::Options options;
  options.targets = {scene_file(folder, "dumbbell", R"(
contact = {mu = 0.3}
clusters = [{parts = [[-0.1, 0, 0.1], [0.1, 0, 0.1]], position = [0, 0.105], mass = 3}]
walls = [{point = [0, 0], normal = [0, 1]}]
time = {step = 1e-4, steps = 500}
)")};
  options.tols = {1e-8};
  options.step_factors = {1};
  options.overlaps = {1e-2};
  const Trade trade = run_trade(options);
  const Trade::Scene& scene = trade.scenes.at(0);
  const Trade::Row& run = trade.rows.at(0);
  ASSERT_EQ(run.status, "completed") << run.message;
  EXPECT_NEAR(run.values[index_of(scene.quantities, "energy lost")], 3 * 9.81 * 0.005,
              0.01 * 3 * 9.81 * 0.005);
  EXPECT_NEAR(run.values[index_of(scene.quantities, "centre of mass")], 0.1, 1e-12);
  EXPECT_NEAR(run.values[index_of(scene.quantities, "floor load")], 1, 1e-6);
  EXPECT_EQ(trade.rows.back().setting.model, Model::kSpringDashpot);
  EXPECT_EQ(trade.rows.back().status, "not run");
  EXPECT_TRUE(says(trade.rows.back().message, "clusters"));
}

constexpr const char* kLeaves = R"(
outlets = [{point = [0.31, 0], normal = [-1, 0]}]
walls = [{point = [0, 0], normal = [0, 1]}]
disks = [{position = [0, 0.1], radius = 0.1, mass = 1, velocity = [10, 0]},
         {position = [0.3, 0.1], radius = 0.1, mass = 1, velocity = [10, 0]}]
time = {step = 1e-3, steps = 61}
)";

// After 60 steps both have left: the mass is known, places are not. The scene's 61 steps are no
// whole number of twice as long ones.
TEST_F(TradeRun, WhatHasLeftIsCountedAndDurationsAreEqual) {
  Trade::Options options = options_of(scene_file(folder, "leaves", kLeaves), {1e-2, 1e-6});
  options.step_factors = {2, 1, 0.5};
  options.accuracies = {};
  const Trade trade = run_trade(options);
  const auto& quantities = trade.scenes.at(0).quantities;
  int run = 0;
  for (const Trade::Row& row : trade.rows) {
    if (row.setting.step_factor == 2) {
      EXPECT_EQ(row.status, "not run");
      EXPECT_TRUE(says(row.message, "whole number of steps")) << row.message;
      continue;
    }
    ++run;
    EXPECT_EQ(row.status, "completed") << row.message;
    EXPECT_NEAR(row.simulated, 0.061, 1e-12);
    EXPECT_EQ(row.values[index_of(quantities, "outflow")], 2);
    EXPECT_EQ(row.values[index_of(quantities, "energy lost")], 0);
    for (const char* place : {"height", "centre of mass", "pressure"}) {
      EXPECT_TRUE(std::isnan(row.values[index_of(quantities, place)])) << place;
    }
  }
  EXPECT_EQ(run, 3);
}

TEST_F(TradeRun, SpringsThatDoNotFitTheSceneAreNotRun) {
  const std::pair<const char*, const char*> kCases[] = {
      {"cell = {width = 1}", "periodic"},
      {"outlets = [{point = [0, -1], normal = [0, 1]}]", "outlets"},
      {"walls = [{point = [0, -1], normal = [0, 1], removed = 1}]", "removed"}};
  for (const auto& [text, reason] : kCases) {
    Trade::Options options;
    options.targets = {scene_file(folder, "falls",
                                  fmt::format(R"(
{}
disks = [{{position = [0.5, 0], radius = 0.1, mass = 1}}]
time = {{step = 1e-3, steps = 2}}
)",
                                              text))};
    options.tols = {1e-2};
    options.step_factors = {1};
    options.overlaps = {1e-2};
    const Trade trade = run_trade(options);
    EXPECT_EQ(trade.rows.back().setting.model, Model::kSpringDashpot);
    EXPECT_EQ(trade.rows.back().status, "not run");
    std::string report = to_text(trade_document(FinishedTrade(trade)));
    std::ranges::replace(report, '\n', ' ');
    EXPECT_TRUE(says(report, "not run: " + trade.rows.back().message)) << report;
    EXPECT_TRUE(says(trade.rows.back().message, reason)) << trade.rows.back().message;
  }
}

TEST_F(TradeRun, BallAndSliderAreMeasuredAgainstTheory) {
  Trade::Options options{.targets = {"bouncing_ball", "sliding_cylinder"},
                         .tols = {1e-8},
                         .step_factors = {2, 1},
                         .accuracies = {1e-2},
                         .overlaps = {1e-4}};
  const Trade trade = run_trade(options);
  ASSERT_EQ(trade.rows.size(), 8u);
  for (const Trade::Row& row : trade.rows) {
    const auto& scene = row.scene == "bouncing_ball" ? trade.scenes[0] : trade.scenes[1];
    EXPECT_EQ(row.status, "completed");
    for (std::size_t q = 0; q < row.values.size(); ++q) {
      EXPECT_NEAR(row.values[q] / scene.quantities[q].exact, 1, row.setting.dem() ? 5e-3 : 2e-3)
          << row.setting.label() << " " << scene.quantities[q].name;
    }
  }
  ASSERT_EQ(trade.scenes[0].quantities.size(), 4u);
  EXPECT_NEAR(trade.scenes[0].quantities[0].exact, 0.081, 1e-12);   // 0.1 x 0.9²
  EXPECT_NEAR(trade.scenes[0].quantities[3].exact, 0.23132, 1e-5);  // 2 x 0.81 √(0.2/9.81)
  EXPECT_NEAR(trade.scenes[1].quantities[0].exact, 2.0 / 3, 1e-12);
  EXPECT_NEAR(trade.scenes[1].quantities[1].exact, 1 / (3 * 0.5 * 9.81), 1e-12);
  for (const SceneTrade& s : analyse_trade(trade)) {
    for (const SceneTrade::Errors& e : s.quantities) EXPECT_EQ(e.reference_kind, "exact");
  }
}

TEST(TradeReport, NamesEveryRunAndNoNumberThatIsNone) {
  Trade trade = manufactured(1, 0, by_solver_and_step);
  trade.scenes[0].title = "<made>";
  trade.scenes[0].target = "made.toml";
  trade.rows[0].status = "time limit";
  trade.rows[0].message = "5 s were up";
  trade.rows[0].values = {kNaN};
  FinishedTrade finished(trade);
  finished.made = provenance("trade", "bipot trade made.toml");
  finished.command_of_scene = "bipot trade {}";
  const std::string csv = to_csv(outcome_table(trade));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 7);
  const Json json = Json::parse(json_text(to_json(finished)));
  EXPECT_EQ(json["rows"].size(), 7u);
  EXPECT_TRUE(json["rows"][0]["values"][0].is_null());
  EXPECT_EQ(json["scenes"][0]["settings"].size(), 7u);
  const std::string page = to_html(trade_page(finished));
  EXPECT_EQ(markup_defect(page), "");
  EXPECT_TRUE(says(page, "<h3 id=\"scene-1\">&lt;made&gt;</h3>"));
  EXPECT_TRUE(says(page, "5 s were up"));
  EXPECT_FALSE(says(page, "nan"));
  EXPECT_TRUE(says(page, "bipot trade made.toml"));
  EXPECT_EQ(page.find("http"), page.find("http://www.w3.org"));  // nothing from elsewhere
  EXPECT_TRUE(says(to_text(trade_document(finished)), "time limit"));
}

}  // namespace
}  // namespace bipot
