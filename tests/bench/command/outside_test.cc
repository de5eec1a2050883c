// What surrounds the program: files that are none, outputs that cannot be written, hostile texts,
// signals.

#include <sys/stat.h>

#include "core/files/hdf5_file.h"
#include "solvers/registry.h"
#include "tests/bench/command/command_fixture.h"

namespace bipot {
namespace {

std::string a_problem() { return shipped_problem("2d_pyramid_10"); }

/// One disk above a floor.
std::string scene_with(const std::string& first_lines) {
  return first_lines + R"(
time = {step = 1e-3, steps = 2}
contact = {mu = 0.3}
walls = [{name = "floor", point = [0, 0], normal = [0, 1]}]
disks = [{position = [0, 1], radius = 0.5, mass = 1}]
)";
}

/// The command with an end after ten seconds (124), if it waits.
Outcome limited(const std::string& arguments) {
  return run_command_line("timeout 10 " BIPOT_COMMAND, arguments);
}

/// What it says on standard error.
std::string complaint(const std::string& arguments, const std::string& output = "/dev/null") {
  return run_command_line("sh -c '" BIPOT_COMMAND " " + arguments + " 2>&1 >" + output + "'", "")
      .out;
}

TEST_F(Command, OnlyRegularFilesAreRead) {
  const std::string pipe = "pipe.hdf5";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const std::string& words : std::initializer_list<std::string>{
           "solve " + pipe, "judge " + pipe, "judge " + a_problem() + " --impulses " + pipe,
           "run " + pipe, "run drum --plan " + pipe, "compare " + pipe + " --quick",
           "solve /dev/zero", "run /dev/zero", "judge " + a_problem() + " --impulses /dev/zero",
           "run " + folder_.string()}) {
    EXPECT_EQ(limited(words).exit_code, 2) << words;
  }
}

TEST_F(Command, ScenesAndProblemsAreToldApart) {
  const std::string scene = source_folder().string() + "/data/scenes/drum.toml";
  expect_said("solve " + scene, 2, {"a scene, not a contact problem"});
  expect_said("run " + a_problem(), 2, {"an HDF5 file, not a scene"});
}

TEST_F(Command, OutputThatIsNotWrittenIsAFailure) {
  write("one.toml", scene_with(""));
  for (const std::string& words : std::initializer_list<std::string>{
           "solve " + a_problem() + " --tol 1e-3 --json -", "solve " + a_problem() + " --tol 1e-3",
           std::string("list scenes"), std::string("--help"), std::string("help --man"),
           "run one.toml --out out"}) {
    EXPECT_EQ(code_of(words + " >/dev/full"), 4) << words;
  }
  EXPECT_TRUE(says(complaint("list scenes --json -", "/dev/full"), "No space left"));
}

TEST_F(Command, APipeIsWrittenOnceItIsRead) {
  const std::string pipe = "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const std::string solve = "solve " + a_problem() + " --tol 1e-3 -q --json " + pipe;
  const Outcome read = bipot(solve + " & cat " + pipe + "; wait $!");
  EXPECT_EQ(nlohmann::json::parse(read.out)["exit_code"], 0);
  // Nobody reads: the signal ends it.
  EXPECT_EQ(run_command_line("timeout --kill-after=20 3 " BIPOT_COMMAND, solve).exit_code, 124);
}

TEST_F(Command, AFailureReplacesNoEarlierResult) {
  ASSERT_EQ(code_of("solve " + a_problem() + " --tol 1e-3 --json verdict.json"), 0);
  const std::string verdict = content("verdict.json");
  EXPECT_EQ(code_of("solve no_such_file --json verdict.json"), 4);
  EXPECT_EQ(content("verdict.json"), verdict);
  EXPECT_EQ(code_of("solve no_such_file --json new.json"), 4);
  EXPECT_EQ(json_in("new.json")["exit_code"], 4);
}

TEST_F(Command, KeysWithManyPartsAreRefused) {
  std::string key = "a";
  for (int k = 0; k < 50000; ++k) key += ".a";
  EXPECT_EQ(code_of("run " + write("deep.toml", key + " = 1\n")), 2);
  EXPECT_EQ(code_of("run " + write("deep_table.toml", "[" + key + "]\n")), 2);
  // Dots elsewhere do not count.
  const std::string dots(1000, '.');
  const std::string scene = scene_with("title = \"" + dots + "\"  # " + dots + "\n");
  EXPECT_EQ(code_of("run " + write("dots.toml", scene) + " --out dots"), 0);
}

TEST_F(Command, TitlesHarmNeitherTerminalNorPicture) {
  const std::string scene = scene_with(R"(title = "a\u001b]0;own\u0007\uFFFE\U0010FFFF b")");
  const Outcome run = bipot("run " + write("title.toml", scene) + " --out out");
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.out.find('\x1b'), std::string::npos);
  EXPECT_EQ(run.out.find('\x07'), std::string::npos);
  EXPECT_TRUE(fs::exists("out/summary.json"));
  EXPECT_TRUE(fs::exists("out/forces.svg"));
  // Nor do keys in messages.
  write("key.toml", "\"\\u001b[2J\" = 1\n" + scene_with(""));
  EXPECT_EQ(complaint("run key.toml").find('\x1b'), std::string::npos);
}

TEST_F(Command, TablesOfAllPairsOfMaterialsHaveALimit) {
  std::string names = "\"m0\"";
  for (int k = 1; k < 20000; ++k) names += ", \"m" + std::to_string(k) + "\"";
  write("many.toml", scene_with("materials = [" + names + "]\n"));
  EXPECT_EQ(limited("run many.toml").exit_code, 2);
}

TEST_F(Command, ProblemFilesCannotReadOtherFiles) {
  fs::copy_file(a_problem(), "linked.hdf5");
  {
    Hdf5File file("linked.hdf5", Hdf5File::Mode::kAppend);
    file.remove("/fclib_global/vectors/mu");
    file.link("/fclib_global/vectors/mu", a_problem(), "/fclib_global/vectors/mu");
  }
  EXPECT_EQ(code_of("solve linked.hdf5"), 2);
}

TEST_F(Command, MpiFindsAFolderForItsFiles) {
  if (find_solver("newton") == nullptr) GTEST_SKIP() << "no PETSc, hence no MPI";
  const Outcome solve = run_command_line("TMPDIR=/proc/nowhere " BIPOT_COMMAND,
                                         "solve " + a_problem() + " --solver newton --tol 1e-6");
  EXPECT_EQ(solve.exit_code, 0);
}

/// Also while the problems are made.
TEST_F(Command, ASignalEndsTheRunThatMakesProblems) {
  EXPECT_EQ(
      code_of("compare pour:100 --quick --solvers apgd -q --out out & p=$!; sleep 2; kill $p; "
              "for k in $(seq 200); do sleep 0.1; kill -0 $p || break; done; kill -9 $p; "
              "wait $p; exit $?"),
      5);
}

/// A gnuplot that hangs does not outlive the signal.
TEST_F(Command, ASignalEndsTheWaitForGnuplot) {
  ASSERT_EQ(chmod(write("gnuplot", "#!/bin/sh\nexec sleep 600\n").c_str(), 0700), 0);
  const Outcome run = run_command_line(
      "PATH=" + folder_.string() + ":$PATH timeout --kill-after=20 3 " BIPOT_COMMAND,
      "compare square:4 --quick --solvers pgs --out out");
  EXPECT_NE(run.exit_code, 137);  // timeout had to kill it
}

}  // namespace
}  // namespace bipot
