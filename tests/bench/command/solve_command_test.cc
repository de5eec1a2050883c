// `bipot solve` and the problems that runs dump for it, as a user runs them.

#include "core/criterion/contact_error.h"
#include "core/files/hdf5_file.h"
#include "core/problem/equality_rows.h"
#include "core/problem_files/fclib_file.h"
#include "core/problem_files/problem_file.h"
#include "tests/bench/command/command_fixture.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

using nlohmann::json;

TEST_F(Command, DumpedProblemIsSolvedAndItsSolutionReadBack) {
  ASSERT_EQ(code_of("run triangular_lattice --steps 1 --dump-problems all --out out"), 0);
  const std::string problem = "out/problems/step_000001.hdf5";
  const json j = json_of("solve " + problem + " --solver pgs --tol 1e-9 --json - --solution " +
                         problem + " --history history.csv");
  EXPECT_EQ(j["status"], "converged");
  EXPECT_EQ(j["dim"], 2);
  const ProblemFile file = read_problem(problem);
  ASSERT_TRUE(file.r.has_value());
  EXPECT_EQ(j["contacts"], file.problem.num_contacts());
  const ContactError error = contact_error(file.problem, *file.r);
  EXPECT_LE(error.guarded(), 1e-9);
  EXPECT_NEAR(j["epsilon"].get<double>(), error.epsilon, 1e-14);
  EXPECT_EQ(content("history.csv").substr(0, 26), "iteration,seconds,epsilon,");
  // Pivots are not judged one by one, the answer is.
  const json lemke = json_of("solve " + problem + " --solver lemke --json - --history lemke.csv");
  const std::string rows = content("lemke.csv");
  const std::string last = rows.substr(rows.rfind('\n', rows.size() - 2) + 1);
  EXPECT_TRUE(last.starts_with(fmt::format("{},", lemke["iterations"].get<int>()))) << last;
  EXPECT_TRUE(says(last, fmt::format(",{:.9e},", lemke["epsilon"].get<double>()))) << last;
}

TEST_F(Command, EqualityRowsAreSolvedReportedJudgedAndCompared) {
  // small_problems.h derives the answer.
  const FourBars bars = four_bars();
  write_fclib("bars.hdf5", with_equality_rows(bars.problem, bars.G, Vector::Zero(8)), {});
  const json j = json_of("solve bars.hdf5 --tol 1e-10 --certify --json - --solution bars.hdf5");
  EXPECT_EQ(j["status"], "converged");
  EXPECT_EQ(j["existence"]["verdict"], "exists");
  EXPECT_EQ(j["equality_rows"], 8);
  EXPECT_LE(j["equality_residual"].get<double>(), 1e-15);
  const ProblemFile file = read_problem("bars.hdf5");
  EXPECT_LE((*file.r - bars.s).norm(), 1e-9 * bars.s.norm());
  EXPECT_NEAR((*file.v)[2], bars.turns_at[0], 1e-10);
  const Vector impulses = multipliers(file.problem, *file.r);
  for (int k = 0; k < 8; ++k) EXPECT_EQ(j["multipliers"][to_size(k)], impulses[k]);
  EXPECT_TRUE(says(bipot("solve bars.hdf5").out, "  8 equality rows, |G v - b| "));
  EXPECT_EQ(code_of("judge bars.hdf5 --tol 1e-9"), 0);
  EXPECT_EQ(code_of("solve bars.hdf5 --several 4"), 0);
  const json table = json_of("compare bars.hdf5 --solvers pgs,ipm --tols 1e-8 --json -");
  ASSERT_EQ(table["rows"].size(), 2u);
  for (const json& row : table["rows"]) EXPECT_EQ(row["status"], "converged");

  Eigen::MatrixXd twice(16, 12);
  twice << bars.G.toDense(), bars.G.toDense();
  write_fclib("bars.hdf5", with_equality_rows(bars.problem, twice.sparseView(), Vector::Zero(16)),
              {});
  {
    Hdf5File spoilt("bars.hdf5", Hdf5File::Mode::kAppend);
    std::vector<double> b(16, 0.0);
    b[3] = 1;
    spoilt.remove("/fclib_global/vectors/b");
    spoilt.write("/fclib_global/vectors/b", b);
  }
  EXPECT_TRUE(
      says(json_of("solve bars.hdf5 --json -", 2)["message"], "of G contradicts other rows: b["));
}

TEST_F(Command, AWarmSolveStartsFromTheDumpedStart) {
  // Disks at rest: the impulses of a step solve the next one.
  ASSERT_EQ(
      code_of(
          "run square_lattice --steps 3 --tol 1e-12 --warm-start --dump-problems all --out out"),
      0);
  EXPECT_EQ(read_problem("out/problems/step_000003.hdf5").guesses.size(), 1u);
  const std::string solve = "solve out/problems/step_000003.hdf5 --solver pgs --tol 1e-6 --json -";
  const json cold = json_of(solve), warm = json_of(solve + " --warm");
  EXPECT_EQ(cold["warm"], false);
  EXPECT_EQ(warm["warm"], true);
  EXPECT_EQ(warm["status"], "converged");
  EXPECT_GT(cold["iterations"], 0);
  EXPECT_EQ(warm["iterations"], 0);

  const json table =
      json_of("compare out/problems/step_000003.hdf5 --solvers pgs --tols 1e-6 --warm --json -");
  ASSERT_EQ(table["rows"].size(), 2u);
  EXPECT_EQ(table["rows"][0]["warm"], 0);
  EXPECT_EQ(table["rows"][0]["iterations"], cold["iterations"]);
  EXPECT_EQ(table["rows"][1]["warm"], 1);
  EXPECT_EQ(table["rows"][1]["iterations"], 0);
  EXPECT_EQ(table["warm_starts"][0]["solved_warm"], 1);

  ASSERT_EQ(code_of("run square_lattice --steps 1 --no-warm-start --dump-problems all --out cold"),
            0);
  EXPECT_EQ(code_of("solve cold/problems/step_000001.hdf5 --warm"), 2);
}

TEST_F(Command, SolveLooksForSeveralAnswers) {
  const std::string problem = shipped_problem("2d_tilt1000hi_182");
  expect_said("solve " + problem + " --several 5", 0, {"Several answers, each exact"}, &bipot);
  json j = json_of("solve " + problem + " --several 12 --seed 3 --json -");
  EXPECT_EQ(j["starts"].size(), 12u);
  ASSERT_GE(j["answers"].size(), 3u);
  EXPECT_GT(j["spread"]["velocity"], 5e-2);
  EXPECT_EQ(j["spread"]["contacts"].get<std::size_t>() > 0, !j["differing_contacts"].empty());
  for (const json& answer : j["answers"]) {
    EXPECT_LE(std::max(answer["epsilon"].get<double>(), answer["eta"].get<double>()), 1e-9);
  }
  // The same seed, the same numbers, seconds aside.
  json again = json_of("solve " + problem + " --several 12 --seed 3 --json -");
  for (json* one : {&j, &again}) {
    one->erase("seconds");
    for (json& start : (*one)["starts"]) start.erase("seconds");
  }
  EXPECT_EQ(j, again);
  EXPECT_EQ(code_of("solve " + problem + " --several 500 --time-limit 0.3"), 1);
  EXPECT_EQ(code_of("solve " + problem + " --several 0"), 2);
  EXPECT_EQ(code_of("solve " + problem + " --several 3 --explain"), 2);
  EXPECT_EQ(code_of("solve " + problem + " --several 3 --reproducible"), 2);
  EXPECT_EQ(code_of("solve " + problem + " --several 3 --warm"), 2);  // has no guess
  expect_interrupted("solve " + problem + " --several 5000");
  std::ofstream("no_contacts.dat") << "2\n0\n0\n0 0\n0 0\n";
  const json none = json_of("solve no_contacts.dat --several 3 --json -");
  EXPECT_EQ(none["status"], "nothing to do");
  EXPECT_EQ(none["exit_code"], 0);
}

TEST_F(Command, DumpedStepsAreDrawnWithTheirAnswers) {
  ASSERT_EQ(code_of("run pyramid --steps 2 --dump-problems all --out run"), 0);
  ASSERT_TRUE(fs::exists("run/problems/step_000002.hdf5"));
  EXPECT_EQ(code_of("solve run/problems/step_000002.hdf5 --several 4 --warm --out answers"), 0);
  const json j = json_in("answers/summary.json");
  EXPECT_EQ(read_problem("answers/answers.hdf5").guesses.size(), j["answers"].size());
  EXPECT_TRUE(says(content("answers/answers.svg"), "<svg"));
  EXPECT_GT(fs::file_size("answers/answers.png"), 1000u);
  const std::string page = content("answers/index.html");
  EXPECT_TRUE(says(page, "<img src=\"answers.svg\""));
  EXPECT_TRUE(says(page, "<a href=\"answers.csv\">"));
  EXPECT_TRUE(content("answers/answers.csv").starts_with("answer,starts,error,kinetic [J],"));
}

TEST_F(Command, ASingleAnswerIsDrawnWithoutDifferences) {
  ASSERT_EQ(code_of("run sliding_cylinder --steps 1 --dump-problems all --out run"), 0);
  const json j = json_of("solve run/problems/step_000001.hdf5 --several 4 --json - --out answers");
  ASSERT_EQ(j["answers"].size(), 1u);
  EXPECT_TRUE(says(bipot("solve run/problems/step_000001.hdf5 --several 4").out,
                   "One answer: no case of open,"));
  EXPECT_FALSE(says(content("answers/answers.svg"), "linearGradient"));  // of the colours
}

TEST_F(Command, SolutionsDoNotGoIntoOtherProblems) {
  // Two lattices that differ in friction alone: the same sizes.
  std::string text = content(shipped_scene("triangular_lattice"));
  const std::string run = "run " + write("a.toml", text) + " --steps 1 --quiet --dump-problems all";
  ASSERT_EQ(code_of(run + " --out a"), 0);
  const std::string mu = "mu = 0.3";
  text.replace(text.find(mu), mu.size(), "mu = 0.4");
  write("a.toml", text);
  ASSERT_EQ(code_of(run + " --out b"), 0);
  const std::string a = "a/problems/step_000001.hdf5", b = "b/problems/step_000001.hdf5";
  EXPECT_EQ(code_of("solve " + a + " --solution " + b), 2);
  EXPECT_FALSE(read_problem(b).r.has_value());
  EXPECT_EQ(code_of("solve " + a + " --solution " + a), 0);
  EXPECT_TRUE(read_problem(a).r.has_value());
  EXPECT_EQ(code_of("solve " + a + " --solution " + write("no.hdf5", "not HDF5")), 2);
}

// M = diag(2, 4), H = I, f = (2, 8) and w = (-9, 0.5) have W = diag(1/2, 1/4) and q = (-8, 2.5). With
// mu = 0.3 the contact slips: u_n = 0 gives s_n = 16, s_t = -4.8, u_t = 2.5 - 1.2, and
// v = (1, 2) + (8, -1.2).
TEST_F(Command, SolutionsGoIntoTheOtherFormOfTheProblem) {
  const std::string M = "0\n2\n2\n2\t2\n2 0\n0 4\n", H = "0\n2\n2\n2\t2\n1 0\n0 1\n";
  const std::string W = "0\n2\n2\n2\t2\n0.5 0\n0 0.25\n";
  write("g.dat", "2\n1\n" + M + H + "2 8\n-9 0.5\n0.3\n");
  write("l.dat", "2\n1\n" + W + "-8 2.5\n0.3\n");
  const std::string of_global = "g.hdf5", of_local = "l.hdf5";
  ASSERT_EQ(code_of("solve -q g.dat --solution " + of_global), 0);
  ASSERT_EQ(code_of("solve -q l.dat --solution " + of_local), 0);
  for (const std::string& flags :
       {"g.dat --solution " + of_local, "l.dat --solution " + of_global}) {
    EXPECT_EQ(json_of("solve " + flags + " --json -")["status"], "converged") << flags;
  }
  EXPECT_LE((*read_problem(of_local).r - Eigen::Vector2d(16, -4.8)).norm(), 1e-6);
  EXPECT_FALSE(read_problem(of_local).v.has_value());
  EXPECT_LE((*read_problem(of_global).v - Eigen::Vector2d(9, 0.8)).norm(), 1e-6);
}

// Neither the problem nor another result is overwritten, and nothing is removed before the solve.
TEST_F(Command, ResultsDoNotReplaceTheInputOrEachOther) {
  const std::string problem = "problem.hdf5", out = "out";
  fs::copy_file(source_folder() / "data/problems/2d_pyramid_10.hdf5", problem);
  const auto size = fs::file_size(problem);
  for (const std::string flags : {"--json problem.hdf5", "--history ./problem.hdf5",
                                  "--json x --history x", "--solution y.hdf5 --json y.hdf5"}) {
    EXPECT_EQ(code_of("solve " + problem + " -q " + flags), 2) << flags;
    EXPECT_EQ(fs::file_size(problem), size) << flags;
  }
  EXPECT_EQ(code_of("judge " + problem + " -q --json " + problem), 2);
  EXPECT_EQ(code_of("solve " + problem + " -q --out " + out), 0);
  EXPECT_EQ(code_of("solve " + problem + " -q --omega 9 --out " + out), 2);
  EXPECT_TRUE(fs::exists(out + "/solution.hdf5"));
}

TEST_F(Command, NamesOfShippedProblemsAreTaken) {
  EXPECT_EQ(code_of("solve 2d_pyramid_10 -q --solution solved.hdf5"), 0);
  EXPECT_EQ(code_of("judge 2d_pyramid_10 -q --impulses solved.hdf5"), 0);
  EXPECT_EQ(code_of("compare 2d_pyramid_10 --solvers apgd --tols 1e-2 -q"), 0);
  EXPECT_EQ(code_of("solve 2d_pyramid -q"), 4);
}

TEST_F(Command, SolvesWhatAComparisonNames) {
  const json table = json_of(
      "compare pyramid:4 pour:6 four_spheres --scene-problems 1 --scene-steps 20 --solvers pgs "
      "--tols 1e-4 --json -");
  ASSERT_EQ(table["rows"].size(), 3u);
  for (const json& row : table["rows"]) {
    const std::string problem = row["problem"];
    const json solved = json_of("solve " + problem + " --solver pgs --tol 1e-4 --json -");
    EXPECT_EQ(solved["iterations"], row["iterations"]) << problem;
    EXPECT_EQ(solved["contacts"], row["contacts"]) << problem;
  }
  expect_said("solve pour:6", 2, {"pour:6: 3 problems; name one, as pour:6@"});
  expect_said("solve drum", 2, {"drum: 3 problems; name one, as drum@"});
  expect_said("solve pyramid:4@2", 2, {"only the run of a scene or a moving family has steps"});
  expect_said("solve four_spheres@0", 2, {"no step, from 1 on, behind '@'"});
  expect_said("solve four_spheres:steps=20@21", 2, {"the run has 20 steps"});
  // Of the first two stages of auto, one has no iterations: the start is in the history once.
  ASSERT_EQ(code_of("solve four_spheres@10 --history stages.csv -q"), 0);
  const std::string history = content("stages.csv");
  EXPECT_NE(history.find("\n0,"), std::string::npos);
  EXPECT_EQ(history.find("\n0,"), history.rfind("\n0,"));
  // Steps behind the length of quick runs.
  EXPECT_EQ(code_of("compare four_spheres@0120 --quick --solvers pgs --tols 1e-1 -q"), 0);
}

TEST_F(Command, InterruptedSolveReportsItsBestImpulse) {
  expect_interrupted("solve " + shipped_problem("2d_compaction_rest") +
                     " --solver pgs --tol 1e-13 --out out");
  const json j = json_in("out/summary.json");
  EXPECT_EQ(j["status"], "interrupted");
  EXPECT_GT(j["iterations"], 0);
  EXPECT_TRUE(read_problem("out/solution.hdf5").r.has_value());
}

/// The run to a step is part of the command's time, and ends as a solve does.
TEST_F(Command, MakingAProblemKeepsTheTimeLimitAndCanBeInterrupted) {
  for (const char* target : {"drum@1400", "pour3d:22@512", "pile:80"}) {
    const json refused = json_of(fmt::format("solve {} --time-limit 0.1 --json -", target), 1);
    EXPECT_EQ(refused["exit_code"], 1);
    EXPECT_TRUE(says(refused["message"], "time limit 0.1 s reached before the problem was made"));
  }
  expect_interrupted("solve pile:80");
}

TEST_F(Command, CertifiesWhetherASolutionExists) {
  ASSERT_EQ(code_of("extremes --only wall_into_row --dump-problem none.hdf5"), 0);
  const Outcome none = bipot("solve none.hdf5 --certify --time-limit 1 --json -");
  EXPECT_EQ(none.exit_code, 3);
  EXPECT_EQ(json::parse(none.out)["exit_code"], 3);
  const json proof = json::parse(none.out)["existence"];
  EXPECT_EQ(proof["verdict"], "none");
  EXPECT_TRUE(says(proof["statement"], "proved"));
  const std::string pile = shipped_problem("2d_pyramid_10");
  const json exists = json_of("solve " + pile + " --certify --json -")["existence"];
  EXPECT_EQ(exists["verdict"], "exists");
  EXPECT_GT(exists["margin"].get<double>(), 0);
  // Rounding in its free velocities is no data.
  EXPECT_EQ(json_of("solve cannonballs:4 --certify --json -")["existence"]["verdict"], "exists");
}

TEST_F(Command, ACertificateKeepsTheTimeLimitAndCanBeInterrupted) {
  write("rolling.toml", changed(content(shipped_scene("pipe")),
                                {{"mu = 0.4", "mu = 0.4\nmu_r = 1e-3\nmu_spin = 1e-3"},
                                 {"count = 150", "count = 400"}}));
  ASSERT_EQ(code_of("solve rolling.toml@500 --solution p.hdf5"), 0);
  const json late =
      json_of(fmt::format("solve p.hdf5 --certify --time-limit {} --json -", BIPOT_TEST_SLOWNESS));
  EXPECT_EQ(late["status"], "converged");
  EXPECT_TRUE(says(late["existence"]["statement"], "undecided: out of time, stopped after"));
  EXPECT_LT(late["existence"]["seconds"], 10 * BIPOT_TEST_SLOWNESS);  // of minutes
  expect_interrupted("solve p.hdf5 --certify --out out");
  EXPECT_TRUE(
      says(json_in("out/summary.json")["existence"]["statement"], "undecided: interrupted"));
}

}  // namespace
}  // namespace bipot
