#include "bench/experiments/packing.h"

#include "bench/experiments/compression_run.h"
#include "bench/problems/compression_scene.h"
#include "bench/problems/scene_catalogue.h"
#include "core/motion/force_balance.h"
#include "core/scene_files/scene_file.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

ContactOutcome<2> carried(int i, int j, double s_n, double s_t = 0) {
  return {.contact = {.i = i, .j = j, .n = Vec2(1, 0)}, .s_n = s_n, .s_t = s_t};
}

Disk disk(double x, double y, double radius) {
  return {.x = Vec2(x, y), .radius = radius, .mass = 2, .inertia = 3};
}

TEST(ForceCorrelation, IsPearsonsOverPairsThatCarrySomethingInEitherStep) {
  const std::vector<ContactOutcome<2>> a = {carried(0, 1, 1), carried(0, 2, 2), carried(1, 2, 3)};
  std::vector<ContactOutcome<2>> b = a;
  EXPECT_DOUBLE_EQ(force_correlation(a, b), 1);
  for (ContactOutcome<2>& o : b) o.s_n = 7 - 2 * o.s_n;
  EXPECT_DOUBLE_EQ(force_correlation(a, b), -1);
  // Pairs of one step alone count with zero, unloaded ones do not: (1, 0), (2, 2), (0, 1) with
  // means 1 and 1: covariance (0·-1 + 1·1 + -1·0)/3 over variances 2/3 each: 1/2.
  EXPECT_DOUBLE_EQ(
      force_correlation(std::vector{carried(0, 1, 1), carried(0, 3, 2), carried(0, 5, 0)},
                        std::vector{carried(0, 3, 2), carried(0, 4, 1), carried(0, 5, 0)}),
      0.5);
  EXPECT_TRUE(std::isnan(force_correlation(a, {})));
  EXPECT_TRUE(std::isnan(force_correlation({}, {})));
}

TEST(MeanContacts, CountWhatAPairDoesNotCarryAsZero) {
  MeanContacts mean;
  State<2> state{.contacts = {carried(0, 1, 6, 3), carried(0, 3, 9)}};
  mean.add(state);
  state.contacts = {carried(0, 2, 3), carried(0, 3, 3)};
  mean.add(state);
  state.contacts = {};
  mean.add(state);
  const State<2> averaged = mean.in(state);
  ASSERT_EQ(averaged.contacts.size(), 3u);
  EXPECT_EQ(averaged.contacts[0].contact.j, 1);
  EXPECT_DOUBLE_EQ(averaged.contacts[0].s_n, 2);
  EXPECT_DOUBLE_EQ(averaged.contacts[0].s_t, 1);
  EXPECT_DOUBLE_EQ(averaged.contacts[1].s_n, 1);
  EXPECT_DOUBLE_EQ(averaged.contacts[2].s_n, 4);
}

TEST(Packing, CoordinationCountsLoadedContactsAtBothEnds) {
  State<2> state{.bodies = {disk(0, 0, 1), disk(2, 0, 1)}};
  // One between the disks (two ends), one with a wall, one that carries nothing.
  state.contacts = {carried(0, 1, 1), carried(1, 2, 1), carried(0, 2, 0)};
  EXPECT_DOUBLE_EQ(coordination(state), 1.5);
}

TEST(Packing, CoveredFractionCountsOverlapsOnce) {
  State<2> state{.bodies = {disk(0, 0, 1), disk(1, 0, 1)}, .contacts = {carried(0, 1, 1)}};
  state.contacts[0].contact.gap = -1;
  // Two unit circles, a radius apart: the lens has 2π/3 - √3/2.
  const double lens = 2 * std::numbers::pi / 3 - std::sqrt(3.0) / 2;
  EXPECT_NEAR(covered_fraction(state, 2), (2 * std::numbers::pi - lens) / 2, 1e-14);
  // Half of the second one is behind a wall.
  state.contacts = {carried(1, 2, 1)};
  state.contacts[0].contact.gap = -1;
  EXPECT_NEAR(covered_fraction(state, 1), 1.5 * std::numbers::pi, 1e-14);
  state.contacts[0].contact.gap = 0.1;
  EXPECT_NEAR(covered_fraction(state, 1), 2 * std::numbers::pi, 1e-14);
}

TEST(Packing, DisplacementEnergyIsThatOfTheMeanVelocities) {
  State<2> before, after;
  before.bodies = after.bodies = {disk(0, 0, 1)};
  before.bodies[0].v = Vec2(1, 5);
  after.bodies[0].v = Vec2(3, -5);
  before.bodies[0].spin = 4;
  after.bodies[0].spin = -2;
  before.walls.resize(1);
  before.walls[0].motion = Wall<2>::Motion::kDriven;
  before.walls[0].mass = 10;
  after.walls = before.walls;
  after.walls[0].v = Vec2(0, 2);
  // ½ 2 (2² + 0²) + ½ 3 1² + ½ 10 1².
  EXPECT_DOUBLE_EQ(displacement_energy(before, after), 4 + 1.5 + 5);
}

TEST(Packing, ForceOnAWallIsOppositeToThatOnTheDisks) {
  State<2> state{.bodies = {disk(0, 0, 1)}};
  state.walls.resize(2);
  state.contacts = {carried(0, 1, 2, 0.5), carried(0, 2, 9)};
  // n = (1, 0), t = (0, 1): the wall gets -(2, 0.5)/h.
  EXPECT_EQ(wall_reactions(state, 0.5).at(0), Vec2(-4, -1));
}

TEST(Surface, OfAnInclinedRowHasItsSlopeAndNoHeap) {
  State<2> state;
  for (int k = 0; k < 20; ++k) state.bodies.push_back(disk(0.5 + k, 10 + 0.1 * k, 0.5));
  const Surface surface = measure_surface(state, 0, 20, 20);
  EXPECT_NEAR(surface.slope, 0.1, 1e-12);
  EXPECT_NEAR(surface.heap, 0, 1e-12);
  EXPECT_NEAR(surface.height, 10 + 0.1 * 9.5 + 0.5, 1e-12);
  // Uniform steps of 0.1: rms 0.1 √((20² - 1)/12).
  EXPECT_NEAR(surface.roughness, 0.1 * std::sqrt(399 / 12.0), 1e-12);
}

TEST(Surface, OfARoofHasAHeapAndNoSlope) {
  State<2> state;
  for (int k = 0; k < 20; ++k) {
    state.bodies.push_back(disk(0.5 + k, 10 - 0.2 * std::abs(k - 9.5), 0.5));
    state.bodies.push_back(disk(0.5 + k, 1, 0.5));  // deep below: not seen
  }
  const Surface surface = measure_surface(state, 0, 20, 20);
  EXPECT_NEAR(surface.slope, 0, 1e-12);
  EXPECT_NEAR(surface.heap, 0.2, 1e-12);
}

TEST(CompressionScene, IsTheShippedOneByDefault) {
  const Scene<2> made = compression_scene({});
  const Scene<2> shipped = read_scene(find_scene("isotropic_compression"));
  ASSERT_EQ(made.bodies.size(), shipped.bodies.size());
  for (std::size_t k = 0; k < made.bodies.size(); ++k) {
    ASSERT_EQ(made.bodies[k].x, shipped.bodies[k].x) << k;
    ASSERT_EQ(made.bodies[k].radius, shipped.bodies[k].radius);
    ASSERT_EQ(made.bodies[k].mass, shipped.bodies[k].mass);
    ASSERT_EQ(made.bodies[k].inertia, shipped.bodies[k].inertia);
  }
  ASSERT_EQ(made.walls.size(), shipped.walls.size());
  for (std::size_t k = 0; k < made.walls.size(); ++k) {
    EXPECT_EQ(made.walls[k].name, shipped.walls[k].name);
    EXPECT_LT((made.walls[k].a - shipped.walls[k].a).norm(), 1e-15);
    EXPECT_EQ(made.walls[k].direction, shipped.walls[k].direction);
    EXPECT_EQ(made.walls[k].force, shipped.walls[k].force);
    EXPECT_EQ(made.walls[k].mass, shipped.walls[k].mass);
  }
  EXPECT_EQ(made.law(0, 0).mu, shipped.law(0, 0).mu);
  EXPECT_EQ(made.law(0, 0).e_n, shipped.law(0, 0).e_n);
  EXPECT_EQ(made.law(0, 0).e_t, shipped.law(0, 0).e_t);
  EXPECT_EQ(made.step, shipped.step);
  EXPECT_EQ(made.num_steps, shipped.num_steps);
  EXPECT_DOUBLE_EQ(made.contact_distance, shipped.contact_distance);
}

TEST(CompressionScene, SmallerOnesAreSoundAndHaveTheSamePressure) {
  for (const int count : {40, 154, 617}) {
    const Scene<2> scene = compression_scene({.count = count, .smooth_walls = true});
    EXPECT_EQ(validate(scene), "");
    EXPECT_EQ(scene.bodies.size(), static_cast<std::size_t>(count));
    EXPECT_NEAR(scene.walls[0].force / scene.walls[1].a[0], 5000 / 0.1, 1e-6);
    EXPECT_EQ(scene.law(0, 1).mu, 0);
    EXPECT_EQ(scene.law(0, 0).mu, 0.1);
    for (const Disk& d : scene.bodies) EXPECT_LE(d.x[1] + d.radius, scene.walls[3].a[1]);
  }
}

TEST(Compression, BalancesTheWallsAndMeetsTheirPressure) {
  Scene<2> scene = compression_scene({.count = 60, .smooth_walls = true});
  scene.solver.max_iterations = 2000;
  const Compression c = run_compression(scene, {});
  EXPECT_LT(c.wall_balance, 1e-11);
  EXPECT_EQ(c.jammed.steps, 100);
  EXPECT_GT(c.flow.steps, 5);
  EXPECT_LT(c.flow.asymmetry, 1e-13);
  EXPECT_NEAR(c.jammed.wall_pressure / c.jammed.applied_pressure, 1, 0.01);
  EXPECT_NEAR(0.5 * c.jammed.stress.trace() / c.jammed.wall_pressure, 1, 0.01);
  EXPECT_LT((c.jammed.stress - c.jammed.walls).norm(), 0.01 * c.jammed.walls.norm());
  EXPECT_DOUBLE_EQ(c.jammed.correlation[0], 1);
  EXPECT_GT(c.solid_fraction, 0.7);
  EXPECT_LT(c.solid_fraction, 0.95);
}

TEST(WindowStatistics, TellHalvesApart) {
  std::vector<double> pressures(kWindows * kWindows, 1.0);
  EXPECT_DOUBLE_EQ(window_statistics(pressures).variation, 0);
  // The right half (columns are stored one after the other) carries three times as much.
  for (std::size_t k = pressures.size() / 2; k < pressures.size(); ++k) pressures[k] = 3;
  const Compression::WindowStatistics s = window_statistics(pressures);
  EXPECT_DOUBLE_EQ(s.horizontal, 0.5);
  EXPECT_DOUBLE_EQ(s.variation, 0.5);  // mean 2, deviations 1
}

}  // namespace
}  // namespace bipot
