#include "bench/command/failure_text.h"

#include <gtest/gtest.h>

#include "core/scene/scene_parts.h"

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

}  // namespace
}  // namespace bipot
