#include "core/pictures/stress_picture.h"

#include <regex>

#include "core/scene/generators.h"
#include "tests/support/source_folder.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

/// An SVG without the numbers that cairo counts its surfaces by.
std::string text_of(const fs::path& path) {
  return std::regex_replace(file_text(path), std::regex("surface[0-9]+"), "surface");
}

TEST(StressPicture, TheBarEndsWhereAllButTwoInAHundredDisksAre) {
  Scene<2> scene{.bodies = rectangular_lattice(10, 10, 0.01, Vec2::Zero()),
                 .materials = {"stone"},
                 .laws = {{}},
                 .step = 1e-3};
  const State<2> state = initial_state(scene);
  std::vector<double> pressures(100, 1900.0);
  pressures[7] = 1e6;
  const TemporaryFolder folder;
  const auto drawn = [&](const std::vector<double>& p, double high) {
    ForcePictureOptions options;
    options.fill.high = high;
    draw_stress_picture(folder / "stress.svg", scene, state, p, "", options);
    return text_of(folder / "stress.svg");
  };
  // 1900 Pa rounds up to 2 kPa, whatever the one outlier is; else the pictures differ.
  const std::string automatic = drawn(pressures, 0);
  EXPECT_TRUE(automatic == drawn(pressures, 2000));
  EXPECT_FALSE(automatic == drawn(pressures, 3000));
  EXPECT_TRUE(says(automatic, "</svg>"));
  // Without any pressure, and with nearly none.
  EXPECT_FALSE(says(drawn(std::vector<double>(100, 0.0), 0), "nan"));
  std::vector<double> one(100, 0.0);
  one[3] = 5;
  EXPECT_TRUE(drawn(one, 0) == drawn(one, 5));
}

TEST(StressPicture, EndsOfColourBarsAreRound) {
  EXPECT_EQ(colour_bar_end({}), 0);
  EXPECT_EQ(colour_bar_end({0, 0}), 0);
  EXPECT_DOUBLE_EQ(colour_bar_end({1234}), 1500);
  EXPECT_DOUBLE_EQ(colour_bar_end({8e4}), 8e4);
  EXPECT_DOUBLE_EQ(colour_bar_end({8.1e-3}), 1e-2);
}

TEST(StressPicture, PressuresAreThoseOfTheDisksOwnAreas) {
  // A disk of radius 2 squeezed with 7 N: Σ F r = 7 · 4 in xx, half of it over π 2².
  State<2> state;
  Disk d;
  d.radius = 2;
  d.mass = d.inertia = 1;
  state.bodies = {d};
  state.walls.resize(2);
  for (int k = 0; k < 2; ++k) {
    state.contacts.push_back(
        {.contact = {.i = 0, .j = 1 + k, .n = Vec2(k == 0 ? 1 : -1, 0)}, .s_n = 7e-3});
  }
  const std::vector<double> pressures = disk_pressures(state, 1e-3);
  ASSERT_EQ(pressures.size(), 1u);
  EXPECT_NEAR(pressures[0], 0.5 * 28 / (4 * std::numbers::pi), 1e-12);
}

}  // namespace
}  // namespace bipot
