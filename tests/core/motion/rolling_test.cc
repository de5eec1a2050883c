// Rolling friction in scenes: the moment of a contact is at most mu_r s_n, and opposes rolling.

#include "core/motion/midpoint.h"
#include "tests/support/refused_scene.h"
#include "tests/support/scene_run.h"
#include "tests/support/scene_text.h"
#include "tests/support/small_scenes.h"

namespace bipot {
namespace {

constexpr double kRollRadius = 0.5, kRollMass = 2, kRollStep = 0.01;
/// m a² / (I + m a²): a body that rolls freely down a slope has this part of g sin θ.
template <int D>
constexpr double kRollsFreely = D == 2 ? 2.0 / 3 : 5.0 / 7;

template <int D>
Scene<D> on_the_flat(const ContactLaw& law) {
  Scene<D> scene = on_floor(heavy_scene<D>(law, kRollStep), kRollRadius, kRollMass);
  scene.contact_distance = 1e-9;
  scene.solver.tol = 1e-13;
  return scene;
}

/// Spin of a body that rolls on the floor without sliding at v.
double rolling_spin(const Vec2& v) { return -v[0] / kRollRadius; }
Vec3 rolling_spin(const Vec3& v) { return Vec3::UnitZ().cross(v) / kRollRadius; }

// The weight has the lever a sin θ about the contact, and N = m g cos θ: the body rolls iff
// tan θ > mu_r / a, with k (g sin θ - mu_r g cos θ / a). It slides before it rolls iff mu is
// smaller: from tan θ > mu on, with g sin θ - mu g cos θ.
template <int D>
void on_a_slope() {
  constexpr int kSteps = 20;
  const auto speed = [&](double tangent, double mu, double ratio) {
    Scene<D> scene = on_the_flat<D>({.mu = mu, .mu_r = ratio * kRollRadius});
    const double angle = std::atan(tangent);
    scene.gravity =
        kGravity * (std::sin(angle) * Vec<D>::Unit(0) - std::cos(angle) * Vec<D>::Unit(D - 1));
    const State<D> state = after_steps(scene, kSteps);
    return state.bodies[0].v[0] / (kSteps * kRollStep * kGravity * std::cos(angle));
  };
  EXPECT_NEAR(speed(0.19, 0.8, 0.2), 0, 1e-10);
  EXPECT_NEAR(speed(0.25, 0.8, 0.2), kRollsFreely<D> * (0.25 - 0.2), 1e-10);
  EXPECT_NEAR(speed(0.25, 0.8, 0), kRollsFreely<D> * 0.25, 1e-10);
  EXPECT_NEAR(speed(0.19, 0.2, 0.5), 0, 1e-10);
  EXPECT_NEAR(speed(0.25, 0.2, 0.5), 0.25 - 0.2, 1e-10) << "slides without rolling";
}
TEST(RollingFriction, ADiskRollsOnASlopeFromTheDerivedAngleOn) { on_a_slope<2>(); }
TEST(RollingFriction, ASphereRollsOnASlopeFromTheDerivedAngleOn) { on_a_slope<3>(); }

// (I + m a²) v̇ / a = -mu_r m g: v̇ = -k g mu_r / a while it rolls. With 25 steps' worth of it as
// the start it stops after v²/2|v̇|, to the bit of the scheme, and stays. All energy is lost there.
template <int D>
void stop_on_the_flat(const Vec<D>& direction) {
  Scene<D> scene = on_the_flat<D>({.mu = 0.6, .mu_r = 0.1});
  const double rate = kRollsFreely<D> * kGravity * 0.1 / kRollRadius, start = 25 * kRollStep * rate;
  Body<D>& body = scene.bodies[0];
  body.v = start * direction;
  body.spin = rolling_spin(body.v);
  const Vec<D> x = body.x;
  const State<D> half = after_steps(scene, 10);
  EXPECT_LT((half.bodies[0].v - 15 * kRollStep * rate * direction).norm(), 1e-10);
  EXPECT_LT(magnitude(half.bodies[0].spin - rolling_spin(half.bodies[0].v)), 1e-10) << "no slip";
  const State<D> state = after_steps(scene, 40);
  EXPECT_LT(state.bodies[0].v.norm(), 1e-10);
  EXPECT_LT((state.bodies[0].x - x - start * start / (2 * rate) * direction).norm(), 1e-10);
  EXPECT_NEAR(state.friction_loss, 0.5 * kRollMass / kRollsFreely<D> * start * start, 1e-10);
}
TEST(RollingFriction, ADiskStopsAfterTheDerivedWay) { stop_on_the_flat<2>(Vec2(1, 0)); }
TEST(RollingFriction, ASphereStopsAfterTheDerivedWayInAnyDirection) {
  stop_on_the_flat<3>(Vec3(0.6, 0.8, 0));
}

// A force F at the centre sets a body on the flat rolling iff F a > mu_r m g.
TEST(RollingFriction, NothingRollsOnTheFlatBelowTheBound) {
  for (const double share : {0.9, 1.1}) {
    Scene<2> scene = on_the_flat<2>({.mu = 0.8, .mu_r = 0.1});
    const double force = share * 0.1 * kRollMass * kGravity / kRollRadius;
    scene.forces = {{.first = 0, .last = 0, .force = Vec2(force, 0)}};
    const State<2> state = after_steps(scene, 20);
    const double rate =
        share < 1 ? 0 : 2.0 / 3 * (force / kRollMass - kGravity * 0.1 / kRollRadius);
    EXPECT_NEAR(state.bodies[0].v[0], 20 * kRollStep * rate, 1e-9);
    // The moment that holds it, on the disk, counter-clockwise: F a, at most mu_r m g.
    EXPECT_NEAR(state.contacts.at(0).moment / kRollStep,
                std::min(1.0, share) * 0.1 * kRollMass * kGravity, 1e-9);
  }
}

// The line of centres of two equal disks leans by φ. The upper weight has the lever a sin φ about
// their contact, whose normal force is m g cos φ: they stand iff tan φ <= mu_r / a (the floor needs
// only sin φ <= mu_r / a, and friction tan φ <= mu). Without rolling friction they never do.
TEST(RollingFriction, TwoStackedDisksStandUpToTheDerivedLean) {
  for (const double mu_r : {0.1, 0.0}) {
    for (const double share : {0.9, 1.1}) {
      Scene<2> scene = on_the_flat<2>({.mu = 0.8, .mu_r = mu_r});
      const double lean = std::atan(share * 0.1 / kRollRadius);
      scene.bodies.push_back(round_body<2>(Vec2(std::sin(lean), kRollRadius + std::cos(lean)),
                                           kRollRadius, kRollMass));
      const State<2> state = after_steps(scene, 10);
      const double moved = state.bodies[0].v.norm() + state.bodies[1].v.norm();
      if (share < 1 && mu_r > 0) {
        EXPECT_LT(moved, 1e-10);
      } else {
        EXPECT_GT(moved, 1e-3);
      }
    }
  }
}

// A disk goes round in a drum that turns at 3 rad/s, without gravity: the work of friction and of
// its moment is 3 rad/s times the angular momentum about the axis that they give.
TEST(RollingFriction, ADrumThatTurnsDoesTheWorkOfItsTorque) {
  Scene<2> scene = on_the_flat<2>({.mu = 0.1, .mu_r = 0.1 * kRollRadius});
  scene.gravity.setZero();
  scene.walls = {Wall<2>{.name = "drum",
                         .shape = Wall<2>::Shape::kHollowCircle,
                         .motion = Wall<2>::Motion::kMoving,
                         .radius = 2 * kRollRadius,
                         .spin = 3}};
  scene.bodies[0].x = Vec2(0, -kRollRadius);
  scene.bodies[0].v = Vec2(0.1 * kRollRadius, 0);
  State<2> state = initial_state(scene);
  TimeStepper<2> stepper = stepper_of(scene);
  for (int k = 0; k < 20; ++k) stepper.advance(state);
  const double gained = angular_momentum(state) - angular_momentum(initial_state(scene));
  EXPECT_GT(gained, 0);
  EXPECT_NEAR(state.wall_work / (3 * gained), 1, 1e-3);
}

// A disk in a hollow circle, small swings about the bottom: 3/2 L φ̈ = -g φ - (mu_r/a) g sign φ̇,
// an oscillator with a constant friction. Each half swing costs twice mu_r/a of the amplitude:
// 0.1, -0.08, 0.06. It comes to rest where |φ| <= mu_r/a.
TEST(RollingFriction, APendulumInAHollowCircleLosesTheDerivedAmplitude) {
  Scene<2> scene = on_the_flat<2>({.mu = 0.8, .mu_r = 0.01 * kRollRadius});
  constexpr double kLength = 2;
  scene.walls = {Wall<2>{.name = "drum", .shape = Wall<2>::Shape::kHollowCircle}};
  scene.walls[0].radius = kLength + kRollRadius;
  scene.step = 2e-3;
  scene.bodies[0].x = kLength * Vec2(std::sin(0.1), -std::cos(0.1));
  std::vector<double> turns;
  double before = 0;
  State<2> state = initial_state(scene);
  TimeStepper<2> stepper = stepper_of(scene);
  for (int k = 0; k < 10000 && turns.size() < 3; ++k) {
    stepper.advance(state);
    const Body<2>& body = state.bodies[0];
    if (before * body.v[0] < 0) turns.push_back(std::atan2(body.x[0], -body.x[1]));
    before = body.v[0];
  }
  ASSERT_EQ(turns.size(), 3u);
  const double expected[] = {-0.08, 0.06, -0.04};
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(turns[k], expected[k], 2e-3);
}

// (2/5) m a² ω̇ = -mu_spin m g about the normal, and nothing else moves.
TEST(RollingFriction, ASphereStopsSpinningAtTheDerivedRate) {
  Scene<3> scene = on_the_flat<3>({.mu = 0.5, .mu_spin = 0.02});
  const double rate = 0.02 * kGravity / (0.4 * kRollRadius * kRollRadius);
  scene.bodies[0].spin = Vec3(0, 0, 30 * kRollStep * rate);
  const State<3> state = after_steps(scene, 10);
  EXPECT_LT((state.bodies[0].spin - Vec3(0, 0, 20 * kRollStep * rate)).norm(), 1e-9);
  EXPECT_LT(state.bodies[0].v.norm(), 1e-10);
  EXPECT_LT(after_steps(scene, 40).bodies[0].spin.norm(), 1e-9);
}

/// Bodies that fall on each other.
template <int D>
Scene<D> falling_on_each_other(const ContactLaw& law) {
  Scene<D> scene = on_the_flat<D>(law);
  scene.bodies.clear();
  for (int k = 0; k < 9; ++k) {
    Vec<D> x = Vec<D>::Zero();
    x[0] = 1.05 * (k % 3) + 0.1 * (k / 3);
    x[D - 1] = kRollRadius + 1.02 * (k / 3) + 0.01 * k;
    Vec<D> v = Vec<D>::Zero();
    v[0] = k % 2 == 0 ? 1 : -1;
    scene.bodies.push_back(round_body<D>(x, kRollRadius, 1 + k % 3, v));
  }
  scene.num_steps = 60;
  scene.solver.tol = 1e-11;
  return scene;
}

// With one coefficient of restitution for all rows no step creates energy (method.md §3).
template <int D>
void lose_energy() {
  for (const double e : {0.0, 0.4}) {
    const Scene<D> scene = falling_on_each_other<D>(
        {.mu = 0.4, .e_n = e, .e_t = e, .mu_r = 0.05, .mu_spin = D == 3 ? 0.02 : 0});
    double lost = 0;
    solved_run(scene, [&](const State<D>& state, const StepReport<D>& r) {
      EXPECT_LT(std::abs(r.energy.imbalance), 1e-9);
      // Gravity is a force: with e > 0 the sum may fall by s·f/2, of the order of the step.
      const double now = state.friction_loss + state.shock_loss;
      EXPECT_GE(now, lost - (e == 0 ? 1e-9 : 0.05));
      lost = now;
    });
    EXPECT_GT(lost, 1);
  }
}
TEST(RollingFriction, DisksNeverCreateEnergy) { lose_energy<2>(); }
TEST(RollingFriction, SpheresNeverCreateEnergy) { lose_energy<3>(); }

// A column that collapses on a rough floor spreads less, and ends higher, the larger mu_r is. Without
// it disks roll away.
TEST(RollingFriction, AHeapIsSteeperWithMoreOfIt) {
  double height = 0;
  for (const double ratio : {0.0, 0.1, 0.4}) {
    Scene<2> scene = on_the_flat<2>({.mu = 0.5, .mu_r = ratio * kRollRadius});
    scene.bodies.clear();
    for (int k = 0; k < 24; ++k) {
      const Vec2 x(1.01 * (k % 3) + 0.3 * (k / 3 % 2), kRollRadius + 1.0 * (k / 3));
      scene.bodies.push_back(round_body<2>(x, kRollRadius, kRollMass));
    }
    scene.solver.tol = 1e-7;
    scene.step = 5e-3;
    scene.num_steps = 500;
    State<2> state = initial_state(scene);
    run_scene(scene, state);
    double sum = 0;
    for (const Disk& disk : state.bodies) sum += disk.x[1] / 24;
    EXPECT_GT(sum, 1.1 * height) << "mu_r / a = " << ratio;
    height = sum;
  }
}

TEST(RollingFriction, ARestartContinuesBitForBit) {
  expect_exact_restart(falling_on_each_other<2>({.mu = 0.4, .mu_r = 0.05}), 23);
}

TEST(RollingFriction, AFallWithoutContactsIsAFall) {
  Scene<3> scene = on_the_flat<3>({.mu = 0.5, .mu_r = 0.1, .mu_spin = 0.1});
  scene.bodies[0].x[2] = 1;
  scene.bodies[0].spin = Vec3(1, 2, 3);
  const State<3> state = after_steps(scene, 5);
  EXPECT_NEAR(state.bodies[0].v[2], -5 * kRollStep * kGravity, 1e-14);
  EXPECT_EQ(state.bodies[0].spin, Vec3(1, 2, 3));
}

// The next step starts from the moments of the step before: a body at rest needs no iteration.
TEST(RollingFriction, AWarmStartHasTheMoments) {
  Scene<2> scene = on_the_flat<2>({.mu = 0.8, .mu_r = 0.2});
  scene.gravity = kGravity * Vec2(0.1, -1);
  State<2> state = initial_state(scene);
  TimeStepper<2> stepper = stepper_of(scene, "pgs");
  stepper.advance(state);
  EXPECT_NEAR(state.contacts.at(0).moment, kRollStep * kRollMass * 0.1 * kGravity * kRollRadius,
              1e-12);
  EXPECT_EQ(stepper.advance(state).iterations, 0);
}

TEST(RollingFriction, IsReadAndRefusedWithItsReason) {
  const std::string rest = "\n[time]\nstep = 0.01\nsteps = 1\n";
  const Scene<2> scene = scene_of(
      "materials = [\"a\", \"b\"]\n[contact]\nmu_r = 0.1\n[[pairs]]\nbetween = [\"a\", \"b\"]\n"
      "mu_r = 0\n" +
      rest);
  EXPECT_EQ(scene.law(0, 0).mu_r, 0.1);
  EXPECT_EQ(scene.law(0, 1).mu_r, 0);
  EXPECT_EQ(scene.contact_rows(), 3);
  const auto refused = refused_scenes(rest);
  refused("[contact]\nmu_r = -1", "mu_r");
  refused("[contact]\nmu_spin = 1", "mu_spin is for spheres");
  refused("model = \"dem\"\n[contact]\nmu_r = 1", "dem");
  refused("[contact]\nmu_r = 1\nimpact = \"poisson\"", "rolling friction");
}

}  // namespace
}  // namespace bipot
