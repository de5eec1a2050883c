#include "bench/command/failure_text.h"

#include "core/motion/spring_dashpot_setup.h"
#include "core/scene/scene_parts.h"
#include "solvers/simulation/scene_run.h"
#include "tests/support/scene_text.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(EnergyGrowth, RoundingOfARestIsNoGrowth) {
  // 1 kg at rest on a floor: a fall by its radius of 0.1 m are 1 J.
  Scene<2> scene = one_law<2>({});
  scene.gravity = Vec2(0, -10);
  scene.bodies = {round_body<2>(Vec2(0, 0.1), 0.1, 1)};
  const State<2> state = initial_state(scene);
  const auto warning = [&](double created) {
    EnergyGrowth growth(scene, state);
    StepReport<2> report;
    report.energy.kinetic = 1e-27;
    report.energy.shock_loss = -created;
    growth.add(scene, report);
    return growth.warning(scene);
  };
  EXPECT_EQ(warning(1e-25), "");
  EXPECT_EQ(warning(1e-13), "");
  EXPECT_NE(warning(1e-9), "");
}

TEST(EnergyGrowth, ForcesThatActWithinAStepAreNoError) {
  // Disks bounce to rest under a lid, and in a cell under pressure. All steps are solved.
  const std::string common = R"(
    gravity = [0, 0]
    contact = { mu = 0.3, e_n = 0.3, e_t = 0.3 }
    [time]
    step = 1e-3
    steps = 200
    [[disks]]
    arrangement = "rectangular"
    columns = 3
    rows = 3
    radius = 0.1
    corner = [0, 0.02]
    density = 1000
  )";
  const std::string lid = R"(
    [[walls]]
    point = [0, 0]
    normal = [0, 1]
    [[walls]]
    point = [0, 0.64]
    normal = [0, -1]
    force = 300
    mass = 5
  )";
  const std::string cell = R"(
    [cell]
    width = 0.64
    height = 0.64
    pressure_x = 1000
    pressure_y = 2000
    mass = 5
  )";
  for (const std::string& driven : {lid, cell}) {
    Scene<2> scene = scene_of<2>(common + driven);
    State<2> state = initial_state(scene);
    EnergyGrowth growth(scene, state);
    SceneRunOptions<2> options;
    options.on_step = [&](const SceneStep<2>& step) {
      growth.add(scene, step.report);
      return true;
    };
    EXPECT_EQ(run_scene(scene, state, options).totals.converged, 200);
    EXPECT_EQ(growth.warning(scene), "") << driven;
  }
}

TEST(EnergyGrowth, ASolvedStepMayErrByItsToleranceOfWhatContactsMove) {
  Scene<2> scene = one_law<2>({});
  scene.solver.tol = 1e-3;
  EnergyGrowth growth(scene, initial_state(scene));
  StepReport<2> report;
  report.error.energy = 1;
  report.energy.shock_loss = -1e-3;
  growth.add(scene, report);
  EXPECT_EQ(growth.warning(scene), "");
}

TEST(EnergyGrowth, OfSpringsComesFromTheSubsteps) {
  // By default e_t = 0 is not e_n, which means nothing to springs.
  Scene<3> scene = one_law<3>({.mu = 0.3, .e_n = 0.5});
  scene.model = Model::kSpringDashpot;
  scene.bodies = {round_body<3>(Vec3::Zero(), 0.1, 1)};
  EnergyGrowth growth(scene, initial_state(scene));
  StepReport<3> report;
  report.energy.kinetic = 1;
  report.energy.shock_loss = -1e-3;
  growth.add(scene, report);
  const std::string warning = growth.warning(scene);
  EXPECT_TRUE(says(warning, "--substep")) << warning;
  EXPECT_FALSE(says(warning, "coefficients")) << warning;
  EXPECT_FALSE(says(warning, "Newton")) << warning;
}

TEST(FailureText, GluedDisksAndPartsOfClustersHaveNoMassThatDiffers) {
  Scene<2> scene = scene_of<2>(R"(
    walls = [{point = [0, 0], normal = [0, 1], name = "floor"}]
    disks = [{position = [0, 0.2], radius = 0.1, mass = 1},
             {position = [5, 0.2], radius = 0.1, wall = "floor"}]
    clusters = [{position = [2, 0.2], mass = 2, parts = [[0, 0, 0.1], [0.1, 0, 0.1]]}]
    time = {step = 1e-3, steps = 1}
  )");
  const auto text = [&] {
    return failure_text<2>(scene, initial_state(scene), {}, ContactProblem(), ContactError(), 1,
                           false);
  };
  EXPECT_FALSE(says(text(), "masses differ")) << text();
  scene.bodies[0].mass = 1e-9;
  EXPECT_TRUE(says(text(), "masses differ by 2e+09")) << text();
}

TEST(PassageAdvice, NamesTheBodiesAlsoWithSprings) {
  // 2 m/s over 1e-3 s are 0.02 radii of 0.1 m.
  Scene<3> scene = one_law<3>({});
  scene.step = 1e-3;
  scene.bodies = {round_body<3>(Vec3::Zero(), 0.1, 1, Vec3(2, 0, 0))};
  SpringDashpotSetup springs{.substep = scene.step};
  const std::string advice = passage_advice(scene, initial_state(scene), &springs, false);
  EXPECT_TRUE(says(advice, "spheres move 0.02 of the smallest radius")) << advice;
}

}  // namespace
}  // namespace bipot
