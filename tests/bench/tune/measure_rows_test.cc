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

TEST(MeasureRows, GoesOnFromTheRowsOfAStoppedMeasurement) {
  const TemporaryFolder folder;
  int loads = 0;
  const ProblemSource source{"lattice@7", "scene.toml", [&] {
                               ++loads;
                               TestProblem made;
                               made.problem = lattice_step(Lattice::kTriangular, 6, 0.3, 10);
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

TEST(MeasureRows, RowsOfAnotherProblemOfThatNameAreRefused) {
  const TemporaryFolder folder;
  int side = 6;
  const ProblemSource source{
      "lattice", "lattice.hdf5",
      [&] { return TestProblem{.problem = lattice_step(Lattice::kTriangular, side, 0.3, 10)}; }};
  const MeasureOptions options{.variants = tuned_variants({"ipm"}), .file = folder / "rows.csv"};
  measure_rows({source}, options);
  side = 7;
  EXPECT_THROW(measure_rows({source}, options), std::invalid_argument);
  // With as many contacts but more friction.
  const ProblemSource rough{
      "lattice", "lattice.hdf5",
      [] { return TestProblem{.problem = lattice_step(Lattice::kTriangular, 6, 0.4, 10)}; }};
  EXPECT_THROW(measure_rows({rough}, options), std::invalid_argument);
  side = 6;
  EXPECT_NO_THROW(measure_rows({source}, options));
}

TEST(MeasureRows, AStepThatASceneDoesNotReachIsLeftOut) {
  const TemporaryFolder folder;
  const ProblemSource fails{"bullet@200", "bullet.toml", []() -> TestProblem {
                              throw StepFailure(StepFailure::Kind::kPassage,
                                                "step 150: through a wall");
                            }};
  const ProblemSource lattice{
      "lattice", "lattice",
      [] { return TestProblem{.problem = lattice_step(Lattice::kTriangular, 6, 0.3, 10)}; }};
  std::string told;
  const MeasureOptions options{.variants = tuned_variants({"ipm"}),
                               .file = folder / "rows.csv",
                               .watch = {},
                               .warn = [&](const std::string& text) { told = text; }};
  EXPECT_EQ(measure_rows({fails, lattice}, options).size(), 6u);
  EXPECT_TRUE(says(told, "bullet@200 is left out: step 150"));
}

/// Rows have the dimension without rolling.
TEST(MeasureRows, RowsOfRollingContactsAreTakenUpAgain) {
  const TemporaryFolder folder;
  const ProblemSource source{
      "rolls", "rolls.hdf5",
      [] { return TestProblem{.problem = manufactured_rolling(6, 4, 6, 1).problem}; }};
  const MeasureOptions options{.variants = tuned_variants({"pgs"}), .file = folder / "rows.csv"};
  const std::size_t rows = measure_rows({source}, options).size();
  EXPECT_GT(rows, 0u);
  EXPECT_EQ(measure_rows({source}, options).size(), rows);
}

/// Failures count for the time that they had.
TEST(MeasureRows, MoreTimeMeasuresFailuresAgain) {
  const TemporaryFolder folder;
  const ProblemSource source{
      "seed1@7", "seed1.toml",
      [] { return TestProblem{.problem = lattice_step(Lattice::kTriangular, 12, 0.3, 10)}; }};
  MeasureOptions options{.variants = tuned_variants({"uzawa"}),
                         .tols = {1e-6},
                         .time_limit = 1e-4,
                         .file = folder / "rows.csv"};
  for (const MeasuredRow& row : measure_rows({source}, options)) {
    EXPECT_EQ(row.scene, "seed1");  // seed2.toml is another scene
    if (row.variant == "uzawa") EXPECT_FALSE(row.solved);
  }
  options.time_limit = 60;
  const std::vector<MeasuredRow> rows = measure_rows({source}, options);
  EXPECT_TRUE(rows.back().variant == "uzawa" && rows.back().solved);
  EXPECT_EQ(measure_rows({source}, options).size(), rows.size());
}

TEST(MeasureRows, TheLooserToleranceIsMetOnTheWay) {
  const TemporaryFolder folder;
  const ProblemSource source{
      "lattice", "lattice",
      [] { return TestProblem{.problem = lattice_step(Lattice::kTriangular, 12, 0.3, 10)}; }};
  MeasureOptions options{
      .variants = tuned_variants({"apgd"}), .tols = {1e-2, 1e-8}, .file = folder / "rows.csv"};
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
