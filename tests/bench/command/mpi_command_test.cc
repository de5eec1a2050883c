// `mpirun -n P bipot solve|run`, as a user runs it.

#include "core/run_files/observable_output.h"
#include "core/run_files/run_reader.h"
#include "tests/bench/command/command_fixture.h"
#include "tests/support/state_bits.h"

namespace bipot {
namespace {

using nlohmann::json;

// Open MPI's own second between SIGTERM and SIGKILL stays: with odls_base_sigkill_timeout 0, mpirun
// 4.1 itself ended in a deadlock of its threads, or in a crash, in 12 of 160 runs that failed (0 of
// 160 with it), and then heeds no SIGTERM.
constexpr const char* kMpirun = "timeout -k 5 200 mpirun --allow-run-as-root --oversubscribe";

class MpiCommand : public Command {
 protected:
  void SetUp() override {
    Command::SetUp();
    if (run_command_line("mpirun", "--version").exit_code != 0) {
      GTEST_SKIP() << "mpirun is not installed: the command on several processes is not tested";
    }
  }
  static Outcome on(int processes, const std::string& arguments) {
    return run_command_line(
        kMpirun, "-n " + std::to_string(processes) + " " + BIPOT_COMMAND + " " + arguments);
  }
  /// The same with standard error in `out` as well: who speaks? `rest`: behind the command.
  static Outcome both_streams(int processes, const std::string& arguments,
                              const std::string& rest = "") {
    return run_command_line(std::string("{ ") + kMpirun, "-n " + std::to_string(processes) + " " +
                                                             BIPOT_COMMAND + " " + arguments +
                                                             rest + " 2>&1; }");
  }
  static int count(const std::string& text, const std::string& what) {
    int n = 0;
    for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; ++at) ++n;
    return n;
  }
};

/// Names in a folder and below, sorted.
std::vector<std::string> files_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    names.push_back(fs::relative(entry.path(), folder).string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

TEST_F(MpiCommand, SolveSaysAndWritesWhatOneProcessDoes) {
  const std::string solve =
      "solve " + shipped_problem("2d_pile_300_mu03") + " --solver apgd --tol 1e-5";
  const json one = json_of(solve + " --json -");
  EXPECT_FALSE(one.contains("distributed"));
  const Outcome run = on(2, solve + " --json - --out out");
  ASSERT_EQ(run.exit_code, 0);
  const json two = json::parse(run.out);  // one document: one process printed
  for (const char* key : {"status", "message", "solver", "contacts", "dim", "iterations", "stick",
                          "slip", "take_off", "worst_contact", "exit_code"}) {
    EXPECT_EQ(one[key], two[key]) << key;
  }
  EXPECT_NEAR(one["epsilon"].get<double>(), two["epsilon"].get<double>(),
              1e-6 * one["epsilon"].get<double>());
  EXPECT_EQ(two["distributed"]["processes"], 2);
  EXPECT_LE(two["distributed"]["imbalance"].get<double>(), 1.2);
  EXPECT_EQ(code_of("judge " + shipped_problem("2d_pile_300_mu03") +
                    " --impulses out/solution.hdf5 --tol 1e-5"),
            0);
  // The history has a line for each judged iteration, from one process.
  EXPECT_EQ(count(content("out/history.csv"), "\n0,"), 1);
}

TEST_F(MpiCommand, OneProcessOfMpirunIsTheOrdinaryCommand) {
  const std::string solve = "solve " + shipped_problem("2d_pour12_170") + " --solver ipm --json -";
  json one = json_of(solve), launched = json::parse(on(1, solve).out);
  for (json* j : {&one, &launched}) {
    j->erase("setup_seconds");
    j->erase("solve_seconds");
  }
  EXPECT_EQ(one, launched);
}

TEST_F(MpiCommand, ReproducibleSolvesHaveTheSameBits) {
  const std::string solve = "solve " + shipped_problem("2d_pour12_170") +
                            " --solver apgd --tol 1e-6 --reproducible --out ";
  const auto history = [&](const std::string& name) {
    std::string text, line;
    std::istringstream lines(content(name + "/history.csv"));
    // Without the seconds, the second column.
    while (std::getline(lines, line)) {
      const std::size_t first = line.find(','), second = line.find(',', first + 1);
      text += line.substr(0, first) + line.substr(second) + "\n";
    }
    return text;
  };
  ASSERT_EQ(code_of(solve + "p1"), 0);
  const std::string alone = history("p1");
  EXPECT_GT(alone.size(), 1000u);
  for (const int processes : {2, 4}) {
    const std::string name = "p" + std::to_string(processes);
    ASSERT_EQ(on(processes, solve + name).exit_code, 0);
    EXPECT_EQ(history(name), alone) << processes;
  }
  EXPECT_EQ(code_of("solve " + shipped_problem("2d_pour12_170") + " --solver pgs --reproducible"),
            2);
}

/// The records of a stage on the root process are known there alone: when it gives the stage up, the
/// others must go on with it.
TEST_F(MpiCommand, AutoGivesUpAStageOfTheRootProcessOnAll) {
  EXPECT_EQ(on(4, "solve " + shipped_problem("2d_pyramid_10") + " --time-limit 60").exit_code, 0);
  EXPECT_EQ(on(2, "solve " + shipped_problem("2d_compaction_rest") + " --time-limit 60").exit_code,
            0);
  EXPECT_EQ(
      on(2, "solve " + shipped_problem("2d_pour12_170") + " --tol 1e-15 --time-limit 2").exit_code,
      1);
}

TEST_F(MpiCommand, ExitCodesAreThoseOfOneProcessAndOneProcessSpeaks) {
  const std::string solve = "solve " + shipped_problem("2d_pour12_170") + " ";
  EXPECT_EQ(on(3, solve + "--solver apgd --tol 1e-12 --max-iterations 20").exit_code, 1);
  EXPECT_EQ(on(3, solve + "--solver none").exit_code, 2);
  EXPECT_EQ(on(2, solve + "--solver apgd --threads 2").exit_code, 2);
  EXPECT_EQ(on(2, solve + "--several 3").exit_code, 2);
  EXPECT_EQ(on(2, solve + "--solver apgd --islands off --tol 1e-3").exit_code, 0);
  EXPECT_EQ(on(2, solve + "--solver apgd --islands on --tol 1e-3").exit_code, 2);
  EXPECT_EQ(on(2, "solve pour:4@20").exit_code, 2);  // each would make it
  EXPECT_EQ(on(2, "run square_lattice --model dem").exit_code, 2);
  const Outcome compare = both_streams(3, "compare " + shipped_problem("2d_pour12_170"));
  EXPECT_EQ(compare.exit_code, 2);
  EXPECT_EQ(count(compare.out, "bipot: compare runs on one process"), 1) << compare.out;
}

TEST_F(MpiCommand, AProcessThatFailsEndsTheRunWithItsMessage) {
  const std::string good = "solve " + shipped_problem("2d_pour12_170");
  const auto beside = [&](const std::string& second) {
    return both_streams(1, good, " : -n 1 " BIPOT_COMMAND " " + second);
  };
  // The second process cannot read its file: the first one says so for it.
  const Outcome unread = beside("solve /nowhere");
  EXPECT_EQ(unread.exit_code, 4);
  EXPECT_EQ(count(unread.out, "bipot: /nowhere: No such file"), 1) << unread.out;
  const Outcome different = beside("solve " + shipped_problem("2d_pour12_250"));
  EXPECT_EQ(different.exit_code, 3);
  EXPECT_EQ(count(different.out, "bipot: the processes were given different problems"), 1)
      << different.out;
  // The first one alone fails to write, once all is solved and in the middle of a run.
  const Outcome full = both_streams(2, good + " --solver apgd --history /dev/full");
  EXPECT_EQ(full.exit_code, 4);
  EXPECT_EQ(count(full.out, "bipot: process 1 of 2: /dev/full: cannot be written"), 1) << full.out;
  fs::create_directories("out");
  write("out/problems", "a file where a folder is to be");
  const Outcome in_a_step =
      both_streams(2, "run pyramid --steps 5 --solver apgd --dump-problems all --out out");
  EXPECT_NE(in_a_step.exit_code, 0);
  EXPECT_LT(in_a_step.exit_code, 124) << "a hang, or a crash";
  EXPECT_EQ(count(in_a_step.out, "bipot: process 1 of 2:"), 1) << in_a_step.out;
}

TEST_F(MpiCommand, ARunHasTheSameFilesAndGoesOnWithAnotherNumberOfProcesses) {
  const std::string run = "run rough_shear --solver apgd --tol 1e-3 --reproducible -q --out ";
  // 12 steps, 10 more and the last 8: on one process, and on four, two and three.
  const auto in_parts = [&](const std::string& name, int a, int b, int c) {
    const auto go = [&](int processes, const std::string& more) {
      const std::string all = run + name + more;
      return processes == 1 ? code_of(all) : on(processes, all).exit_code;
    };
    EXPECT_EQ(go(a, " --steps 12"), 0);
    EXPECT_EQ(go(b, " --restart " + name + " --steps 10"), 0);
    EXPECT_EQ(go(c, " --restart " + name + " --steps 8"), 0);
  };
  in_parts("one", 1, 1, 1);
  in_parts("several", 4, 2, 3);
  const std::string ledger = content("one/ledger.csv");
  EXPECT_EQ(count(ledger, "\n"), 31) << ledger;
  EXPECT_EQ(content("several/ledger.csv"), ledger);
  EXPECT_EQ(files_in("several"), files_in("one"));
  EXPECT_EQ(content("several/frames/00000030.h5"), content("one/frames/00000030.h5"));
  const json j = json_in("several/summary.json");
  EXPECT_EQ(j["processes"], 3);
  EXPECT_EQ(j["status"], "completed");
}

TEST_F(MpiCommand, AnAccuracyCutsStepsAlikeOnEachNumberOfProcesses) {
  const std::string run =
      "run drum --accuracy 0.05 --step-size 0.05 --steps 3 --solver apgd --reproducible -q --out ";
  EXPECT_EQ(code_of(run + "one"), 0);
  const std::string ledger = content("one/ledger.csv");
  EXPECT_TRUE(says(ledger, ",parts,rejected,smallest_part,misplaced,limited_by\n"));
  EXPECT_TRUE(says(ledger, ",impact "));
  for (const int processes : {2, 3}) {
    const std::string folder = std::to_string(processes);
    EXPECT_EQ(on(processes, run + folder).exit_code, 0);
    EXPECT_EQ(content(folder + "/ledger.csv"), ledger);
  }
}

/// A packing under a lid that a force presses, on a floor that moves: at rest but for that.
constexpr const char* kPressed = R"(
title = "Pressed"
gravity = [0, -9.81]
contact = {mu = 0.3}
disks = [{arrangement = "triangular", columns = 10, rows = 10, radius = 0.05, density = 1000}]
walls = [{name = "floor", point = [0, 0], normal = [0, 1], velocity = [0.05, 0]},
  {name = "left", point = [0, 0], normal = [1, 0]},
  {name = "right", point = [1, 0], normal = [-1, 0]},
  {name = "lid", point = [0, 0.87943], normal = [0, -1], force = 500, mass = 40}]
time = {step = 1e-3, steps = 1000}
solver = {name = "apgd", tol = 1e-8}
output = {every = 10}
)";

TEST_F(MpiCommand, AStateOnSeveralProcessesLeavesTheFilesOfOne) {
  const std::string run = "run " + write("pressed.toml", kPressed) + " --steps 25 --out ";
  ASSERT_EQ(code_of(run + "one"), 0);
  const Outcome four = on(4, run + "four");
  ASSERT_EQ(four.exit_code, 0);
  EXPECT_EQ(count(four.out, "processes    4, state distributed"), 1) << four.out;
  EXPECT_EQ(files_in("four"), files_in("one"));
  // Impulses agree to the tolerance, places to what it moves in 25 steps.
  const State<2> one = read_state<2>("one"), many = read_state<2>("four");
  EXPECT_EQ(many.step, 25);
  EXPECT_LE(farthest(one.bodies, many.bodies), 1e-6);
  EXPECT_NEAR(one.walls[3].a[1], many.walls[3].a[1], 1e-6);
  ASSERT_EQ(one.contacts.size(), many.contacts.size());
  for (std::size_t k = 0; k < one.contacts.size(); ++k) {
    EXPECT_EQ(one.contacts[k].contact.i, many.contacts[k].contact.i);
    EXPECT_EQ(one.contacts[k].contact.j, many.contacts[k].contact.j);
  }
  // Rows of the ledger: the same columns, the same steps, numbers of the same size.
  const auto a = read_number_table("one/ledger.csv").rows;
  const auto b = read_number_table("four/ledger.csv").rows;
  ASSERT_EQ(a.size(), 25u);
  ASSERT_EQ(b.size(), a.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    ASSERT_EQ(a[k].size(), b[k].size());
    for (const std::size_t column : {0u, 1u, 2u, 5u}) EXPECT_EQ(a[k][column], b[k][column]) << k;
    for (const std::size_t column : {10u, 11u, 12u, 13u, 14u, 20u, 21u, 22u, 23u, 24u, 25u}) {
      EXPECT_NEAR(a[k][column], b[k][column], 1e-4 * (1 + std::abs(a[k][column])))
          << k << ", " << column;
    }
    EXPECT_NEAR(b[k][15], 0, 1e-10) << "energy, step " << k;
    EXPECT_NEAR(b[k][18], 0, 1e-10) << "momentum, step " << k;
    EXPECT_NEAR(b[k][19], 0, 1e-10) << "momentum, step " << k;
  }
  const json j = json_in("four/summary.json");
  EXPECT_EQ(j["state"], "distributed");
  EXPECT_EQ(j["disks"], one.bodies.size());
  EXPECT_LT(j["domains"]["most_bodies"].get<double>(), 0.6 * one.bodies.size());
  EXPECT_GT(j["domains"]["a_step"]["detection"]["messages"].get<double>(), 0);
  EXPECT_EQ(j["domains"]["gathers"], 26);  // a row each step, and the end
}

TEST_F(MpiCommand, TheStateIsGatheredWhenItIsDueAndNotElse) {
  const std::string scene = changed(kPressed, {{"every = 10", "every = 10, ledger_every = 4"}});
  const std::string run = "run " + write("rare.toml", scene) + " --steps 14 --tol 1e-4 -q --out ";
  ASSERT_EQ(on(2, run + "two").exit_code, 0);
  const json j = json_in("two/summary.json");
  EXPECT_EQ(j["domains"]["gathers"], 5);  // rows 4, 8, 12, the frame of step 10, and the end
  ASSERT_EQ(code_of(run + "one"), 0);
  EXPECT_EQ(count(content("two/ledger.csv"), "\n"), count(content("one/ledger.csv"), "\n"));
}

TEST_F(MpiCommand, WhatKeepsItsStateOnEveryProcessSaysWhy) {
  const auto state_of = [&](const std::string& arguments) {
    const Outcome run =
        on(2, "run " + arguments +
                  " --overwrite --solver apgd --max-iterations 20 --steps 2 --json -");
    return json::parse(run.out)["state"].get<std::string>();
  };
  EXPECT_EQ(state_of("rough_shear"), "on every process: the scene is periodic");
  EXPECT_EQ(state_of("trefoils"), "on every process: the scene has clusters");
  EXPECT_EQ(state_of("hopper"), "on every process: the scene has inlets or outlets");
  EXPECT_EQ(state_of("pyramid --reproducible"), "on every process: --reproducible");
  EXPECT_EQ(state_of("pyramid --on-failure stop"), "on every process: --on-failure stop");
  EXPECT_EQ(state_of("four_spheres"), "distributed");
  EXPECT_FALSE(json_of("run pyramid --overwrite --steps 1 --json -").contains("state"));
}

TEST_F(MpiCommand, AKilledRunGoesOnWithAnotherNumberOfProcesses) {
  write("pressed.toml", kPressed);
  const std::string run = "run pressed.toml --tol 1e-6 -q --out several";
  // One of four processes is killed once there is a frame of a later step; mpirun ends the others.
  const Outcome killed = both_streams(
      4, run,
      " & run=$!; for k in $(seq 300); do [ -e several/frames/00000010.h5 ] && break; "
      "sleep 0.1; done; launcher=$(pgrep -P $run); kill -9 $(pgrep -P $launcher | head -n 1); wait $run");
  ASSERT_NE(killed.exit_code, 0) << killed.out;
  const int left = read_state<2>("several").step;
  ASSERT_GE(left, 10);
  ASSERT_EQ(on(2, run + " --restart several --steps 9").exit_code, 0);
  ASSERT_EQ(on(3, run + " --restart several --steps 7").exit_code, 0);
  const State<2> several = read_state<2>("several");
  EXPECT_EQ(several.step, left + 16);
  ASSERT_EQ(
      code_of("run pressed.toml --tol 1e-6 -q --steps " + std::to_string(left + 16) + " --out one"),
      0);
  EXPECT_LE(farthest(several.bodies, read_state<2>("one").bodies), 1e-5);
  EXPECT_EQ(count(content("several/ledger.csv"), "\n"), left + 17);
}

/// A signal for one of them is one for all: the summary, which another one writes, says so.
TEST_F(MpiCommand, AnInterruptOfOneProcessIsToldByAll) {
  write("pressed.toml", kPressed);
  both_streams(2, "run pressed.toml --tol 1e-6 -q --steps 100000 --out several",
               " & run=$!; for k in $(seq 300); do [ -e several/frames/00000010.h5 ] && break; "
               "sleep 0.1; done; launcher=$(pgrep -P $run); "
               "kill -INT $(pgrep -P $launcher | tail -n 1); wait $run");
  const json summary = json_in("several/summary.json");
  EXPECT_EQ(summary["status"], "interrupted");
  EXPECT_EQ(summary["exit_code"], 5);
}

TEST_F(MpiCommand, AKilledSolveEndsAtOnce) {
  const Outcome killed = both_streams(2,
                                      "solve " + shipped_problem("2d_pour300_392") +
                                          " --solver pgs --tol 1e-16 --max-iterations 100000000",
                                      " & run=$!; sleep 2; launcher=$(pgrep -P $run); "
                                      "kill -9 $(pgrep -P $launcher | head -n 1); wait $run");
  EXPECT_EQ(killed.exit_code, 137) << killed.out;
}

// A lattice of small disks, 50 mm apart; a disk of 10 mm flies through a row of them, 290 mm a step:
// it passes some that others have, and hits one that it meets in the middle of a step.
TEST_F(MpiCommand, SeveralProcessesSeeTheSamePassagesAndOverlaps) {
  std::string scene =
      "gravity = [0, 0]\n[time]\nstep = 1e-3\nsteps = 3\n[[disks]]\nposition = [-0.12, 0.21]\n"
      "radius = 0.01\nmass = 1\nvelocity = [290, 0]\n";
  for (int k = 0; k < 200; ++k) {
    scene += "[[disks]]\nposition = [" + std::to_string(0.05 * (k % 20)) + ", " +
             std::to_string(0.05 * (k / 20)) + "]\nradius = 0.012\nmass = 1\n";
  }
  const std::string run = "run " + write("shot.toml", scene) + " --on-tunnel warn --json - --out ";
  const json one = json_of(run + "one");
  EXPECT_GT(one["passages"]["count"], 2);
  EXPECT_GT(one["overlap"]["steps_beyond"], 0);
  const json three = json::parse(on(3, run + "three").out);
  EXPECT_EQ(three["state"], "distributed");
  for (const char* entry : {"passages", "travel"}) EXPECT_EQ(three[entry], one[entry]) << entry;
  EXPECT_EQ(three["overlap"]["pair"], one["overlap"]["pair"]);
  EXPECT_NEAR(three["overlap"]["largest"].get<double>(), one["overlap"]["largest"].get<double>(),
              1e-6);
  // The verdict as well.
  const std::string refused = "run shot.toml --out ";
  EXPECT_EQ(code_of(refused + "refused"), 3);
  EXPECT_EQ(on(3, refused + "refused_three").exit_code, 3);
  EXPECT_EQ(read_state<2>("refused").step, read_state<2>("refused_three").step);
}

// A disk of 1 m between walls that come at 1 m/s and 2 m/s; others lie far away.
TEST_F(MpiCommand, SeveralProcessesEndBeforeAStepWithoutSolution) {
  std::string scene =
      "gravity = [0, 0]\n[time]\nstep = 1e-3\nsteps = 3\n[[disks]]\nposition = [0, 0]\n"
      "radius = 0.5\nmass = 1\n[[walls]]\nfrom = [-0.5, -1]\nto = [-0.5, 1]\nvelocity = [1, 0]\n"
      "[[walls]]\nfrom = [0.5, -1]\nto = [0.5, 1]\nvelocity = [-2, 0]\n";
  for (int k = 0; k < 20; ++k) {
    scene += "[[disks]]\nposition = [" + std::to_string(10 + k) + ", 0]\nradius = 0.5\nmass = 1\n";
  }
  const std::string run =
      "run " + write("jam.toml", scene) + " --max-iterations 2000 --json - --out ";
  const Outcome two = on(2, run + "two");
  EXPECT_EQ(two.exit_code, 3);
  EXPECT_EQ(json::parse(two.out)["status"], "no solution");
  EXPECT_EQ(json::parse(two.out)["last_step"], 0);
}

TEST_F(MpiCommand, AProcessThatFailsEndsARunWhoseStateIsDistributed) {
  write("pressed.toml", kPressed);
  const auto three = [&](const std::string& arguments) {
    return both_streams(3, "run " + arguments);
  };
  // The first one alone fails to write, when the others are at the next step: a frame stands as a
  // folder where a file is to be.
  fs::create_directories("out/run.xdmf/in_the_way");
  const Outcome full = three("pressed.toml --steps 30 --tol 1e-4 --out out");
  EXPECT_EQ(full.exit_code, 4) << full.out;
  EXPECT_EQ(count(full.out, "bipot: process 1 of 3:"), 1) << full.out;
  // All know what one cannot detect.
  std::string twice = kPressed;
  const std::string disk = ", {position = [0.3, 2], radius = 0.01, density = 1000}";
  twice.insert(twice.find("]", twice.find("density")), disk + disk);
  const Outcome coincident = three(write("twice.toml", twice) + " --steps 2 --tol 1e-4");
  EXPECT_NE(coincident.exit_code, 0);
  EXPECT_NE(coincident.exit_code, 124) << "a hang";
  EXPECT_EQ(count(coincident.out, "disks 95 and 96 have the same centre"), 1) << coincident.out;
  // A step that is not solved: taken, told once, and the run goes on.
  const Outcome unsolved = three("pressed.toml --steps 3 --max-iterations 2 --out unsolved");
  EXPECT_EQ(unsolved.exit_code, 1);
  EXPECT_EQ(count(unsolved.out, "status       not converged: 3 of 3 steps"), 1) << unsolved.out;
}

}  // namespace
}  // namespace bipot
