// Walls, forces and drag that depend on time, and bodies from distributions and files.

#include "core/scene/wall_motion.h"
#include "tests/support/refused_scene.h"
#include "tests/support/scene_run.h"
#include "tests/support/scene_text.h"

namespace bipot {
namespace {

constexpr double kDriveStep = 0.01, kOmega = 2 * std::numbers::pi * 3, kDriveBound = 1e-11;

/// The scene of a text, with the step above.
Scene<2> drive_scene(const std::string& text) {
  return scene_of("gravity = [0, 0]\n" + text + "\n[time]\nstep = 0.01\nsteps = 1\n");
}

TEST(Drive, AWallSwingsAndIsPushedAsASine) {
  const std::string place = "[[walls]]\npoint = [0, 0]\nnormal = [0, 1]\nfrequency = 3\n";
  const double integral = (1 - std::cos(23 * kOmega * kDriveStep)) / kOmega;  // of sin ω t
  // A velocity 2 sin ω t.
  EXPECT_NEAR(after_steps(drive_scene(place + "velocity = [0, 2]"), 23, kDriveBound).walls[0].a[1],
              2 * integral, 1e-13);
  // A force 5 sin ω t on 4 kg.
  const State<2> pushed = after_steps(drive_scene(place + "force = 5\nmass = 4"), 23, kDriveBound);
  EXPECT_NEAR(pushed.walls[0].v[1], 5.0 / 4 * integral, 1e-13);
  EXPECT_NEAR(pushed.wall_work, 0.5 * 4 * std::pow(pushed.walls[0].v[1], 2), 1e-13);
}

TEST(Drive, ATableIsLinearBetweenItsTimesAndHoldsForSpinAndBelt) {
  const Scene<2> scene = drive_scene(
      "[[walls]]\ncenter = [0, 0]\nradius = 1\nspin = 8\ntimes = [1, 3]\nfactors = [0, 0.5]\n"
      "[[walls]]\npoint = [0, -5]\nnormal = [0, 1]\nsurface_velocity = [4, 0]\n"
      "times = [0, 1, 2]\nfactors = [0, 1, 0]");
  const double times[] = {0, 1.5, 4}, spins[] = {0, 1, 4}, belts[] = {0, 2, 0};
  for (int k = 0; k < 3; ++k) {
    const auto walls = walls_at(scene.walls, scene.walls, times[k]);
    EXPECT_NEAR(walls[0].spin, spins[k], 1e-15);
    EXPECT_NEAR(walls[1].belt[0], belts[k], 1e-15);
  }
}

// The triangle from (0, 0) over (1, 1) to (2, 0) has the area t²/2, then 1 - (2 - t)²/2.
TEST(Drive, TheMeanOfATableIsExact) {
  const TimeFactor table{.times = {0, 1, 2}, .factors = {0, 1, 0}};
  EXPECT_NEAR(table.mean(0.5, 1.5), (1 - 0.25) / 1, 1e-15);
  EXPECT_NEAR(table.mean(-1, 0.5), 0.125 / 1.5, 1e-15);
  EXPECT_NEAR(table.mean(1.5, 4), 0.125 / 2.5, 1e-15);
  EXPECT_NEAR(table.mean(-1, 3), 1.0 / 4, 1e-15);
  EXPECT_EQ(table.mean(0.25, 0.25), 0.25);
  EXPECT_EQ(table.mean(1, 2), 0.5);
}

// A force F sin ω t on a free body: v_k = F/(m ω) (1 - cos ω k h), the exact velocity. With the mean
// of the velocities, x_n = F h/(m ω) (n - sin(ω n h)/(2 tan(ω h/2))).
TEST(Drive, AForceOnABodyMovesItAsDerived) {
  const Scene<2> scene = drive_scene(
      "[[disks]]\nposition = [0, 0]\nradius = 0.5\nmass = 2\n[[disks]]\nposition = [0, 9]\nradius = "
      "0.5\nmass = 2\n[[forces]]\nbodies = [0, 0]\nforce = [3, 0]\nfrequency = 3");
  const int n = 37;
  const State<2> end = after_steps(scene, n, kDriveBound);
  const double half = 0.5 * kOmega * kDriveStep;
  EXPECT_NEAR(end.bodies[0].v[0], 1.5 / kOmega * (1 - std::cos(2 * n * half)), 1e-13);
  EXPECT_NEAR(end.bodies[0].x[0],
              1.5 * kDriveStep / kOmega * (n - std::sin(2 * n * half) / (2 * std::tan(half))),
              1e-13);
  EXPECT_EQ(end.bodies[1].v, Vec2(0, 0));
  EXPECT_NEAR(end.wall_work, end.bodies[0].v[0] * end.bodies[0].v[0], 1e-13);
}

// Drag with k = coefficient a/m: v = v0 exp(-k t) without gravity, whatever the step; with it a body
// that falls at w + g/k keeps that speed.
template <int D>
void drag_as_derived() {
  Scene<D> scene = one_law<D>({});
  scene.step = kDriveStep;
  scene.bodies = {round_body<D>(Vec<D>::Zero(), 0.5, 2, 3 * Vec<D>::Unit(0))};
  scene.drag.coefficient = 20;  // k = 5/s
  EXPECT_NEAR(after_steps(scene, 40, kDriveBound).bodies[0].v[0], 3 * std::exp(-5 * 0.4), 1e-13);
  scene.drag.velocity = Vec<D>::Unit(0);
  scene.gravity = -kGravity * Vec<D>::Unit(D - 1);
  const Vec<D> terminal = Vec<D>::Unit(0) + scene.gravity / 5;
  scene.bodies[0].v = terminal;
  const State<D> end = after_steps(scene, 40, kDriveBound);
  EXPECT_LT((end.bodies[0].v - terminal).norm(), 1e-12);
  // A disk that lies on a floor in the wind slides without friction as a free one.
  scene.walls = {half_space<D>(-0.5 * Vec<D>::Unit(D - 1), Vec<D>::Unit(D - 1))};
  scene.bodies[0].v.setZero();
  EXPECT_NEAR(after_steps(scene, 40, kDriveBound).bodies[0].v[0], 1 - std::exp(-5 * 0.4), 1e-9);
}

TEST(Drive, DragIsExactInDecayAndAtTheTerminalSpeed) {
  drag_as_derived<2>();
  drag_as_derived<3>();
}

// In a cell that shears the fluid shears with it. A disk and its image in the cell above, which
// moves at 0.2 m/s more, do the same, and the books close.
TEST(Drive, TheFluidDeformsWithTheCell) {
  const auto after = [](int k) {
    Scene<2> scene = one_law<2>({});
    scene.step = kDriveStep;
    scene.cell.in_x = scene.cell.in_y = true;
    scene.cell.width.length = scene.cell.height.length = 2.5;
    scene.cell.offset = {.motion = CellSide::Motion::kMoving, .speed = 0.2};
    scene.drag.coefficient = 20;
    scene.bodies = {round_body<2>(Vec2(0.7, 0.5 + 2.5 * k), 0.5, 2, Vec2(0.3 + 0.2 * k, 0.1))};
    return after_steps(scene, 40, kDriveBound);
  };
  const State<2> here = after(0), above = after(3);
  EXPECT_LT((above.bodies[0].x - here.bodies[0].x - here.cell.shift(0, 3)).norm(), 1e-12);
  EXPECT_LT((above.bodies[0].v - here.bodies[0].v - Vec2(0.6, 0)).norm(), 1e-12);
  EXPECT_GT(here.bodies[0].v[0], 0.04);  // by the fluid at the height of 0.5 m, 0.04 m/s
}

// Quantiles (k + ½)/n: of a log-normal law the middle one is the median, and logarithms are
// symmetric about its logarithm; their variance is σ² but for the tails. Of a table linear from 1 to
// 2 they are 1 + (k + ½)/n.
TEST(Drive, SizesFollowADistribution) {
  const auto radii = [](const std::string& law) {
    const Scene<2> scene = drive_scene(
        "[[disks]]\narrangement = \"random\"\ncount = 1001\nwidth = 99\ndensity = 1\n" + law);
    std::vector<double> sizes;
    for (const Disk& d : scene.bodies) sizes.push_back(d.radius);
    EXPECT_FALSE(std::is_sorted(sizes.begin(), sizes.end())) << "they lie at random";
    std::sort(sizes.begin(), sizes.end());
    return sizes;
  };
  const std::vector<double> normal = radii("lognormal = [0.5, 0.3]");
  EXPECT_NEAR(normal[500], 0.5, 1e-14);
  double mean = 0, square = 0;
  for (const double r : normal) {
    mean += std::log(r / 0.5) / 1001;
    square += std::pow(std::log(r / 0.5), 2) / 1001;
  }
  EXPECT_NEAR(mean, 0, 1e-14);
  EXPECT_NEAR(std::sqrt(square), 0.3, 1e-3);
  const std::vector<double> linear = radii("passing = [[1, 0], [2, 1]]");
  for (int k = 0; k < 1001; ++k) EXPECT_NEAR(linear[to_size(k)], 1 + (k + 0.5) / 1001, 1e-14);
}

TEST(Drive, BodiesComeFromAFileWithTheirMotion) {
  const TemporaryFolder folder;
  std::ofstream(folder / "bodies.csv") << "vx,radius,x,y,spin\n1.5,0.5,3,4,7\n";
  std::ofstream(folder / "scene.toml")
      << "[[disks]]\narrangement = \"file\"\nfile = \"bodies.csv\"\nmass = 2\nvelocity = [0, 2]\n"
         "[time]\nstep = 0.01\nsteps = 1\n";
  const Scene<2> scene = read_scene(folder / "scene.toml");
  ASSERT_EQ(scene.bodies.size(), 1u);
  EXPECT_EQ(scene.bodies[0].x, Vec2(3, 4));
  EXPECT_EQ(scene.bodies[0].v, Vec2(1.5, 2));
  EXPECT_EQ(scene.bodies[0].spin, 7);
}

TEST(Drive, WhatCannotBeIsRefused) {
  const auto refused = refused_scenes("\n[time]\nstep = 0.01\nsteps = 1\n", "gravity = [0, 0]\n");
  const std::string wall = "[[walls]]\npoint = [0, 0]\nnormal = [0, 1]\n";
  refused(wall + "frequency = 3", "belongs to a wall that moves");
  refused(wall + "velocity = [0, 1]\ntimes = [1, 0]\nfactors = [1, 1]", "increase");
  refused(wall + "velocity = [0, 1]\ntimes = [1]\nfactors = [1, 1]", "as many");
  refused(wall + "velocity = [0, 1]\ntimes = [1]\nfactors = [1]\nfrequency = 2", "either");
  refused("[[forces]]\nbodies = [0, 0]\nforce = [1, 0]", "no bodies 0 to 0");
  refused("model = \"dem\"\n[drag]\ncoefficient = 1", "dem");
  const std::string some =
      "[[disks]]\narrangement = \"random\"\ncount = 3\nwidth = 9\ndensity = 1\n";
  refused(some + "lognormal = [0.5, 0.3]\nradii = [1]", "one of");
  refused(some + "passing = [[1, 0.1], [2, 1]]", "from 0 to 1");
}

}  // namespace
}  // namespace bipot
