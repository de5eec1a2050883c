// What `bipot run` refuses, keeps and says: the start, the folder of the results, the time.

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "core/run_files/run_reader.h"
#include "tests/bench/command/command_fixture.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

using RunCommand = Command;

/// Both streams, in one text.
Outcome both_streams(const std::string& arguments) {
  return run_command_line(BIPOT_COMMAND, arguments + " 2>&1 #");
}

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// Five rows of disks, 40 mm high; the lid hangs at 28 mm and cuts two rows off.
std::string cut_packing(const std::string& more = "") {
  return "[[disks]]\narrangement = 'rectangular'\ncolumns = 3\nrows = 5\nradius = 0.004\n"
         "mass = 1\n[[walls]]\npoint = [0, 0]\nnormal = [0, 1]\n"
         "[[walls]]\nname = 'lid'\npoint = [0, 0.028]\nnormal = [0, -1]\n"
         "[time]\nstep = 1e-4\nsteps = 3\n" +
         more;
}

TEST_F(RunCommand, AStartThatOverlapsIsRefusedWithAPicture) {
  const std::string scene = write("cut.toml", cut_packing());
  for (const std::string steps : {"", " --steps 0"}) {
    const Outcome run = both_streams("run " + scene + steps);
    EXPECT_EQ(run.exit_code, 2);
    // The rows at 28 and 36 mm; the highest disk by 36 + 4 - 28 = 12 mm, 3 radii.
    EXPECT_TRUE(holds(run.out,
                      "6 disks overlap at the start, worst disk 12 and wall 'lid': 12 mm, "
                      "3 radii"))
        << run.out;
    EXPECT_TRUE(holds(run.out, "out/cut/start.png")) << run.out;
    EXPECT_GT(fs::file_size(folder_ / "out" / "cut" / "start.png"), 1000u);
    EXPECT_FALSE(fs::exists(folder_ / "out" / "cut" / "run.h5"));
    fs::remove(folder_ / "out" / "cut" / "start.png");
  }
}

TEST_F(RunCommand, AStartThatOverlapsIsAllowedOrPushedApartOnDemand) {
  const Outcome allowed = bipot(
      "run " + write("allow.toml", cut_packing("[start]\noverlaps = 'allow'\n")) + " --json -");
  ASSERT_EQ(allowed.exit_code, 0);
  const json start = json::parse(allowed.out)["start"];
  EXPECT_EQ(start["overlapping"], 6);
  EXPECT_EQ(start["pair"], "disk 12 and wall 'lid'");
  EXPECT_NEAR(start["depth"].get<double>(), 0.012, 1e-12);
  EXPECT_NEAR(start["depth_over_radius"].get<double>(), 3, 1e-9);
  // Rows one above the other cannot give way to the sides; staggered rows can.
  std::string text = cut_packing("[start]\noverlaps = 'push apart'\n");
  const Outcome jammed = both_streams("run " + write("jammed.toml", text));
  EXPECT_EQ(jammed.exit_code, 2);
  EXPECT_TRUE(holds(jammed.out, "pushed apart in ")) << jammed.out;
  text.replace(text.find("rectangular"), 11, "triangular");
  const Outcome pushed = bipot("run " + write("push.toml", text) + " --steps 0 --json -");
  ASSERT_EQ(pushed.exit_code, 0);
  const json push = json::parse(pushed.out)["start"]["pushed_apart"];
  EXPECT_GE(push["rounds"], 1);
  // Five rows of 0.008 √3/2 m: the highest disks came down by 0.008 + 0.0277 - 0.028 m at least.
  EXPECT_GE(push["way"].get<double>(), 0.0077);
  for (const Disk& d : read_state<2>(path("out/push")).bodies) {
    EXPECT_GE(d.x[1], 0.004 - 1e-7);
    EXPECT_LE(d.x[1], 0.024 + 1e-7);
  }
}

TEST_F(RunCommand, ARunIsNotDeletedUnlessToldSo) {
  const std::string run = "run sliding_cylinder --steps ";
  ASSERT_EQ(bipot(run + "7").exit_code, 0);
  const std::string ledger = content(path("out/sliding_cylinder/ledger.csv"));
  const Outcome again = both_streams(run + "2");
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_TRUE(holds(again.out,
                    "out/sliding_cylinder holds a run of 7 steps: --restart "
                    "out/sliding_cylinder or --overwrite"))
      << again.out;
  EXPECT_EQ(content(path("out/sliding_cylinder/ledger.csv")), ledger);
  // Without --out a restart goes on where it is.
  ASSERT_EQ(bipot(run + "4 --restart out/sliding_cylinder").exit_code, 0);
  EXPECT_EQ(read_state<2>(path("out/sliding_cylinder")).step, 11);
  EXPECT_EQ(bipot(run + "2 --restart out/sliding_cylinder --overwrite").exit_code, 2);
  // The folder of another run is not a place to go on to.
  ASSERT_EQ(bipot(run + "3 --out other").exit_code, 0);
  EXPECT_EQ(bipot(run + "1 --restart out/sliding_cylinder --out other").exit_code, 2);
  const Outcome over = both_streams(run + "2 --overwrite");
  EXPECT_EQ(over.exit_code, 0);
  EXPECT_TRUE(holds(over.out, "results in   out/sliding_cylinder\n")) << over.out;
  EXPECT_EQ(read_state<2>(path("out/sliding_cylinder")).step, 2);
}

TEST_F(RunCommand, TwoRunsDoNotWriteIntoOneFolder) {
  const std::string run =
      std::string("run compaction --tol 1e-6 --time-limit 20 -q --out ") + path("one");
  // The first one runs until the second one has been refused.
  const Outcome second = run_command_line(
      "sh", "-c '" BIPOT_COMMAND " " + run + " & p=$!; sleep 2; " BIPOT_COMMAND " " + run +
                " --overwrite 2>&1; code=$?; kill -INT $p; wait $p; exit $code' 2>&1 #");
  EXPECT_EQ(second.exit_code, 2);
  EXPECT_TRUE(holds(second.out, "another run writes into")) << second.out;
}

TEST_F(RunCommand, TheStepSizeLeavesTheDurationOfTheScene) {
  // duration = 0.1 s: 1000 steps of 1e-4 s, whatever the scene's own step is.
  const auto ends = [&](const std::string& flags) {
    return json::parse(bipot("run sliding_cylinder --overwrite --json - " + flags).out);
  };
  const json finer = ends("--step-size 1e-4");
  EXPECT_NEAR(finer["time"].get<double>(), 0.1, 1e-9);
  EXPECT_EQ(finer["steps"], 1000);
  EXPECT_EQ(finer["note"], "");
  const json shorter = ends("--step-size 1e-3 --duration 0.02");
  EXPECT_NEAR(shorter["time"].get<double>(), 0.02, 1e-9);
  EXPECT_EQ(shorter["note"], "the run ends at t = 0.02 s, the scene at 0.1 s");
  EXPECT_NEAR(ends("--step-size 1e-3 --steps 5")["time"].get<double>(), 0.005, 1e-9);
  EXPECT_EQ(bipot("run sliding_cylinder --overwrite --steps 5 --duration 1").exit_code, 2);
  // A restart with other steps ends when the scene does; more time is more.
  ends("--step-size 1e-3 --steps 50");
  const json rest = json::parse(
      bipot("run sliding_cylinder --step-size 5e-4 --restart out/sliding_cylinder --json -").out);
  EXPECT_EQ(rest["steps"], 100);
  EXPECT_NEAR(rest["time"].get<double>(), 0.1, 1e-9);
  const json more = json::parse(bipot("run sliding_cylinder --step-size 5e-4 --duration 0.01 "
                                      "--restart out/sliding_cylinder --json -")
                                    .out);
  EXPECT_NEAR(more["time"].get<double>(), 0.11, 1e-9);
}

TEST_F(RunCommand, WhereStepsCountTheStepSizeChangesTheTimeAndSaysSo) {
  const std::string scene = write("count.toml",
                                  "[[disks]]\nposition = [0, 1]\nradius = 0.1\nmass = 1\n"
                                  "[time]\nstep = 1e-3\nsteps = 20\n");
  const json run = json::parse(bipot("run " + scene + " --step-size 2e-3 --json -").out);
  EXPECT_EQ(run["steps"], 20);
  EXPECT_EQ(run["note"], "the run ends at t = 0.04 s, the scene at 0.02 s");
}

}  // namespace
}  // namespace bipot
