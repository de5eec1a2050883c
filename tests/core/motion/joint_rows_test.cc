// Pins and ropes: what is known by hand.

#include "core/motion/joint_rows.h"

#include "core/problem/equality_rows.h"
#include "core/scene/cluster_motion.h"
#include "core/scene/joints.h"
#include "tests/support/scene_run.h"
#include "tests/support/scene_text.h"

namespace bipot {
namespace {

constexpr double kG = 9.81;

/// A scene of so many steps of h.
template <class SceneType>
SceneType timed(SceneType scene, double h, int steps) {
  scene.step = h;
  scene.num_steps = steps;
  return scene;
}

/// A disk of 2 kg at `angle` from below its pin, which is 0.5 m from its centre.
Scene<2> pendulum(double angle) {
  const Vec2 x = 0.5 * Vec2(std::sin(angle), -std::cos(angle));
  return scene_of(
      fmt::format("time = {{step = 1e-3, steps = 1}}\n"
                  "disks = [{{position = [{}, {}], radius = 0.2, mass = 2}}]\n"
                  "pins = [{{bodies = [0], point = [0, 0]}}]\n",
                  x[0], x[1]));
}

double energy(const EnergyLedger& e) { return e.kinetic + e.potential; }

/// T = 2π √(length/g) 2/π K(sin θ/2), from one passage of the lowest point to the second after it;
/// `length` is I/(m l), `place` that of the centre from the pin.
template <int D, class Place>
void expect_period(const Scene<D>& scene, double amplitude, double length, const Place& place) {
  std::vector<double> passages;
  double before = amplitude;
  solved_run(scene, [&](const State<D>& state, const StepReport<D>& r) {
    const Vec<D> x = place(state);
    const double angle = std::atan2(x[0], -x[D - 1]);
    if (before * angle < 0 && std::abs(angle) < 1) {
      passages.push_back(r.time - scene.step * angle / (angle - before));
    }
    before = angle;
  });
  ASSERT_GE(passages.size(), 3u);
  const double period = 4 * std::sqrt(length / kG) * std::comp_ellint_1(std::sin(amplitude / 2));
  EXPECT_NEAR((passages[2] - passages[0]) / period, 1, 1e-5) << amplitude;
}

// I = m (a²/2 + l²) about the pin.
TEST(Pin, APendulumHasThePeriodOfTheEllipticIntegral) {
  for (const double amplitude : {0.01, 1.0, 2.8}) {
    expect_period(timed(pendulum(amplitude), 1e-3, 7000), amplitude, (0.5 * 0.04 + 0.25) / 0.5,
                  [](const State<2>& state) { return state.bodies[0].x; });
  }
}

// Midpoints lie on the circle to the third order; a state halfway between two of them is l (1 -
// cos(h w/2)) inside it. So the pin is open by h² w² l/8, for ever.
TEST(Pin, KeepsItsLengthAndItsEnergyOverTenThousandSteps) {
  const double h = 1e-3;
  const Scene<2> scene = timed(pendulum(2.8), h, 10000);
  const double start = 2 * kG * scene.bodies[0].x[1];
  const double acceleration = kG * 0.5 / (0.02 + 0.25);  // at most
  double worst = 0, open = 0, late = 0;
  solved_run(scene, [&](const State<2>& state, const StepReport<2>& r) {
    const auto [on_body, on_ground] = joint_points<2>(scene.joints[0], state.bodies);
    const double gap = (on_body - on_ground).norm(), spin = state.bodies[0].spin;
    const double third = std::pow(std::abs(spin), 3) + 0.5 * std::abs(spin) * acceleration;
    EXPECT_LE(gap, 0.5 * h * h * spin * spin / 8 + h * h * h * third + 1e-10);
    open = std::max(open, gap);
    const double off = std::abs(energy(r.energy) - start);
    worst = std::max(worst, off);
    if (r.step > 9000) late = std::max(late, off);
    EXPECT_LE(std::abs(r.energy.imbalance), 1e-12);
    EXPECT_LE(r.momentum_imbalance.norm(), 1e-12);
    EXPECT_NEAR(r.from_rest, kG * h * kG * h, 1e-12);  // 2 kg at g h
    EXPECT_NEAR(r.energy.shock_loss, start - energy(r.energy), 1e-9);
  });
  EXPECT_GT(open, 1e-7);
  EXPECT_LE(worst, 5e-5 * 2 * kG);
  EXPECT_LE(late, 1.5 * worst);
}

// After a start an even rotation repeats itself, 0.3 rad in each step: no energy is made.
TEST(Pin, AnEvenRotationKeepsItsEnergyAtLongSteps) {
  Scene<2> scene = timed(pendulum(0), 1e-2, 300);
  scene.gravity.setZero();
  scene.bodies[0].spin = 30;
  scene.bodies[0].v = Vec2(15, 0);
  double early = 0, late = 0;
  solved_run(scene, [&](const State<2>&, const StepReport<2>& r) {
    (r.step <= 30 ? early : late) = r.energy.kinetic;
    EXPECT_NEAR(r.energy.kinetic / (0.5 * 2 * 225 + 0.5 * 0.04 * 900), 1, 0.05) << r.step;
  });
  EXPECT_NEAR(late / early, 1, 1e-9);
}

// Two light links, 1.05 m and 0.7 m, the masses at the far ends of both from their joint: it snaps
// when they come in line. Energy begins with m g y and I w²/2: -19.54 J, and cannot grow. A step of
// 0.01 s does not see the snap.
TEST(Pin, AStepTooLongForItsBodiesFails) {
  Scene<2> scene = scene_of(R"(
time = {step = 1e-2, duration = 4}
disks = [{position = [0.3, -0.5], radius = 0.05, mass = 2},
  {position = [0.6, -0.5], radius = 0.05, mass = 2, spin = 8}]
pins = [{bodies = [0, 1], point = [1.3, -0.5]}, {bodies = [0], point = [0.25, -0.5]}]
)");
  for (const double travel : {0.0, 0.5}) {  // in whole steps, in parts of them
    scene.travel = travel;
    double most = -kInfinity;
    const auto failure = caught<StepFailure>([&] {
      solved_run(scene, [&](const State<2>&, const StepReport<2>& r) {
        most = std::max(most, energy(r.energy));
      });
    });
    ASSERT_TRUE(failure);
    EXPECT_EQ(failure->kind, StepFailure::Kind::kPlaces);
    EXPECT_TRUE(says(failure->what(), "pins and ropes made"));
    // Falling by 0.05 m and 1.75 m at most gives 35.3 J; with what was made, a tenth of the kinetic
    // energy, this is 35.4/0.9 J.
    EXPECT_LE(most, -19.54 + 4);
  }
}

/// A disk pinned to the ground, and one pinned to it, both to the right at rest.
Scene<2> double_pendulum() {
  return scene_of(R"(
time = {step = 1e-3, steps = 1}
disks = [{position = [0.5, 0], radius = 0.1, mass = 2}, {position = [1.3, 0], radius = 0.1, mass = 1}]
pins = [{bodies = [0], point = [0, 0]}, {bodies = [0, 1], point = [0.9, 0]}]
)");
}

TEST(Pin, ADoublePendulumKeepsItsEnergyToTheSecondOrder) {
  const auto loss = [](double h) {
    double worst = 0;
    solved_run(timed(double_pendulum(), h, static_cast<int>(std::lround(1 / h))),
               [&](const State<2>&, const StepReport<2>& r) {
                 worst = std::max(worst, std::abs(energy(r.energy)));
               });
    return worst;
  };
  const double coarse = loss(2e-3), fine = loss(1e-3);
  EXPECT_LE(fine, 1e-3);
  EXPECT_GT(coarse / fine, 3);
  EXPECT_LT(coarse / fine, 5.5);
}

// Three links of 1 kg and 1 m between points 2 m apart: the outer ones at 60° to the level, as 1 + 2
// cos 60° = 2. The middle one hangs on m g/2 at both ends. Moments of an outer one about the
// ground: H l sin = m g l/2 cos + m g/2 l cos, so H = m g cot 60°; the ground bears 3/2 m g.
TEST(Pin, AChainOfThreeLinksHangsInItsEquilibrium) {
  const double s = std::sqrt(3.0) / 2;
  Scene<2> scene = scene_of(fmt::format(R"(
time = {{step = 1e-3, steps = 500}}
disks = [{{position = [0.25, {0}], radius = 0.1, mass = 1}},
  {{position = [1, {1}], radius = 0.1, mass = 1}}, {{position = [1.75, {0}], radius = 0.1, mass = 1}}]
pins = [{{bodies = [0], point = [0, 0]}}, {{bodies = [0, 1], point = [0.5, {1}]}},
  {{bodies = [1, 2], point = [1.5, {1}]}}, {{bodies = [2], point = [2, 0]}}]
)",
                                        -s / 2, -s));
  State<2> state = initial_state(scene);
  TimeStepper<2> stepper = stepper_of(scene, "auto", {});
  while (state.step < 500) stepper.advance(state);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LE((state.bodies[i].x - scene.bodies[i].x).norm(), 1e-9) << i;
    EXPECT_LE(std::abs(state.bodies[i].angle), 1e-9) << i;
  }
  const Vector forces = multipliers(stepper.problem(), Vector()) / scene.step;
  EXPECT_LE((forces.head<2>() - kG * Vec2(-1 / std::sqrt(3.0), 1.5)).norm(), 1e-7);
  EXPECT_LE((forces.tail<2>() - kG * Vec2(1 / std::sqrt(3.0), 1.5)).norm(), 1e-7);
}

// A parallelogram with a third bar: its pins depend on each other.
TEST(Pin, RowsThatDependOnOthersAreTaken) {
  const Scene<2> scene = scene_of(R"(
time = {step = 1e-3, steps = 1000}
disks = [{position = [0, -0.5], radius = 0.1, mass = 1}, {position = [1, -0.5], radius = 0.1, mass = 1},
  {position = [2, -0.5], radius = 0.1, mass = 1}, {position = [1, -1], radius = 0.1, mass = 1}]
pins = [{bodies = [0], point = [0, 0]}, {bodies = [1], point = [1, 0]}, {bodies = [2], point = [2, 0]},
  {bodies = [0, 3], point = [0, -1]}, {bodies = [1, 3], point = [1, -1]}, {bodies = [2, 3], point = [2, -1]}]
)");
  Scene<2> pushed = scene;
  for (std::size_t i = 0; i < 3; ++i) {
    pushed.bodies[i].spin = 2;
    pushed.bodies[i].v = Vec2(1, 0);
  }
  pushed.bodies[3].v = Vec2(2, 0);
  double start = 0;
  for (const Disk& d : pushed.bodies) {
    start +=
        0.5 * d.mass * d.v.squaredNorm() + 0.5 * d.inertia * d.spin * d.spin + d.mass * kG * d.x[1];
  }
  solved_run(pushed, [&](const State<2>& state, const StepReport<2>& r) {
    EXPECT_NEAR(energy(r.energy), start, 1e-4);
    for (const auto& joint : scene.joints) {
      const auto [from, to] = joint_points<2>(joint, state.bodies);
      EXPECT_LE((from - to).norm(), 1e-5);
    }
    EXPECT_NEAR(state.bodies[3].angle, 0, 1e-6);  // the coupler stays level
  });
}

TEST(Pin, BodiesThatItJoinsDoNotTouch) {
  // They would, at the pin. The second hangs below the first and swings alone.
  const Scene<2> scene = scene_of(R"(
time = {step = 1e-3, steps = 200}
contact = {mu = 0.5}
disks = [{position = [0, 0], radius = 0.5, mass = 1}, {position = [1, 0], radius = 0.5, mass = 1}]
pins = [{bodies = [0], point = [-0.5, 0]}, {bodies = [0, 1], point = [0.5, 0]}]
)");
  solved_run(scene, [](const State<2>&, const StepReport<2>& r) { EXPECT_EQ(r.contacts, 0); });
}

// A bar of three disks (a cluster) is pinned at the first and lies on a plane. The contact of the
// first has no motion and carries nothing. The moments about the pin are those of the weight: Σ s_n
// x = m g h/2.
TEST(Pin, ABarOnAPlaneIsCarriedAndItsBlockedContactIsNot) {
  const Scene<2> scene = scene_of(R"(
time = {step = 1e-3, steps = 50}
walls = [{point = [0, 0], normal = [0, 1]}]
clusters = [{parts = [[0, 0, 0.1], [0.5, 0, 0.1], [1, 0, 0.1]], position = [0, 0.1], mass = 3}]
pins = [{bodies = [0], point = [0, 0.1]}]
)");
  const State<2> end = solved_run(scene);
  ASSERT_EQ(end.contacts.size(), 3u);
  EXPECT_EQ(end.contacts[0].s_n, 0);
  const double moment = 0.5 * end.contacts[1].s_n + end.contacts[2].s_n;
  EXPECT_NEAR(moment, 3 * kG * 1e-3 * 0.5, 1e-9);
  EXPECT_LE((end.clusters.bodies[0].x - scene.clusters.bodies[0].x).norm(), 1e-9);
}

// The disk cannot leave its pin: a wall that moves away or along is nothing to it.
TEST(Pin, AWallThatMovesIntoAPinnedDiskFails) {
  using Row = std::tuple<const char*, const char*, bool>;
  const char* glued = ", {position = [0, -0.1], radius = 0.1, wall = 'press'}";
  for (const auto& [more, velocity, fails] :
       {Row("", "[0.1, 0.1]", true), Row(glued, "[0, 0.1]", true), Row("", "[0.1, 0]", false),
        Row(glued, "[0.1, 0]", false), Row("", "[0, -0.1]", false)}) {
    const Scene<2> scene = scene_of(fmt::format(R"(
contact = {{mu = 0.5}}
time = {{step = 1e-3, steps = 3}}
disks = [{{position = [0, 0.1], radius = 0.1, mass = 1}}{}]
walls = [{{name = "press", point = [0, {}], normal = [0, 1], velocity = {}}}]
pins = [{{bodies = [0], point = [0, 0.1]}}]
)",
                                                more, more == glued ? -0.2 : 0.0, velocity));
    for (const OnFailure rule : {OnFailure::kContinue, OnFailure::kSmallerStep}) {
      SceneRunOptions<2> options;
      options.on_failure = rule;
      State<2> state = initial_state(scene);
      const SceneRun<2> run = run_scene(scene, state, options);
      ASSERT_EQ(run.failure.has_value(), fails) << velocity;
      if (!fails) continue;
      EXPECT_EQ(run.failure->kind, StepFailure::Kind::kPlaces);
      EXPECT_TRUE(says(run.failure->what(), "wall 'press' moves into disk 0, which pins hold"));
    }
  }
}

// A disk falls 0.5 m into its rope, to v = √(g): the rope takes m v and with it all of m g 0.5 m.
TEST(Rope, CatchesAFallingDiskWithoutRebound) {
  const Scene<2> scene = scene_of(R"(
time = {step = 1e-3, steps = 500}
disks = [{position = [0, -0.5], radius = 0.1, mass = 2}]
ropes = [{bodies = [0], to = [0, 0], length = 1}]
)");
  double fastest = 0, jerk = 0;
  Vec2 before = Vec2::Zero();
  const State<2> end = solved_run(scene, [&](const State<2>& state, const StepReport<2>& r) {
    const Vec2& v = state.bodies[0].v;
    fastest = std::max(fastest, -v[1]);
    if (v[1] - before[1] > 1e-6) jerk += 2 * (v[1] - before[1] + kG * 1e-3);
    EXPECT_LE(v[1], 1e-9) << r.step;
    EXPECT_LE(std::abs(r.energy.imbalance), 1e-12);
    EXPECT_LE(r.momentum_imbalance.norm(), 1e-12);
    before = v;
  });
  EXPECT_NEAR(fastest, std::sqrt(kG), 2 * kG * 1e-3);
  EXPECT_NEAR(jerk, 2 * fastest, 2 * kG * 4e-3);  // and the weight of these steps
  EXPECT_NEAR(end.bodies[0].x[1], -1, 1e-9);
  EXPECT_LE(end.bodies[0].v.norm(), 1e-9);
  EXPECT_NEAR(end.shock_loss, 2 * kG * 0.5, 1e-8);
}

TEST(Rope, PullsOnlyAndSwingsWithoutLoss) {
  // Let go level, it falls on the circle; thrown inwards it flies on a parabola.
  Scene<2> scene = scene_of(R"(
time = {step = 1e-3, steps = 1000}
disks = [{position = [1, 0], radius = 0.1, mass = 2}]
ropes = [{bodies = [0], to = [0, 0]}]
)");
  solved_run(scene, [](const State<2>& state, const StepReport<2>& r) {
    EXPECT_NEAR(energy(r.energy), 0, 2e-4);
    const double speed = state.bodies[0].v.norm();
    EXPECT_NEAR(state.bodies[0].x.norm(), 1, 1e-6 * speed * speed / 8 + 1e-7);
  });
  scene.bodies[0].v = Vec2(-1, 1);
  EXPECT_LE((solved_run(scene, 100).bodies[0].x - Vec2(0.9, 0.1 - 0.5 * kG * 0.01)).norm(), 1e-12);
}

// Two disks 0.1 m apart on a rope of 0.4 m fall: without any contact and any rope that may pull.
TEST(Rope, SlackItLetsItsBodiesFall) {
  const Scene<2> scene = scene_of(R"(
time = {step = 1e-2, steps = 10}
disks = [{position = [0, 0], radius = 0.01, mass = 3}, {position = [0.1, 0], radius = 0.01, mass = 1, velocity = [0.2, 0]}]
ropes = [{bodies = [0, 1], length = 0.4}]
)");
  const State<2> end = solved_run(scene);
  EXPECT_LE((end.bodies[0].x - Vec2(0, -0.5 * kG * 0.01)).norm(), 1e-12);
  EXPECT_LE((end.bodies[1].x - Vec2(0.12, -0.5 * kG * 0.01)).norm(), 1e-12);
}

TEST(Rope, TwoBodiesShareItsPull) {
  // Without gravity a disk of 1 kg leaves one of 3 kg at 4 m/s: the rope makes both run at 1 m/s.
  const Scene<2> scene = scene_of(R"(
gravity = [0, 0]
time = {step = 1e-3, steps = 400}
disks = [{position = [0, 0], radius = 0.1, mass = 3}, {position = [0.5, 0], radius = 0.1, mass = 1, velocity = [4, 0]}]
ropes = [{bodies = [0, 1], length = 1}]
)");
  const State<2> end = solved_run(scene);
  EXPECT_NEAR(end.bodies[0].v[0], 1, 1e-9);
  EXPECT_NEAR(end.bodies[1].v[0], 1, 1e-9);
  EXPECT_NEAR(end.bodies[1].x[0] - end.bodies[0].x[0], 1, 1e-9);
  EXPECT_NEAR(end.shock_loss, 0.5 * 16 - 0.5 * 4, 1e-9);  // ½ m v² - ½ (m + M) 1²
}

// In space: v² = g l sin tan for the angle of a conical pendulum; its height does not change.
TEST(Rope, AConicalPendulumKeepsItsHeight) {
  const double s = std::sin(0.6), c = std::cos(0.6), v = std::sqrt(kG * s * s / c);
  const auto scene = scene_of<3>(fmt::format(R"(
time = {{step = 1e-3, steps = 2000}}
contact = {{mu = 0.3}}
spheres = [{{position = [{}, 0, {}], radius = 0.1, mass = 2, velocity = [0, {}, 0]}}]
ropes = [{{bodies = [0], to = [0, 0, 0]}}]
)",
                                             s, -c, v));
  solved_run(scene, [&](const State<3>& state, const StepReport<3>& r) {
    EXPECT_NEAR(state.bodies[0].x[2], -c, 1e-5);
    EXPECT_NEAR(state.bodies[0].v.norm(), v, 1e-5);
    EXPECT_LE(r.momentum_imbalance.norm(), 1e-12);
  });
}

// A sphere pinned in space, with a spin of its own: energy and the vertical angular momentum about
// the pin stay.
TEST(Pin, ASphereInSpaceKeepsEnergyAndVerticalAngularMomentum) {
  const auto scene = scene_of<3>(R"(
time = {step = 1e-3, steps = 2000}
spheres = [{position = [0.5, 0, 0], radius = 0.2, mass = 2, velocity = [0, 1, 0], spin = [0, 0, 2]}]
pins = [{bodies = [0], point = [0, 0, 0]}]
)");
  const double inertia = 0.4 * 2 * 0.04, start = 0.5 * 2 + 0.5 * inertia * 4;
  solved_run(scene, [&](const State<3>& state, const StepReport<3>& r) {
    const Sphere& b = state.bodies[0];
    EXPECT_NEAR(energy(r.energy), start, 5e-4);
    EXPECT_NEAR((2 * b.x.cross(b.v) + inertia * b.spin)[2], 1 + 2 * inertia, 1e-4);
    const auto [from, to] = joint_points<3>(scene.joints[0], state.bodies);
    EXPECT_LE((from - to).norm(), 2e-6 + 1e-6 * b.spin.squaredNorm());
  });
}

/// Two spheres of one body, 2 kg and moments 0.01, 0.09, 0.09 kg m²; its centre is 0.5 m along x
/// from the pin.
Scene<3> pinned_bar(const std::string& more) {
  return scene_of<3>(
      "dim = 3\ntime = {step = 1e-3, steps = 3000}\n"
      "clusters = [{parts = [[0, 0, 0, 0.1], [0.4, 0, 0, 0.1]], position = [0.3, 0, 0], mass = 2, "
      "inertia = [0.01, 0.09, 0.09]" +
      more + "}]\npins = [{bodies = [0], point = [0, 0, 0]}]\n");
}

// I = 0.09 + 2 * 0.25 about the pin; from the horizontal the amplitude is π/2.
TEST(Pin, ABarOfSpheresHasThePeriodOfTheEllipticIntegral) {
  expect_period(pinned_bar(""), std::numbers::pi / 2, 0.59 / (2 * 0.5), [](const State<3>& state) {
    const Vec3 x = 0.5 * (state.bodies[0].x + state.bodies[1].x);
    EXPECT_NEAR(x[1], 0, 1e-12);
    return x;
  });
}

// Thrown sideways with a spin about its own axis: energy and the vertical angular momentum about the
// pin stay to the second order, and the pin does not open.
TEST(Pin, ATumblingBarOfSpheresKeepsEnergyAndVerticalAngularMomentum) {
  Scene<3> scene = pinned_bar(", velocity = [0, 1, 0], spin = [30, 0, 2]");
  const double start = 0.5 * 2 + 0.5 * (0.01 * 900 + 0.09 * 4);
  double worst[] = {0, 0};
  for (const int parts : {1, 2}) {
    scene.step = 1e-3 / parts;
    solved_run(scene, 1000 * parts, [&](const State<3>& state, const StepReport<3>& r) {
      const Cluster<3>& body = state.clusters.bodies[0];
      const double momentum = (2 * body.x.cross(body.v) + own_momentum(body))[2];
      worst[parts - 1] = std::max({worst[parts - 1], std::abs(energy(r.energy) - start),
                                   std::abs(momentum - (1 + 0.09 * 2))});
      const auto [from, to] = joint_points<3>(scene.joints[0], state.bodies);
      EXPECT_LE((from - to).norm(), 1e-5);
    });
  }
  EXPECT_LT(worst[0], 5e-3);
  EXPECT_LT(worst[1], 0.35 * worst[0]);
}

}  // namespace
}  // namespace bipot
