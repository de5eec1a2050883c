// [time] accuracy: parts of steps that end on impacts. Errors of places are given in radii.

#include "solvers/simulation/accurate_step.h"

#include "solvers/simulation/scene_stepper.h"
#include "tests/support/pendulum_angle.h"
#include "tests/support/scene_run.h"
#include "tests/support/small_scenes.h"

namespace bipot {
namespace {

constexpr double kRadius = 0.01;

template <int D>
Scene<D> with_accuracy(Scene<D> scene, double x, double step, int steps) {
  scene.accuracy = x;
  scene.step = step;
  scene.num_steps = steps;
  scene.solver.tol = 1e-12;
  scene.contact_distance = std::min(1e-6, 0.01 * x) * smallest_radius(scene);
  return scene;
}

template <int D>
struct Ended {
  State<D> state;
  SceneTotals<D> totals;
};

template <int D>
Ended<D> run(const Scene<D>& scene) {
  EXPECT_EQ(validate(scene), "");
  State<D> state = initial_state(scene);
  const SceneRun<D> done = run_scene(scene, state);
  if (done.failure) throw *done.failure;
  EXPECT_EQ(done.totals.converged, done.totals.steps) << done.totals.message;
  EXPECT_LE(done.totals.cut.misplaced, 1.5 * scene.accuracy);
  return {state, done.totals};
}

/// A disk or sphere 0.1 m above a floor.
template <int D>
Scene<D> ball(double e) {
  Scene<D> scene = heavy_scene<D>({.e_n = e});
  scene.walls = {flat_floor<D>()};
  scene.bodies = {round_body<D>(Vec<D>(0.11 * Vec<D>::Unit(D - 1)), kRadius, 1)};
  return scene;
}

/// Its height at a time.
double height(double e, double time) {
  const double fall = std::sqrt(2 * 0.1 / 9.81);
  if (time <= fall) return 0.11 - 0.5 * 9.81 * time * time;
  double speed = 9.81 * fall, left = time - fall;
  for (;;) {
    speed *= e;
    const double flight = 2 * speed / 9.81;
    if (left <= flight || flight < 1e-12) return kRadius + speed * left - 0.5 * 9.81 * left * left;
    left -= flight;
  }
}

/// A disk to the right of a wall at x = 0.
Scene<2> beside_wall(double e, double x, double mass = 1, const Vec2& v = Vec2::Zero()) {
  Scene<2> scene = one_law<2>({.e_n = e});
  scene.walls = {half_space<2>(Vec2::Zero(), Vec2(1, 0))};
  scene.bodies = {round_body<2>(Vec2(x, 0), kRadius, mass, v)};
  return scene;
}

/// A disk at this height over a plate that swings at speed sin(turn t).
Scene<2> over_plate(double e, double y, double speed, double turn) {
  Scene<2> scene = heavy_scene({.e_n = e});
  scene.walls = {flat_floor<2>()};
  move_at(scene.walls[0], Vec2(0, speed));
  scene.walls[0].time_factor.frequency = turn / (2 * std::numbers::pi);
  scene.bodies = {round_body<2>(Vec2(0, y), kRadius, 2)};
  return scene;
}

// Two disks that turn about each other at 5 rad/s are held by cohesion, m w² a = 0.25 N, through two
// turns, with the moment of momentum that they had. A third one that hangs stays where it is.
TEST(AccurateStep, CohesionHoldsWhatTurnsAndHangs) {
  Scene<2> scene = one_law<2>({.mu = 0.3, .cohesion = 20});
  scene.cohesion_range = 4e-4;
  scene.walls = {half_space<2>(Vec2(0, 1), Vec2(0, -1))};
  scene.bodies = {round_body<2>(Vec2(-kRadius, 0), kRadius, 1, Vec2(0, -0.05), 5),
                  round_body<2>(Vec2(kRadius, 0), kRadius, 1, Vec2(0, 0.05), 5)};
  for (const double pull : {0.0, -9.81}) {
    scene.gravity = Vec2(0, pull);
    if (pull != 0) scene.bodies = {round_body<2>(Vec2(0, 1 - kRadius), kRadius, 1)};
    const Scene<2> cut = with_accuracy(scene, 0.01, 0.05, 50);
    const double turning = angular_momentum(initial_state(cut));
    const State<2> end = run(cut).state;
    ASSERT_EQ(end.contacts.size(), 1u);
    EXPECT_LT(end.contacts[0].contact.gap, 2 * 0.01 * kRadius);
    EXPECT_LT(end.contacts[0].s_n, 0);
    if (pull == 0) {
      EXPECT_NEAR(angular_momentum(end), turning, 1e-3 * turning);
    } else {
      EXPECT_NEAR(end.bodies[0].x[1], 1 - kRadius, 1e-9);
    }
  }
}

// A wall rises by 10 mm within 2 ms and goes back, all within a step. In its middle, at 5 mm and at
// 10 m/s, it strikes a disk at rest: twice its speed.
TEST(AccurateStep, SeesAWallThatMovesForAMomentOnly) {
  Scene<2> scene = one_law<2>({.e_n = 1});
  scene.walls = {flat_floor<2>()};
  move_at(scene.walls[0], Vec2(0, 10));
  scene.walls[0].time_factor = {.times = {0.151, 0.152, 0.153, 0.154, 0.155},
                                .factors = {0, 1, 0, -1, 0}};
  scene.bodies = {round_body<2>(Vec2(0, 0.005 + kRadius), kRadius, 2)};
  // Misplaced by 1e-5 m, it meets a speed that is off by 1e4 m/s² × 1e-6 s.
  const Ended<2> end = run(with_accuracy(scene, 1e-3, 0.1, 4));
  EXPECT_NEAR(end.state.bodies[0].v[1], 20, 0.1);
}

// A disk sticks on a wall that swings along itself, or on a belt: the same motion.
TEST(AccurateStep, ABeltCarriesAsAMovedWallDoes) {
  double x[2];
  for (const bool belt : {false, true}) {
    Scene<2> scene = heavy_scene({.mu = 5});
    scene.walls = {flat_floor<2>()};
    Wall<2>& wall = scene.walls[0];
    if (belt) {
      wall.belt = Vec2(1, 0);
    } else {
      move_at(wall, Vec2(1, 0));
    }
    wall.time_factor.frequency = 1;
    scene.bodies = {round_body<2>(Vec2(0, kRadius), kRadius, 2)};
    x[belt ? 1 : 0] = run(with_accuracy(scene, 1e-2, 0.1, 5)).state.bodies[0].x[0];
  }
  EXPECT_GT(x[0], kRadius);
  EXPECT_NEAR(x[0], x[1], 1e-3 * kRadius);
}

TEST(AccurateStep, AnImpactIsMisplacedByItsPlaceInAStepOfFixedSize) {
  // It is noticed at the next mid-step: late by (1/2 - t) h, or by (3/2 - t) h. In the meantime the
  // body goes on with w instead of -e w.
  const double h = 0.01, w = 1, e = 0.5;
  for (const double t : {0.1, 0.3, 0.5, 0.7, 0.9}) {
    Scene<2> scene = beside_wall(e, kRadius + w * t * h, 1, Vec2(-w, 0));
    scene.step = h;
    scene.contact_distance = 1e-12;
    State<2> state = initial_state(scene);
    SceneStepper<2> stepper(scene);
    stepper.advance(state);
    stepper.advance(state);
    const double exact = kRadius + e * w * (2 - t) * h;
    const double late = t <= 0.5 ? 0.5 - t : 1.5 - t;
    EXPECT_NEAR(state.bodies[0].x[0] - exact, -(1 + e) * w * h * late, 1e-11) << t;
  }
}

TEST(AccurateStep, AWallMeetsADiskInTheMiddleOfAPart) {
  // After 0.2 s; the disk leaves at (1 + e) 0.5 m/s. Parts are placed a hundredth late, so that
  // rounding finds the pair in touch: x r / 100.
  std::vector<int> parts;
  for (const double x : {1e-1, 1e-2, 1e-3}) {
    Scene<2> scene = beside_wall(0.8, 0.11);
    move_at(scene.walls[0], Vec2(0.5, 0));
    const Ended<2> end = run(with_accuracy(scene, x, 0.3, 1));
    EXPECT_NEAR(end.state.bodies[0].v[0], 0.9, 1e-12);
    EXPECT_NEAR(end.state.bodies[0].x[0], 0.2 - 0.01 * x * kRadius, 1e-9 * x);
    EXPECT_EQ(end.totals.cut.rejected(), 0);
    parts.push_back(end.totals.cut.parts);
  }
  EXPECT_EQ(parts, std::vector<int>(3, parts[0]));
  EXPECT_LE(parts[0], 9);
}

TEST(AccurateStep, ABallBouncesWithAnErrorProportionalToTheAccuracy) {
  // Without restitution it ends as deep as its part was late.
  for (const double x : {1e-1, 1e-2, 1e-3}) {
    const Ended<2> end = run(with_accuracy(ball<2>(0), x, 0.05, 13));
    EXPECT_NEAR((kRadius - end.state.bodies[0].x[1]) / kRadius, 0.01 * x, 4e-4 * x) << x;
  }
  std::vector<double> errors;
  std::vector<int> parts;
  for (const double x : {1e-1, 1e-2, 1e-3, 1e-4}) {
    const Ended<2> end = run(with_accuracy(ball<2>(0.9), x, 0.065, 10));
    errors.push_back(std::abs(end.state.bodies[0].x[1] - height(0.9, 0.65)) / (kRadius * x));
    parts.push_back(end.totals.cut.parts);
    EXPECT_NEAR(end.totals.last.energy.imbalance, 0, 1e-14);
    EXPECT_EQ(end.totals.cut.rejected(), 0);
  }
  // Each of the three impacts is late by 0.01 x r, which is time for the next flights. No step ends
  // beside an impact: that would cut its part.
  for (const double error : errors) EXPECT_NEAR(error, 0.103, 0.002);
  EXPECT_EQ(parts, std::vector<int>(4, parts[0]));
}

TEST(AccurateStep, InSpaceItIsTheSameBall) {
  const Ended<2> flat = run(with_accuracy(ball<2>(0.9), 1e-3, 0.05, 13));
  const Ended<3> space = run(with_accuracy(ball<3>(0.9), 1e-3, 0.05, 13));
  EXPECT_NEAR(space.state.bodies[0].x[2], flat.state.bodies[0].x[1], 1e-12);
  EXPECT_EQ(space.totals.cut.parts, flat.totals.cut.parts);
}

TEST(AccurateStep, BouncesThatSinkBelowTheAccuracyEnd) {
  // The sum of all flights of e = 1/2 is 0.143 (1 + 2) = 0.43 s.
  for (const double x : {1e-2, 1e-4}) {
    const Ended<2> end = run(with_accuracy(ball<2>(0.5), x, 0.05, 13));
    EXPECT_NEAR(end.state.bodies[0].x[1], kRadius, x * kRadius);
    EXPECT_NEAR(end.state.bodies[0].v[1], 0, 1e-6);
    EXPECT_LE(end.totals.cut.parts, 80 + 3 * 13);
  }
}

/// Six disks on a line between two walls, without gravity.
Scene<2> chain() {
  Scene<2> scene = one_law<2>({.e_n = 0.8});
  const double gaps[] = {0.006, 0.009, 0.02, 0.015, 0.006, 0.013, 0.01};
  const double speeds[] = {2, -0.6, 0.1, -0.75, 0.35, 0.84},
               masses[] = {1, 0.7, 1.9, 0.6, 1.2, 1.6};
  double x = 0;
  for (std::size_t k = 0; k < 6; ++k) {
    x += gaps[k] + kRadius;
    scene.bodies.push_back(round_body<2>(Vec2(x, 0), kRadius, masses[k], Vec2(speeds[k], 0)));
    x += kRadius;
  }
  scene.walls = {half_space<2>(Vec2::Zero(), Vec2(1, 0)),
                 half_space<2>(Vec2(x + gaps[6], 0), Vec2(-1, 0))};
  return scene;
}

/// The places of its disks, from collision to collision.
std::vector<double> places(const Scene<2>& scene, double time, int& collisions) {
  std::vector<double> x, v, m;
  for (const Body<2>& d : scene.bodies) {
    x.push_back(d.x[0]);
    v.push_back(d.v[0]);
    m.push_back(d.mass);
  }
  const std::size_t n = x.size();
  const double e = scene.laws[0].e_n, end = scene.walls[1].a[0];
  for (collisions = 0;; ++collisions) {
    double next = time;
    std::size_t which = n + 1;
    for (std::size_t c = 0; c <= n; ++c) {
      const double gap = c == 0   ? x[0] - kRadius
                         : c == n ? end - x[n - 1] - kRadius
                                  : x[c] - x[c - 1] - 2 * kRadius;
      const double w = c == 0 ? -v[0] : c == n ? v[n - 1] : v[c - 1] - v[c];
      if (w > 1e-14 && gap / w < next) {
        next = gap / w;
        which = c;
      }
    }
    for (std::size_t k = 0; k < n; ++k) x[k] += v[k] * next;
    time -= next;
    if (which > n) return x;
    if (which == 0 || which == n) {
      v[which == 0 ? 0 : n - 1] *= -e;
      continue;
    }
    const double push = (1 + e) * (v[which - 1] - v[which]) / (1 / m[which - 1] + 1 / m[which]);
    v[which - 1] -= push / m[which - 1];
    v[which] += push / m[which];
  }
}

TEST(AccurateStep, AChainOfCollisionsIsFollowed) {
  int collisions = 0;
  const std::vector<double> exact = places(chain(), 0.2, collisions);
  EXPECT_GE(collisions, 15);
  for (const double x : {1e-2, 1e-3, 1e-4}) {
    const Ended<2> end = run(with_accuracy(chain(), x, 0.1, 2));
    double error = 0;
    for (std::size_t k = 0; k < exact.size(); ++k) {
      error = std::max(error, std::abs(end.state.bodies[k].x[0] - exact[k]) / kRadius);
    }
    EXPECT_LT(error, 0.05 * x);
    EXPECT_EQ(end.totals.cut.rejected(), 0);
    EXPECT_LE(end.totals.cut.parts, 3 * collisions + 6);
  }
}

TEST(AccurateStep, ABlowThrowsBackWhatHasJustBounced) {
  // The second disk meets the first one 0.24 µs after its bounce. With x r / ((1 + e) 1 m/s) =
  // 0.6 µs both fall into one part: the pair with the wall pushes, and approaches again.
  Scene<2> scene = one_law<2>({.e_n = 0.7});
  scene.bodies = {round_body<2>(Vec2(kRadius + 1e-3, 0), kRadius, 1, Vec2(-1, 0)),
                  round_body<2>(Vec2(3 * kRadius + 5e-3 + 1.36e-6, 0), kRadius, 1, Vec2(-5, 0))};
  scene.walls = {half_space<2>(Vec2::Zero(), Vec2(1, 0)), half_space<2>(Vec2(0.2, 0), Vec2(-1, 0))};
  EXPECT_EQ(run(with_accuracy(scene, 1e-4, 0.01, 2)).totals.cut.rejected(), 0);
  int collisions = 0;
  const std::vector<double> exact = places(scene, 0.02, collisions);
  const Ended<2> end = run(with_accuracy(scene, 1e-5, 0.01, 2));
  for (std::size_t k = 0; k < exact.size(); ++k) {
    EXPECT_NEAR(end.state.bodies[k].x[0], exact[k], 1e-5 * kRadius);
  }
}

TEST(AccurateStep, RollingDownASlopeIsExactAndPartsGrow) {
  const double angle = 20 * std::numbers::pi / 180, time = 0.5;
  for (const double x : {1e-1, 1e-4}) {
    Scene<2> scene = one_law<2>({.mu = 0.5});
    scene.gravity = 9.81 * Vec2(std::sin(angle), -std::cos(angle));
    scene.walls = {flat_floor<2>()};
    scene.bodies = {round_body<2>(Vec2(0, kRadius), kRadius, 1)};
    const Ended<2> end = run(with_accuracy(scene, x, time, 1));
    // A cylinder rolls with 2/3 of the acceleration.
    EXPECT_NEAR(end.state.bodies[0].x[0], 9.81 * std::sin(angle) * time * time / 3, 1e-12);
    EXPECT_EQ(end.totals.cut.parts, 4);  // 0.1 twice, for new contacts; 0.3; the rest
  }
}

TEST(AccurateStep, ASlidingCylinderStartsToRollWithTheErrorOfOnePart) {
  const double mu = 0.5, step = 5e-3, time = 0.1, stop = 1 / (3 * mu * 9.81);
  const double exact =
      stop - 0.5 * mu * 9.81 * stop * stop + (1 - mu * 9.81 * stop) * (time - stop);
  Scene<2> scene = heavy_scene({.mu = mu});
  scene.walls = {flat_floor<2>()};
  scene.bodies = {round_body<2>(Vec2(0, kRadius), kRadius, 1, Vec2(1, 0))};
  const Ended<2> end = run(with_accuracy(scene, 1e-3, step, 20));
  // The switch at t h of a step costs mu g h² t (1 - t) / 2.
  EXPECT_NEAR(end.state.bodies[0].x[0], exact, mu * 9.81 * step * step / 8);
}

TEST(AccurateStep, MotionAfterAnImpactIsJudgedFromThereOn) {
  // A disk falls 1 m at 2 m/s, lands, slides and rolls. The impact takes J = mu g t1 from v and
  // leaves a slip of 2 - 3 J. Friction ends it after (2 - 3 J)/(3 mu g).
  const double mu = 0.1, g = 9.81, fall = std::sqrt(2 / g), impulse = mu * g * fall;
  const double v = 2 - impulse, slides = (2 - 3 * impulse) / (3 * mu * g);
  const double exact = 2 * fall + v * slides - 0.5 * mu * g * slides * slides +
                       (v - mu * g * slides) * (2 - fall - slides);
  for (const int steps : {1, 4}) {
    for (const double x : {1e-2, 1e-3, 1e-4}) {
      Scene<2> scene = heavy_scene({.mu = mu});
      scene.walls = {flat_floor<2>()};
      scene.bodies = {round_body<2>(Vec2(0, 1.1), 0.1, 1, Vec2(2, 0))};
      const Ended<2> end = run(with_accuracy(scene, x, 2.0 / steps, steps));
      EXPECT_NEAR(end.state.bodies[0].x[0], exact, x * (exact + 0.1)) << steps << " steps, " << x;
      EXPECT_GT(end.totals.cut.accelerating, 0);
    }
  }
}

TEST(AccurateStep, SlidingInABowlIsOfTheSecondOrder) {
  const double length = 0.09, start = std::numbers::pi / 3;
  Scene<2> scene = heavy_scene({});
  scene.walls = {{.shape = Wall<2>::Shape::kHollowCircle, .radius = 0.1}};
  scene.bodies = {round_body<2>(length * Vec2(std::sin(start), -std::cos(start)), kRadius, 1)};
  const double angle =
      pendulum_angle(start, 1, [&](double a, double) { return -9.81 / length * std::sin(a); });
  const Vec2 exact = length * Vec2(std::sin(angle), -std::cos(angle));
  std::vector<double> errors;
  std::vector<int> parts;
  for (const double x : {1e-2, 1e-3, 1e-4}) {
    const Ended<2> end = run(with_accuracy(scene, x, 0.05, 20));
    errors.push_back((end.state.bodies[0].x - exact).norm() / kRadius / x);
    parts.push_back(end.totals.cut.parts);
  }
  // The error is proportional to x, the number of parts to 1/√x.
  for (const double error : errors) EXPECT_NEAR(error / errors[0], 1, 0.5);
  EXPECT_NEAR(static_cast<double>(parts[2]) / parts[1], std::sqrt(10.0), 0.3);
}

TEST(AccurateStep, ADrivenWallIsFollowedWithItsAcceleration) {
  // 2 kg, 4 N: 0.04 m in 0.2 s, then at 0.4 m/s on a disk of 2 kg at rest: together at 0.2 m/s with
  // 1 m/s².
  Scene<2> scene = beside_wall(0, 0.04 + kRadius, 2);
  drive(scene.walls[0], Vec2(1, 0), 2, 4);
  for (const double x : {1e-1, 1e-3}) {
    const Ended<2> end = run(with_accuracy(scene, x, 0.3, 1));
    EXPECT_NEAR(end.state.bodies[0].x[0], 0.05 + 0.02 + 0.005, 0.1 * x * kRadius);
    EXPECT_NEAR(end.state.bodies[0].v[0], 0.3, 1e-2 * x);
    EXPECT_EQ(end.totals.cut.rejected(), 0);
  }
}

TEST(AccurateStep, AForceDrivesADiskAgainstAWall) {
  // 2 m/s² over 0.04 m: 0.4 m/s after 0.2 s, then back, slowed, to 0.4 · 0.1 - 0.01 m from the wall.
  Scene<2> scene = beside_wall(1, 0.04 + kRadius, 2);
  scene.forces = {{.first = 0, .last = 0, .force = Vec2(-4, 0)}};
  for (const double x : {1e-1, 1e-3}) {
    const Ended<2> end = run(with_accuracy(scene, x, 0.3, 1));
    EXPECT_NEAR(end.state.bodies[0].x[0], kRadius + 0.03, 0.1 * x * kRadius);
    EXPECT_NEAR(end.state.bodies[0].v[0], 0.2, 1e-2 * x);
    EXPECT_EQ(end.totals.cut.rejected(), 0);
  }
}

TEST(AccurateStep, AForceIsForeseenInTheFirstPart) {
  // 2 m/s² over 0.5 mm from rest: an impact after 0.0224 s, within the first part, of 0.03 s. The disk
  // then rests at the wall.
  Scene<2> scene = beside_wall(0, 5e-4 + kRadius, 2);
  scene.forces = {{.first = 0, .last = 0, .force = Vec2(-4, 0)}};
  const Ended<2> end = run(with_accuracy(scene, 1e-3, 0.3, 1));
  EXPECT_NEAR(end.state.bodies[0].x[0], kRadius, 1e-3 * kRadius);
  EXPECT_EQ(end.totals.cut.rejected(), 0);
}

TEST(AccurateStep, AForceThatSwingsMovesADiskAsDerived) {
  // v = F/(m w) (1 - cos w t), so that the way is F/(m w) (t - sin(w t)/w): 7 m, of which
  // the share x may be wrong. The steps of 0.1 s are a third of a period.
  constexpr double kTurn = 6 * std::numbers::pi, kForce = 300, kMass = 2;
  Scene<2> scene = one_law<2>({});
  scene.bodies = {round_body<2>(Vec2::Zero(), kRadius, kMass)};
  scene.forces = {{.first = 0, .last = 0, .force = Vec2(kForce, 0)}};
  scene.forces[0].time_factor.frequency = kTurn / (2 * std::numbers::pi);
  const double t = 0.9, way = kForce / kMass / kTurn * (t - std::sin(kTurn * t) / kTurn);
  for (const double x : {1e-3, 1e-4, 1e-5}) {
    const Ended<2> end = run(with_accuracy(scene, x, 0.1, 9));
    EXPECT_NEAR(end.state.bodies[0].x[0], way, x * way) << x;
  }
}

TEST(AccurateStep, AForceOfManyPeriodsAStepIsSeen) {
  // 100 N on 1 kg at 100 Hz, on a disk and on a wall; a tenth of the step is a period. After whole
  // periods v = 0 again, and the way is F t/(m w) = 0.0796 m.
  constexpr double kFrequency = 100, kTurn = 2 * std::numbers::pi * kFrequency;
  Scene<2> scene = one_law<2>({});
  scene.bodies = {round_body<2>(Vec2(0, 50), kRadius, 1)};
  scene.forces = {{.first = 0, .last = 0, .force = Vec2(0, 100)}};
  scene.forces[0].time_factor.frequency = kFrequency;
  scene.walls = {flat_floor<2>()};
  drive(scene.walls[0], Vec2(0, 1), 1, 100);
  scene.walls[0].time_factor.frequency = kFrequency;
  const double way = 100 / kTurn * 0.5;
  for (const double x : {1e-1, 1e-2, 1e-3}) {
    const Ended<2> end = run(with_accuracy(scene, x, 0.1, 5));
    EXPECT_NEAR(end.state.bodies[0].x[1], 50 + way, x * (way + kRadius)) << x;
    EXPECT_NEAR(end.state.walls[0].a[1], way, x * (way + kRadius)) << x;
  }
}

TEST(AccurateStep, OppositePulsesWithinAPartAreSeen) {
  // 9 N on 1 kg for 0.01 s, then -9 N: triangles that rise for 5 ms. Each changes v by 0.045 m/s.
  // The way of the middle of the first to that of the second is 0.01 · 0.045 m.
  Scene<2> scene = one_law<2>({});
  scene.bodies = {round_body<2>(Vec2::Zero(), kRadius, 1)};
  scene.forces = {{.first = 0, .last = 0, .force = Vec2(9, 0)}};
  scene.forces[0].time_factor.times = {0, 0.005, 0.01, 0.015, 0.02};
  scene.forces[0].time_factor.factors = {0, 1, 0, -1, 0};
  for (const double x : {1e-1, 1e-3}) {
    const Ended<2> end = run(with_accuracy(scene, x, 0.5, 2));
    EXPECT_NEAR(end.state.bodies[0].x[0], 0.01 * 0.045, x * kRadius) << x;
    EXPECT_NEAR(end.state.bodies[0].v[0], 0, 1e-13) << x;
  }
}

TEST(AccurateStep, AVibratingPlateThrowsADisk) {
  // The plate's velocity v sin w t. The disk leaves it where w v cos w t = -g, with the velocity
  // and the height of the plate.
  constexpr double kSpeed = 1, kTurn = 10 * std::numbers::pi, kEndTime = 0.15;
  const double leaves = std::acos(-9.81 / (kTurn * kSpeed)) / kTurn, flies = kEndTime - leaves;
  const double flown = kSpeed / kTurn * (1 - std::cos(kTurn * leaves)) +
                       kSpeed * std::sin(kTurn * leaves) * flies - 0.5 * 9.81 * flies * flies;
  const Scene<2> scene = over_plate(0, kRadius, kSpeed, kTurn);
  for (const double x : {1e-2, 1e-3, 1e-4}) {
    const Ended<2> end = run(with_accuracy(scene, x, kEndTime / 150, 150));
    EXPECT_NEAR(end.state.bodies[0].x[1], kRadius + flown, 2 * x * kRadius) << x;
    EXPECT_LT(end.totals.cut.parts, 1000) << x;
  }
}

TEST(AccurateStep, AVibratingPlateBouncesADisk) {
  // Between impacts the disk falls freely; the plate is at v/w (1 - cos w t). With e it leaves the
  // plate at (1 + e) times the plate's speed less e times its own. The times of impact by bisection.
  constexpr double kSpeed = 1, kTurn = 40 * std::numbers::pi, kBounce = 0.6, kEndTime = 0.3;
  const auto plate = [](double t) { return kSpeed / kTurn * (1 - std::cos(kTurn * t)); };
  double start = 0, from = 0.05, speed = 0;
  const auto height = [&](double t) {
    return from + speed * (t - start) - 0.5 * 9.81 * (t - start) * (t - start);
  };
  for (double t = 1e-4; t < kEndTime; t += 1e-4) {
    if (height(t) > plate(t)) continue;
    double before = t - 1e-4;
    for (int k = 0; k < 60; ++k) {
      const double middle = 0.5 * (before + t);
      (height(middle) > plate(middle) ? before : t) = middle;
    }
    const double meets = speed - 9.81 * (t - start), pushes = kSpeed * std::sin(kTurn * t);
    from = plate(t);
    speed = (1 + kBounce) * pushes - kBounce * meets;
    start = t;
  }
  const Scene<2> scene = over_plate(kBounce, 0.05 + kRadius, kSpeed, kTurn);
  for (const double x : {1e-3, 1e-4}) {
    const Ended<2> end = run(with_accuracy(scene, x, kEndTime / 30, 30));
    EXPECT_NEAR(end.state.bodies[0].x[1], kRadius + height(kEndTime), 40 * x * kRadius) << x;
    EXPECT_EQ(end.totals.cut.rejected(), 0) << x;
  }
}

TEST(AccurateStep, ImagesOfACellCollide) {
  // 0.58 m apart across the edge, at 2 m/s: after 0.29 s they exchange their velocities.
  Scene<2> scene = one_law<2>({.e_n = 1});
  scene.cell.in_x = scene.cell.in_y = true;
  scene.cell.width.length = scene.cell.height.length = 1;
  scene.bodies = {round_body<2>(Vec2(0.3, 0.5), kRadius, 1, Vec2(-1, 0)),
                  round_body<2>(Vec2(0.7, 0.5), kRadius, 1, Vec2(1, 0))};
  for (const double x : {1e-1, 1e-3}) {
    const Ended<2> end = run(with_accuracy(scene, x, 0.4, 1));
    EXPECT_NEAR(end.state.bodies[0].x[0], 0.3 - 0.29 + 0.11, 0.03 * x * kRadius);
    EXPECT_NEAR(end.state.bodies[1].v[0], -1, 1e-12);
    EXPECT_EQ(end.totals.cut.rejected(), 0);
  }
}

TEST(AccurateStep, ClustersAndCylindersCollide) {
  Scene<2> scene = one_law<2>({.e_n = 1});
  scene.walls = {half_space<2>(Vec2::Zero(), Vec2(1, 0))};
  scene.bodies = {round_body<2>(Vec2(0.11, -kRadius), kRadius, 1, Vec2(-1, 0)),
                  round_body<2>(Vec2(0.11, kRadius), kRadius, 1, Vec2(-1, 0))};
  scene.clusters.bodies = {
      {.x = Vec2(0.11, 0), .v = Vec2(-1, 0), .mass = 1, .inertia = 1e-4, .size = 1}};
  scene.clusters.arms = {Vec2(0, -kRadius), Vec2(0, kRadius)};
  for (Body<2>& d : scene.bodies) {
    d.mass = d.inertia = 0;
    d.cluster = 0;
  }
  const double x = 1e-2;
  EXPECT_NEAR(run(with_accuracy(scene, x, 0.2, 1)).state.clusters.bodies[0].x[0], 0.11,
              0.03 * x * kRadius);

  Scene<3> pipe = one_law<3>({.e_n = 1});
  pipe.walls = {{.shape = Wall<3>::Shape::kHollowCircle, .normal = Vec3(0, 0, 1), .radius = 0.11}};
  pipe.bodies = {round_body<3>(Vec3(0, 0, 0), kRadius, 1, Vec3(1, 0, 1))};
  const Ended<3> end = run(with_accuracy(pipe, x, 0.2, 1));
  EXPECT_NEAR(end.state.bodies[0].x[0], 0, 0.03 * x * kRadius);
  EXPECT_NEAR(end.state.bodies[0].x[2], 0.2, 1e-12);
}

/// Disks that fall into a box.
Scene<2> pour(int count) {
  Scene<2> scene = heavy_scene({.mu = 0.3});
  scene.walls = trough(0.08);
  for (int k = 0; k < count; ++k) {
    const double radius = kRadius * (0.8 + 0.05 * ((7 * k) % 9));
    scene.bodies.push_back(
        round_body<2>(Vec2(0.014 + 0.026 * (k % 3) + 1e-4 * (k % 5), 0.015 + 0.026 * (k / 3)),
                      radius, 1000 * std::numbers::pi * radius * radius));
  }
  return scene;
}

TEST(AccurateStep, TheSameStateGivesTheSameBitsAlsoAfterARestart) {
  Scene<2> scene = with_accuracy(pour(9), 3e-2, 0.02, 10);
  scene.output.every = 5;
  const SceneTotals<2> totals = run(scene).totals;
  EXPECT_GT(totals.cut.parts, 30);
  EXPECT_LT(totals.overlap, 4 * scene.accuracy);
  EXPECT_LT(std::abs(totals.last.energy.imbalance), 1e-12);
  EXPECT_EQ(expect_exact_restart(scene, 5).step, 10);
}

TEST(AccurateStep, EachPartIsSolvedOnce) {
  const Scene<2> scene = with_accuracy(pour(6), 1e-2, 0.05, 4);
  int solves = 0;
  const StepSolver solver = make_step_solver(require_solver("auto"), to_options(scene.solver));
  SceneRunOptions<2> options;
  options.solver = [&](const ContactProblem& problem, Vector s0) {
    ++solves;
    return solver(problem, std::move(s0));
  };
  State<2> state = initial_state(scene);
  const StepParts cut = run_scene(scene, state, options).totals.cut;
  EXPECT_EQ(solves, cut.parts + cut.rejected());
}

TEST(AccurateStep, APartThatMissesACollisionIsTakenAgain) {
  // The floor throws a disk that spins, and falls at 1 m/s, to the right: at mu (1 m/s) = 5 m/s. In
  // the half part that is left, x r / (2 m/s), it goes 2.5 x r, but the wall is 1e-3 r away.
  Scene<2> scene = one_law<2>({.mu = 5});
  scene.walls = {flat_floor<2>(),
                 half_space<2>(Vec2((1 + 1e-3) * kRadius, 0), Vec2(-1, 0), "side")};
  scene.bodies = {round_body<2>(Vec2(0, 0.05), kRadius, 1, Vec2(0, -1), -3000)};
  const double x = 1e-2;
  const Ended<2> end = run(with_accuracy(scene, x, 0.1, 1));
  EXPECT_GT(end.totals.cut.misplacing, 0);
  EXPECT_LE(end.state.bodies[0].x[0], (1e-3 + 1.5 * x) * kRadius);
}

TEST(AccurateStep, ItEndsWithASentenceWhereAPartWouldBeTooShort) {
  // The part of the impact at 1.4 m/s: x r / w = 7e-9 s, below 0.65 s / 2^20.
  const Scene<2> scene = with_accuracy(ball<2>(0), 1e-6, 0.65, 1);
  State<2> state = initial_state(scene);
  SceneStepper<2> stepper(scene);
  const auto failure = caught<StepFailure>([&] { stepper.advance(state); });
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->kind, StepFailure::Kind::kInvalidInput);
  EXPECT_TRUE(says(failure->what(), "impact 0 floor"));
  EXPECT_EQ(state.step, 0);
}

TEST(AccurateStep, WallsStartInTheMiddleOfAStep) {
  // It starts at 0.13 s, at 0.5 m/s: 0.035 m until 0.2 s.
  Scene<2> scene = beside_wall(0, kRadius);
  move_at(scene.walls[0], Vec2(0.5, 0));
  scene.walls[0].starts = 0.13;
  const Ended<2> end = run(with_accuracy(scene, 1e-2, 0.2, 1));
  EXPECT_NEAR(end.state.walls[0].a[0], 0.035, 1e-14);
  EXPECT_NEAR(end.state.bodies[0].x[0], kRadius + 0.035, 1e-2 * kRadius);
}

template <int D>
void throw_by_a_floor_that_starts() {
  // The ball rests. The floor starts within the fourth step, at 2 m/s, and the ball leaves it at
  // (1 + e) times that. A part with this impact at its beginning misplaces the ball by x/2.
  constexpr double kStarts = 0.0337, kBounce = 0.7, kFlight = 0.1 - kStarts;
  const double thrown = (1 + kBounce) * 2 * kFlight - 0.5 * 9.81 * kFlight * kFlight;
  Scene<D> scene = ball<D>(kBounce);
  scene.bodies[0].x[D - 1] = kRadius;
  move_at(scene.walls[0], 2 * Vec<D>::Unit(D - 1));
  scene.walls[0].starts = kStarts;
  for (const double x : {1e-2, 1e-4}) {
    const Ended<D> end = run(with_accuracy(scene, x, 0.01, 10));
    EXPECT_NEAR(end.state.bodies[0].x[D - 1], kRadius + thrown, x * kRadius) << x;
    EXPECT_EQ(end.totals.cut.rejected(), 0) << x;
  }
}
TEST(AccurateStep, AFloorThatStartsThrowsWhatRestsOnIt) {
  throw_by_a_floor_that_starts<2>();
  throw_by_a_floor_that_starts<3>();
}

TEST(AccurateStep, ADrivenWallStartsWithItsSpeedAndStops) {
  // From 0.033 s to 0.087 s at 0.5 m/s and 8 N / 2 kg, beside a disk that lies on a floor.
  constexpr double kTime = 0.087 - 0.033;
  Scene<2> scene = ball<2>(0);
  scene.bodies[0].x[1] = kRadius;
  scene.walls.push_back(half_space<2>(Vec2(1, 0), Vec2(-1, 0), "press"));
  Wall<2>& press = scene.walls[1];
  drive(press, Vec2(-1, 0), 2, 8);
  press.v = Vec2(-0.5, 0);
  press.starts = 0.033;
  press.stops = 0.087;
  const Ended<2> end = run(with_accuracy(scene, 1e-5, 0.01, 10));
  EXPECT_NEAR(end.state.walls[1].a[0], 1 - 0.5 * kTime - 0.5 * 4 * kTime * kTime, 1e-12);
  EXPECT_EQ(end.totals.cut.rejected(), 0);
}

/// A wall that stops at the end of a step moves in all of it, wherever rounding puts that end.
TEST(AccurateStep, AWallThatStopsAtTheEndOfAStepMovesInAllOfIt) {
  for (int k = 2; k < 40; ++k) {
    Scene<2> scene = ball<2>(0);
    scene.walls.push_back(half_space<2>(Vec2(1, 0), Vec2(-1, 0), "press"));
    move_at(scene.walls[1], Vec2(-1, 0));
    scene.walls[1].stops = k * 1e-3;
    const Ended<2> end = run(with_accuracy(scene, 0.1, 1e-3, k));
    EXPECT_EQ(end.state.walls[1].v[0], -1) << k;
    EXPECT_NEAR(end.state.walls[1].a[0], 1 - k * 1e-3, 1e-12);
  }
}

}  // namespace
}  // namespace bipot
