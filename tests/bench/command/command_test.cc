// The `bipot` command, run as a user runs it. Single problems: solve_command_test.cc.

#include "bench/command/blas_kernels.h"
#include "core/criterion/contact_error.h"
#include "core/files/input_file.h"
#include "core/run_files/observable_output.h"
#include "core/run_files/run_reader.h"
#include "tests/bench/command/command_fixture.h"
#include "tests/support/state_bits.h"

namespace bipot {
namespace {

using nlohmann::json;

/// Where OpenBLAS does not know this processor, the command starts again with kernels that fit:
/// with all of its arguments, and once.
TEST_F(Command, RunsOnKernelsOfThisProcessor) {
  const auto asked = [](const std::string& arguments) {
    return run_command_line("sh -c \"env -u OPENBLAS_CORETYPE OPENBLAS_VERBOSE=2 " BIPOT_COMMAND
                            " " +
                                arguments + " 2>&1\"",
                            "");
  };
  const Outcome version = asked("--version");
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_TRUE(says(version.out, "bipot "));
  const Outcome missing = asked("solve 'no such file.hdf5'");
  EXPECT_EQ(missing.exit_code, code_of("solve 'no such file.hdf5'"));
  EXPECT_TRUE(says(missing.out, "no such file.hdf5"));
  const std::string says = "Core: ";
  const std::size_t at = version.out.rfind(says);
  if (at == std::string::npos) GTEST_SKIP() << "BLAS is not OpenBLAS";
  if (fitting_kernels() == nullptr) GTEST_SKIP() << "no AVX2";
  const std::size_t from = at + says.size();
  const std::string core = version.out.substr(from, version.out.find('\n', from) - from);
  EXPECT_FALSE(kernels_without_avx2(core)) << core;
}

TEST_F(Command, RunsAShippedSceneAndLeavesItsFiles) {
  const json j = json_of("run square_lattice --json - --out " + path("out"));
  EXPECT_EQ(j["status"], "completed");
  EXPECT_EQ(j["steps"], 10);
  EXPECT_EQ(j["steps_converged"], 10);
  EXPECT_LE(j["epsilon"].get<double>(), 1e-8);
  EXPECT_TRUE(j["epsilon_raw"].is_null());  // nothing slides: (42) is undefined
  expect_files("out",
               {"run.h5", "run.xdmf", "ledger.csv", "forces.svg", "forces.png", "summary.json"});
}

TEST_F(Command, TheStressPictureIsDrawnWhereTheSceneAsksForIt) {
  const std::string scene = content(shipped_scene("square_lattice"));
  const std::string text = scene +
                           (scene.find("[output]") == std::string::npos ? "\n[output]" : "") +
                           "\nstress_picture = true\n";
  const json stress =
      json_of("run " + write("lattice.toml", text) + " --json - --out out")["stress"];
  expect_files("out", {"stress.svg", "stress.png"});
  // The summary's stress is that of the ledger's last row: area, xx, yy, xy, kinetic pressure.
  const std::vector<double> row = read_number_table("out/ledger.csv").rows.back();
  ASSERT_EQ(row.size(), 28u);
  EXPECT_NEAR(stress["area"].get<double>(), row[23], 1e-8 * std::abs(row[23]));
  EXPECT_NEAR(stress["yy"].get<double>(), row[25], 1e-8 * std::abs(row[25]));
  EXPECT_NEAR(stress["pressure"].get<double>(), 0.5 * (row[24] + row[25]), 1e-8 * row[25]);
  bipot("run square_lattice --steps 1 --quiet --out plain");
  EXPECT_FALSE(fs::exists("plain/stress.svg"));
}

TEST_F(Command, TheSummaryHasTheEnergiesOfTheLastRow) {
  // A floor lifts a sticky disk, which slides to the right, while another leaves.
  const std::string lift =
      "[[walls]]\npoint = [0, 0]\nnormal = [0, 1]\nvelocity = [0, 0.5]\n"
      "[[disks]]\nposition = [0, 0.1]\nradius = 0.1\nmass = 1\nvelocity = [1, 0]\n"
      "[[disks]]\nposition = [3.998, 5]\nradius = 0.1\nmass = 1\nvelocity = [1, 0]\n"
      "[time]\nstep = 1e-3\nsteps = 5\n[contact]\nmu = 0.5\n";
  const std::string leave = "cohesion = 1\n[[outlets]]\npoint = [4, 0]\nnormal = [-1, 0]\n";
  for (const auto& [out, text] :
       {std::pair("sticky", lift + leave), std::pair("dem", "model = 'dem'\n" + lift)}) {
    const json energy =
        json_of("run " + write("lift.toml", text) + " --json - --out " + out)["energy"];
    EXPECT_GE(energy.size(), 6u);
    const NumberTable ledger = read_number_table(fs::path(out) / "ledger.csv");
    for (const auto& [name, value] : energy.items()) {
      const double expected = ledger.rows.back()[ledger.column(name)];
      EXPECT_NE(expected, 0) << name;
      EXPECT_NEAR(value.get<double>(), expected, 1e-8 * std::abs(expected)) << name;
    }
  }
}

// 142² = 20 164 disks that nothing moves.
TEST_F(Command, AVectorPictureIsLeftOutOfManyBodies) {
  std::ofstream("many.toml") << "gravity = [0, 0]\n[[disks]]\narrangement = 'rectangular'\n"
                                "columns = 142\nrows = 142\nradius = 1\nmass = 1\n"
                                "[time]\nstep = 1\nsteps = 1\n[output]\npage = false\n";
  ASSERT_EQ(code_of("run many.toml -q --out out"), 0);
  expect_files("out", {"run.h5", "forces.png"});
  EXPECT_FALSE(fs::exists("out/forces.svg"));
}

TEST_F(Command, EachFailureHasItsExitCode) {
  EXPECT_EQ(code_of("run square_lattice --max-iterations 3 --steps 1"), 1);
  EXPECT_EQ(code_of("run no_such_scene"), 2);
  EXPECT_EQ(code_of("run square_lattice --solver no_such_solver"), 2);
  EXPECT_EQ(code_of("run square_lattice --solver pgs --omega 7"), 2);
  EXPECT_EQ(code_of("run square_lattice --no-such-flag"), 2);
  EXPECT_EQ(code_of("solve missing.hdf5"), 4);
  EXPECT_EQ(code_of("solve " + write("text.dat", "not a problem")), 2);
  EXPECT_EQ(code_of("run square_lattice --steps 1 --out /proc/nowhere"), 4);
  const std::string nan_scene = content(shipped_scene("square_lattice"));
  EXPECT_EQ(code_of("run " + write("bad.toml", nan_scene + "\n[outptu]\nevery = 1\n")), 2);
}

TEST_F(Command, RestartContinuesBitForBit) {
  const std::string flags = " --tol 1e-4 --quiet --out ";
  ASSERT_EQ(code_of("run compaction --steps 60" + flags + "whole"), 0);
  ASSERT_EQ(code_of("run compaction --steps 35" + flags + "first"), 0);
  ASSERT_EQ(code_of("run compaction --steps 25 --restart first/run.h5" + flags + "second"), 0);
  const State<2> whole = read_state("whole/run.h5");
  const State<2> parts = read_state("second/run.h5");
  EXPECT_EQ(whole.step, parts.step);
  EXPECT_EQ(whole.friction_loss, parts.friction_loss);
  EXPECT_EQ(bits_of_bodies(whole), bits_of_bodies(parts));
}

/// Disks that fall apart: the triangular lattice, smaller, without its right wall.
std::string collapsing_scene(int steps) {
  std::string text = content(shipped_scene("triangular_lattice"));
  const std::size_t wall = text.find("[[walls]]\nname = \"right\"");
  text.erase(wall, text.find("[time]") - wall);
  return changed(text, {{"columns = 10", "columns = 5"},
                        {"rows = 10", "rows = 5"},
                        {"steps = 10", "steps = " + std::to_string(steps)}});
}

TEST_F(Command, RestartGoesOnToTheScenesPlannedEnd) {
  write("collapse.toml", collapsing_scene(400));
  const std::string run = "run collapse.toml --tol 1e-4 --json - --out ";
  ASSERT_EQ(code_of(run + "whole"), 0);
  ASSERT_EQ(code_of(run + "parts --steps 260"), 0);
  const json j = json_of(run + "parts --restart parts");
  EXPECT_EQ(j["steps"], 140);
  EXPECT_EQ(j["steps_planned"], 140);
  EXPECT_EQ(j["last_step"], 400);
  const State<2> whole = read_state("whole"), parts = read_state("parts");
  EXPECT_EQ(parts.step, 400);
  EXPECT_EQ(whole.time, parts.time);
  EXPECT_EQ(whole.friction_loss, parts.friction_loss);
  EXPECT_GT(whole.friction_loss, 0);  // something slid
  EXPECT_EQ(bits_of_bodies(whole), bits_of_bodies(parts));
  EXPECT_EQ(content("whole/ledger.csv"), content("parts/ledger.csv"));

  // At the end there is nothing to do, and nothing is touched.
  const std::string summary = content("parts/summary.json");
  const json again = json_of(run + "parts --restart parts");
  EXPECT_EQ(again["status"], "nothing to do");
  EXPECT_EQ(again["last_step"], 400);
  EXPECT_EQ(content("parts/summary.json"), summary);
  EXPECT_EQ(json_of(run + "parts --steps 0 --restart parts")["status"], "nothing to do");
  // As a signal after the last frame leaves it: what lacks is made.
  fs::remove("parts/summary.json");
  fs::remove("parts/forces.png");
  fs::remove("parts/index.html");
  EXPECT_EQ(json_of(run + "parts --restart parts")["status"], "completed");
  expect_files("parts", {"summary.json", "forces.png", "index.html"});
  EXPECT_EQ(json_in("parts/summary.json")["last_step"], 400);
  EXPECT_EQ(content("whole/ledger.csv"), content("parts/ledger.csv"));
  EXPECT_EQ(json_of(run + "parts --restart parts")["status"], "nothing to do");
  // Without a ledger nothing says that they were solved; no step at all is none that failed.
  fs::remove("parts/summary.json");
  fs::remove("parts/ledger.csv");
  EXPECT_EQ(json_of(run + "parts --restart parts", 1)["status"], "not converged");
  write("rare.toml",
        changed(collapsing_scene(400), {{"[output]\n", "[output]\nledger_every = 0\n"}}));
  EXPECT_EQ(json_of("run rare.toml --steps 0 --json - --out rare")["status"], "completed");
  write("shorter.toml", collapsing_scene(300));
  expect_said("run shorter.toml --restart parts", 0,
              {"is at step 400, the scene ends at step 300"});
  // --steps N is N more.
  EXPECT_EQ(json_of(run + "more --steps 5 --restart parts")["steps"], 5);
  EXPECT_EQ(read_state("more").step, 405);
}

TEST_F(Command, EveryCommandSaysInItsJsonWhyItRefuses) {
  for (const auto& [arguments, code] : {std::pair<const char*, int>{"run no_such_scene", 2},
                                        {"run square_lattice --steps -3", 2},
                                        {"run square_lattice --out /proc/nowhere", 4},
                                        {"solve no_such_file.hdf5", 4},
                                        {"solve", 2},
                                        {"compare no_such_thing", 2},
                                        {"compare square:4 --tols abc", 2},
                                        {"compare square:4 --out /proc/nowhere", 4},
                                        {"advise no_such_scene --energy 0.1", 2},
                                        {"paper --only table3", 2},
                                        {"trade no_such_scene", 2},
                                        {"list nonsense", 2},
                                        {"list solvers no_such_solver", 2}}) {
    const std::string words = arguments;
    const Outcome refused = bipot(words + " --json -");
    EXPECT_EQ(refused.exit_code, code) << words;
    const json j = json::parse(refused.out, nullptr, false);
    ASSERT_FALSE(j.is_discarded()) << words << ": " << refused.out;
    EXPECT_EQ(j["command"], words.substr(0, words.find(' ')));
    EXPECT_EQ(j["exit_code"], code) << words;
    EXPECT_EQ(j["status"], code == 4 ? "input or output failed" : "invalid input") << words;
    EXPECT_FALSE(j["message"].get<std::string>().empty()) << words;
    fs::remove("refusal.json");
    bipot(words + " --json=refusal.json");
    EXPECT_EQ(json::parse(content("refusal.json")), j) << words;
  }
}

TEST_F(Command, DestinationsAreLookedAtBeforeTheWork) {
  const std::string problem = shipped_problem("2d_triangular_lattice");
  const std::string solve = "solve " + problem + " --solver pgs --tol 1e-4";
  EXPECT_EQ(code_of(solve + " --history h.csv --json /proc/nowhere/a.json"), 4);
  EXPECT_FALSE(fs::exists("h.csv"));  // nothing was solved
  EXPECT_EQ(code_of(solve + " --json a.json --solution /proc/nowhere/s.hdf5"), 4);
  EXPECT_EQ(json_in("a.json")["exit_code"], 4);
  fs::create_symlink("nothing.json", "link.json");
  EXPECT_EQ(code_of(solve + " --json link.json --solution /proc/nowhere/s.hdf5"), 4);
  EXPECT_EQ(json_in("nothing.json")["exit_code"], 4);
  EXPECT_EQ(code_of(solve + " --json link.json"), 0);
  EXPECT_EQ(json_in("nothing.json")["exit_code"], 0);
  EXPECT_TRUE(fs::is_symlink("link.json"));
  EXPECT_EQ(code_of("run square_lattice --json /proc/nowhere/a.json"), 4);
  EXPECT_EQ(code_of(solve + " --solution s.hdf5"), 0);
  EXPECT_EQ(code_of(solve + " --solution s.hdf5"), 0);  // the same problem
}

TEST_F(Command, NothingIsWrittenOverWhatIsRead) {
  const std::string scene = content(shipped_scene("sliding_cylinder"));
  write("s.toml", scene);
  fs::create_directory("z");
  write("z/plan.toml", scene);
  for (const char* words :
       {"run s.toml --steps 2 --json s.toml", "advise s.toml --json s.toml",
        "trade s.toml:steps=5 --json=s.toml", "compare s.toml:steps=20 --json s.toml"}) {
    expect_said(words, 2, {"there is a file that is not JSON", "kept as it was"});
  }
  for (const char* words : {"tune s.toml --out s.toml", "tune z/plan.toml",
                            "tune s.toml:steps=5 --out p.toml --rows s.toml"}) {
    EXPECT_EQ(code_of(std::string(words) + " --solvers apgd --tols 1e-2"), 2) << words;
  }
  EXPECT_EQ(content("s.toml"), scene);
  EXPECT_EQ(content("z/plan.toml"), scene);
  // JSON of before may be replaced, as an empty file.
  write("old.json", "[1, 2]");
  EXPECT_EQ(code_of("list solvers --json old.json"), 0);
  EXPECT_EQ(json_in("old.json")[0]["name"], "auto");
  write("-", "no JSON");
  EXPECT_EQ(json_of("list solvers --json -")[0]["name"], "auto");
  write("empty", "");
  EXPECT_EQ(code_of("list solvers --json empty"), 0);
}

TEST_F(Command, MessagesThatCannotBeWrittenStopNothing) {
  for (const char* nowhere : {" 2>&- #", " 2>/dev/full #"}) {
    const auto code = [&](const std::string& words) {
      return run_command_line(BIPOT_COMMAND, words + nowhere).exit_code;
    };
    EXPECT_EQ(code("solve no_such_file.hdf5"), 4);
    EXPECT_EQ(code("solve square:4 --solver nonsense"), 2);
    EXPECT_EQ(code("run compaction_100 --steps 20 --overwrite --out run"), 0);
    EXPECT_TRUE(fs::exists("run/index.html"));
    EXPECT_EQ(json_in("run/summary.json")["status"], "completed");
  }
  // The progress of a closed stream must not end in the file that was opened next.
  EXPECT_EQ(code_of("tune square:6 pile:6 --tols 1e-2 --out p.toml 2>&- #"), 0);
  EXPECT_FALSE(says(content("p.csv"), "left"));
  EXPECT_EQ(code_of("tune square:6 pile:6 --tols 1e-2 --out p.toml"), 0);
  EXPECT_EQ(code_of("list solvers >&- #"), 4);
}

TEST_F(Command, ARefusalReachesAPipe) {
  const Outcome refused =
      run_command_line("sh", "-c 'mkfifo pipe; " BIPOT_COMMAND
                             " solve no_such_file.hdf5 --json pipe & timeout 60 cat pipe' #");
  EXPECT_EQ(json::parse(refused.out)["exit_code"], 4);
}

TEST_F(Command, OneFolderHasOneComparison) {
  const Outcome both = run_command_line(
      "sh",
      "-c '" BIPOT_COMMAND
      " compare pile:24 --tols 1e-2,1e-10 --min-time 1 -q --out c & "
      "p=$!; for k in $(seq 300); do [ -e c/limits.json ] && break; sleep 0.1; done; " BIPOT_COMMAND
      " compare square:4 -q --out c 2>&1; code=$?; "
      "kill -INT $p; wait $p; exit $code' 2>&1 #");
  EXPECT_EQ(both.exit_code, 2);
  EXPECT_TRUE(says(both.out, "another command writes into"));
}

TEST_F(Command, ADamagedLedgerIsNotContinued) {
  ASSERT_EQ(code_of("run compaction_100 --steps 20 --no-page --out run"), 0);
  const std::string ledger = content("run/ledger.csv");
  const std::size_t row = ledger.find("\n7,");
  write("run/ledger.csv", changed(ledger, {{"\n7,", "\nabc,"}}));
  EXPECT_NE(row, std::string::npos);
  expect_said("run compaction_100 --restart run --steps 1 --no-page", 4,
              {"ledger.csv", "without the number of its step"});
  write("run/ledger.csv", ledger);
  // A summary of another kind is as good as none.
  for (const char* summary :
       {"{\"last_step\": \"x\"}", "{\"last_step\": 20, \"status\": 3}", "[]"}) {
    write("run/summary.json", summary);
    EXPECT_NE(code_of("run compaction_100 --restart run --no-page"), 3) << summary;
  }
}

TEST_F(Command, ASolverOfAnotherBuildNamesItsOption) {
  if (bipot("list solvers").out.find("siconos:nsgs") != std::string::npos) {
    GTEST_SKIP() << "built with Siconos";
  }
  const json run = json_of("run square_lattice --solver siconos:nsgs --json -", 2);
  EXPECT_TRUE(says(run["message"], "BIPOT_WITH_SICONOS"));
}

TEST_F(Command, InterruptedRunLeavesAReadableState) {
  expect_interrupted("run compaction --tol 1e-3 --out out");
  const State<2> state = read_state("out/run.h5");
  EXPECT_EQ(state.bodies.size(), 342u);
  EXPECT_GT(state.step, 0);
  EXPECT_EQ(json_in("out/summary.json")["status"], "interrupted");
}

TEST_F(Command, ComparisonLeavesATableAndAPage) {
  const std::string arguments =
      "compare square:4 pyramid:3 --solvers pgs,ipm,lemke --tols 1e-2,1e-6 --quick --out out";
  const json j = json_of(arguments + " --json -");  // nothing else on standard output
  EXPECT_EQ(j["rows"].size(), 12u);
  EXPECT_EQ(j["rows_kept"], 0);
  EXPECT_TRUE(j["complete"]);
  for (const json& row : j["rows"]) EXPECT_EQ(row["status"], "converged") << row;
  expect_files("out", {"rows.csv", "comparison.csv", "comparison.json", "report.html",
                       "problems/square_4.hdf5", "references/pyramid_3.json"});
  const std::string table = content("out/comparison.csv");
  expect_said(arguments, 0, {"12 of 12 rows from before"}, &bipot);
  EXPECT_EQ(content("out/comparison.csv"), table);
  // The progress on a terminal.
  const std::string shown = "script -qec '" BIPOT_COMMAND " " + arguments + "' /dev/null";
  EXPECT_TRUE(says(run_command_line(shown, "").out, "pyramid:3 lemke 1e-6"));
  EXPECT_EQ(code_of("compare no_such_thing"), 2);
  write("no_problem.hdf5", "hi");
  EXPECT_EQ(code_of("compare no_problem.hdf5 --solvers pgs --tols 1e-2 --quiet"), 2);
  EXPECT_EQ(code_of("compare square:4 --solvers pgz"), 2);
  EXPECT_EQ(code_of("compare square:4 --whole-runs no_such_scene --out nothing"), 2);
  EXPECT_FALSE(fs::exists("nothing"));
  EXPECT_EQ(code_of("compare square:4 --out /proc/nowhere"), 4);
}

TEST_F(Command, JudgesPopularSettingsAndSubmittedImpulses) {
  const json j = json_of("compare square:4 --settings popular --quick --json - --out set");
  EXPECT_EQ(j["settings"].size(), 8u);
  EXPECT_GT(j["tolerances"].size(), 4u);
  expect_files("set", {"settings.csv", "popular.svg", "report.html"});
  for (const char* const flag : {"--tols 1e-3", "--solvers apgd", "--repeat 3", "--min-time 1",
                                 "--try-all", "--whole-runs pyramid", "--threads 2"}) {
    EXPECT_EQ(code_of(fmt::format("compare square:4 --settings popular --quick {}", flag)), 2);
  }
  EXPECT_EQ(code_of("compare"), 2);
  fs::copy_file(source_folder() / "data/problems/2d_triangular_lattice.hdf5", "set.hdf5");
  fs::create_directories("mine");
  EXPECT_EQ(code_of("solve set.hdf5 --tol 1e-9 --quiet --solution mine/set.hdf5"), 0);
  const json board = json_of("leaderboard mine --problems set.hdf5 --json - --out board");
  ASSERT_EQ(board["solved"].size(), 2u);  // it, and auto
  EXPECT_EQ(board["solved"][0]["who"], "mine");
  EXPECT_EQ(board["solved"][0]["solved_1e-8"], 1);
  expect_files("board", {"leaderboard.csv", "index.html"});
  EXPECT_EQ(code_of("leaderboard nowhere"), 4);
  std::ofstream("mine/set.csv") << "1 2 3\n";  // comes before the other
  const std::string without = "leaderboard mine --problems set.hdf5 --no-solvers";
  EXPECT_TRUE(says(whole_output(without).out, "mine, set: "));
  EXPECT_EQ(code_of(without + " --solvers pgs"), 2);
}

TEST_F(Command, TuneWritesAPlanThatSolveAndRunTake) {
  const std::string arguments =
      "tune square:4 pyramid:4 --solvers pgs,ipm --tols 1e-2,1e-6 --least-rows 2 --out plan.toml";
  expect_said(arguments, 0,
              {"tuned, scenes left out", "auto, present plan", "ipm",
               "12 rows in plan.csv, 0 of them from before"},
              &bipot);
  const std::string rows = content("plan.csv"), text = content("plan.toml");
  EXPECT_TRUE(says(text, "[[class]]"));
  EXPECT_TRUE(says(bipot(arguments).out, ", 12 of them from before"));
  EXPECT_EQ(bipot(arguments + " -q").out, "");
  EXPECT_EQ(content("plan.csv"), rows);
  EXPECT_EQ(content("plan.toml").substr(text.find('\n')),
            text.substr(text.find('\n')));  // from the rows
  const std::string problem = shipped_problem("1d_square_20");
  expect_said("solve " + problem + " --explain --plan plan.toml", 0, {"plan.toml: "}, &bipot);
  const json told = json_of("solve " + problem + " --explain --json -");
  EXPECT_TRUE(says(told["explanation"].get<std::string>(), "contacts, d = "));
  EXPECT_EQ(code_of("solve " + problem + " --solver pgs --plan plan.toml"), 2);
  EXPECT_EQ(code_of("run four_spheres --steps 2 --plan plan.toml --out run"), 0);
  std::ofstream("plan.toml") << "[[class]]\nname = 'a'\nstages = [{solver = 'pgz'}]\n";
  expect_said("solve " + problem + " --json - --plan plan.toml", 2,
              {"plan.toml:3: unknown solver 'pgz'"}, &bipot);
  const std::string one_row = "tune square:4 --solvers pgs --tols 1e-2 --least-rows 1 -q ";
  EXPECT_EQ(code_of(one_row + "--out new/folder/plan.toml"), 0);
  EXPECT_EQ(code_of("tune no_such_thing --out plan.toml"), 2);
  fs::create_directory("own");
  fs::copy_file(shipped_scene("four_spheres"), "own/my.toml");
  EXPECT_EQ(code_of("tune own/my.toml:steps=20 --solvers pgs --tols 1 --least-rows 1 -q"), 0);
  EXPECT_TRUE(fs::exists("own/plan.toml"));
  EXPECT_EQ(code_of("tune --out none.toml"), 2);
  EXPECT_EQ(code_of("tune square:4 --solvers auto --out none.toml"), 2);
  EXPECT_EQ(code_of("tune square:4 --solvers pgs --out none.csv"), 2);  // the rows
  for (const char* none : {"none.toml", "none.csv"}) EXPECT_FALSE(fs::exists(none)) << none;
  const std::string hopeless =
      "tune pyramid:8 --solvers pgs --tols 1e-12 --time-limit 1e-6 -q --out hard.toml";
  EXPECT_EQ(code_of(hopeless), 1);
  EXPECT_FALSE(fs::exists("hard.toml"));
  write("apart.toml",
        "time = { step = 1e-3, steps = 2 }\n[[disks]]\nposition = [0, 0]\nradius = 1\nmass = 1\n");
  expect_said("tune apart.toml --out free.toml", 2, {"nothing touches in the targets"});
  EXPECT_TRUE(fs::exists("hard.csv"));
  // No contact arises in two steps of this scene: nothing but the check would read the plan.
  const std::string run = "run drum --steps 2 --no-page --out none";
  EXPECT_EQ(code_of(run + " --plan plan.toml"), 2);
  EXPECT_EQ(code_of(run + " --plan missing.toml"), 4);
  EXPECT_EQ(code_of("solve " + problem + " --plan missing.toml"), 4);
}

TEST_F(Command, AdviceIsWrittenIntoACopyOfTheScene) {
  const std::string scene =
      write("scene.toml", changed(content(shipped_scene("triangular_lattice")),
                                  {{"steps = 10", "steps = 40"}}));  // for several stretches
  const std::string arguments = "advise " + scene +
                                " --force-error 1e-2 --solvers apgd,ipm --time-limit 20 --json - "
                                "--write advised.toml";
  const json j = json_of(arguments);  // nothing else on standard output
  EXPECT_EQ(j["status"], "met");
  EXPECT_EQ(j["advised_run"]["steps_run"], j["advised_run"]["steps_planned"]);
  EXPECT_TRUE(j["goal"]["energy"].is_null());            // not asked for
  EXPECT_EQ(code_of(arguments), 2);                      // the copy exists
  const json written = json_of(arguments + " --force");  // times decide: the choice may differ
  const json r = json_of("run advised.toml --json -");
  EXPECT_EQ(r["solver"], written["advice"]["solver"]);
  EXPECT_EQ(r["tol"], written["advice"]["tol"]);
  EXPECT_EQ(r["steps"], written["advice"]["steps"]);
  // Without a goal: five lines, the last of which is a command that runs, and a page.
  const Outcome five =
      bipot("advise " + scene + " --solvers ipm --time-limit 20 --tune --out advice");
  EXPECT_EQ(five.exit_code, 0) << five.out;
  EXPECT_TRUE(says(five.out, "tuned, problems left out")) << five.out;
  EXPECT_TRUE(says(content("plan.toml"), "solver = \"ipm\""));
  EXPECT_TRUE(says(five.out, "--plan plan.toml"));
  const std::size_t command = five.out.find("bipot run ");
  ASSERT_NE(command, std::string::npos) << five.out;
  const std::string line = five.out.substr(command + 6, five.out.find('\n', command) - command - 6);
  EXPECT_EQ(code_of(line + " --out as_advised"), 0) << line;
  const std::size_t last = five.out.rfind("bipot run ");
  const std::string planned = five.out.substr(last + 6, five.out.find('\n', last) - last - 6);
  const json with_plan = json_of(planned + " --json -");
  const json advised = json_in("advice/advice.json")["advice"];
  EXPECT_EQ(with_plan["tol"], advised["tol"]);
  EXPECT_EQ(with_plan["steps"], advised["steps"]);
  EXPECT_EQ(with_plan["solver"], "auto");
  EXPECT_TRUE(says(content("advice/advice.html"), "Step and tolerance"));
  EXPECT_TRUE(says(content("advice/advice.csv"), "choice,solver,tol,"));
  EXPECT_EQ(code_of("advise " + scene + " --force-error 1e-2 --json /proc/nowhere/a.json"), 4);
  EXPECT_EQ(code_of("advise " + scene + " --energy nan"), 2);
  EXPECT_EQ(code_of("advise " + scene + " --solvers auto --tune"), 2);
  EXPECT_TRUE(says(bipot("advise " + scene + " --tune 2>&1 | cat").out,
                   "plan.toml exists: move it, or give --force"));
}

TEST_F(Command, PaperItemsBecomeAPageThatKeepsItsOtherItems) {
  const std::string arguments = "paper --quick --out out";
  const json j = json_of(arguments + " --only table2 --json -");  // nothing else on standard output
  EXPECT_EQ(j["checks"], j["checks_held"]);
  EXPECT_GT(j["checks"], 2);
  EXPECT_FALSE(j["all_items_done"]);
  ASSERT_EQ(code_of(arguments + " --only table1"), 0);
  const json both = json_in("out/results.json");
  for (const json& item : both["items"]) {
    const bool made = item["name"] == "table1" || item["name"] == "table2";
    EXPECT_EQ(item["status"], made ? "done" : "not run") << item["name"];
  }
  const std::string page = content("out/index.html");
  for (const char* name : {"table2_velocity.svg", "table1_film.csv"}) {
    EXPECT_TRUE(says(page, name)) << name;
    EXPECT_GT(fs::file_size(std::string("out/") + name), 100u) << name;
  }
  EXPECT_EQ(code_of("paper --only table3 --out out"), 2);
  EXPECT_EQ(code_of("paper --only table2 --out /proc/nowhere"), 4);
}

TEST_F(Command, InterruptedPaperKeepsWhatIsDone) {
  expect_interrupted("paper --only table2,fig13 --out out");
  const json results = json_in("out/results.json");
  for (const json& item : results["items"]) {
    if (item["name"] != "table2" && item["name"] != "fig13") continue;
    EXPECT_EQ(item["status"], item["name"] == "table2" ? "done" : "interrupted");
  }
  EXPECT_GT(fs::file_size("out/index.html"), 100u);
}

TEST_F(Command, InterruptedMeasurementsSaySoAndLeaveValidFiles) {
  expect_interrupted(
      "compare pile:24 --tols 1e-2,1e-4,1e-6,1e-8,1e-10 --min-time 1 "
      "--json compare.json --out compare");
  EXPECT_EQ(json_in("compare.json")["complete"], false);
  EXPECT_EQ(json_in("compare/comparison.json")["complete"], false);
  EXPECT_GT(fs::file_size("compare/report.html"), 100u);

  expect_interrupted(
      "extremes --random-problems 100000 --random-scenes 9 --solver auto --json random.json");
  EXPECT_EQ(json_in("random.json")["complete"], false);

  expect_interrupted("trade compaction --json trade.json --out trade");
  EXPECT_EQ(json_in("trade.json")["complete"], false);
  EXPECT_EQ(json_in("trade/trade.json")["complete"], false);

  expect_interrupted("validate --quick --out validate");
  EXPECT_EQ(json_in("validate/validate.json")["all_items_done"], false);

  expect_interrupted("advise compaction --force-error 1e-2 --json advice.json");
  EXPECT_EQ(json_in("advice.json")["status"], "interrupted");
  EXPECT_EQ(json_in("advice.json")["exit_code"], 5);
}

TEST_F(Command, TimeLimitLeavesTheLastWholeStep) {
  const json j = json_of("run compaction --tol 1e-6 --time-limit 1.5 --json - --out out", 1);
  EXPECT_EQ(j["status"], "time limit");
  EXPECT_EQ(j["message"], "");                  // the status says all
  EXPECT_EQ(j["steps"], j["steps_converged"]);  // the step that was cut short is not taken
  EXPECT_EQ(read_state("out").step, j["steps"]);
}

TEST_F(Command, RestartRefusesAnotherScene) {
  ASSERT_EQ(code_of("run sliding_cylinder --steps 5 --quiet --out a"), 0);
  const std::string text =
      changed(content(shipped_scene("sliding_cylinder")), {{"radius = 0.01", "radius = 0.02"}});
  const json j = json_of("run " + write("other.toml", text) + " --json - --restart a",
                         2);  // refusals are JSON too
  EXPECT_EQ(j["status"], "invalid input");
  EXPECT_TRUE(says(j["message"], "radius"));
}

TEST_F(Command, ForeignOutputDoesNotMixWithJson) {
  if (json_of("list solvers --json -").dump().find("\"newton\"") == std::string::npos) {
    GTEST_SKIP() << "built without PETSc: there is no foreign output";
  }
  const json solve = json_of("solve " + shipped_problem("2d_triangular_lattice") +
                             " --solver newton --petsc \"-snes_monitor -ksp_view\" --json -");
  EXPECT_EQ(solve["status"], "converged");
}

TEST_F(Command, SpringDashpotModelRunsTheSameScene) {
  const json j = json_of("run square_lattice --model dem --steps 60 --json - --out a");
  EXPECT_EQ(j["status"], "completed");
  EXPECT_EQ(j["model"], "dem");
  EXPECT_TRUE(j["epsilon"].is_null());  // there is no contact problem to judge
  EXPECT_EQ(j["iterations_max"], j["dem"]["substeps_per_step"]);
  EXPECT_LT(j["dem"]["substep"], j["dem"]["critical_step"]);
  EXPECT_FALSE(j["dem"]["departures"].empty());  // e_n = 0
  EXPECT_GT(j["penetration"], 1e-6);
  EXPECT_TRUE(says(j["overlap"]["pair"], "disk "));
  expect_files("a", {"run.h5", "run.xdmf", "ledger.csv", "forces.svg", "summary.json"});
  // 40 and 20 steps with a restart between: the same bits.
  ASSERT_EQ(code_of("run square_lattice --model dem --steps 40 -q --out b"), 0);
  ASSERT_EQ(code_of("run square_lattice --model dem --steps 20 -q --restart b --out b"), 0);
  const State<2> whole = read_state("a"), parts = read_state("b");
  EXPECT_EQ(bits_of_bodies(whole), bits_of_bodies(parts));
  EXPECT_EQ(content("a/ledger.csv"), content("b/ledger.csv"));
  // Unstable substeps, flags of the other model and a stiffness that gives way are refused.
  EXPECT_EQ(code_of("run square_lattice --model dem --substep 1e-3"), 2);
  EXPECT_EQ(code_of("run square_lattice --model dem --tol 1e-3"), 2);
  const json sums = json_of("run square_lattice --model dem --reproducible --json -", 2);
  EXPECT_TRUE(says(sums["message"], "--reproducible has no meaning under --model dem"));
  EXPECT_EQ(code_of("run square_lattice --stiffness 1e6"), 2);
  EXPECT_EQ(code_of("run square_lattice --model dem --stiffness 1e3 --steps 100"), 3);
}

TEST_F(Command, TradeRunsWholeSimulationsAndLeavesAPage) {
  const std::string text = changed(content(shipped_scene("square_lattice")),
                                   {{"columns = 10", "columns = 3"},
                                    {"rows = 10", "rows = 3"},
                                    {"point = [0.2, 0.0]", "point = [0.06, 0.0]"}});
  write("tiny.toml", text);
  const json j = json_of(
      "trade --quick tiny.toml:steps=30 --json - --out out");  // nothing else on standard output
  EXPECT_TRUE(j["complete"]);
  // 2 tolerances, the witness, 2 more time steps, an accuracy, 2 kinds of springs; disks that stand
  // need no replicas.
  ASSERT_EQ(j["rows"].size(), 8u);
  EXPECT_EQ(j["rows"][2]["solver"], "apgd");
  for (const json& row : j["rows"]) EXPECT_EQ(row["status"], "completed") << row;
  const json& settings = j["scenes"][0]["settings"];
  EXPECT_GT(settings[6]["penetration"], 5 * settings[7]["penetration"].get<double>());
  EXPECT_FALSE(j["scenes"][0]["answer"].get<std::string>().empty());
  expect_files("out", {"trade.csv", "trade.json", "trade.html"}, 1000);
  EXPECT_EQ(code_of("trade no_such_scene"), 2);
  EXPECT_EQ(code_of("trade tiny.toml --solvers pgz"), 2);
  EXPECT_EQ(code_of("trade tiny.toml:steps=x"), 2);
  expect_said("trade tiny.toml:stps=3", 2, {"unknown part 'stps'; did you mean 'steps'?"});
  EXPECT_EQ(code_of("trade tiny.toml --overlaps 0.5"), 2);
  expect_said("trade tiny.toml --step-sizes 1e-3", 2, {"did you mean '--step-factors'"});
  EXPECT_EQ(code_of("trade tiny.toml --out /proc/nowhere"), 4);
  EXPECT_EQ(code_of("trade tiny.toml --json /proc/nowhere/a.json"), 4);
  EXPECT_EQ(json_of("trade no_such_scene --json -", 2)["exit_code"], 2);
}

TEST_F(Command, AStepThatIsNotSolvedLeavesItsProblemAndSaysWhatToTry) {
  // Ten sweeps are too few for the first disks that land on others, in step 28.
  const std::string run = "run " + shipped_scene("compaction_100") +
                          " --solver pgs --tol 1e-3 "
                          "--max-iterations 10 --steps 40 --on-failure stop --out out";
  const std::string stopped = expect_said(
      run, 1,
      {"worst contact", "disk 7 and disk 15", "a solution exists (proved", "1. ", "3. ", "try "},
      &complaints);
  EXPECT_TRUE(fs::exists("out/problems/step_000028.hdf5"));
  EXPECT_EQ(code_of("solve out/problems/step_000028.hdf5 -q"), 0);
  EXPECT_TRUE(says(stopped, "smaller-step"));
  // What was tried is not proposed again.
  const std::string split = expect_said("run " + shipped_scene("compaction_100") +
                                            " --solver pgs --tol 1e-12 --max-iterations 1 --steps "
                                            "40 --on-failure smaller-step",
                                        1, {"3. "}, &complaints);
  EXPECT_FALSE(says(split, "smaller-step")) << split;
}

// A long step of disks that land on each other: with these limits steps 18 and 23 are not solved
// whole, and those after them begin in parts. A restart after step 18 goes on as the run did.
TEST_F(Command, ARestartGoesOnAcrossSplitStepsBitForBit) {
  std::string text = content(shipped_scene("compaction_100"));
  text.replace(text.find("every ="), text.find('\n', text.find("every =")) - text.find("every ="),
               "every = 1");
  const std::string run = "run " + write("fall.toml", text) +
                          " --solver anderson --tol 1e-2 --step-size 3e-3 --max-iterations 500 "
                          "--on-failure smaller-step --out ";
  const auto split = [](const Outcome& o) { return json::parse(o.out)["steps_split"].get<int>(); };
  const Outcome whole = bipot(run + "whole --steps 26 --json -");
  ASSERT_EQ(whole.exit_code, 0) << whole.out;
  EXPECT_EQ(split(whole), 7);
  EXPECT_EQ(split(bipot(run + "part --steps 18 --json -")), 1);
  const Outcome rest = bipot(run + "part --restart part --steps 8 --json -");
  ASSERT_EQ(rest.exit_code, 0) << rest.out;
  EXPECT_EQ(split(rest), 6);
  EXPECT_EQ(content("whole/ledger.csv"), content("part/ledger.csv"));
  int frames = 0;
  for (const auto& frame : fs::directory_iterator("whole/frames")) {
    ++frames;
    EXPECT_EQ(content(frame.path()), content("part/frames" / frame.path().filename()))
        << frame.path();
  }
  EXPECT_EQ(frames, 27);
}

TEST_F(Command, ExtremesLeaveAPageAndAnExitCode) {
  EXPECT_EQ(code_of("extremes --only s --solver auto,pgs --quick --out out"), 0);
  expect_files("out", {"extremes.csv", "extremes.html", "extremes.json", "extremes.md"});
  const json extremes = json_in("out/extremes.json");
  for (const json& row : extremes["cells"]) {
    EXPECT_EQ(row["steps_solved"] == row["steps"], row["end"] == "solved") << row;
  }
  EXPECT_EQ(code_of("extremes --only no_such_case"), 2);
  expect_said(
      "extremes --random-problems 6 --random-scenes 2 --solver auto --out out --json r.json", 0,
      {"6 random problems"}, &bipot);
  const json random = json_in("r.json");
  EXPECT_EQ(random["sets"][0]["done"], 6);
  EXPECT_EQ(random["tallies"][0]["tried"], 6);
  EXPECT_EQ(random["tallies"][0]["false_claims"], 0);
  EXPECT_TRUE(fs::exists("out/random.csv"));
  // One of the set, on its own.
  ASSERT_EQ(code_of("extremes --random-problems 1 --first 4 --dump-problem 4.hdf5"), 0);
  EXPECT_EQ(code_of("solve 4.hdf5 -q"), 0);
  for (const char* without_effect :
       {"--random-problems 2 --only wedge", "--only wedge --seed 9", "--only wedge --first 5",
        "--random-problems 1 --dump-problem 5.hdf5 --out out", "--random-problems 0",
        "--random-problems 1 --dump-problem 5.hdf5 --random-scenes 3",
        "--only wedge --dump-problem 5.hdf5 --quick",
        "--random-problems 1 --dump-problem 5.hdf5 --solver pgs", "--only column_1000 --quick"}) {
    EXPECT_EQ(code_of(fmt::format("extremes {}", without_effect)), 2) << without_effect;
  }
}

TEST_F(Command, StudyDrawsItsRowsAgain) {
  ASSERT_EQ(code_of("study --quick --only answers -q --out out"), 0);
  expect_files("out", {"index.html", "rows.csv", "answers_speed.svg"});
  const std::string drawn = read_text_file("out/answers_speed.svg");
  ASSERT_EQ(code_of("study --draw -q --rows out/rows.csv --out again"), 0);
  EXPECT_EQ(read_text_file("again/answers_speed.svg"), drawn);
  EXPECT_EQ(code_of("study --only no_such_part"), 2);
  EXPECT_EQ(code_of("study --draw --quick --rows out/rows.csv --out none"), 2);
  EXPECT_EQ(code_of("study --draw --only depth --rows out/rows.csv --out none"), 4);
  expect_said("study --draw --rows none.csv --out none", 4, {"none.csv", "No such file"});
}

TEST_F(Command, ValidateLeavesAPageAndAnExitCode) {
  const std::string out = expect_said("validate --quick --only disk_,groove --out out", 0,
                                      {"disk_rolls", "groove_interval"}, &bipot);
  EXPECT_FALSE(says(out, "sphere_")) << out;
  expect_files("out",
               {"index.html", "validate.json", "validate.csv", "verdicts.csv", "errors_1.svg"});
  const json told = json_of("validate --quick --only groove_interval --json -");
  const json& claim = told["items"][0]["numbers"][0];
  EXPECT_EQ(claim["name"], "groove_interval");
  EXPECT_EQ(claim["holds"], true);
  EXPECT_FALSE(claim["source"].empty());
  EXPECT_EQ(code_of("validate --only no_such_row"), 2);
  EXPECT_EQ(code_of("validate --quick --only disk_,brazil_nut"), 2);  // it has no short form
  EXPECT_EQ(code_of("validate --solver no_such_solver"), 2);
  // What does not hold is said, with the reason.
  expect_said("validate --quick --only three_disks --max-iterations 1", 1,
              {"does not hold", "did not reach"}, &bipot);
}

TEST_F(Command, ListsWhatItHas) {
  EXPECT_EQ(json_of("list solvers --json -")[0]["name"], "auto");
  EXPECT_GE(json_of("list scenes --json -").size(), 6u);
}

TEST_F(Command, OneSolverIsListedWithItsParameters) {
  const json j = json_of("list solvers pgs --json -");
  EXPECT_EQ(j["name"], "pgs");
  bool omega = false;
  for (const json& p : j["parameters"]) {
    if (p["name"] != "omega") continue;
    omega = true;
    EXPECT_EQ(p["flag"], "--omega");
    EXPECT_EQ(p["default"], "1");
    EXPECT_EQ(p["domain"], "number in [0.001, 1.999]");
    EXPECT_TRUE(p.contains("unit"));
  }
  EXPECT_TRUE(omega);
  expect_said("list solvers apgd", 0, {"--step", "1/lambda_max"}, &bipot);
  expect_said("list solvers pgs", 0, {"integer in [0, 4294967295]"}, &bipot);
  EXPECT_EQ(code_of("list scenes pgs"), 2);
  // What the list names is a flag, though the help of the commands passes over it.
  for (const json& solver : json::parse(bipot("list solvers --json -").out)) {
    for (const json& p : solver["parameters"]) {
      const std::string flag = p["flag"];
      const Outcome run = bipot("run square_lattice --overwrite --steps 0 --json - --solver " +
                                solver["name"].get<std::string>() + " " + flag + " ''");
      if (run.exit_code == 0) continue;  // a text may be empty
      const std::string message = json::parse(run.out)["message"];
      EXPECT_TRUE(says(message, p["name"].get<std::string>())) << flag << message;
    }
  }
}

TEST_F(Command, HelpFitsOnAScreen) {
  for (const char* command : {"", "run", "solve", "compare", "advise", "trade", "paper", "list"}) {
    std::istringstream help(bipot(std::string(command) + " --help").out);
    int lines = 0;
    for (std::string line; std::getline(help, line); ++lines) {
      const auto columns =
          std::count_if(line.begin(), line.end(), [](char c) { return (c & 0xC0) != 0x80; });
      EXPECT_LE(columns, 100) << command << ": " << line;
    }
    EXPECT_LE(lines, 48) << command;
    EXPECT_GT(lines, 5) << command;
  }
}

TEST_F(Command, TheBenchmarksHelpShowsItsOwnFlagsAndGoogles) {
  const Outcome help = run_command_line(BIPOT_SOLVER_BENCH, "--help");
  EXPECT_EQ(help.exit_code, 0);
  for (const char* flag : {"--solver", "--family", "--sizes", "--fit-out", "--benchmark_out"}) {
    EXPECT_TRUE(says(help.out, flag)) << flag;
  }
  EXPECT_EQ(run_command_line(BIPOT_SOLVER_BENCH, "--no-such-flag").exit_code, 2);
}

TEST_F(Command, ThePeersBenchmarkHoldsSolversAgainstSiconosOrSaysThatItIsNotThere) {
  const Outcome out =
      run_command_line("(" BIPOT_PEER_BENCH,
                       "square:4 --tols 1e-4 --repeat 1 --variants planar,newton --solvers auto "
                       "--csv peers.csv 2>&1)");
#ifdef BIPOT_WITH_SICONOS
  EXPECT_EQ(out.exit_code, 0) << out.out;
  // Four lines: two variants, `auto` by natural map and by the shared criterion; all of them met.
  for (const char* who : {"Siconos planar", "Siconos newton", "auto (map)", "auto (ε, η)"}) {
    EXPECT_TRUE(says(out.out, who)) << who;
  }
  EXPECT_FALSE(says(out.out, "not met")) << out.out;
  EXPECT_TRUE(fs::exists("peers.csv"));
#else
  EXPECT_EQ(out.exit_code, 2);
  EXPECT_TRUE(says(out.out, "built without Siconos"));
  EXPECT_TRUE(says(out.out, "-DBIPOT_WITH_SICONOS=ON"));
#endif
}

TEST_F(Command, HelpNamesExamples) {
  for (const char* command : {"--help", "run --help", "solve --help", "compare --help",
                              "advise --help", "trade --help", "paper --help", "list --help"}) {
    expect_said(command, 0, {"Examples"}, &bipot);
  }
}

}  // namespace
}  // namespace bipot
