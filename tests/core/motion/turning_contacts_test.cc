// Contacts that turn while bodies slide or roll on each other: of the second order in the time step
// where a scene has an accuracy. Steps of equal size, without its controller.

#include "tests/support/pendulum_angle.h"
#include "tests/support/scene_run.h"
#include "tests/support/small_scenes.h"

namespace bipot {
namespace {

constexpr double kRadius = 0.01, kBowl = 0.1, kLength = kBowl - kRadius;

struct Ended {
  double error = 0;   // of the place                                     [radii]
  double energy = 0;  // largest energy above that of the start               [J]
};

/// Runs for a time in equal steps; `place`: of the body at the end.
template <int D>
Ended run(Scene<D> scene, double time, int steps, const Vec<D>& place) {
  scene.accuracy = 0.1;
  scene.step = time / steps;
  scene.contact_distance = 1e-4 * kRadius;
  State<D> state = initial_state(scene);
  TimeStepper<D> stepper = stepper_of(scene, "auto", {.tol = 1e-12});
  Ended ended;
  double start = 0;
  for (int k = 0; k < steps; ++k) {
    const StepReport<D> report = stepper.advance(state);
    EXPECT_TRUE(report.converged) << report.message;
    EXPECT_NEAR(report.energy.imbalance, 0, 1e-12);
    const double energy = report.energy.kinetic + report.energy.potential;
    if (k == 0) start = energy;
    ended.energy = std::max(ended.energy, energy - start);
  }
  ended.error = (state.bodies[0].x - place).norm() / kRadius;
  return ended;
}

/// Half a step has a quarter of the error. `most`: error of the shorter steps. Where no wall moves,
/// energy is not created, but for that order.
template <int D>
void expect_second_order(const Scene<D>& scene, double time, int steps, const Vec<D>& place,
                         double most) {
  const Ended one = run<D>(scene, time, steps, place), two = run<D>(scene, time, 2 * steps, place);
  EXPECT_LT(two.error, most);
  EXPECT_GT(one.error, 3.4 * two.error);
  const bool fixed = scene.walls[0].motion == Wall<D>::Motion::kFixed;
  EXPECT_LT(two.energy, fixed ? 1e-5 : kInfinity);
}

/// A disk in a bowl, at an angle to its lowest point.
Scene<2> in_a_bowl(double mu, double angle) {
  Scene<2> scene = heavy_scene({.mu = mu});
  scene.walls = {{.shape = Wall<2>::Shape::kHollowCircle, .radius = kBowl}};
  scene.bodies = {round_body<2>(kLength * Vec2(std::sin(angle), -std::cos(angle)), kRadius, 1)};
  return scene;
}

TEST(TurningContacts, ADiskSlidesAndRollsInABowl) {
  // Rolling adds half of the mass to the inertia of a pendulum.
  const double start = std::numbers::pi / 3;
  for (const double mu : {0.0, 5.0}) {
    const double inertia = mu == 0 ? 1 : 1.5;
    const double angle = pendulum_angle(
        start, 1, [&](double a, double) { return -kGravity / (inertia * kLength) * std::sin(a); });
    const Vec2 place = kLength * Vec2(std::sin(angle), -std::cos(angle));
    expect_second_order<2>(in_a_bowl(mu, start), 1, 400, place, mu == 0 ? 2e-3 : 4e-3);
  }
}

TEST(TurningContacts, ADiskRollsDownAHill) {
  // On a solid circle the gap opens as the normal turns. It rolls until it flies off, later.
  const double length = kBowl + kRadius, start = 0.3;
  Scene<2> scene = in_a_bowl(5, 0);
  scene.walls[0].shape = Wall<2>::Shape::kSolidCircle;
  scene.bodies[0].x = length * Vec2(std::sin(start), std::cos(start));
  const double angle = pendulum_angle(
      start, 0.12, [&](double a, double) { return kGravity / (1.5 * length) * std::sin(a); });
  expect_second_order<2>(scene, 0.12, 100, length * Vec2(std::sin(angle), std::cos(angle)), 2e-5);
}

TEST(TurningContacts, ASphereRollsRoundAnUprightPipe) {
  // Rolling in a pipe with its axis along gravity. The moments about the point of contact of a ball
  // of inertia 2/5 m a² give, with the spin w_r along the normal and the rate W of the way round,
  //   W' = 0,   a w_r' = W z',   7/5 z'' = -g - 2/5 a W w_r.
  // So z'' + 2/7 W² z is constant: the ball comes up again, z = -5 g/(2 W²) (1 - cos √(2/7) W t).
  const double rate = 40, time = 0.2;
  Scene<3> scene = heavy_scene<3>({.mu = 50});
  scene.walls = {{.shape = Wall<3>::Shape::kHollowCircle, .radius = kBowl}};
  scene.bodies = {round_body<3>(Vec3(kLength, 0, 0), kRadius, 1, Vec3(0, rate * kLength, 0))};
  scene.bodies[0].spin = Vec3(0, 0, -rate * kLength / kRadius);
  const double z =
      -2.5 * kGravity / (rate * rate) * (1 - std::cos(std::sqrt(2.0 / 7) * rate * time));
  const Vec3 place(kLength * std::cos(rate * time), kLength * std::sin(rate * time), z);
  expect_second_order<3>(scene, time, 400, place, 2e-2);
}

TEST(TurningContacts, ARodSlidesOnItsEnd) {
  // Two joined disks; the first touches a floor without friction. About the centre of mass, at the
  // distance c of both: (I + m c² cos² a) a'' = -m g c cos a + m c² sin a cos a a'².
  const double c = 0.05, inertia = 2e-3, mass = 1, start = 1.2, time = 0.1;
  Scene<2> scene = heavy_scene({});
  scene.walls = {flat_floor<2>()};
  const Vec2 arm = c * Vec2(std::cos(start), std::sin(start)), centre(0, kRadius + arm[1]);
  scene.bodies = {round_body<2>(centre - arm, kRadius, 1), round_body<2>(centre + arm, kRadius, 1)};
  scene.clusters.bodies = {{.x = centre, .mass = mass, .inertia = inertia, .size = 1}};
  scene.clusters.arms = {-arm, arm};
  for (Body<2>& d : scene.bodies) {
    d.mass = d.inertia = 0;
    d.cluster = 0;
  }
  const double angle = pendulum_angle(start, time, [&](double a, double w) {
    return c * mass * std::cos(a) * (c * std::sin(a) * w * w - kGravity) /
           (inertia + mass * c * c * std::cos(a) * std::cos(a));
  });
  expect_second_order<2>(scene, time, 50, Vec2(-c * std::cos(angle), kRadius), 1e-3);
}

/// A plate with the velocity (v, w) sin 2 pi f t carries a body. It never pulls: 2 pi f w < g.
template <int D>
Scene<D> on_a_shaken_plate(double inertia) {
  Scene<D> scene = on_floor(heavy_scene<D>({.mu = 5}), kRadius, 1);
  move_at(scene.walls[0], 0.3 * Vec<D>::Unit(0) + 0.2 * Vec<D>::Unit(D - 1));
  scene.walls[0].time_factor.frequency = 3;
  scene.bodies[0].inertia = inertia * kRadius * kRadius;
  return scene;
}

TEST(TurningContacts, AShakenPlateCarriesABodyThatRolls) {
  // A body of the inertia k m a² rolls with k/(1 + k) of the plate's acceleration.
  const double time = 0.25, turn = 6 * std::numbers::pi;
  const double way = (1 - std::cos(turn * time)) / turn;
  expect_second_order<2>(on_a_shaken_plate<2>(0.5), time, 100,
                         Vec2(0.3 / 3 * way, 0.2 * way + kRadius), 2e-3);
  expect_second_order<3>(on_a_shaken_plate<3>(0.4), time, 100,
                         Vec3(0.3 * 2 / 7 * way, 0, 0.2 * way + kRadius), 2e-3);
}

}  // namespace
}  // namespace bipot
