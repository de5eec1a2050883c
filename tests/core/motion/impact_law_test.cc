// Moreau's impact law: contacts that touch at the same time take their impulses at the same time.

#include <gtest/gtest.h>

#include <vector>

#include "core/scene_files/scene_file.h"
#include "tests/support/scene_run.h"

namespace bipot {
namespace {

/// Five balls in a row, `gap` apart; the first one comes with 1 m/s from 5 mm away.
Scene<2> cradle(double gap) {
  std::string text =
      "gravity = [0, 0]\ncontact = { e_n = 1 }\ntime = { step = 1e-3, steps = 200 }\n"
      "[[disks]]\nposition = [-0.205, 0]\nradius = 0.1\nmass = 1\nvelocity = [1, 0]\n";
  for (int k = 0; k < 4; ++k) {
    text += "[[disks]]\nposition = [" + std::to_string(k * (0.2 + gap)) +
            ", 0]\nradius = 0.1\nmass = 1\n";
  }
  return parse_scene(text, "cradle.toml");
}

std::vector<double> speeds(const State<2>& state) {
  std::vector<double> v;
  for (const Disk& d : state.bodies) v.push_back(d.v[0]);
  return v;
}

// Each contact that gets an impulse leaves with u⁺ = -e u⁻: v₂ - v₁ = 1, and v₂ = v₃ = v₄ = v₅
// where nothing approached. Momentum 1 = v₁ + 4 (v₁ + 1) gives v₁ = -0.6.
TEST(ImpactLaw, ATouchingRowIsStruckAsAWhole) {
  const std::vector<double> expected = {-0.6, 0.4, 0.4, 0.4, 0.4};
  const std::vector<double> v = speeds(solved_run(cradle(0)));
  for (std::size_t k = 0; k < v.size(); ++k) EXPECT_NEAR(v[k], expected[k], 1e-6) << k;
}

// With gaps that take more than a step to cross, the pairs meet one after the other and exchange
// their velocities.
TEST(ImpactLaw, GapsMakeImpactsOneAfterTheOther) {
  const std::vector<double> expected = {0, 0, 0, 0, 1};
  const std::vector<double> v = speeds(solved_run(cradle(0.003)));
  for (std::size_t k = 0; k < v.size(); ++k) EXPECT_NEAR(v[k], expected[k], 1e-6) << k;
}

}  // namespace
}  // namespace bipot
