#include "bench/tune/measure_rows.h"

#include <fstream>

#include "core/files/input_file.h"
#include "core/motion/time_stepping.h"
#include "solvers/solve.h"
#include "tests/support/manufactured.h"
#include "tests/support/small_problems.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

/// A triangular lattice on a slope of 10 degrees; the target tells of which scene.
ProblemSource lattice(const std::string& name, const std::string& target, int side = 6,
                      double mu = 0.3) {
  return {name, target,
          [=] { return TestProblem{.problem = lattice_step(Lattice::kTriangular, side, mu, 10)}; }};
}

struct MeasureRows : testing::Test {
  const TemporaryFolder folder;

  MeasureOptions options_of(const std::string& solver) const {
    return {.variants = tuned_variants({solver}), .file = folder / "rows.csv"};
  }
};

TEST_F(MeasureRows, GoesOnFromTheRowsOfAStoppedMeasurement) {
  int loads = 0;
  const ProblemSource source{"lattice@7", "scene.toml", [&] {
                               ++loads;
                               TestProblem made = lattice("", "").load();
                               made.start = solve("pgs", made.problem, {.max_iterations = 3}).s;
                               return made;
                             }};
  MeasureOptions options{.variants = tuned_variants({"anderson", "ipm"})};
  ASSERT_EQ(options.variants.size(), 2u);
  options.tols = {1e-6, 1e-2};
  options.file = folder / "rows.csv";
  int solves = 0;
  options.watch.progress = [&](long, long, const std::string&) { ++solves; };
  options.watch.interrupted = [&] { return solves >= 2; };
  EXPECT_EQ(measure_rows({source}, options).size(), 4u);  // auto and anderson, cold
  options.watch.interrupted = nullptr;
  const std::vector<MeasuredRow> rows = measure_rows({source}, options);
  EXPECT_EQ(loads, 2);
  EXPECT_EQ(solves, 6);
  ASSERT_EQ(rows.size(), 12u);  // three variants, two tolerances, two starts
  for (const MeasuredRow& row : rows) {
    EXPECT_TRUE(row.solved) << row.variant;
    EXPECT_GT(row.seconds, 0);
    EXPECT_GT(row.iterations, 0);
    EXPECT_EQ(row.scene, "lattice");
    EXPECT_TRUE(row.traits.marks & kDisks);
  }
  EXPECT_EQ(measure_rows({source}, options).size(), 12u);
  EXPECT_EQ(solves, 6);
  EXPECT_EQ(loads, 3);  // the problem is looked at: another one may have that name now
  // An editor put UTF-8's mark before the text, and the last line was cut off: that row alone is
  // measured again.
  const std::string text = read_text_file(options.file);
  std::ofstream(options.file) << "\xEF\xBB\xBF" << text.substr(0, text.size() - 3);
  EXPECT_EQ(measure_rows({source}, options).size(), 12u);
  EXPECT_EQ(solves, 7);
  EXPECT_EQ(read_measured_rows(options.file).size(), 12u);
}

TEST_F(MeasureRows, RowsOfAnotherProblemOfThatNameAreRefused) {
  const auto measure = [&](int side, double mu) {
    measure_rows({lattice("lattice", "lattice.hdf5", side, mu)}, options_of("ipm"));
  };
  measure(6, 0.3);
  EXPECT_THROW(measure(7, 0.3), std::invalid_argument);
  EXPECT_THROW(measure(6, 0.4), std::invalid_argument);  // with as many contacts
  EXPECT_NO_THROW(measure(6, 0.3));
}

TEST_F(MeasureRows, AStepThatASceneDoesNotReachIsLeftOut) {
  const ProblemSource fails{"bullet@200", "bullet.toml", []() -> TestProblem {
                              throw StepFailure(StepFailure::Kind::kPassage,
                                                "step 150: through a wall");
                            }};
  std::string told;
  MeasureOptions options = options_of("ipm");
  options.warn = [&](const std::string& text) { told = text; };
  EXPECT_EQ(measure_rows({fails, lattice("lattice", "lattice")}, options).size(), 6u);
  EXPECT_TRUE(says(told, "bullet@200 is left out: step 150"));
}

/// Rows have the dimension without rolling.
TEST_F(MeasureRows, RowsOfRollingContactsAreTakenUpAgain) {
  const ProblemSource source{
      "rolls", "rolls.hdf5",
      [] { return TestProblem{.problem = manufactured_rolling(6, 4, 6, 1).problem}; }};
  const std::size_t rows = measure_rows({source}, options_of("pgs")).size();
  EXPECT_GT(rows, 0u);
  EXPECT_EQ(measure_rows({source}, options_of("pgs")).size(), rows);
}

/// Failures count for the time that they had.
TEST_F(MeasureRows, MoreTimeMeasuresFailuresAgain) {
  const ProblemSource source = lattice("seed1@7", "seed1.toml", 12);
  MeasureOptions options = options_of("uzawa");
  options.tols = {1e-6};
  options.time_limit = 1e-4;
  for (const MeasuredRow& row : measure_rows({source}, options)) {
    EXPECT_EQ(row.scene, "seed1");  // seed2.toml is another scene
    EXPECT_TRUE(row.variant == "auto" || !row.solved);
  }
  options.time_limit = 60;
  const std::vector<MeasuredRow> rows = measure_rows({source}, options);
  EXPECT_TRUE(rows.back().variant == "uzawa" && rows.back().solved);
  EXPECT_EQ(measure_rows({source}, options).size(), rows.size());
}

TEST_F(MeasureRows, TheLooserToleranceIsMetOnTheWay) {
  const ProblemSource source = lattice("lattice", "lattice", 12);
  MeasureOptions options = options_of("apgd");
  options.tols = {1e-2, 1e-8};
  int loose = 0, tight = 0;
  for (const MeasuredRow& row : measure_rows({source}, options)) {
    if (row.variant == "apgd") (row.traits.tol == 1e-2 ? loose : tight) = row.iterations;
  }
  EXPECT_GT(loose, 0);
  EXPECT_GT(tight, loose);
  EXPECT_THROW(tuned_variants({"apgt"}), std::invalid_argument);
  EXPECT_THROW(tuned_variants({"apgd", "ipm", "apgd"}), std::invalid_argument);
  options.tols = {1e-2, 1e-2};
  options.file = folder / "once.csv";
  EXPECT_EQ(measure_rows({source}, options).size(), 3u);  // of auto and two of apgd, cold
}

}  // namespace
}  // namespace bipot
