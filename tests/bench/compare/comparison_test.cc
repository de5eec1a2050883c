#include "bench/compare/comparison.h"

#include <Eigen/Dense>
#include <nlohmann/json.hpp>

#include "bench/compare/comparison_report.h"
#include "bench/compare/comparison_rows.h"
#include "bench/compare/warm_gain.h"
#include "bench/measure/true_error.h"
#include "core/base/file_error.h"
#include "core/base/triplets.h"
#include "core/criterion/contact_error.h"
#include "core/files/input_file.h"
#include "core/problem_files/fclib_file.h"
#include "solvers/solve.h"
#include "tests/bench/compare/quick_comparison.h"
#include "tests/support/markup_defect.h"
#include "tests/support/naive_error.h"
#include "tests/support/small_problems.h"
#include "tests/support/source_folder.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

ProblemSource source_of(const std::string& name, const ContactProblem& problem) {
  return {name, name, [problem] {
            return TestProblem{
                .origin = "test", .problem = problem, .step = 0.01, .smallest_radius = 0.5};
          }};
}

const Comparison::Row& row_of(const Comparison& c, const std::string& solver, double tol) {
  for (const Comparison::Row& row : c.rows) {
    if (row.solver == solver && row.tol == tol) return row;
  }
  throw std::out_of_range(solver);
}

/// Everything but the times, which no two runs share.
std::string without_times(std::vector<Comparison::Row> rows) {
  std::string text;
  for (Comparison::Row& row : rows) {
    row.total_min = row.setup_min = row.setup_median = row.solve_min = row.solve_median =
        row.cpu_min = 0;
    text += to_csv(row) + '\n';
  }
  return text;
}

TEST(Comparison, HasARowForEachProblemSolverAndTolerance) {
  const auto sources = expand_targets({"square:4", "triangular:4:tilt=10"});
  const Comparison c = compare(sources, quick({"pgs", "ipm"}, {1e-8, 1e-2}));
  ASSERT_TRUE(c.complete);
  ASSERT_EQ(c.rows.size(), 8u);
  EXPECT_EQ(c.rows[0].problem, "square:4");
  EXPECT_EQ(c.rows[0].tol, 1e-2);  // from loose to tight, whatever the order of the flags
  for (const Comparison::Row& row : c.rows) {
    EXPECT_EQ(row.status, "converged") << row.solver << ": " << row.message;
    EXPECT_LE(row.guarded, row.tol);
    EXPECT_GT(row.total_min, 0);
    EXPECT_EQ(row.take_off + row.stick + row.slip, row.contacts);
  }
  ASSERT_EQ(c.problems.size(), 2u);
  for (const Comparison::Problem& p : c.problems)
    EXPECT_LE(p.reference.error.guarded(), 1e-12) << p.name;
  EXPECT_EQ(count_solved(c, 1e-8)[0].solved, 2);
}

TEST(Comparison, JudgesSolversThatACallerBringsAlong) {
  const auto solves =
      run_of([](const ContactProblem& p, const SolverOptions& o) { return solve("ipm", p, o); });
  const auto lies = run_of([](const ContactProblem& p, const SolverOptions&) {
    return SolveResult{.status = SolveStatus::kConverged, .s = Vector::Zero(p.num_rows())};
  });
  Comparison::Options options = quick({"pgs"}, {1e-6});
  options.foreign = {{.name = "honest", .run = solves}, {.name = "liar", .run = lies}};
  const Comparison c = compare(expand_targets({"square:4"}), options);
  ASSERT_EQ(c.rows.size(), 3u);
  EXPECT_EQ(row_of(c, "honest", 1e-6).status, "converged");
  EXPECT_LE(row_of(c, "honest", 1e-6).guarded, 1e-6);
  EXPECT_EQ(row_of(c, "liar", 1e-6).status, "numerical failure");
  EXPECT_GT(row_of(c, "liar", 1e-6).guarded, 1);
  options.foreign[0].name = "pgs";
  EXPECT_THROW(compare({}, options), std::invalid_argument);
  options.foreign[0].name = "liar";
  EXPECT_THROW(compare({}, options), std::invalid_argument);
}

TEST(Comparison, AProblemWithoutContactsKeepsItsDimension) {
  ContactProblem free{.dim = 1};
  const Comparison c = compare({source_of("free", free)}, quick({"pgs"}, {1e-3}));
  ASSERT_EQ(c.rows.size(), 1u);
  EXPECT_EQ(c.rows[0].status, "nothing to do");
  EXPECT_EQ(c.rows[0].contacts, 0);
  EXPECT_EQ(c.rows[0].dim, 1);
}

TEST(Comparison, RowsSayWhatASolveOfTheirOwnSays) {
  const ContactProblem problem = lattice_step(Lattice::kTriangular, 5, 0.3, 20);
  const Comparison c = compare({source_of("t5", problem)}, quick({"pgs"}, {1e-3}));
  const SolveResult alone = solve("pgs", problem, {.tol = 1e-3});
  ASSERT_EQ(c.rows.size(), 1u);
  EXPECT_EQ(c.rows[0].iterations, alone.iterations);
  const NaiveError naive = naive_error(problem, alone.s);
  EXPECT_NEAR(c.rows[0].guarded, naive.guarded(), 1e-9 * naive.guarded());
  EXPECT_NEAR(c.rows[0].natural_map, naive.natmap_scaled, 1e-9 * naive.natmap_scaled);
}

TEST(ReferenceSolution, MeetsItsErrorInTheNaiveCriterion) {
  TestProblem given{.problem = lattice_step(Lattice::kTriangular, 5, 0.3, 20)};
  const ReferenceSolution reference = find_reference(given, 20);
  EXPECT_LE(reference.error.guarded(), 1e-12);
  // The naive criterion rounds differently at this size.
  EXPECT_LE(naive_error(given.problem, reference.s).guarded(), 1e-11);
  EXPECT_GE(reference.attempts.size(), 2u);
  EXPECT_LE(reference.velocity_spread, 1e-8);
}

TEST(TrueError, AgreesWithDenseMatrices) {
  TestProblem given{.problem = lattice_step(Lattice::kTriangular, 4, 0.3, 20),
                    .step = 0.01,
                    .smallest_radius = 0.5};
  const ContactProblem& p = given.problem;
  const ReferenceSolution reference = find_reference(given, 20);
  const Vector s = solve("pgs", p, {.tol = 1e-2}).s;
  const TrueError error = TrueErrorEvaluator(given, reference)(s);

  const Eigen::MatrixXd A(p.A), H(p.H);
  const Eigen::VectorXd v = p.v_free + A.inverse() * H * s;
  const Eigen::VectorXd v_ref = p.v_free + A.inverse() * H * reference.s;
  const auto energy = [&](const Eigen::VectorXd& x) { return x.dot(A * x); };
  EXPECT_NEAR(error.velocity, std::sqrt(energy(v - v_ref) / energy(v_ref - p.v_free)), 1e-9);
  EXPECT_GT(error.velocity, 1e-6);
  const double kinetic = 0.5 * (energy(p.v_free) - energy(v));
  EXPECT_NEAR(error.dissipated, kinetic, 1e-9 * std::abs(kinetic));
  const double kinetic_ref = 0.5 * (energy(p.v_free) - energy(v_ref));
  EXPECT_NEAR(error.energy, std::abs(kinetic - kinetic_ref) / std::abs(kinetic_ref), 1e-9);
  double worst = 0, largest = 0;
  const Eigen::VectorXd f = H * (s - reference.s), f_ref = H * reference.s;
  for (Eigen::Index b = 0; b + 2 < f.size(); b += 3) {
    worst = std::max(worst, std::hypot(f[b], f[b + 1]));
    largest = std::max(largest, std::hypot(f_ref[b], f_ref[b + 1]));
  }
  EXPECT_NEAR(error.force, worst / largest, 1e-9);
  const Eigen::VectorXd u = H.transpose() * A.inverse() * H * s + p.u_free;
  double approach = 0;
  for (int c = 0; c < p.num_contacts(); ++c) approach = std::max(approach, -u[2 * c]);
  EXPECT_NEAR(error.penetration_velocity, approach, 1e-12);
  EXPECT_NEAR(error.penetration, approach * 0.01 / 0.5, 1e-14);
}

TEST(TrueError, IsThatOfTheLocalFormWhereNoBodiesAreGiven) {
  TestProblem given, local;
  given.problem = lattice_step(Lattice::kSquare, 4, 0.3, 10);
  local.problem = local_form(given.problem);
  const ReferenceSolution reference = find_reference(given, 20);
  const Vector s = solve("pgs", given.problem, {.tol = 1e-2}).s;
  const TrueError a = TrueErrorEvaluator(given, reference)(s);
  const TrueError b = TrueErrorEvaluator(local, reference)(s);
  EXPECT_NEAR(a.velocity, b.velocity, 1e-9);
  EXPECT_TRUE(std::isfinite(a.force));
  EXPECT_TRUE(std::isnan(b.force));
}

TEST(TrueError, GivesContactForcesOnlyWhereTheyAreUnique) {
  TestProblem packing, single;
  packing.problem = lattice_step(Lattice::kSquare, 4, 0.3, 10);
  single.problem = one_contact_problem(2, 1, 2, 0.3, -1, Vector::Constant(1, 0.1));
  const auto contact_force = [](const TestProblem& given) {
    const ReferenceSolution reference = find_reference(given, 20);
    return TrueErrorEvaluator(given, reference)(0.9 * reference.s).contact_force;
  };
  EXPECT_TRUE(std::isnan(contact_force(packing)));
  EXPECT_NEAR(contact_force(single), 0.1, 1e-9);
}

TEST(BodyRows, FindDrivenWallsBehindTheDisks) {
  // Two disks on four driven walls, whose rows fill another body's place and one more.
  ContactProblem p{.dim = 2,
                   .A = SparseMatrix(10, 10),
                   .v_free = Vector::Zero(10),
                   .u_free = Vector::Constant(8, -1),
                   .mu = Vector::Constant(4, 0.3)};
  p.A.setIdentity();
  Triplets h;
  for (int c = 0; c < 4; ++c) {
    const int disk = 3 * (c / 2), axis = c % 2;
    h.emplace_back(disk + axis, 2 * c, 1.0);
    h.emplace_back(6 + c, 2 * c, -1.0);
    h.emplace_back(disk + 1 - axis, 2 * c + 1, 1.0);
    h.emplace_back(disk + 2, 2 * c + 1, -0.5);
  }
  p.H = from_triplets(10, 8, h);
  ASSERT_EQ(validate(p), "");
  const auto rows = find_body_rows(p);
  ASSERT_TRUE(rows.has_value());
  EXPECT_EQ(rows->bodies, 2);
  EXPECT_EQ(rows->walls, 4);
  p.H *= 1.1;  // no unit normals: not rigid bodies as this program lays them out
  EXPECT_FALSE(find_body_rows(p).has_value());
}

TEST(Comparison, ShowsATimeOutAndDoesNotRepeatItAtTighterTolerances) {
  Comparison::Options options = quick({"uzawa"}, {1e-9, 1e-12});
  options.time_limit = 1e-4;
  const Comparison c = compare(expand_targets({"triangular:20:tilt=10"}), options);
  ASSERT_EQ(c.rows.size(), 2u);
  EXPECT_EQ(c.rows[0].status, "time limit");
  EXPECT_GT(c.rows[0].guarded, 1e-9);
  EXPECT_TRUE(std::isfinite(c.rows[0].velocity_error));
  EXPECT_EQ(c.rows[1].status, "time limit");
  EXPECT_TRUE(c.rows[1].message.starts_with("not run again: out of time at tol 1e-9 "));
  EXPECT_EQ(c.rows[1].guarded, c.rows[0].guarded);
  EXPECT_EQ(count_solved(c, 1e-9)[0].solved, 0);
  EXPECT_TRUE(says(to_text(c), " T "));
}

TEST(Comparison, DoesNotTryLargeProblemsAfterATimeOutOnSmallOnes) {
  const TemporaryFolder folder;
  // What uzawa does in a tenth of a millisecond is not enough for 60 disks.
  Comparison::Options options = quick({"uzawa", "auto"}, {1e-10}, folder / "table");
  options.time_limit = 1e-4;
  const auto sources =
      expand_targets({"triangular:8:tilt=10", "triangular:9:tilt=10", "triangular:9:tilt=5"});
  const Comparison c = compare(sources, options);
  ASSERT_EQ(c.rows.size(), 6u);
  EXPECT_EQ(c.rows[0].status, "time limit");
  EXPECT_EQ(c.rows[2].status, Comparison::Row::kNotTried);
  EXPECT_TRUE(says(c.rows[2].message, "triangular:8:tilt=10"));
  EXPECT_TRUE(std::isnan(c.rows[2].guarded));
  EXPECT_TRUE(std::isnan(c.rows[2].time()));
  EXPECT_EQ(c.rows[2].contacts, c.rows[3].contacts);
  EXPECT_NE(c.rows[3].status, Comparison::Row::kNotTried);  // auto always runs
  EXPECT_EQ(c.rows[4].status, "time limit");                // another series
  EXPECT_EQ(to_csv(compare(sources, options)), to_csv(c));
  options.out.clear();
  options.try_all = true;
  EXPECT_EQ(compare(sources, options).rows[2].status, "time limit");
}

TEST(Comparison, KeepsTheHistoryOfTheTightestSolve) {
  const TemporaryFolder folder;
  Comparison::Options options = quick({"pgs", "ipm"}, {1e-2, 1e-8}, folder / "table");
  const auto sources = expand_targets({"triangular:6:tilt=10"});
  const Comparison c = compare(sources, options);
  ASSERT_EQ(c.histories.size(), 2u);
  for (const Comparison::History& h : c.histories) {
    const Comparison::Row& row = row_of(c, h.solver, 1e-8);
    EXPECT_EQ(h.tol, 1e-8);
    ASSERT_GE(h.points.size(), 3u);
    EXPECT_EQ(h.points.front().iteration, 0);
    EXPECT_EQ(h.points.back().iteration, row.iterations);
    EXPECT_NEAR(h.points.back().guarded(), row.guarded, 1e-6 * row.guarded);
    for (std::size_t k = 1; k < h.points.size(); ++k) {
      EXPECT_GT(h.points[k].iteration, h.points[k - 1].iteration);
    }
  }
  // s = 0 has the error of no contact forces at all.
  const ContactProblem problem = sources[0].load().problem;
  EXPECT_NEAR(c.histories[0].points[0].guarded(),
              naive_error(problem, Vector::Zero(problem.num_rows())).guarded(), 1e-9);
  const Comparison again = compare(sources, options);
  ASSERT_EQ(again.histories.size(), 2u);
  EXPECT_EQ(to_csv(again.histories[1]), to_csv(c.histories[1]));

  // A looser solve that is added later does not replace it.
  options.tols.push_back(1e-4);
  EXPECT_EQ(to_csv(compare(sources, options).histories[1]), to_csv(c.histories[1]));

  // A solve that was cut off and begun again stands twice in the file; its second run counts.
  Comparison::History broken = c.histories[0];
  broken.points.resize(2);
  std::ofstream(folder / "h.csv") << history_csv_header() << '\n'
                                  << to_csv(broken) << to_csv(c.histories[0]);
  const auto read = read_csv_histories(folder / "h.csv");
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(to_csv(read[0]), to_csv(c.histories[0]));
}

TEST(Comparison, RepeatsShortSolves) {
  Comparison::Options options = quick({"pgs"}, {1e-4});
  options.min_time = 0.01;
  const Comparison c = compare(expand_targets({"square:3"}), options);
  EXPECT_GT(c.rows[0].repeats, 3);  // a few microseconds each
  EXPECT_LE(c.rows[0].cpu_min * c.rows[0].repeats, 0.02);
}

TEST(Comparison, ShowsSolversThatRefuseAProblem) {
  const Comparison c = compare(expand_targets({"square:30"}), quick({"lemke", "apgd"}, {1e-2}));
  const Comparison::Row& row = row_of(c, "lemke", 1e-2);
  EXPECT_EQ(row.status, "invalid input");
  EXPECT_TRUE(says(row.message, "at most"));
  EXPECT_TRUE(std::isnan(row.guarded));
  EXPECT_EQ(row_of(c, "apgd", 1e-2).status, "converged");
}

TEST(Comparison, AProblemThatCouldNotBeReadIsReadWhenItGoesOn) {
  const TemporaryFolder folder;
  const fs::path file = folder / "mended.hdf5";
  std::ofstream(file) << "hi";
  Comparison::Options options = quick({"pgs"}, {1e-4}, folder / "out");
  const auto status = [&] {
    return compare(expand_targets({file.string()}), options).rows[0].status;
  };
  EXPECT_EQ(status(), "invalid input");
  fs::copy_file(source_folder() / "data/problems/2d_sliding_cylinder.hdf5", file,
                fs::copy_options::overwrite_existing);
  EXPECT_EQ(status(), "converged");
}

/// All rows are known, but not of this scene: with more friction the reference is none.
TEST(Comparison, RowsOfASceneThatWasEditedAreRefused) {
  const TemporaryFolder folder;
  const fs::path file = folder / "edited.toml";
  std::string text = read_text_file(source_folder() / "data/scenes/compaction_100.toml");
  std::ofstream(file) << text;
  TargetOptions one_step{.scene_problems = 1, .scene_steps = 400};
  const Comparison::Options options = quick({"pgs"}, {1e-4}, folder / "out");
  const auto rows = [&] {
    return compare(expand_targets({file.string()}, one_step), options).rows;
  };
  ASSERT_EQ(rows().size(), 1u);
  EXPECT_EQ(rows().size(), 1u);
  const std::size_t mu = text.find("mu = ");
  ASSERT_NE(mu, std::string::npos);
  text.replace(mu, text.find('\n', mu) - mu, "mu = 0.05");
  std::ofstream(file) << text;
  EXPECT_THROW(rows(), std::invalid_argument);
}

/// A disk goes through a wall in step 150: the step before is a problem, those after it are told.
TEST(Comparison, AStepThatARunDoesNotReachLeavesTheOthers) {
  const TemporaryFolder folder;
  std::ofstream(folder / "bullet.toml") << R"(
gravity = [0, -9.81]
disks = [{position = [0, 0.01], radius = 0.01, mass = 1},
  {position = [1, 1], radius = 0.01, mass = 1, velocity = [100, 0]}]
walls = [{point = [0, 0], normal = [0, 1]}, {from = [16, -5], to = [16, 5]}]
time = {step = 1e-3, steps = 300}
)";
  const auto sources = expand_targets({(folder / "bullet.toml").string()});
  ASSERT_EQ(sources.size(), 3u);  // after 100, 200 and 300 steps
  const Comparison c = compare(sources, quick({"pgs"}, {1e-4}));
  ASSERT_EQ(c.rows.size(), 3u);
  EXPECT_EQ(c.rows[0].status, "converged");
  for (const std::size_t k : {1u, 2u}) {
    EXPECT_EQ(c.rows[k].status, "invalid input");
    EXPECT_TRUE(says(c.problems[k].defect, "step 150")) << c.problems[k].defect;
  }
}

/// Where all contacts stick, the answer stays one with more friction: the problem is another one.
TEST(Comparison, MoreFrictionOrAnotherTiltIsAnotherProblem) {
  const TemporaryFolder folder;
  Comparison::Options options = quick({"pgs"}, {1e-4}, folder / "out");
  const auto rows = [&](double mu, double tilt) {
    return compare({source_of("t", lattice_step(Lattice::kTriangular, 4, mu, tilt))}, options).rows;
  };
  EXPECT_EQ(rows(0.6, 0).size(), 1u);
  EXPECT_EQ(rows(0.6, 0).size(), 1u);
  EXPECT_THROW(rows(0.9, 0), std::invalid_argument);
  EXPECT_THROW(rows(0.6, 15), std::invalid_argument);
  options.tols = {1e-2, 1e-4};  // a row is missing
  EXPECT_THROW(rows(0.6, 15), std::invalid_argument);
}

TEST(Comparison, RowsWithADamagedNumberAreRefused) {
  const TemporaryFolder folder;
  const Comparison::Options options = quick({"pgs"}, {1e-4}, folder / "out");
  const auto sources = expand_targets({"square:4"});
  compare(sources, options);
  const std::string text = read_text_file(folder / "out/rows.csv");
  const std::size_t converged = text.find("converged");
  ASSERT_NE(converged, std::string::npos);
  std::ofstream(folder / "out/rows.csv") << std::string(text).replace(converged + 10, 1, "x");
  EXPECT_THROW(compare(sources, options), FileError);
}

TEST(Comparison, ProblemsWhoseNamesBecomeTheSameFileNameHaveTwoFiles) {
  const TemporaryFolder folder;
  const auto made = expand_targets({"square:4", "pyramid:3"});
  const ContactProblem first = made[0].load().problem, second = made[1].load().problem;
  Comparison::Options options = quick({"pgs"}, {1e-2}, folder.path());
  compare({source_of("a b", first), source_of("a_b", second)}, options);
  const auto contacts = [&](const char* file) {
    return read_reference(options.out / "references" / file).contacts;
  };
  EXPECT_EQ(contacts("a_b.json"), first.num_contacts());
  EXPECT_EQ(contacts("a_b~2.json"), second.num_contacts());
  EXPECT_TRUE(fs::exists(folder / "problems/a_b~2.hdf5"));
}

TEST(Comparison, GoesOnWhereItWasStopped) {
  const TemporaryFolder folder;
  const auto sources = expand_targets({"square:4", "pyramid:4"});
  Comparison::Options options = quick({"pgs", "apgd", "lemke"}, {1e-2, 1e-6});
  const Comparison whole = compare(sources, options);

  options.out = folder / "table";
  int rows = 0;
  options.on_row = [&rows](const Comparison::Row&, int, int) { ++rows; };
  options.watch.interrupted = [&rows] { return rows == 5; };
  const Comparison stopped = compare(sources, options);
  EXPECT_FALSE(stopped.complete);
  EXPECT_EQ(stopped.rows.size(), 5u);
  options.watch = {};
  // The program died in the middle of a line.
  std::ofstream(options.out / "rows.csv", std::ios::app) << "\"pyramid:4\",\"pg";
  const Comparison resumed = compare(sources, options);
  EXPECT_TRUE(resumed.complete);
  EXPECT_EQ(resumed.rows_kept, 5);
  EXPECT_EQ(without_times(resumed.rows), without_times(whole.rows));

  // Nothing is left to do: the same table to the last character, problems untouched.
  auto closed = sources;
  for (ProblemSource& source : closed) {
    source.load = []() -> TestProblem { throw std::logic_error("made again"); };
  }
  const Comparison again = compare(closed, options);
  EXPECT_EQ(again.rows_kept, static_cast<int>(whole.rows.size()));
  EXPECT_EQ(to_csv(again), to_csv(resumed));
  EXPECT_EQ(again.problems[1].reference.error.guarded(),
            resumed.problems[1].reference.error.guarded());
  EXPECT_EQ(read_csv_rows(options.out / "rows.csv").size(), whole.rows.size());

  options.time_limit = 7;
  EXPECT_THROW(compare(sources, options), std::invalid_argument);
}

/// A problem whose step before left its solution.
ProblemSource started_at_its_solution(const std::string& name, const ContactProblem& problem) {
  const Vector start = solve("ipm", problem, {.tol = 1e-13}).s;
  return {name, name, [problem, start] {
            return TestProblem{.origin = "test", .problem = problem, .start = start};
          }};
}

TEST(Comparison, HasWarmRowsBesideTheColdOnesWhereAProblemHasAStart) {
  const TemporaryFolder folder;
  const ContactProblem lattice = lattice_step(Lattice::kSquare, 5, 0.3, 10);
  const std::vector<ProblemSource> sources{started_at_its_solution("warm", lattice),
                                           source_of("cold", lattice)};
  Comparison::Options options = quick({"pgs", "apgd"}, {1e-2, 1e-6});
  const Comparison cold = compare(sources, options);
  EXPECT_TRUE(cold.warm_rows.empty());
  EXPECT_TRUE(warm_gains(cold).empty());

  options.warm = true;
  options.out = folder / "table";
  const Comparison both = compare(sources, options);
  EXPECT_EQ(without_times(both.rows), without_times(cold.rows));
  for (const Comparison::Row& row : both.rows) EXPECT_GT(row.iterations, 0);
  ASSERT_EQ(both.warm_rows.size(), 4u);  // "cold" has no start
  for (const Comparison::Row& row : both.warm_rows) {
    EXPECT_EQ(row.problem, "warm");
    EXPECT_EQ(row.warm, 1);
    EXPECT_EQ(row.status, "converged");
    EXPECT_EQ(row.iterations, 0) << row.solver;
  }
  const std::vector<WarmGain> gains = warm_gains(both);
  ASSERT_EQ(gains.size(), 4u);
  EXPECT_EQ(gains[0].solver, "pgs");
  EXPECT_EQ(gains[0].problems, 1);
  EXPECT_EQ(gains[0].solved_warm, 1);
  EXPECT_EQ(gains[0].iterations_ratio, 0);

  // The file has both, and a second run takes both from it.
  EXPECT_EQ(read_csv_rows(options.out / "rows.csv").size(), 12u);
  EXPECT_EQ(read_fclib(options.out / "problems" / "warm.hdf5").guesses.size(), 1u);
  const Comparison again = compare(sources, options);
  EXPECT_EQ(again.rows_kept, 12);
  EXPECT_EQ(to_csv(again), to_csv(both));
}

TEST(Comparison, ACancelledSolveLeavesNoRow) {
  const ContactProblem lattice = lattice_step(Lattice::kSquare, 6, 0.3, 10);
  Comparison::Options options = quick({"pgs"}, {1e-2, 1e-12});
  int polls = 0;
  bool first_row_done = false;
  options.on_row = [&](const Comparison::Row&, int, int) { first_row_done = true; };
  options.watch.interrupted = [&] { return first_row_done && ++polls > 3; };
  const Comparison stopped = compare({source_of("lattice", lattice)}, options);
  EXPECT_FALSE(stopped.complete);
  ASSERT_EQ(stopped.rows.size(), 1u);
  EXPECT_EQ(stopped.rows[0].tol, 1e-2);
}

TEST(Comparison, KeepsUnreadableProblemsInTheTable) {
  const TemporaryFolder folder;
  write_fclib(folder / "good.hdf5", lattice_step(Lattice::kSquare, 3, 0.3, 0), {});
  std::ofstream(folder / "bad.dat") << "not a problem";
  const Comparison c = compare(expand_targets({folder.path().string()}), quick({"pgs"}, {1e-4}));
  ASSERT_EQ(c.rows.size(), 2u);
  EXPECT_EQ(c.rows[0].problem, "bad");
  EXPECT_EQ(c.rows[0].status, "invalid input");
  EXPECT_TRUE(says(c.rows[0].message, "bad.dat"));
  EXPECT_EQ(c.rows[1].status, "converged");
}

TEST(Comparison, RowsThatWereMeasuredAgainHaveOneLine) {
  const TemporaryFolder folder;
  Comparison::Options options = quick({"lemke", "pgs"}, {1e-10}, folder / "table");
  const auto lines = [&] { return read_csv_rows(options.out / "rows.csv"); };
  // A free pyramid that slides apart: exact solutions with different velocities exist, lemke's
  // among them. Its error is the distance to itself.
  const auto sources = expand_targets({"pyramid:5"});
  const Comparison c = compare(sources, options);
  const Comparison::Row& lemke = row_of(c, "lemke", 1e-10);
  EXPECT_LE(lemke.guarded, 1e-10);
  EXPECT_LT(lemke.velocity_error, 1e-6);
  EXPECT_GT(lemke.answer, 0);
  EXPECT_LE(c.problems[0].reference.error.guarded(), 1e-11);
  EXPECT_GT(c.problems[0].reference.spread.velocity, 1e-4);
  EXPECT_EQ(ranking(c.problems[0], c.rows).measure, Ranking::Measure::kForce);
  ASSERT_EQ(lines().size(), 2u);
  EXPECT_EQ(to_csv(lines()[0]), to_csv(c.rows[0]));
  // A program that died left an old line; other rows of the file are kept.
  Comparison::Row old = c.rows[0], other = c.rows[0];
  other.solver = "another";
  std::ofstream file(options.out / "rows.csv");
  old.velocity_error = 7;
  file << csv_header() << '\n';
  for (const Comparison::Row& row : {old, other, c.rows[1], c.rows[0]}) file << to_csv(row) << '\n';
  file.close();
  EXPECT_EQ(to_csv(compare(sources, options)), to_csv(c));
  ASSERT_EQ(lines().size(), 3u);
  EXPECT_EQ(to_csv(lines()[0]), to_csv(c.rows[0]));
  EXPECT_EQ(lines()[1].solver, "another");
}

TEST(ComparisonTargets, AreCheckedBeforeAnythingRuns) {
  for (const char* bad :
       {"no_such_scene", "squre:10", "square:0", "square:ten", "square", "square:10:mu=-1",
        "square:10:speed=3", "square:10:angle=3", "pile:5:ratio=2", "pour:5:ratio=2",
        "cubic:3:seed=2", "tilt:5:angle=200"}) {
    EXPECT_THROW(expand_targets({bad}), std::invalid_argument) << bad;
  }
  for (const char* good : {"triangular:32:mu=0.5:tilt=10:ratio=1e4:e=0.5:seed=2", "pile:4:seed=2",
                           "tilt:5:angle=20:e=0.5", "cubic:3:tilt=10"}) {
    EXPECT_NO_THROW(expand_targets({good})) << good;
  }
  EXPECT_THROW(expand_targets({"square:4", "square:4"}), std::invalid_argument);
  const auto shared = [](const char* folder) {
    setenv("BIPOT_PROBLEMS", folder, 1);
    const std::size_t count = expand_targets({"benchmark"}).size();
    unsetenv("BIPOT_PROBLEMS");
    return count;
  };
  const TemporaryFolder folder;
  write_fclib(folder / "other.hdf5", lattice_step(Lattice::kSquare, 3, 0.3, 0), {});
  EXPECT_GT(shared(""), 30u);
  EXPECT_EQ(shared(folder.path().c_str()), shared("") + 1);
  EXPECT_LT(expand_targets({"benchmark"}, {.quick = true}).size(), 20u);
  EXPECT_THROW(compare(expand_targets({"square:4"}), quick({"pgz"}, {1e-2})),
               std::invalid_argument);
}

TEST(ComparisonTargets, TellSeriesAndSizes) {
  const auto sources = expand_targets({"square:10:tilt=10:mu=0.5", "square:20:tilt=10:mu=0.5"});
  EXPECT_EQ(sources[0].series, "square:tilt=10:mu=0.5");
  EXPECT_EQ(sources[1].series, sources[0].series);
  EXPECT_EQ(sources[1].size, 20);
}

TEST(ComparisonTargets, HitAPileWithAFastDisk) {
  const auto sources = expand_targets({"pile:4", "impact:4"});
  const TestProblem rest = sources[0].load(), hit = sources[1].load();
  EXPECT_EQ(hit.problem.num_dofs(), rest.problem.num_dofs() + 3);
  EXPECT_GT(hit.problem.num_contacts(), rest.problem.num_contacts());
  // Of the approach of 20 m/s at least cos 60 degrees goes along a normal; the pile is at rest.
  EXPECT_LT(hit.problem.u_free.minCoeff(), -9);
  EXPECT_GT(rest.problem.u_free.minCoeff(), -1);
}

TEST(ComparisonTargets, TakeProblemsAlongARun) {
  const auto sources = expand_targets({"square_lattice"}, {.scene_problems = 2, .scene_steps = 6});
  ASSERT_EQ(sources.size(), 2u);
  EXPECT_EQ(sources[0].name, "square_lattice@3");
  EXPECT_EQ(sources[1].name, "square_lattice@6");
  const TestProblem made = sources[1].load();
  EXPECT_GT(made.problem.num_contacts(), 0);
  EXPECT_GT(made.step, 0);
  EXPECT_GT(made.smallest_radius, 0);
}

TEST(ComparisonRows, SurviveTheCsvFile) {
  const TemporaryFolder folder;
  Comparison::Row row{.problem = "a,\"b\"",
                      .solver = "pgs",
                      .tol = 0.1 + 0.2,
                      .message = "first, \"second\"\nthird",
                      .iterations = 12,
                      .guarded = std::numeric_limits<double>::infinity()};
  std::ofstream(folder / "rows.csv") << csv_header() << '\n' << to_csv(row) << '\n';
  const auto rows = read_csv_rows(folder / "rows.csv");
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].problem, row.problem);
  EXPECT_EQ(rows[0].tol, row.tol);
  EXPECT_EQ(rows[0].message, "first, \"second\" third");
  EXPECT_EQ(rows[0].guarded, row.guarded);
  EXPECT_TRUE(std::isnan(rows[0].epsilon));
  EXPECT_EQ(to_csv(rows[0]).size(), to_csv(row).size());
}

TEST(ComparisonReport, FindsTheFastestAndTheUnbeaten) {
  Comparison::Problem problem{.name = "p", .contacts = 1};
  std::vector<Comparison::Row> rows;
  const auto add = [&rows](const char* solver, double seconds, double error) {
    rows.push_back({.problem = "p", .solver = solver, .cpu_min = seconds, .velocity_error = error});
  };
  add("quick", 1, 1e-2);
  add("beaten", 2, 1e-2);
  add("slow", 3, 1e-6);
  add("wrong", 0.1, 2);  // worse than no forces at all
  EXPECT_EQ(fastest_to(problem, rows, 1e-2)->solver, "quick");
  EXPECT_EQ(fastest_to(problem, rows, 1e-3)->solver, "slow");
  EXPECT_EQ(fastest_to(problem, rows, 1e-9), nullptr);
  const auto best = pareto_rows(problem, rows);
  ASSERT_EQ(best.size(), 2u);
  EXPECT_EQ(best[0]->solver, "quick");
  EXPECT_EQ(best[1]->solver, "slow");
}

TEST(ComparisonReport, PageStandsAlone) {
  const Comparison c =
      compare(expand_targets({"square:3", "pyramid:3"}), quick({"pgs", "ipm"}, {1e-2, 1e-6}));
  ReportContext context{.made = provenance("compare", "bipot compare <targets> & more"),
                        .command_of_target = "bipot compare {}"};
  Document more;
  more.heading("Whole simulations & more", "simulations");
  more.say("inside");
  const std::string page = to_html(comparison_page(c, context, more));
  EXPECT_EQ(markup_defect(page), "");
  EXPECT_TRUE(
      says(page, "<h2 id=\"simulations\">Whole simulations &amp; more</h2>\n<p>inside</p>"));
  EXPECT_TRUE(says(page, "<a href=\"#simulations\">Whole simulations &amp; more</a>"));
  for (const char* foreign : {"http://", "https://", "src=", "@import", "url(", "//cdn"}) {
    EXPECT_FALSE(says(page, foreign)) << foreign;
  }
  EXPECT_TRUE(says(page, "bipot compare &lt;targets&gt; &amp; more"));
  // Success for the one size; work and precision of both problems at the top; three figures a
  // problem. Two problems have no profiles.
  std::size_t figures = 0;
  for (std::size_t at = 0; (at = page.find("<svg", at)) != std::string::npos; ++at) ++figures;
  EXPECT_EQ(figures, 9u);
  const auto json = to_json(c, context);
  EXPECT_EQ(json["rows"].size(), c.rows.size());
  EXPECT_FALSE(json["commit"].get<std::string>().empty());
  EXPECT_FALSE(json["compiler"].get<std::string>().empty());
  EXPECT_EQ(json["rows"][0]["iterations"], c.rows[0].iterations);
  // Two solvers at two tolerances, by time and by iterations; four true errors; no auto, no series.
  EXPECT_EQ(json["profiles"].size(), 2u * (2 * 2 + 4));
  // 1e-3 to 1e-6, one size.
  EXPECT_EQ(json["success"].size(), 2u * 4);
  EXPECT_EQ(json["success"][0]["problems"], 2);
  EXPECT_EQ(json["errors_within"].size(), 2u * 3);
  EXPECT_EQ(json["tolerance_meaning"].size(), 2u);
  EXPECT_TRUE(json["growth"].empty());
  EXPECT_EQ(json["regret_of_auto"]["cases"], 0);
}

TEST(Comparison, TakesFamiliesAndScenesOfSpheres) {
  // 1 + 4 + 9 cannon balls; each but those at the floor has four below it: 9 + 4·4 + 4 contacts,
  // and those of a layer touch: 12 in 3 x 3, 4 in 2 x 2. Without friction velocities and resultants
  // are unique: solvers agree to their tolerance.
  TargetOptions targets{.scene_problems = 2, .scene_steps = 20};
  const std::vector<ProblemSource> sources =
      expand_targets({"cannonballs:3", "cubic:3:mu=0", "four_spheres"}, targets);
  ASSERT_EQ(sources.size(), 4u);
  EXPECT_EQ(sources[2].name, "four_spheres@10");
  const TestProblem pyramid = sources[0].load();
  EXPECT_EQ(pyramid.problem.dim, 3);
  EXPECT_EQ(pyramid.problem.num_contacts(), 9 + 16 + 4 + 12 + 4);
  EXPECT_EQ(sources[2].load().problem.num_dofs(), 4 * 6);
  EXPECT_EQ(sources[2].load().smallest_radius, 0.05);
  const Comparison c = compare(sources, quick({"pgs", "admm"}, {1e-6}));
  ASSERT_EQ(c.rows.size(), 8u);
  for (const Comparison::Row& row : c.rows) {
    EXPECT_EQ(row.status, "converged") << row.problem << ' ' << row.solver;
    EXPECT_LE(row.guarded, 1e-6);
  }
  EXPECT_THROW(expand_targets({"cubic:3:ratio=2"}), std::invalid_argument);
  EXPECT_THROW(expand_targets({"cubic:3:e=0.5"}), std::invalid_argument);
  EXPECT_THROW(expand_targets({"cubic:99"}), std::invalid_argument);
}

}  // namespace
}  // namespace bipot
