// Names, help, completion and the manual page of the `bipot` command, as a user asks for them.

#include "core/base/version.h"
#include "tests/bench/command/command_fixture.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

std::string said(const std::string& arguments) { return whole_output(arguments).out; }

TEST(CommandLine, UnknownCommandsAndFlagsNameTheNearest) {
  expect_said("ruin", 2, {"unknown command 'ruin'", "did you mean 'run'", "judge"});
  expect_said("frobnicate", 2, {"unknown command 'frobnicate'", "Valid: run"});
  EXPECT_FALSE(says(said("frobnicate"), "did you mean"));
  expect_said("run drum --tolerance 1e-3", 2, {"unknown flag '--tolerance'", "'--tol'"});
  expect_said("run drum --dt=1e-3", 2, {"unknown flag '--dt'", "'--step-size'"});
  expect_said("run drum --setps 3", 2, {"'--setps'", "did you mean '--steps'"});
  expect_said("solve --zzz", 2, {"bipot solve: unknown flag '--zzz' (bipot solve --help"});
  expect_said("-v", 2, {"unknown flag '-v'", "'--version'"});
  expect_said("", 2, {"name a command"});
  expect_said("run drum --tol", 2, {"bipot run: --tol: 1 required"});
  expect_said("leaderboard", 2, {"bipot leaderboard: folders is required"});
  expect_said("list nonsense", 2,
              {"bipot list: what: unknown value 'nonsense'. Valid: solvers, scenes, problems"});
  expect_said("run drum --steps 1.5", 2, {"--steps: expected a whole number such as 10, got 1.5"});
  expect_said("run drum --steps -1", 2, {"--steps: expected a number of at least 0, got -1"});
  for (const char* command : {"run drum", "compare pile:3", "tune pile:3", "paper"}) {
    expect_said(std::string(command) + " --out ''", 2, {"--out: expected ", "an empty text"});
  }
  expect_said("compare pile:3:ratio=2", 2, {"pile takes mu, tilt, seed, not 'ratio'"});
  expect_said("compare pile:3:mu=0.3:mu=0.5", 2, {"mu is given twice"});
  expect_said("extremes --random-scenes 2 --solver auto,pgs", 2,
              {"a second --solver has no effect"});
}

TEST(CommandLine, ASceneThatIsMissedIsPointedOut) {
  const TemporaryFolder folder;
  const std::string mine = folder / "mine";
  std::ofstream(mine + ".toml") << "[time]\nstep = 1e-3\nsteps = 1\n";
  expect_said("run " + mine, 2, {"no such file; did you mean '" + mine + ".toml'?"});
  expect_said("run heap", 2, {"heap: no such file; a template: bipot new heap > heap.toml"});
}

TEST(CommandLine, ATargetBehindAListIsMissed) {
  expect_said("compare --solvers pgs square:4", 2, {"TARGETS is missing", "in front of lists"});
}

TEST(CommandLine, ComparingAStepWithoutImpulsesIsPointedOut) {
  for (const auto& [length, last] : {std::pair{"", "100"}, std::pair{":steps=120", "120"}}) {
    expect_said(
        std::string("compare bouncing_ball") + length + " --quick --solvers apgd --tols 1e-2", 0,
        {std::string("bouncing_ball@") + last + ": no impulse is needed", "--scene-steps"});
  }
  expect_said("compare random:4 --quick --solvers apgd --tols 1e-2", 0,
              {"random:4: no impulse is needed", "its disks are loose: pile"});
}

TEST(CommandLine, TheSameQuestionHasManyForms) {
  const std::string version = said("--version");
  EXPECT_TRUE(says(version, "bipot " + program_version() + " ("));  // with the commit
  for (const char* form : {"version", "-V"}) EXPECT_EQ(said(form), version) << form;
  EXPECT_EQ(said("help"), said("--help"));
  EXPECT_EQ(said("help run"), said("run --help"));
  expect_said("help run", 0, {"bipot run", "--step-size"});
  expect_said("help nonsense", 2, {"unknown command 'nonsense'"});
  expect_said("version --help", 0, {"Print the version"});
  expect_said("completion --help", 0, {"bash, zsh, fish"});
  EXPECT_FALSE(says(said("completion --help"), "Exit codes"));
}

TEST(CommandLine, ListAloneNamesEverything) {
  expect_said("list", 0,
              {"solvers", "apgd", "scenes", "sliding_cylinder", "problems", "2d_pile_300_mu03",
               "templates", "hopper"});
  expect_said("list problems", 0, {"2d_pile_300_mu03", "2D", "contacts"});
  const nlohmann::json all = json_of("list --json -");
  EXPECT_GT(all["solvers"].size(), 5u);
  EXPECT_GT(all["problems"].size(), 5u);
  expect_said("list poblems", 2, {"poblems"});
}

TEST(CommandLine, ShellsCompleteFromTheDeclarations) {
  const auto completed = [](const std::string& words) {
    return run_command_line(
               "bash -c 'source <(" BIPOT_COMMAND " completion bash); COMP_WORDS=(bipot " + words +
                   "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _bipot; printf \"%s\\n\" "
                   "\"${COMPREPLY[@]}\"'",
               "")
        .out;
  };
  EXPECT_EQ(completed("ru"), "run\n");
  EXPECT_EQ(completed("run --step-"), "--step-size\n");
  EXPECT_EQ(completed("run --model n"), "nscd\n");
  EXPECT_EQ(completed("list p"), "problems\n");
  EXPECT_EQ(completed("new he"), "heap\n");
  EXPECT_EQ(completed("help ju"), "judge\n");
  EXPECT_EQ(completed("run squ"), "square_lattice\n");
  EXPECT_EQ(completed("solve x --solver apg"), "apgd\n");
  EXPECT_EQ(completed("run x --stop ra"), "raw42\n");
  const TemporaryFolder folder;
  std::ofstream(folder / "a scene.toml") << "";
  const std::string scene = (folder / "a scene.toml").string(), part = (folder / "a").string();
  for (const char* before : {"run ", "run x --restart ", "solve x --out "}) {
    EXPECT_EQ(completed(before + part), scene + "\n") << before;
  }
  for (const char* shell : {"zsh", "fish"}) {
    expect_said(std::string("completion ") + shell, 0, {"bipot", "step-size", "nscd dem"});
  }
  expect_said("completion tcsh", 2, {"tcsh"});
}

// What fish offers itself, and that zsh can read its script.
TEST(CommandLine, FishAndZshTakeTheirScripts) {
  const auto has = [](const char* shell) {
    return run_command_line(shell, "-c true").exit_code == 0;
  };
  if (!has("fish") && !has("zsh")) GTEST_SKIP() << "neither fish nor zsh is installed";
  const auto offered = [](const std::string& typed) {
    return run_command_line("fish --no-config -c",
                            "'" BIPOT_COMMAND " completion fish | source; complete -C\"bipot " +
                                typed + "\"' | cut -f 1")
        .out;
  };
  if (has("fish")) {
    EXPECT_EQ(offered("ru"), "run\n");
    EXPECT_EQ(offered("run --step-"), "--step-size\n");
    EXPECT_EQ(offered("run --model n"), "nscd\n");
    EXPECT_EQ(offered("new he"), "heap\n");
  }
  if (has("zsh")) {
    const Outcome read =
        run_command_line("zsh -f -c", "'autoload -U compinit; compinit -D; source <(" BIPOT_COMMAND
                                      " completion zsh); print $_comps[bipot]'");
    EXPECT_EQ(read.exit_code, 0);
    EXPECT_EQ(read.out, "_bipot\n");
  }
}

TEST(CommandLine, TheManualPageHasEveryCommandAndIsSound) {
  expect_said("help --man", 0,
              {".TH BIPOT 1", ".SS run scene", "\\-\\-step\\-size", ".SS judge", "Exit codes"});
  if (std::system("command -v groff > /dev/null") != 0) GTEST_SKIP() << "no groff";
  const Outcome page =
      run_command_line("sh -c \"" BIPOT_COMMAND
                       " help --man | groff -Kutf8 -man -Tutf8 -ww 2>&1 | sed 's/.\\x08//g'\"",
                       "");
  EXPECT_FALSE(says(page.out, "warning")) << page.out;
  EXPECT_TRUE(says(page.out, "COMMANDS"));
  const std::string codes = "Exit codes:";
  EXPECT_EQ(page.out.find(codes), page.out.rfind(codes));  // once
}

TEST_F(Command, EveryTemplateRunsWithoutChange) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(source_folder() / "data" / "templates")) {
    ++count;
    const std::string name = entry.path().stem().string();
    const Outcome text = bipot("new " + name);
    EXPECT_EQ(text.exit_code, 0);
    EXPECT_EQ(text.out.rfind("# ", 0), 0u) << name;
    const nlohmann::json j =
        json_of("run " + write(name + ".toml", text.out) + " --steps 5 --json - --out " + name);
    EXPECT_EQ(j["status"], "completed") << name;
    EXPECT_FALSE(j["title"].get<std::string>().empty());
    EXPECT_LT(j["penetration"].get<double>(), 1e-4) << name;  // nothing overlaps at the start
    EXPECT_EQ(j["overlap"]["pair"] != "", j["overlap"]["largest"] > 0) << name;
    EXPECT_TRUE(says(bipot("new").out, name));
  }
  EXPECT_EQ(count, 7);
  expect_said("new haep", 2, {"unknown template 'haep'", "did you mean 'heap'"});
}

TEST_F(Command, ARunKeepsALogAndSaysWhatIsOdd) {
  write("scene.toml",
        "title = \"\\u001b[31mred\"\ngravity = [0, 0]\ntime = {step = 1e-3, steps = 20}\n"
        "disks = [{position = [1, 1], radius = 1, mass = 1}]\n"
        "walls = [{name = 'left', point = [0, 0], normal = [1, 0], force = 5, mass = 1},\n"
        "  {name = 'right', point = [2, 0], normal = [-1, 0], force = 4, mass = 1}]\n");
  const std::string run = expect_said("run scene.toml --out out", 0,
                                      {"walls 'left' and 'right'", "top at 2 m", "work of walls"});
  EXPECT_EQ(run.find('\x1b'), std::string::npos) << run;
  const std::string log = content("out/run.log");
  EXPECT_TRUE(says(log, " 50 %  step 10, t = 0.01 s, 0 unsolved"));
  EXPECT_TRUE(says(log, "completed: 20 of 20 steps"));
}

TEST_F(Command, ARunSaysWhatItsMeansAndStressesLack) {
  write("scene.toml",
        "time = {step = 1e-3, steps = 5}\nobservables = {starts = 0.01}\n"
        "disks = [{position = [0, 1], radius = 0.1, mass = 1}]\n"
        "ropes = [{bodies = [0], to = [0, 2]}]\n");
  expect_said("run scene.toml --out out", 0,
              {"no means: these begin at 0.01 s", "without the forces of pins and ropes"});
}

}  // namespace
}  // namespace bipot
