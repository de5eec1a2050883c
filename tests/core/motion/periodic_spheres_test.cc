// Spheres in a cell that repeats itself in x, or in x and y.

#include "core/motion/periodic_state.h"
#include "core/motion/sample_volume.h"
#include "core/pictures/flat_view.h"
#include "core/scene/periodic_detection.h"
#include "tests/support/refused_scene.h"
#include "tests/support/scene_run.h"
#include "tests/support/scene_text.h"
#include "tests/support/small_scenes.h"

namespace bipot {
namespace {

PeriodicCell block(double width, double depth) {
  PeriodicCell cell{.in_x = true, .in_y = depth > 0};
  cell.width.length = width;
  cell.height.length = depth;
  return cell;
}

TEST(PeriodicSpheres, EveryPairOfImagesIsMetOnce) {
  // Against all pairs of all images. The places are up to three cells away from the origin.
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const double depth : {0.0, 1.3}) {
    const PeriodicCell cell = block(1.1, depth);
    std::vector<Sphere> spheres;
    for (int k = 0; k < 60; ++k) {
      spheres.push_back(round_body<3>(
          Vec3(3 * unit(random), (depth > 0 ? 3 : 0.6) * unit(random), 0.5 * unit(random)),
          k % 3 == 0 ? 0.12 : 0.2, 2));
    }
    const auto found = detect_periodic_contacts<3>(spheres, {}, cell, 1e-3, 1);
    std::set<std::tuple<int, int, int, int>> expected, seen;
    for (int i = 0; i < 60; ++i) {
      for (int j = i + 1; j < 60; ++j) {
        for (int kx = -8; kx <= 8; ++kx) {
          for (int ky = (depth > 0 ? -8 : 0); ky <= (depth > 0 ? 8 : 0); ++ky) {
            const Sphere &a = spheres[to_size(i)], &b = spheres[to_size(j)];
            const Vec3 d = a.x - b.x - Vec3(kx * 1.1, ky * depth, 0);
            if (d.norm() - a.radius - b.radius <= 1e-3) expected.insert({i, j, kx, ky});
          }
        }
      }
    }
    for (const Contact<3>& c : found) {
      EXPECT_TRUE(seen.insert({c.i, c.j, c.image_x, c.image_y}).second);
      const Sphere &a = spheres[to_size(c.i)], &b = spheres[to_size(c.j)];
      const Vec3 d = a.x - b.x - Vec3(c.image_x * 1.1, c.image_y * depth, 0);
      EXPECT_NEAR(c.gap, d.norm() - a.radius - b.radius, 1e-12);
      EXPECT_LT((c.n - d.normalized()).norm(), 1e-12);
    }
    EXPECT_EQ(seen, expected);
    EXPECT_GT(expected.size(), 40u);
  }
}

constexpr const char* kLayer =
    R"(
contact = {mu = 0.3}
cell = {width = 0.43, depth = 0.57}
walls = [{point = [0, 0, 0], normal = [0, 0, 1]},
  {name = "plate", point = [0, 0, 1], normal = [0, 0, -1], force = 100, mass = 5}]
time = {step = 2e-3, steps = 60}
solver = {name = "pgs", tol = 1e-6}
)"
    "spheres = [{arrangement = 'cubic', columns = 3, rows = 4, layers = 3, radius = 0.07, density = 1000, "
    "velocity = [1, -2, 0]}]\n";

TEST(PeriodicSpheres, WhereTheCellBeginsChangesNothing) {
  // All spheres moved by half a cell, and by whole cells: the same impulses, other images.
  auto scene = scene_of<3>(kLayer);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const double k = static_cast<double>(i);
    scene.bodies[i].v = Vec3(std::sin(3 * k), std::cos(5 * k), 0);
  }
  Scene<3> moved = scene;
  for (std::size_t i = 0; i < moved.bodies.size(); ++i) {
    moved.bodies[i].x += Vec3(0.2 + 0.43 * (static_cast<double>(i % 3) - 1), 0.3 + 0.57 * 2, 0);
  }
  State<3> a = initial_state(scene), b = initial_state(moved);
  TimeStepper<3> at = stepper_of(scene, "pgs", {.tol = 1e-9}),
                 bt = stepper_of(moved, "pgs", {.tol = 1e-9});
  bool across_x = false, across_y = false;
  while (a.step < 60) {
    const StepReport<3> r = at.advance(a);
    bt.advance(b);
    EXPECT_LT(std::abs(r.energy.imbalance), 1e-10);
    EXPECT_LT(r.momentum_imbalance.norm(), 1e-11);
    for (const auto& c : a.contacts) {
      across_x |= c.s_n > 0 && c.contact.image_x != 0;
      across_y |= c.s_n > 0 && c.contact.image_y != 0;
    }
  }
  EXPECT_TRUE(across_x && across_y);
  EXPECT_LT((momentum(a) - momentum(b)).norm(), 1e-5 * momentum(a).norm());
  EXPECT_NEAR(kinetic_energy(a), kinetic_energy(b), 1e-5 * kinetic_energy(a));
  const double volume = sample_measure(a, scene.step);
  const double plate = a.walls[1].a[2] - 0.5 * scene.step * a.walls[1].v[2];
  EXPECT_NEAR(volume, 0.43 * 0.57 * plate, 1e-12);
  EXPECT_NEAR(sample_measure(b, scene.step), volume, 1e-6);
  const Mat<3> stress = sample_stress<3>(a, scene.step, volume, contact_moments(a)).total();
  EXPECT_LT((stress - stress.transpose()).norm(), 1e-10 * stress.norm());
}

TEST(PeriodicSpheres, VolumeIsThatOfTheCellAndOfWhatClosesIt) {
  // Without planes as high as the spheres reach; in a cell of x alone as deep as they reach.
  State<3> state{.cell = block(2, 3)};
  state.bodies = {round_body<3>(Vec3(0.5, 0.5, 1), 0.5, 2),
                  round_body<3>(Vec3(9, 1.5, 2), 0.25, 2)};
  EXPECT_NEAR(sample_measure(state, 0), 2 * 3 * (2.25 - 0.5), 1e-9);
  state.walls = {half_space<3>(Vec3::Zero(), Vec3::UnitZ())};
  EXPECT_NEAR(sample_measure(state, 0), 2 * 3 * 2.25, 1e-9);
  state.cell = block(2, 0);
  EXPECT_NEAR(sample_measure(state, 0), 2 * (1.75 - 0) * 2.25, 1e-9);
}

TEST(PeriodicSpheres, ASphereRollsOnThroughTheEdge) {
  // Thrown along the floor it ends at 5/7 of its speed, wherever cells begin, and keeps its
  // coordinates; in the wrapped state it lies in the cell.
  Scene<3> scene = heavy_scene<3>({.mu = 0.4});
  scene.cell = block(0.5, 0.7);
  scene.walls = {half_space<3>(Vec3::Zero(), Vec3::UnitZ())};
  scene.bodies = {round_body<3>(Vec3(0.1, 0.1, 0.1), 0.1, 2, Vec3(2, -1, 0))};
  scene.contact_distance = 1e-9;
  scene.step = 1e-3;
  scene.num_steps = 800;
  scene.solver.tol = 1e-11;
  ASSERT_EQ(validate(scene), "");
  const State<3> end = solved_run(scene);
  EXPECT_LT((end.bodies[0].v - 5.0 / 7 * Vec3(2, -1, 0)).norm(), 1e-7);
  EXPECT_GT(end.bodies[0].x[0], 1);
  const State<3> inside = wrapped_state(end);
  EXPECT_GE(inside.bodies[0].x[0], 0);
  EXPECT_LT(inside.bodies[0].x[0], 0.5);
  EXPECT_GE(inside.bodies[0].x[1], 0);
  EXPECT_LT(inside.bodies[0].x[1], 0.7);
}

TEST(PeriodicSpheres, ARunGoesOnBitForBitAndIsDrawn) {
  const auto scene = scene_of<3>(kLayer);
  const State<3> end = expect_exact_restart(scene, 40);
  // The picture repeats itself to the right, and shows contacts with the image there.
  const FlatView all = project(scene, end);
  EXPECT_TRUE(all.state.cell.in_x && !all.state.cell.in_y);
  EXPECT_EQ(all.state.contacts.size(), end.contacts.size());
  int with_image = 0;
  for (const ContactOutcome<2>& c : all.state.contacts)
    with_image += c.contact.image_x != 0 ? 1 : 0;
  EXPECT_GT(with_image, 0);
  // What is in front is drawn last, however far away it is.
  std::vector<double> front(end.bodies.size(), 0);
  front[to_size(all.bodies.front())] = 1;
  EXPECT_EQ(project(scene, end, front).bodies.back(), all.bodies.front());
}

TEST(PeriodicSpheres, PlanesAcrossTheCellAndObliqueCylindersAreRefused) {
  const std::string rest = "dim = 3\n[cell]\nwidth = 2\n[time]\nstep = 1e-3\nsteps = 1\n";
  const auto refused = refused_scenes("", rest);
  parse_any_scene(rest + "[[walls]]\npoint = [0, 0, 0]\nnormal = [0, 1, 1]\n", "test.toml");
  refused("[[walls]]\npoint = [0, 0, 0]\nnormal = [1, 0, 1]\n", "along the directions");
  refused("[[walls]]\ncenter = [0, 0, 0]\naxis = [1, 0, 1]\nradius = 0.5\n", "along an axis");
  refused("[[walls]]\ncenter = [0, 0, 0]\naxis = [0, 1, 0]\nradius = 1.5\n", "3 m wide");
  parse_any_scene(rest + "[[walls]]\ncenter = [0, 0, 0]\naxis = [1, 0, 0]\nradius = 9\n", "t");
  const auto refused_in_y = refused_scenes(
      "", "dim = 3\ncell = { width = 9, depth = 2 }\n" + rest.substr(rest.find("[time]")));
  refused_in_y("[[walls]]\ncenter = [0, 0, 0]\naxis = [1, 0, 0]\nradius = 1.5\n", "3 m deep");
  refused("[[spheres]]\nposition = [0, 0, 0]\nradius = 0.6\nmass = 1\n", "diameters");
}

}  // namespace
}  // namespace bipot
