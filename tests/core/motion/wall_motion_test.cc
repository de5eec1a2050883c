#include "core/scene/wall_motion.h"

#include "core/motion/sample_area.h"
#include "core/motion/spring_dashpot.h"
#include "tests/support/scene_run.h"
#include "tests/support/small_scenes.h"

namespace bipot {
namespace {

Scene<2> pulled_scene(double mu) {
  Scene<2> scene = heavy_scene({.mu = mu});
  scene.solver.name = "pgs";
  scene.solver.tol = 1e-11;
  scene.contact_distance = 1e-6;
  return scene;
}
Scene<2> rough_scene(double mu) {
  Scene<2> scene = pulled_scene(mu);
  scene.gravity.setZero();
  return scene;
}

/// A plate on top of the disk that is pressed down with `force` and moved along x with `speed`.
Wall<2> pressed_plate(double height, double force, double speed) {
  Wall<2> plate = half_space<2>(Vec2(0, height), Vec2(0, -1));
  drive(plate, Vec2(0, -1), 4, force);
  plate.across = Vec2(speed, 0);
  plate.v = plate.across;
  return plate;
}

TEST(WallMotion, AMovedAndPressedPlateRollsADiskAtHalfItsSpeed) {
  // A disk between a fixed floor and a plate pressed on it with 50 N and moved along with 0.3 m/s;
  // no gravity. Both contacts have the same normal force, so both friction forces are mu 50 N while
  // they slide, in the same direction (+x) at the top, and against the floor's sliding at the
  // bottom. At rest the floor contact does not slide. The disk ends rolling: velocity 0.15 m/s,
  // spin -0.15/0.1 (its top moves with the plate, its bottom stands).
  Scene<2> scene = on_floor(rough_scene(0.4), 0.1, 2);
  scene.walls.push_back(pressed_plate(0.2, 50, 0.3));
  const State<2> end = closed_run(scene, 100, 1e-12, 1e-12);
  EXPECT_NEAR(end.bodies[0].v[0], 0.15, 1e-9);
  EXPECT_NEAR(end.bodies[0].spin, -1.5, 1e-8);
  EXPECT_NEAR(end.walls[1].v[0], 0.3, 1e-15);
  EXPECT_NEAR(end.walls[1].a[0], 0.03, 1e-14);
  EXPECT_NEAR(end.walls[1].a[1], 0.2, 1e-8);  // pressed, but the disk does not give way
  for (const ContactOutcome<2>& c : end.contacts) EXPECT_NEAR(c.s_n / scene.step, 50, 1e-6);
  // What the plate did is the disk's energy and what slid: 1/2 m v² (1 + 1/2) in the end.
  EXPECT_NEAR(end.wall_work - end.friction_loss - end.shock_loss, 0.75 * 2 * 0.15 * 0.15, 1e-9);
  EXPECT_GT(end.friction_loss, 0);
}

TEST(WallMotion, AMovedPlateDoesTheWorkOfItsFriction) {
  // A disk that cannot move between three walls: pressed from above by 50 N, against a side wall
  // by friction mu 50 N = 10 N. All else frictionless, so the disk turns: its spin grows by
  // mu N a / I = 10 * 0.1 / 0.01 = 100 rad/s², until its rim has the plate's 0.3 m/s at t = 0.03 s.
  // In the 20 steps before that the plate does the work 10 N * 0.3 m/s * 0.02 s.
  Scene<2> scene = rough_scene(0);
  scene.materials = {"smooth", "rough"};
  scene.laws = {{.mu = 0}, {.mu = 0.2}, {.mu = 0.2}, {.mu = 0}};
  scene.bodies = {round_body<2>(Vec2(0, 0.1), 0.1, 2)};
  scene.walls = {flat_floor<2>(), pressed_plate(0.2, 50, 0.3),
                 half_space<2>(Vec2(0.1, 0), Vec2(-1, 0))};
  scene.walls[1].material = 1;
  const State<2> end = solved_run(scene, 20);
  EXPECT_NEAR(end.bodies[0].spin, -100 * 0.02, 1e-8);
  EXPECT_NEAR(end.wall_work, 10 * 0.3 * 0.02, 1e-9);
}

TEST(WallMotion, ThePlatesOwnMotionAcrossIsNotItsEnergy) {
  const Wall<2> plate = pressed_plate(0, 1, 0.3);
  EXPECT_EQ(wall_kinetic_energy(plate), 0);
  EXPECT_EQ(wall_momentum(plate), Vec2::Zero());
  Wall<2> falling = plate;
  falling.v = driven_velocity(plate, 2);
  EXPECT_EQ(falling.v, Vec2(0.3, -2));
  EXPECT_EQ(driven_speed(falling), 2);
  EXPECT_EQ(wall_kinetic_energy(falling), 0.5 * 4 * 4);
  EXPECT_EQ(wall_momentum(falling), Vec2(0, -8));
}

TEST(WallMotion, ARoughPlateLiesOnWhatItsDisksTouch) {
  // A plate of 4 kg, pressed down with 50 N, carries a glued disk of radius 0.1, which stands on
  // a free disk of the same size straight above the floor: both contacts carry 50 N (no gravity),
  // and the plate stays. Momentum and energy close.
  Scene<2> scene = rough_scene(0.4);
  scene.bodies = {round_body<2>(Vec2(0, 0.1), 0.1, 2), round_body<2>(Vec2(0, 0.3), 0.1, 2)};
  scene.walls = {flat_floor<2>(), pressed_plate(0.35, 50, 0)};
  scene.bodies[1].mass = scene.bodies[1].inertia = 0;
  scene.bodies[1].wall = 1;
  ASSERT_EQ(validate(scene), "");
  const State<2> end = closed_run(scene, 20, 1e-13, 1e-13);
  ASSERT_EQ(end.contacts.size(), 2u);
  for (const ContactOutcome<2>& c : end.contacts) {
    EXPECT_EQ(c.contact.i, 0);
    EXPECT_NEAR(c.s_n / scene.step, 50, 1e-7);
  }
  EXPECT_NEAR(end.bodies[1].x[1], 0.3, 1e-8);
}

TEST(WallMotion, ARoughPlateFallsWithItsDisks) {
  // Nothing below: plate and glued disk fall with 50/4 m/s² together, and no contact is seen
  // between the two glued disks, which overlap, nor between them and their wall.
  Scene<2> scene = rough_scene(0.4);
  scene.bodies = {round_body<2>(Vec2(0, 1), 0.1, 2), round_body<2>(Vec2(0.1, 1), 0.1, 2)};
  scene.walls = {pressed_plate(1, 50, 0.3)};
  for (Disk& d : scene.bodies) {
    d.mass = d.inertia = 0;
    d.wall = 0;
  }
  const State<2> end = solved_run(scene, 10, [](const State<2>&, const StepReport<2>& r) {
    EXPECT_EQ(r.contacts, 0);
    EXPECT_LT(std::abs(r.energy.imbalance), 1e-14);
  });
  EXPECT_NEAR(end.walls[0].v[1], -12.5 * 0.01, 1e-14);
  for (const Disk& d : end.bodies) {
    EXPECT_NEAR(d.x[1] - end.walls[0].a[1], 0, 1e-15);
    EXPECT_NEAR(d.v[0], 0.3, 1e-15);
  }
  EXPECT_NEAR(end.bodies[0].x[0], 0.003, 1e-15);
}

TEST(WallMotion, ARoughWallHoldsADiskThatASmoothOneLetsSlide) {
  // A disk in the hollow of two glued disks on a slope of 20 degrees, without friction: it stands
  // as long as the slope is less than the hollow's 30 degrees (three equal disks in touch), here
  // against contacts with s_n = m g h cos(30 -+ 20)/sin(60), by the triangle of forces. The walls
  // carry the weight.
  const double angle = std::numbers::pi / 9, third = std::numbers::pi / 3;
  Scene<2> scene = rough_scene(0);
  scene.gravity = kGravity * Vec2(std::sin(angle), -std::cos(angle));
  const double rise = 0.1 * std::sqrt(3.0);
  scene.bodies = {round_body<2>(Vec2(-0.1, 0), 0.1, 2), round_body<2>(Vec2(0.1, 0), 0.1, 2),
                  round_body<2>(Vec2(0, rise), 0.1, 2)};
  scene.walls = {flat_floor<2>()};
  for (std::size_t k = 0; k < 2; ++k) {
    scene.bodies[k].mass = scene.bodies[k].inertia = 0;
    scene.bodies[k].wall = 0;
  }
  const State<2> end = solved_run(scene, 50, [](const State<2>&, const StepReport<2>& r) {
    EXPECT_LT(r.momentum_imbalance.norm(), 1e-14);
  });
  EXPECT_NEAR((end.bodies[2].x - Vec2(0, rise)).norm(), 0, 1e-7);
  ASSERT_EQ(end.contacts.size(), 2u);
  // Normals at +-30 degrees from the upright; f_0 (sin 30, cos 30) + f_1 (-sin 30, cos 30) = -m g.
  for (const ContactOutcome<2>& c : end.contacts) {
    EXPECT_EQ(c.contact.i, 2);
    const double side = c.contact.j == 0 ? -1 : 1;  // of the disk that is uphill: less
    const double lean = std::sin(third / 2 + side * angle) / std::sin(third);
    EXPECT_NEAR(c.s_n / scene.step, 2 * kGravity * lean, 1e-5);
  }
}

TEST(WallMotion, SurfacesOfCirclesTurnCounterClockwise) {
  Wall<2> drum{.shape = Wall<2>::Shape::kHollowCircle, .radius = 2, .spin = 3};
  // At the lowest point of a hollow circle the normal points up; counter-clockwise is +x there.
  EXPECT_EQ(surface_velocity(drum, Vec2(0.5, 0), Vec2(0, 1)), Vec2(6.5, 0));
  // At its right: the normal points to the left, counter-clockwise is up.
  EXPECT_EQ(surface_velocity(drum, Vec2::Zero(), Vec2(-1, 0)), Vec2(0, 6));
  drum.shape =
      Wall<2>::Shape::kSolidCircle;  // on top of a solid one: the normal points up, it moves -x
  EXPECT_EQ(surface_velocity(drum, Vec2::Zero(), Vec2(0, 1)), Vec2(-6, 0));
}

/// A disk at the bottom of a drum.
Scene<2> drum_scene(double spin, double mu) {
  Scene<2> scene = pulled_scene(mu);
  scene.walls = {{.shape = Wall<2>::Shape::kHollowCircle, .radius = 1, .spin = spin}};
  scene.bodies = {round_body<2>(Vec2(0, -0.9), 0.1, 2)};
  return scene;
}

TEST(WallMotion, ADrumSpinsADiskUpToItsOwnSurface) {
  // A disk at the bottom of a slowly turning drum, gravity down. Steady: no force along the
  // surface, so the disk stays at the bottom and its rim moves with the drum: spin = Omega R / a,
  // counter-clockwise as the drum.
  Scene<2> scene = drum_scene(0.2, 0.5);
  scene.bodies[0].spin = 2;
  const State<2> end = closed_run(scene, 300, 1e-12, 1e-12);
  EXPECT_NEAR(end.bodies[0].spin, 2, 1e-8);
  EXPECT_NEAR(end.bodies[0].x[0], 0, 1e-8);
}

TEST(WallMotion, ADrumThatStartsDragsADiskWithFriction) {
  // The same disk at rest: it slides, so friction mu m g turns it counter-clockwise and pushes it
  // along the surface, +x at the bottom. After 10 ms: v = mu g t less what the rise of the arc
  // takes, (g/l) mu g t³/6 with l = 0.9 m; spin = mu g t m a / I = 2 mu g t / a; and the drum has
  // done the work mu m g Omega R t.
  const double mu = 0.1, t = 0.01;
  const State<2> end = solved_run(drum_scene(1, mu), 10);
  EXPECT_NEAR(end.bodies[0].v[0], mu * kGravity * t * (1 - kGravity / 0.9 * t * t / 6), 1e-7);
  EXPECT_NEAR(end.bodies[0].spin, 2 * mu * kGravity * t / 0.1, 1e-5);
  EXPECT_NEAR(end.wall_work, mu * 2 * kGravity * 1 * t, 1e-6);
}

TEST(WallMotion, ADiskSwingsInAHollowCircleAsAPendulum) {
  // No friction: a pendulum of length R - a = 0.9 m. From 0.1 rad at rest it passes the bottom
  // after a quarter of the period 2 pi sqrt(l/g) (1 + angle²/16).
  Scene<2> scene = drum_scene(0, 0);
  scene.step = 1e-4;
  scene.bodies[0].x = 0.9 * Vec2(std::sin(0.1), -std::cos(0.1));
  const double quarter = 0.5 * std::numbers::pi * std::sqrt(0.9 / kGravity) * (1 + 0.1 * 0.1 / 16);
  double passed = 0;
  solved_run(scene, 6000, [&](const State<2>& state, const StepReport<2>&) {
    if (passed == 0 && state.bodies[0].x[0] <= 0) passed = state.time;
  });
  EXPECT_NEAR(passed / quarter, 1, 2e-3);
}

TEST(WallMotion, ADiskLiesOnASolidCircleAndRollsOff) {
  // On the very top it stays; the circle carries its weight.
  Scene<2> scene = pulled_scene(0.5);
  scene.walls = {{.shape = Wall<2>::Shape::kSolidCircle, .radius = 1}};
  scene.bodies = {round_body<2>(Vec2(0, 1.1), 0.1, 2)};
  const State<2> end = solved_run(scene, 50);
  EXPECT_NEAR(end.bodies[0].x[1], 1.1, 1e-9);
  EXPECT_NEAR(end.contacts.at(0).s_n / scene.step, 2 * kGravity, 1e-6);
  EXPECT_EQ(end.contacts[0].contact.n, Vec2(0, 1));
}

TEST(WallMotion, AWallThatIsRemovedLetsTheDiskFall) {
  // The floor goes at 10 ms: from then on free fall. Steps 1 to 10 have their middles before.
  Scene<2> scene = on_floor(pulled_scene(0.5), 0.1, 2);
  scene.walls[0].removed = 0.01;
  const State<2> end = solved_run(scene, 30, [](const State<2>& state, const StepReport<2>& r) {
    EXPECT_LT(std::abs(r.energy.imbalance), 1e-13);
    EXPECT_EQ(r.contacts, r.step <= 10 ? 1 : 0);
    EXPECT_EQ(state.walls[0].present, r.step <= 10);
  });
  EXPECT_NEAR(end.bodies[0].v[1], -kGravity * 0.02, 1e-12);
  EXPECT_NEAR(end.bodies[0].x[1], 0.1 - 0.5 * kGravity * 0.02 * 0.02, 1e-9);
}

TEST(WallMotion, AWallStartsAndStops) {
  // A floor that lifts a disk with 0.5 m/s from 5 ms to 15 ms: 10 steps of it. When it stops, the
  // disk flies on.
  Scene<2> scene = on_floor(rough_scene(0), 0.1, 2);
  move_at(scene.walls[0], Vec2(0, 0.5));
  scene.walls[0].starts = 0.005;
  scene.walls[0].stops = 0.015;
  const State<2> end = solved_run(scene, 25, [](const State<2>& state, const StepReport<2>& r) {
    const bool moves = r.step > 5 && r.step <= 15;
    EXPECT_EQ(state.walls[0].v[1], moves ? 0.5 : 0.0) << r.step;
    EXPECT_LT(std::abs(r.energy.imbalance), 1e-14);
  });
  EXPECT_NEAR(end.walls[0].a[1], 0.005, 1e-15);
  EXPECT_NEAR(end.bodies[0].v[1], 0.5, 1e-10);
  EXPECT_NEAR(end.bodies[0].x[1], 0.1 + 0.5 * 0.02 - 0.5 * 0.5 * 1e-3, 1e-9);  // first step: half
}

TEST(WallMotion, ADrivenWallThatStopsGivesItsEnergyToWhatStopsIt) {
  // 8 N on 4 kg for 10 ms: 0.02 m/s. What stops it takes 1/2 4 0.02² J and 0.08 N s.
  Scene<2> scene = rough_scene(0);
  scene.walls = {pressed_plate(10, 8, 0)};
  scene.walls[0].stops = 0.01;
  const State<2> end = solved_run(scene, 12, [](const State<2>&, const StepReport<2>& r) {
    EXPECT_LT(std::abs(r.energy.imbalance), 1e-16);
    EXPECT_LT(r.momentum_imbalance.norm(), 1e-16);
    EXPECT_NEAR(r.momentum[1], r.step <= 10 ? -8e-3 * r.step : 0, 1e-15);
  });
  EXPECT_NEAR(end.wall_work, 0, 1e-16);
  EXPECT_NEAR(end.walls[0].a[1], 10 - 0.5 * 2 * 0.01 * 0.01, 1e-14);
}

TEST(WallMotion, TiltedDiskSlidesWhenTheSlopeExceedsFriction) {
  // Without rotation (friction blocks none here: a disk rolls at once), so the angle is seen in the
  // acceleration: a disk rolls down with 2/3 g sin(angle), angle = rate (t - starts), hence
  // v = 2/3 g (1 - cos(rate (t - starts)))/rate.
  const double rate = 0.5;
  Scene<2> scene = on_floor(pulled_scene(1), 0.1, 2);
  scene.tilt = {.rate = rate, .starts = 0.05};
  const State<2> end = closed_run(scene, 250, 1e-13, 1e-13);
  // Turned counter-clockwise, gravity (0, -g) gains a part along +x.
  const double speed = 2.0 / 3 * kGravity * (1 - std::cos(rate * 0.2)) / rate;
  EXPECT_NEAR(end.bodies[0].v[0] / speed, 1, 1e-6);
  // The energy of a body in turned gravity, from nothing but the work of turning and of rolling:
  // kinetic + potential = initial potential + work.
  const double angle = rate * 0.2;
  const Vec2 g = kGravity * Vec2(std::sin(angle), -std::cos(angle));
  const double potential = -2 * g.dot(end.bodies[0].x);
  EXPECT_NEAR(0.75 * 2 * speed * speed + potential, 2 * kGravity * 0.1 + end.wall_work, 1e-5);
}

TEST(WallMotion, GravityStopsTurning) {
  Scene<2> scene = one_law<2>({});
  scene.gravity = Vec2(0, -2);
  scene.tilt = {.rate = std::numbers::pi, .starts = 1, .stops = 1.5};
  EXPECT_EQ(gravity_at(scene, 0.5), Vec2(0, -2));
  EXPECT_NEAR((gravity_at(scene, 1.25) - Vec2(std::sqrt(2), -std::sqrt(2))).norm(), 0, 1e-15);
  EXPECT_NEAR((gravity_at(scene, 9) - Vec2(2, 0)).norm(), 0, 1e-15);
}

// The same scenes with springs. Their books close to the order of the substeps, not to round-off.
TEST(WallMotion, SpringsKnowPlatesDrumsAndTilts) {
  Scene<2> plate = on_floor(rough_scene(0.4), 0.1, 2);
  plate.walls.push_back(pressed_plate(0.2, 50, 0.3));
  Scene<2> drum = drum_scene(0.2, 0.5);
  drum.tilt = {.rate = 0.1, .starts = 0.05};
  drum.bodies[0].spin = 2;
  for (Scene<2>* scene : {&plate, &drum}) {
    scene->model = Model::kSpringDashpot;
    scene->dem.stiffness = 1e6;
    SpringDashpotStepper stepper(*scene);
    State<2> state = initial_state(*scene);
    for (int step = 0; step < 100; ++step) {
      const StepReport<2> r = stepper.advance(state);
      EXPECT_LT(std::abs(r.energy.imbalance), 1e-7);  // of 0.03 J
      EXPECT_LT(r.momentum_imbalance.norm(), 1e-11);
    }
    if (scene == &plate) {
      EXPECT_NEAR(state.bodies[0].v[0], 0.15, 1e-3);
      EXPECT_NEAR(state.bodies[0].spin, -1.5, 1e-2);
    } else {
      EXPECT_NEAR(state.bodies[0].spin, 2, 0.1);
    }
  }
  plate.walls[0].removed = 1;
  EXPECT_THROW(SpringDashpotStepper{plate}, std::invalid_argument);
}

TEST(WallMotion, AreaOfADrumIsTheSamplesArea) {
  Scene<2> scene = drum_scene(0, 0);
  scene.bodies = {round_body<2>(Vec2(0, 0.5), 0.1, 2), round_body<2>(Vec2(0, -0.5), 0.1, 2)};
  scene.walls.push_back({.shape = Wall<2>::Shape::kSolidCircle, .radius = 0.2});
  EXPECT_NEAR(sample_measure(initial_state(scene), scene.step), std::numbers::pi * (1 - 0.04),
              1e-14);
}

// A disk put on a belt with V = 1 m/s and mu 0.2. Friction mu m g gives v = mu g t and, with the
// inertia m a²/2, a spin of 2 mu g t / a. It rolls from v + a spin = V on: v = V/3, spin 2 V/(3 a),
// after V/(3 mu g) = 0.1699 s and 0.0283 m. At 5 s it is at 0.3 + 0.0283 + (5 - 0.1699)/3 m.
TEST(WallMotion, ABeltCarriesADiskAndStays) {
  Scene<2> scene = pulled_scene(0.2);
  scene.bodies = {round_body<2>(Vec2(0.3, 0.1), 0.1, 1)};
  scene.walls = {{.shape = Wall<2>::Shape::kSegment, .b = Vec2(2, 0), .belt = Vec2(1, 0)}};
  const State<2> end = closed_run(scene, 5000, 1e-9, 1e-12);
  EXPECT_NEAR(end.bodies[0].v[0], 1.0 / 3, 1e-8);
  EXPECT_NEAR(end.bodies[0].spin, 20.0 / 3, 1e-7);
  EXPECT_NEAR(end.bodies[0].x[0], 1.9384, 1e-3);
  EXPECT_EQ(end.walls[0].b, Vec2(2, 0));
}

// At an end the surface turns with the normal: it never moves towards the disk.
TEST(WallMotion, ABeltTurnsAtItsEnds) {
  Wall<2> belt{.shape = Wall<2>::Shape::kSegment, .b = Vec2(2, 0), .belt = Vec2(1, 0)};
  const Vec2 n = Vec2(1, 1).normalized();
  const Vec2 v = surface_velocity<2>(belt, Vec2::Zero(), n);
  EXPECT_NEAR(v.dot(n), 0, 1e-15);
  EXPECT_NEAR(v[0], 0.5, 1e-15);
  EXPECT_EQ(surface_velocity<2>(belt, Vec2(0, 3), Vec2(0, 1)), Vec2(1, 3));
}

}  // namespace
}  // namespace bipot
