#include "bench/study/study.h"

#include <nlohmann/json.hpp>

#include "core/files/atomic_file.h"
#include "core/files/input_file.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

const Study::Stopped kNever = [] { return false; };

const Study::Part& part_called(const std::string& name) {
  return *std::ranges::find(Study::parts(), name, &Study::Part::name);
}

Study::Job job(int seed, int& runs, double value = 0) {
  return {{"thresholds", "pour", 9, seed, "apgd", 0.1, 0.5}, [&runs, value](const Study::Stopped&) {
            ++runs;
            return Study::Values{{"height", value}, {"with, comma", 1.0 / 3}};
          }};
}

TEST(Study, GoesOnFromTheMeasurementsThatAreComplete) {
  const TemporaryFolder folder;
  const auto rows = folder.path() / "rows.csv";
  int runs = 0;
  ASSERT_TRUE(Study::measure(rows, {job(1, runs, 2.5), job(2, runs)}, {}));
  EXPECT_EQ(runs, 2);
  const Study::Measured measured = Study::read(rows);
  ASSERT_EQ(measured.size(), 2u);
  const Study::Values& first = measured.begin()->second;
  EXPECT_EQ(first.at("height"), 2.5);
  EXPECT_NEAR(first.at("with, comma"), 1.0 / 3, 1e-6);
  EXPECT_GE(first.at("cpu"), 0);

  // The last line loses its end, as if the program had been killed there.
  std::string text = read_text_file(rows);
  text.resize(text.rfind('='));
  write_text_file(rows, text);
  EXPECT_EQ(Study::read(rows).size(), 1u);
  ASSERT_TRUE(Study::measure(rows, {job(1, runs), job(2, runs), job(3, runs)}, {}));
  EXPECT_EQ(runs, 4);  // 2 again, and 3
  EXPECT_EQ(Study::read(rows).size(), 3u);

  // One that is stopped leaves no rows.
  EXPECT_FALSE(Study::measure(rows, {job(4, runs)}, {.interrupted = [] { return true; }}));
  EXPECT_EQ(Study::read(rows).size(), 3u);
}

// Differences -1, 0, 1, 2 over the reference's mean 4: mean 0.5; their standard deviation is
// sqrt(5/3), and Student's t with 3 degrees of freedom 3.182.
TEST(Study, ErrorsArePairedBySeed) {
  Study::Measured measured;
  Study::Case exact{"thresholds", "pour", 9, 0, "apgd", 1e-6, 0}, rough = exact;
  rough.tol = 1;
  const double at[] = {1, 3, 5, 7};
  for (int seed = 1; seed <= 4; ++seed) {
    exact.seed = rough.seed = seed;
    measured[exact]["height"] = at[seed - 1];
    measured[rough]["height"] = at[seed - 1] + seed - 2;
  }
  rough.seed = 9;  // without a partner
  measured[rough]["height"] = 100;
  Study::Case other = exact;
  other.scene = "shear";
  measured[other]["height"] = 1000;
  const Study::PairedError e = paired_error(measured, rough, exact, "height");
  EXPECT_NEAR(e.error, 0.5 / 4, 1e-12);
  EXPECT_NEAR(e.bar, 3.18245 * std::sqrt(5.0 / 3 / 4) / 4, 1e-5);
}

// Logarithms 0, 1, 2: mean 1, standard deviation 1, Student's t with 2 degrees of freedom 4.3027.
TEST(Study, GeometricMeansHaveTheIntervalOfTheLogarithms) {
  const Study::Geometric mean =
      geometric_mean({{1, 1}, {2, std::numbers::e}, {3, std::exp(2.0)}, {4, 0}, {5, kNaN}});
  EXPECT_EQ(mean.seeds, 3);
  EXPECT_NEAR(std::log(mean.mean), 1, 1e-12);
  EXPECT_NEAR(std::log(mean.low), 1 - 4.30265 / std::sqrt(3.0), 1e-4);
  EXPECT_NEAR(std::log(mean.high), 1 + 4.30265 / std::sqrt(3.0), 1e-4);
}

// Errors of the same flow: the solver's part falls with the tolerance and the step's part with the
// step; their sum bounds the whole. Springs end near the rigid reference.
TEST(Study, PathsTellTheErrorOfTheStepFromTheSolvers) {
  std::map<std::pair<double, double>, Study::Values> rigid;
  Study::Values springs;
  for (const Study::Job& j : part_called("paths").jobs(true)) {
    if (j.of.scene != "collapse" || j.of.seed != 1) continue;
    const Study::Values values = j.run(kNever);
    ASSERT_FALSE(values.contains("failed")) << j.of.method;
    (j.of.method == "dem" ? springs : rigid[{j.of.x, j.of.tol}]) = values;
  }
  ASSERT_EQ(rigid.size(), 4u);
  const auto solver_error = [&](double factor, double tol) {
    return rigid[std::pair(factor, tol)]["solver_error"];
  };
  for (const double factor : {2.0, 0.5}) {
    EXPECT_LT(solver_error(factor, 1e-2), solver_error(factor, 1));
    for (const double tol : {1.0, 1e-2}) {
      auto& of = rigid[std::pair(factor, tol)];
      EXPECT_LE(of["error"], of["solver_error"] + of["step_error"]) << factor << " " << tol;
    }
  }
  const std::pair<double, double> fine{0.5, 1}, coarse{2, 1};
  EXPECT_LT(rigid[fine]["step_error"], 0.5 * rigid[coarse]["step_error"]);
  EXPECT_LT(springs.at("error"), 0.1);
  EXPECT_LE(springs.at("error"), springs.at("own_error") + springs.at("law_error"));
}

// Error of the step 0.1 h, of the solver 0.02 ε: both are equal at ε = 5 h. Rigid contacts cost
// 1 ms / h, so 1/3 ms at an error of 0.3; springs with the error 20 o cost 30 us / o, at o = 0.015
// then 2 ms, six times more.
TEST(Study, PathsAreBalancedAndComparedAtEqualError) {
  Study::Measured measured;
  for (int seed = 1; seed <= 3; ++seed) {
    for (const double h : {1.0, 2.0, 4.0}) {
      for (const double tol : {0.1, 1.0, 100.0}) {
        measured[{"paths", "pour", 64, seed, "apgd", tol, h}] = {{"error", 0.1 * h},
                                                                 {"step_error", 0.1 * h},
                                                                 {"solver_error", 0.02 * tol},
                                                                 {"overlap", 0.1},
                                                                 {"cpu", 1e-3 / h}};
      }
    }
    for (const double overlap : {0.03, 0.01, 0.003}) {
      measured[{"paths", "pour", 64, seed, "dem", overlap, 1}] = {{"error", 20 * overlap},
                                                                  {"own_error", 20 * overlap},
                                                                  {"law_error", 0.02},
                                                                  {"overlap", overlap},
                                                                  {"cpu", 3e-5 / overlap}};
    }
  }
  const Json told = to_json(part_called("paths").report(measured));
  ASSERT_EQ(told["balance"].size(), 3u);
  for (const Json& row : told["balance"]) {
    EXPECT_NEAR(row.at("balance").get<double>(), 5 * row.at("step_factor").get<double>(), 1e-9);
  }
  const Json& orders = told["orders"][0];
  for (const char* exponent : {"p", "q", "r"})
    EXPECT_NEAR(orders.at(exponent).get<double>(), 1, 1e-9);
  EXPECT_NEAR(told["laws_of_contact"][0]["c"].get<double>(), -1, 1e-9);
  const Json& at_equal_error = told["cheapest"][0];
  EXPECT_EQ(at_equal_error.at("wanted"), 0.3);
  EXPECT_NEAR(at_equal_error.at("ratio").get<double>(), 6, 1e-9);
  EXPECT_EQ(at_equal_error.at("bounds"), 0);
}

TEST(Study, EveryPartHasJobsOfItsOwnNameAndDrawsWhatThereIs) {
  for (const Study::Part& part : Study::parts()) {
    const std::vector<Study::Job> all = part.jobs(false), quick = part.jobs(true);
    EXPECT_GT(all.size(), quick.size()) << part.name;
    std::set<Study::Case> cases;
    for (const Study::Job& j : all) {
      EXPECT_EQ(j.of.part, part.name);
      EXPECT_TRUE(cases.insert(j.of).second) << part.name << " measures a case twice";
    }
    EXPECT_NO_THROW(to_text(part.report({}))) << part.name;
  }
}

// Disks in a box at rest: the height is that of a dense filling, the floor and the walls carry the
// weight, and friction is within its bound. A run at a loose tolerance has larger overlaps.
TEST(Study, QuantitiesOfAPourAreThoseOfAPackingAtRest) {
  const Study::Sample sample{.scene = "pour", .size = 25};
  const Study::Values tight = Study::run(sample, {.solver = "apgd", .tol = 1e-4}, kNever);
  // The area of the disks over the width of 5 at a fraction from 0.7 to 0.9, halved.
  EXPECT_GT(tight.at("height"), 0.5 * 25 * 0.257 * std::numbers::pi / 5 / 0.9);
  EXPECT_LT(tight.at("height"), 0.5 * 25 * 0.257 * std::numbers::pi / 5 / 0.65);
  EXPECT_LT(std::abs(tight.at("wall_share")), 1);
  EXPECT_GE(tight.at("sliding_share"), 0);
  EXPECT_LT(tight.at("sliding_share"), 1);
  const Study::Values loose = Study::run(sample, {.solver = "apgd", .tol = 10}, kNever);
  EXPECT_GT(loose.at("overlap"), tight.at("overlap"));
}

// Closed form of a column of grains: the first step from rest loads the floor with the weight
// where the walls have no friction, and the sweeps grow with the height.
TEST(Study, ColumnsWithoutFrictionStandOnTheirFloor) {
  std::map<double, double> sweeps;
  for (const Study::Job& j : part_called("depth").jobs(true)) {
    if (j.of.scene != "crystalline:mu_wall=0" || j.of.method != "pgs" || j.of.tol != 1e-4) continue;
    const Study::Values values = j.run(kNever);
    EXPECT_NEAR(values.at("floor_share"), 1, 1e-2);
    EXPECT_EQ(values.at("unsolved"), 0);
    sweeps[j.of.x] = values.at("iterations");
  }
  ASSERT_EQ(sweeps.size(), 3u);
  // N²: four times the height, sixteen times the sweeps, less the criterion's cadence.
  EXPECT_GT(sweeps[4], 8 * sweeps[1]);
}

}  // namespace
}  // namespace bipot
