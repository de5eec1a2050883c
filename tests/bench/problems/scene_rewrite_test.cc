#include "bench/problems/scene_rewrite.h"

#include "core/scene_files/scene_file.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

const std::string kHead = R"(# A scene of mine.
title = "Zylinder, 2 × größer"   # umlauts

[[disks]]
position = [0.0, 0.01]   # on the floor
radius = 0.01
mass = 1.0

[[walls]]
point = [0.0, 0.0]
normal = [0.0, 1.0]

)";

SceneChanges changes() {
  return {.step = 2e-4,
          .num_steps = 50,
          .solver = "pgs",
          .parameters = {{"omega", "1.5"}},
          .tol = 1e-3,
          .warm_start = true,
          .comment = "advised"};
}

TEST(SceneRewrite, ChangesValuesAndKeepsTheRest) {
  const std::string text = kHead + R"([time]
step = 1e-4   # small
steps = 100

[solver]
name = "uzawa"     # the paper's
tol = 1e-8
parameters = { rho = "paper" }

[output]
every = 5
)";
  EXPECT_EQ(rewrite_scene(text, "t.toml", changes()), kHead + R"([time]
# advised; step was 1e-4
step = 0.0002   # small
# advised; steps was 100
steps = 50

[solver]
# advised; name was "uzawa"
name = "pgs"     # the paper's
# advised; tol was 1e-8
tol = 0.001
# advised; parameters was { rho = "paper" }
parameters = { omega = "1.5" }

[output]
every = 5
)");
}

TEST(SceneRewrite, APlanStaysWithAutoAndGoesWithOthers) {
  const std::string text =
      kHead + "[time]\nstep = 1e-4\nsteps = 100\n\n[solver]\nplan = \"mine.toml\"\ntol = 1e-8\n";
  const SolverChoice before = parse_scene(text, "t.toml").solver;
  SceneChanges wanted = changes();
  EXPECT_EQ(parse_scene(rewrite_scene(text, "t.toml", wanted), "t.toml").solver.parameters,
            wanted.parameters);
  wanted.parameters.clear();
  EXPECT_TRUE(says(rewrite_scene(text, "t.toml", wanted), "plan was \"mine.toml\"\nplan = \"\""));
  wanted.solver = "auto";
  wanted.parameters = before.parameters;
  const std::string kept = rewrite_scene(text, "t.toml", wanted);
  EXPECT_EQ(parse_scene(kept, "t.toml").solver.parameters, before.parameters);
  EXPECT_TRUE(says(kept, "plan = \"mine.toml\"\n"));
}

TEST(SceneRewrite, AddsWhatIsNotThere) {
  const std::string text = kHead + "[time]\nstep = 1e-4\nduration = 0.01\n";
  const std::string written = rewrite_scene(text, "t.toml", changes());
  const Scene<2> scene = parse_scene(written, "t.toml");
  EXPECT_EQ(scene.solver.name, "pgs");
  EXPECT_EQ(scene.solver.tol, 1e-3);
  EXPECT_EQ(scene.step, 2e-4);
  EXPECT_EQ(scene.num_steps, 50);  // the duration stays 0.01 s
  EXPECT_EQ(written, kHead + R"([time]
# advised; step was 1e-4
step = 0.0002
duration = 0.01

[solver]
# advised; name was not set
name = "pgs"
# advised; tol was not set
tol = 0.001
# advised; parameters was not set
parameters = { omega = "1.5" }
)");
}

TEST(SceneRewrite, FollowsInlineTablesAndDottedKeys) {
  const std::string inline_table =
      "solver = { name = \"uzawa\" }  # mine\n" + kHead + "[time]\nstep = 1e-4\nsteps = 100\n";
  const std::string dotted =
      "solver.name = \"uzawa\"  # mine\n" + kHead + "[time]\nstep = 1e-4\nsteps = 100\n";
  const std::string empty = kHead + "[solver]\n\n[time]\nstep = 1e-4\nsteps = 100\n";
  for (const std::string& text : {inline_table, dotted, empty}) {
    const std::string written = rewrite_scene(text, "t.toml", changes());
    const Scene<2> scene = parse_scene(written, "t.toml");
    EXPECT_EQ(scene.solver.name, "pgs") << written;
    EXPECT_EQ(scene.solver.tol, 1e-3) << written;
    EXPECT_EQ(scene.solver.parameters.at("omega"), "1.5") << written;
    if (text != empty) {
      EXPECT_TRUE(says(written, "# mine"));
    }
  }
}

TEST(SceneRewrite, LeavesATextAloneThatSaysItAlready) {
  SceneChanges same = changes();
  same.parameters.clear();
  const std::string text = kHead +
                           "[time]\nstep = 2e-4\nsteps = 50\n[solver]\nname = \"pgs\"\ntol = "
                           "1e-3\n";
  EXPECT_EQ(rewrite_scene(text, "t.toml", same), text);
}

TEST(SceneRewrite, PutsTheStopTestRight) {
  const std::string text = kHead +
                           "[time]\nstep = 1e-4\nsteps = 100\n[solver]\nname = \"pgs\"\nstop = "
                           "\"impulse\"\n";
  const Scene<2> scene = parse_scene(rewrite_scene(text, "t.toml", changes()), "t.toml");
  EXPECT_EQ(scene.solver.stop, "guarded");
}

TEST(SceneRewrite, RefusesWhatItCannotFollow) {
  const std::string text =
      kHead + "[time]\nstep = 1e-4\nsteps = 100\n[solver.parameters]\nrho = \"paper\"\n";
  EXPECT_THROW(rewrite_scene(text, "t.toml", changes()), std::runtime_error);
  EXPECT_THROW(rewrite_scene("[time\n", "t.toml", changes()), SceneFileError);
}

}  // namespace
}  // namespace bipot
