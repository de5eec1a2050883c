// What `bipot run` refuses, keeps and says: the start, the folder of the results, the time.

#include "core/run_files/run_reader.h"
#include "tests/bench/command/command_fixture.h"

namespace bipot {
namespace {

using nlohmann::json;

using RunCommand = Command;

/// Five rows of disks, 40 mm high; the lid hangs at 28 mm and cuts two rows off.
std::string cut_packing(const std::string& more = "") {
  return "[[disks]]\narrangement = 'rectangular'\ncolumns = 3\nrows = 5\nradius = 0.004\n"
         "mass = 1\n[[walls]]\npoint = [0, 0]\nnormal = [0, 1]\n[[walls]]\nname = 'lid'\n"
         "point = [0, 0.028]\nnormal = [0, -1]\n[time]\nstep = 1e-4\nsteps = 3\n" +
         more;
}

TEST_F(RunCommand, AStartThatOverlapsIsRefusedWithAPicture) {
  write("cut.toml", cut_packing());
  for (const std::string steps : {"", " --steps 0"}) {
    // The rows at 28 and 36 mm; the highest disk by 36 + 4 - 28 = 12 mm, 3 radii.
    expect_said("run cut.toml" + steps, 2,
                {"6 disks overlap at the start, worst disk 12 and wall 'lid': 12 mm, 3 radii",
                 "out/cut/start.png"});
    EXPECT_GT(fs::file_size("out/cut/start.png"), 1000u);
    EXPECT_FALSE(fs::exists("out/cut/run.h5"));
    fs::remove("out/cut/start.png");
  }
  expect_said("run cut.toml --time-limit 1e-9", 2, {"No picture: the time limit is over"});
  for (const char* command : {"advise --energy 1e-2 ", "trade --quick ", "compare ", "tune "}) {
    EXPECT_EQ(code_of(std::string(command) + "cut.toml"), 2) << command;
  }
}

TEST_F(RunCommand, AShippedSceneIsFoundBesideAFolderOfItsName) {
  EXPECT_EQ(bipot("run sliding_cylinder --steps 2 --out sliding_cylinder -q").exit_code, 0);
  EXPECT_EQ(bipot("run sliding_cylinder --steps 2 --out again -q").exit_code, 0);
  write("bouncing_ball", "no scene");  // a file is what was meant
  EXPECT_EQ(bipot("run bouncing_ball --steps 2 -q").exit_code, 2);
}

TEST_F(RunCommand, AStartThatOverlapsIsAllowedOrPushedApartOnDemand) {
  write("allow.toml", cut_packing("[start]\noverlaps = 'allow'\n"));
  const json start = json_of("run allow.toml --json -")["start"];
  EXPECT_EQ(start["overlapping"], 6);
  EXPECT_EQ(start["pair"], "disk 12 and wall 'lid'");
  EXPECT_NEAR(start["depth"].get<double>(), 0.012, 1e-12);
  EXPECT_NEAR(start["depth_over_radius"].get<double>(), 3, 1e-9);
  // Rows one above the other cannot give way to the sides; staggered rows can.
  std::string text = cut_packing("[start]\noverlaps = 'push apart'\n");
  // What does not help is not proposed: it did not, or is not taken.
  const std::string jammed = "run " + write("jammed.toml", text);
  EXPECT_FALSE(says(expect_said(jammed, 2, {"they do not fit"}), "\"push apart\""));
  expect_said(jammed + " --time-limit 1e-9", 2, {"; the time limit is over. No picture"});
  const std::string cell =
      "cell = {width = 1}\ntime = {step = 1, steps = 1}\ngravity = [0, 0]\n"
      "disks = [{position = [0.5, 0.1], radius = 0.2, mass = 1},\n"
      "  {position = [0.6, 0.1], radius = 0.2, mass = 1}]\n";
  EXPECT_FALSE(says(expect_said("run " + write("cell.toml", cell), 2, {"overlaps to \"allow\""}),
                    "\"push apart\""));
  text.replace(text.find("rectangular"), 11, "triangular");
  const json pushed = json_of("run " + write("push.toml", text) + " --steps 0 --json -");
  expect_said("compare push.toml --quick --json -", 0, {"warning: 5 disks", "pushed apart in "},
              &complaints);
  EXPECT_TRUE(pushed["energy"]["potential"].is_null());  // no step, no ledger
  const json& push = pushed["start"]["pushed_apart"];
  EXPECT_GE(push["rounds"], 1);
  // Five rows of 0.008 √3/2 m: the highest disks came down by 0.008 + 0.0277 - 0.028 m at least.
  EXPECT_GE(push["way"].get<double>(), 0.0077);
  for (const Disk& d : read_state<2>("out/push").bodies) {
    EXPECT_GE(d.x[1], 0.004 - 1e-7);
    EXPECT_LE(d.x[1], 0.024 + 1e-7);
  }
}

TEST_F(RunCommand, ARunIsNotDeletedUnlessToldSo) {
  const std::string run = "run sliding_cylinder --steps ";
  ASSERT_EQ(code_of(run + "7"), 0);
  const std::string ledger = content("out/sliding_cylinder/ledger.csv");
  expect_said(run + "2", 2,
              {"out/sliding_cylinder holds a run of 7 steps: --restart out/sliding_cylinder or "
               "--overwrite"});
  EXPECT_EQ(content("out/sliding_cylinder/ledger.csv"), ledger);
  // Without --out a restart goes on where it is.
  ASSERT_EQ(code_of(run + "4 --restart out/sliding_cylinder"), 0);
  EXPECT_EQ(read_state<2>("out/sliding_cylinder").step, 11);
  EXPECT_EQ(code_of(run + "2 --restart out/sliding_cylinder --overwrite"), 2);
  // The folder of another run is not a place to go on to.
  ASSERT_EQ(code_of(run + "3 --out other"), 0);
  EXPECT_EQ(code_of(run + "1 --restart out/sliding_cylinder --out other"), 2);
  for (const char* name : {"gates.csv", "observables_x.png", "summary.json", "notes.txt"}) {
    std::ofstream(std::string("out/sliding_cylinder/") + name) << "{}";
  }
  expect_said(run + "2 --overwrite", 0, {"results in   out/sliding_cylinder\n"});
  EXPECT_EQ(read_state<2>("out/sliding_cylinder").step, 2);
  EXPECT_FALSE(fs::exists("out/sliding_cylinder/gates.csv"));
  EXPECT_FALSE(fs::exists("out/sliding_cylinder/observables_x.png"));
  EXPECT_GT(content("out/sliding_cylinder/summary.json").size(), 2u);
  EXPECT_EQ(content("out/sliding_cylinder/notes.txt"), "{}");
}

TEST_F(RunCommand, WhatIsLeftOutIsToldOnceByEveryCommand) {
  const std::string disk =
      "$bdyty\n RBDY2  1\n$nodty\n NO3xx  1  coo1= 0.1  coo2= 0.2  coo3= 0\n$tacty\n";
  write("BODIES.DAT", disk + " DISKx  1  color  BLEUx  byrd= 0.05\n$$$$$$\n" + disk +
                          " JONCx  1  color  DOWNx  axe1= 4  axe2= 0.1\n$$$$$$\n");
  write("foreign.toml",
        "contact = {distance = 1e-4}\n"
        "disks = [{arrangement = 'file', file = 'BODIES.DAT', density = 100}]\n"
        "time = {step = 1e-3, steps = 2}\n");
  const std::string told = "bipot: warning: BODIES.DAT: 1 read, left out: 1 JONCx";
  for (const char* command :
       {"run foreign.toml", "trade foreign.toml --quick", "advise foreign.toml --time-limit 1",
        "compare foreign.toml --quick --whole-runs foreign.toml", "tune foreign.toml",
        "trade foreign.toml --quick --json -", "advise foreign.toml --time-limit 1 --json -",
        "compare foreign.toml --quick --json -"}) {
    const std::string said = complaints(command).out;
    EXPECT_TRUE(says(said, told)) << command << ": " << said;
    EXPECT_EQ(said.find(told), said.rfind(told)) << command;
    EXPECT_FALSE(says(said, "distance")) << command;
  }
  // The springs of a scene with the distance of rigid contacts do not use it.
  expect_said("run foreign.toml --model dem --overwrite", 0,
              {told + "; [contact] distance is left out: springs need none\n"});
  write("wide.toml", changed(content("foreign.toml"), {{"1e-4", "1e-1"}}));
  EXPECT_TRUE(says(complaints("run wide.toml").out, "distance lets bodies rest"));
  expect_said("run wide.toml --model dem --overwrite", 0,
              {told + "; [contact] distance is left out: springs need none\n"});
}

TEST_F(RunCommand, ARunOutOfTimeSaysHowToGoOn) {
  expect_said("run compaction --tol 1e-6 --time-limit 0.2 --out cut", 1,
              {"--restart cut goes on\n"});
}

TEST_F(RunCommand, WithoutGnuplotNothingButChartsIsMissing) {
  const Outcome run = run_command_line("PATH=/nowhere " BIPOT_COMMAND,
                                       "run dam_break --steps 10 --no-page --out out 2>&1 #");
  EXPECT_EQ(run.exit_code, 0) << run.out;
  const std::string warning = "charts are left out: gnuplot";
  EXPECT_TRUE(says(run.out, warning)) << run.out;
  EXPECT_EQ(run.out.find(warning), run.out.rfind(warning));
  expect_files("out", {"observables_state.csv", "observables_state.gp", "summary.json"});
  EXPECT_FALSE(fs::exists("out/observables_state.svg"));
}

TEST_F(RunCommand, ChartsOfAProfileNameItsAxis) {
  std::ofstream("layers.toml")
      << "disks = [{ position = [0, 0.01], radius = 0.01, mass = 1 }]\n"
         "walls = [{ point = [0, 0], normal = [0, 1] }]\ntime = { step = 1e-3, steps = 10 }\n"
         "observables = { every = 1, profile = 'x', profile_range = [-0.1, 0.1] }\n";
  EXPECT_EQ(code_of("run layers.toml --no-page --out out"), 0);
  for (const char* chart : {"velocity", "stress", "fraction"}) {
    EXPECT_TRUE(says(content(fmt::format("out/observables_{}.gp", chart)), "x [m]")) << chart;
  }
}

TEST_F(RunCommand, TwoRunsDoNotWriteIntoOneFolder) {
  const std::string run = "run compaction --tol 1e-6 --time-limit 20 -q --out one";
  // The first one runs until the second one has been refused.
  const Outcome second = run_command_line(
      "sh", "-c '" BIPOT_COMMAND " " + run + " & p=$!; sleep 2; " BIPOT_COMMAND " " + run +
                " --overwrite 2>&1; code=$?; kill -INT $p; wait $p; exit $code' 2>&1 #");
  EXPECT_EQ(second.exit_code, 2);
  EXPECT_TRUE(says(second.out, "another command writes into"));
}

TEST_F(RunCommand, TheStepSizeLeavesTheDurationOfTheScene) {
  // duration = 0.1 s: 1000 steps of 1e-4 s, whatever the scene's own step is.
  const auto ends = [&](const std::string& flags) {
    return json_of("run sliding_cylinder --overwrite --json - " + flags);
  };
  const json finer = ends("--step-size 1e-4");
  EXPECT_NEAR(finer["time"].get<double>(), 0.1, 1e-9);
  EXPECT_EQ(finer["steps"], 1000);
  EXPECT_EQ(finer["note"], "");
  const json shorter = ends("--step-size 1e-3 --duration 0.02");
  EXPECT_NEAR(shorter["time"].get<double>(), 0.02, 1e-9);
  EXPECT_EQ(shorter["note"], "the run ends at t = 0.02 s, the scene at 0.1 s");
  EXPECT_NEAR(ends("--step-size 1e-3 --steps 5")["time"].get<double>(), 0.005, 1e-9);
  EXPECT_EQ(code_of("run sliding_cylinder --overwrite --steps 5 --duration 1"), 2);
  // A restart with other steps ends when the scene does; more time is more.
  ends("--step-size 1e-3 --steps 50");
  const json rest =
      json_of("run sliding_cylinder --step-size 5e-4 --restart out/sliding_cylinder --json -");
  EXPECT_EQ(rest["steps"], 100);
  EXPECT_NEAR(rest["time"].get<double>(), 0.1, 1e-9);
  const json more = json_of(
      "run sliding_cylinder --step-size 5e-4 --duration 0.01 "
      "--restart out/sliding_cylinder --json -");
  EXPECT_NEAR(more["time"].get<double>(), 0.11, 1e-9);
}

TEST_F(RunCommand, AnAccuracyIsKeptWithALongStep) {
  const json run = json_of("run bouncing_ball --accuracy 1e-3 --step-size 0.05 --json -");
  EXPECT_EQ(run["steps"], 13);
  const json& parts = run["accuracy"];
  EXPECT_EQ(parts["asked"], 1e-3);
  EXPECT_GE(parts["parts"].get<int>(), 13);
  EXPECT_LE(parts["misplaced"].get<double>(), 1.5e-3);
  EXPECT_LT(parts["smallest_part"].get<double>(), 0.005);
  expect_said("run bouncing_ball --accuracy 0.1 --step-size 1e-4 --overwrite", 0,
              {"longer steps cost less"}, &bipot);
  EXPECT_EQ(code_of("run bouncing_ball --accuracy 1 --overwrite"), 2);
  EXPECT_EQ(code_of("run bouncing_ball --accuracy 0.1 --model dem --overwrite"), 2);
}

TEST_F(RunCommand, WhereStepsCountTheStepSizeChangesTheTimeAndSaysSo) {
  write("count.toml",
        "[[disks]]\nposition = [0, 1]\nradius = 0.1\nmass = 1\n[time]\nstep = 1e-3\nsteps = 20\n");
  const json run = json_of("run count.toml --step-size 2e-3 --json -");
  EXPECT_EQ(run["steps"], 20);
  EXPECT_EQ(run["note"], "the run ends at t = 0.04 s, the scene at 0.02 s");
}

// Models and options with columns of their own, in the plane and in space.
TEST_F(RunCommand, EachRowOfTheLedgerHasTheColumnsOfItsHeader) {
  const std::string time = "[time]\nstep = 1e-4\nsteps = 3\n";
  for (const std::string& body :
       {std::string("[[disks]]\nposition = [0, 0.1]\nradius = 0.1\nmass = 1\n[[walls]]\n"
                    "point = [0, 0]\nnormal = [0, 1]\n"),
        std::string("[[spheres]]\nposition = [0, 0, 0.1]\nradius = 0.1\nmass = 1\n[[walls]]\n"
                    "point = [0, 0, 0]\nnormal = [0, 0, 1]\n")}) {
    for (const std::string more : {"", "[contact]\ncohesion = 1\n", "accuracy", "dem"}) {
      const bool rigid = more != "dem", parts = more == "accuracy";
      write("columns.toml", (rigid && !parts ? more : "") + body + time);
      json_of(std::string("run columns.toml --overwrite --out columns --json -") +
              (parts ? " --accuracy 1e-2" : "") + (rigid ? "" : " --model dem"));
      std::ifstream file("columns/ledger.csv");
      std::string line;
      std::set<long> counts;
      while (std::getline(file, line)) counts.insert(std::count(line.begin(), line.end(), ','));
      EXPECT_EQ(counts.size(), 1u) << body << more;
    }
  }
}

// The centre comes to lie on the segment in the middle of the first step, but for rounding: no
// normal. The files stay, and the step is named.
TEST_F(RunCommand, AContactWithoutANormalEndsTheRunWithASummary) {
  write("normal.toml",
        "gravity = [0, 0]\n"
        "disks = [{position = [0.2, 0.3], radius = 0.02, mass = 1, velocity = [0, -200]}]\n"
        "walls = [{name = 'plate', from = [0, 0.2], to = [1, 0.2]}]\n"
        "time = {step = 1e-3, steps = 3}\n");
  expect_said("run normal.toml --overwrite --out normal", 3,
              {"step 1 at t = 0 s: the centre of disk 0 lies on wall 'plate'"});
  EXPECT_EQ(json_in("normal/summary.json")["status"], "failed");
}

// 300 m/s in steps of 1 ms: 30 radii a step.
const char* const kShot =
    "gravity = [0, 0]\n"
    "disks = [{position = [-0.1, 0], radius = 0.01, mass = 1, velocity = [300, 0]}]\n"
    "walls = [{name = 'plate', from = [0, -1], to = [0, 1]}]\n"
    "time = {step = 1e-3, steps = 3}\n";

TEST_F(RunCommand, ADiskThatGoesThroughAWallEndsTheRun) {
  const std::string run = "run " + write("shot.toml", kShot) + " --overwrite";
  expect_said(
      run, 3,
      {"step 1 at t = 0 s: disk 0 went through wall 'plate' at 300 m/s", "passed through: 0 of 3",
       "30 of the smallest radius", "--step-size 1.7e-05", "--on-tunnel smaller-step"});
  expect_said(run + " --on-tunnel warn", 0,
              {"warning: 1 pair went through each other, first in step 1"});
  const json counted = json_of(run + " --on-tunnel warn --json -");
  EXPECT_EQ(counted["passages"]["count"], 1);
  EXPECT_EQ(counted["passages"]["first"], "disk 0 went through wall 'plate' at 300 m/s");
  EXPECT_NEAR(counted["travel"]["largest"].get<double>(), 30, 1e-9);
  // Parts of 1/64 of the step move it by half a radius: it is stopped at the plate.
  const json parts = json_of(run + " --on-tunnel smaller-step --json -");
  EXPECT_EQ(parts["status"], "completed");
  EXPECT_EQ(parts["passages"]["count"], 0);
  EXPECT_EQ(parts["steps_split"], 1);
  const State<2> end = read_state<2>("out/shot");
  EXPECT_NEAR(end.bodies[0].x[0], -0.01, 0.005);
  EXPECT_NEAR(end.bodies[0].v[0], 0, 1e-6);
  // Half a step has its middle where the centre lies on the plate: only smaller ones have a normal.
  write("on.toml", changed(kShot, {{"-0.1", "-0.075"}}));
  EXPECT_EQ(json_of("run on.toml --on-tunnel smaller-step --json -")["status"], "completed");
}

// A disk of 0.5 m falls at 10 m/s, h = 10 ms: at the middle of the second step its centre is at
// 0.58 - 0.15 = 0.43 m, an overlap of 0.07 m, 14 % of its radius.
TEST_F(RunCommand, DeepOverlapsAreAWarningWithStepAndPair) {
  write("fall.toml",
        "gravity = [0, 0]\n"
        "disks = [{position = [0, 0.58], radius = 0.5, mass = 2, velocity = [0, -10]}]\n"
        "walls = [{name = 'floor', point = [0, 0], normal = [0, 1]}]\n"
        "time = {step = 0.01, steps = 2}\n");
  expect_said("run fall.toml", 0,
              {"warning: overlaps beyond 5 % of the smaller radius in 1 step, most in step 2: "
               "14 %, disk 0 and wall 'floor'"});
  const json overlap = json_of("run fall.toml --overwrite --json -")["overlap"];
  EXPECT_NEAR(overlap["largest"].get<double>(), 0.14, 1e-12);
  EXPECT_EQ(overlap["step"], 2);
  EXPECT_EQ(overlap["pair"], "disk 0 and wall 'floor'");
  EXPECT_EQ(overlap["steps_beyond"], 1);
  EXPECT_TRUE(says(content("out/fall/ledger.csv"), "penetration,overlap,travel,"));
}

// A disk between walls that come at 1 m/s and 2 m/s: no velocity obeys the law.
TEST_F(RunCommand, AStepWithoutSolutionEndsTheRunUnlessToldToContinue) {
  write("jam.toml",
        "gravity = [0, 0]\ndisks = [{position = [0, 0], radius = 0.5, mass = 1}]\n"
        "walls = [{point = [-0.5, 0], normal = [1, 0], velocity = [1, 0]},\n"
        "  {point = [0.5, 0], normal = [-1, 0], velocity = [-2, 0]}]\n"
        "time = {step = 1e-3, steps = 3}\n");
  const std::string run = "run jam.toml --overwrite --max-iterations 2000";
  const std::string ended =
      expect_said(run, 3,
                  {"no solution exists (proved", "no solution: 0 of 3 steps",
                   "a wall is driven into what is jammed", "--on-failure continue"});
  for (const char* word : {"stop", "smaller-step"}) {
    expect_said(run + " --on-failure " + word, 3, {"no solution: 0 of 3 steps"});
  }
  const json j = json_of(run + " --on-failure continue --json -", 1);
  EXPECT_EQ(j["steps"], 3);
  EXPECT_EQ(j["steps_converged"], 0);
  EXPECT_EQ(j["steps_without_solution"], 3);
  // No tolerance and no other solver helps, and the step that is named is the worst.
  for (const char* part : {"is tight", "several solutions", "another one"}) {
    EXPECT_FALSE(says(ended, part)) << ended;
  }
  const std::string worst = "step " + std::to_string(j["worst_step"].get<int>()) + ": ";
  EXPECT_EQ(j["message"].get<std::string>().rfind(worst, 0), 0u) << j["message"];
  // Touching disks in a cell that shrinks in both directions.
  write("cell.toml",
        "gravity = [0, 0]\ncell = {width = 1, height = 1, width_speed = -1, height_speed = -1}\n"
        "disks = [{arrangement = 'rectangular', columns = 4, rows = 4, radius = 0.125, mass = 1}]\n"
        "time = {step = 1e-3, steps = 3}\n");
  expect_said("run cell.toml --max-iterations 2000", 3, {"the cell is driven into what is jammed"});
}

// At most 4096 parts of 1e-4 of 0.1 m in a step of 0.01 s: to 4.096 m/s, the speed of step 41.75.
TEST_F(RunCommand, ATravelThatIsTooShortLaterIsNoBadInput) {
  write("fall.toml",
        "disks = [{position = [0, 0], radius = 0.1, mass = 1}]\n"
        "time = {step = 1e-2, steps = 100, travel = 1e-4}\n");
  expect_said("run fall.toml", 3, {"failed: 41 of 100 steps", "give a smaller step"});
  ASSERT_EQ(code_of("run fall.toml --steps 41 --out begun"), 0);
  expect_said("run fall.toml --restart begun --steps 1", 3, {"give a smaller step"});
}

// Of the exact solvers homotopy knows the plane alone.
TEST_F(RunCommand, TheSolversThatAreProposedTakeTheScene) {
  write(
      "slab.toml",
      "contact = {mu = 3}\nspheres = [{arrangement = 'pyramid', rows = 3, radius = 1, mass = 1}]\n"
      "walls = [{point = [0, 0, 0], normal = [0, 0, 1]}]\ntime = {step = 1e-3, steps = 1}\n");
  const std::string said =
      expect_said("run slab.toml --max-iterations 1", 1, {"friction is large (mu = 3)", "ipm"});
  EXPECT_FALSE(says(said, "homotopy")) << said;
}

// 1e10 kg on 1 kg on a floor: the rounding of the upper impulse alone is beyond 1e-8 of the energies.
TEST_F(RunCommand, WhereDoublesEndNothingButALooserToleranceIsAdvised) {
  write("heavy.toml",
        "disks = [{position = [0, 1], radius = 1, mass = 1},\n"
        "  {position = [0, 3], radius = 1, mass = 1e10}]\n"
        "walls = [{point = [0, 0], normal = [0, 1]}]\n"
        "time = {step = 1e-3, steps = 1}\n");
  const std::string run =
      expect_said("run heavy.toml", 1, {"below what doubles can express here; try --tol 1e-5"});
  EXPECT_FALSE(says(run, "try --solver")) << run;
}

TEST_F(RunCommand, TheAdviceAgainstOverlapsFitsTheScene) {
  const auto said = [&](const std::string& contact, const std::string& time) {
    write("fall.toml", "gravity = [0, 0]\n" + contact +
                           "[[disks]]\nposition = [0, 0.58]\nradius = 0.5\nmass = 2\n"
                           "velocity = [0, -10]\n[[walls]]\nname = 'floor'\npoint = [0, 0]\n"
                           "normal = [0, 1]\n[time]\nstep = 0.01\nsteps = 2\n" +
                           time);
    return whole_output("run fall.toml --overwrite").out;
  };
  EXPECT_TRUE(says(said("", ""), "or overlaps = \"predict\""));
  EXPECT_FALSE(says(said("[contact]\ne_n = 0.5\ne_t = 0.5\n", ""), "predict"));
  EXPECT_TRUE(says(said("", "travel = 0.2\n"), "a travel below 0.2 in [time]"));
}

TEST_F(RunCommand, TheSummaryHasTheToleranceThatWasGiven) {
  expect_said("run square_lattice --steps 1 --tol 1.5e-3", 0, {"to guarded 1.5e-3\n"});
}

TEST_F(RunCommand, ADurationBelowAStepIsRefused) {
  expect_said("run sliding_cylinder --duration 1e-9", 2, {"1e-09 s is shorter than a step of"});
}

}  // namespace
}  // namespace bipot
