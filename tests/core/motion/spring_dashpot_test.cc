#include "core/motion/spring_dashpot.h"

#include "core/scene/generators.h"
#include "tests/support/scene_run.h"
#include "tests/support/scene_text.h"
#include "tests/support/small_scenes.h"

namespace bipot {
namespace {

constexpr double kPi = std::numbers::pi;

template <int D = 2>
Scene<D> spring_scene(double mu, double e_n, double e_t = 0) {
  Scene<D> scene = heavy_scene<D>({.mu = mu, .e_n = e_n, .e_t = e_t});
  scene.model = Model::kSpringDashpot;
  return scene;
}

template <int D>
State<D> run(const Scene<D>& scene, int steps, const OnStep<D>& on_step = {}) {
  SpringDashpotStepper stepper(scene);
  State<D> state = initial_state(scene);
  for (int step = 0; step < steps; ++step) {
    const StepReport<D> report = stepper.advance(state);
    EXPECT_TRUE(report.converged);
    EXPECT_EQ(report.iterations, stepper.setup().substeps);
    if (D == 3) {
      EXPECT_NEAR(report.momentum_imbalance.norm(), 0, 1e-12);
    }
    if (on_step) on_step(state, report);
  }
  return state;
}
/// Of a scene that says how many steps.
State<2> run(const Scene<2>& scene, const OnStep<2>& on_step = {}) {
  return run(scene, scene.num_steps, on_step);
}

/// Two bodies of 1 and 3 kg meet head-on at 2 m/s; ends after they have parted.
template <int D = 2>
Scene<D> head_on(double e_n, double stiffness, const Vec<D>& along = Vec<D>::Unit(0)) {
  Scene<D> scene = spring_scene<D>(0.3, e_n);
  scene.gravity.setZero();
  scene.dem.stiffness = stiffness;
  scene.bodies = {round_body<D>(Vec<D>::Zero(), 0.1, 1, Vec<D>(1.5 * along)),
                  round_body<D>(Vec<D>(0.2001 * along), 0.1, 3, Vec<D>(-0.5 * along))};
  scene.step = 1e-5;
  scene.num_steps = 800;
  return scene;
}

TEST(SpringDashpot, RestitutionAndDampingAreInverse) {
  EXPECT_EQ(restitution_of_damping(0), 1);
  EXPECT_NEAR(restitution_of_damping(1), std::exp(-2), 1e-12);
  // Both branches meet there.
  EXPECT_NEAR(restitution_of_damping(1 - 1e-6), restitution_of_damping(1 + 1e-6), 1e-6);
  // Weakly damped, acos(zeta) is pi/2: the textbook's e = exp(-pi zeta).
  EXPECT_NEAR(restitution_of_damping(1e-4), std::exp(-kPi * 1e-4), 1e-7);
  for (const double e : {0.05, 0.1, 0.1353, 0.136, 0.5, 0.9, 0.999}) {
    EXPECT_NEAR(restitution_of_damping(damping_of_restitution(e)), e, 1e-12) << e;
  }
  EXPECT_EQ(damping_of_restitution(1), 0);
  EXPECT_EQ(damping_of_restitution(0), kMaxDamping);
}

TEST(SpringDashpot, HeadOnImpactGivesTheRestitutionAndTheDuration) {
  // m = 3/4 kg, k = 1e6 N/m: half period pi √(m/k) = 2.72e-3 s. The contact ends when the force
  // vanishes, after 2 acos(zeta) / (w √(1 - zeta²)).
  const double k = 1e6, w = std::sqrt(k / 0.75);
  for (const double e : {1.0, 0.9, 0.5, 0.2, 0.1}) {
    int first = -1, last = -1;
    const Scene<2> scene = head_on(e, k);
    const State<2> end = run(scene, [&](const State<2>& state, const StepReport<2>& r) {
      if (r.active > 0) {
        if (first < 0) first = state.step;
        last = state.step;
      }
      EXPECT_NEAR(r.momentum_imbalance.norm(), 0, 1e-12);
      EXPECT_NEAR(r.momentum[0], 0, 1e-12);
    });
    EXPECT_TRUE(end.contacts.empty());
    EXPECT_NEAR((end.bodies[1].v[0] - end.bodies[0].v[0]) / 2, e, 0.01) << "e " << e;
    const double zeta = damping_of_restitution(e);
    const double duration = zeta < 1 ? 2 * std::acos(zeta) / (w * std::sqrt(1 - zeta * zeta))
                                     : 2 * std::acosh(zeta) / (w * std::sqrt(zeta * zeta - 1));
    EXPECT_NEAR((last - first + 1) * scene.step / duration, 1, 0.015) << "e " << e;
    // What was lost: m_eff v²/2 (1 - e²), by the normal force alone.
    const double measured = (end.bodies[1].v[0] - end.bodies[0].v[0]) / 2;
    EXPECT_NEAR(end.shock_loss, 0.5 * 0.75 * 4 * (1 - measured * measured), 1e-9);
    EXPECT_EQ(end.friction_loss, 0);
  }
}

TEST(SpringDashpot, ConvergesWithTheSubstep) {
  // Elastic impacts to second order. With a dashpot the force jumps when the contact begins, at any
  // phase of a substep: first order. Errors depend on where in a substep a contact begins and ends,
  // so they are averaged over 16 gaps and 8 stiffnesses.
  const auto error = [](double e, double substep) {
    double sum = 0;
    for (int k = 0; k < 128; ++k) {
      Scene<2> scene = head_on(e, 1e6 * (1 + 0.3 * (k / 16) / 8));
      scene.step = substep;
      scene.dem.substep = substep;
      scene.bodies[1].x[0] += 2 * substep * (k % 16) / 16;
      const State<2> end = run(scene, static_cast<int>(std::lround(4e-3 / substep)));
      const double difference = (end.bodies[1].v[0] - end.bodies[0].v[0]) / 2 - e;
      sum += difference * difference;
    }
    return std::sqrt(sum / 128);
  };
  EXPECT_NEAR(std::log2(error(1, 1e-4) / error(1, 1.25e-5)) / 3, 2, 0.2);
  EXPECT_NEAR(std::log2(error(0.5, 1e-4) / error(0.5, 1.25e-5)) / 3, 1, 0.2);
}

TEST(SpringDashpot, DiskAtRestOverlapsByItsWeightOverTheStiffness) {
  const Scene<2> scene = on_floor(spring_scene(0.4, 0.3), 0.1, 2);
  const SpringDashpotSetup setup = spring_dashpot_setup(scene);
  // The default stiffness: weight over 1e-3 of the radius.
  EXPECT_NEAR(setup.stiffness, 2 * kGravity / 1e-4, 1e-6 * setup.stiffness);
  const State<2> end = run(scene, 3000);
  EXPECT_NEAR(end.contacts.at(0).contact.gap, -1e-4, 1e-12);
  EXPECT_NEAR(end.contacts.at(0).s_n / scene.step, 2 * kGravity, 1e-9);
  EXPECT_EQ(end.contacts.at(0).s_t, 0);
  EXPECT_EQ(end.bodies[0].x[0], 0);
  EXPECT_NEAR(end.bodies[0].v[1], 0, 1e-13);
  // It came down by d = mg/k and lost half of mg d, the other half is in the spring.
  EXPECT_NEAR(end.shock_loss / (2 * kGravity * 1e-4), 0.5, 1e-3);
}

TEST(SpringDashpot, BouncingBallReachesTheHeightsOfTable1) {
  // h_p = h0 e^2p, flights 2 e^p √(2 h0/g). Where in a substep the dashpot sets in moves e = 0.9 by
  // up to 0.006, which is 1.3 % of a height.
  for (const double e : {1.0, 0.9}) {
    Scene<2> scene = spring_scene(0, e);
    scene.walls = {flat_floor<2>()};
    scene.bodies = {round_body<2>(Vec2(0, 0.11), 0.01, 1)};
    scene.step = 1e-4;
    scene.num_steps = 8000;
    std::vector<double> heights, impacts;
    double height = 0;
    bool touched = false;
    run(scene, [&](const State<2>& state, const StepReport<2>& r) {
      if (r.active > 0 && !touched) impacts.push_back(state.time);
      if (r.active > 0 && !touched && impacts.size() > 1) heights.push_back(height);
      if (r.active > 0) height = 0;
      touched = r.active > 0;
      height = std::max(height, state.bodies[0].x[1] - 0.01);
    });
    ASSERT_GE(heights.size(), 2u);
    const double fall = std::sqrt(2 * 0.1 / kGravity);
    EXPECT_NEAR(impacts[0], fall, 1.1e-4);
    for (int p = 1; p <= 2; ++p) {
      EXPECT_NEAR(heights[p - 1] / (0.1 * std::pow(e, 2 * p)), 1, 0.02) << "e " << e;
      const double flight = impacts[p] - impacts[p - 1];
      EXPECT_NEAR(flight / (2 * std::pow(e, p) * fall), 1, 0.01) << "e " << e;
    }
  }
}

TEST(SpringDashpot, SlidingCylinderRollsAtTwoThirdsOfItsSpeed) {
  Scene<2> scene = on_floor(spring_scene(0.5, 0), 0.01, 1, Vec2(1, 0));
  scene.step = 1e-4;
  scene.num_steps = 1500;
  double rolls_from = -1;
  const State<2> end = run(scene, [&](const State<2>& state, const StepReport<2>&) {
    if (state.contacts.at(0).status == ContactStatus::kStick && rolls_from < 0 &&
        state.time > 0.01) {
      rolls_from = state.time;
    }
  });
  EXPECT_NEAR(end.bodies[0].v[0], 2.0 / 3, 1e-4);
  EXPECT_NEAR(end.bodies[0].spin * 0.01, -2.0 / 3, 1e-4);
  EXPECT_NEAR(rolls_from, 1 / (3 * 0.5 * kGravity), 2e-3);
  // From m v0²/2 to 3/4 m (2/3 v0)²: m v0²/6.
  EXPECT_NEAR(end.friction_loss, 1.0 / 6, 1e-4);
}

/// A cylinder on a plane at the given angle, gravity vertical; the plane falls to the right.
Scene<2> spring_incline(double angle, double mu) {
  Scene<2> scene = spring_scene(mu, 0.2);
  const Vec2 n(std::sin(angle), std::cos(angle));
  scene.walls = {half_space<2>(Vec2::Zero(), n)};
  scene.bodies = {round_body<2>(0.1 * n, 0.1, 2)};
  scene.num_steps = 400;
  return scene;
}

TEST(SpringDashpot, RollsWithoutSlipUpToTheThreshold) {
  // Below tan(angle) = 3 mu: a = 2/3 g sin(angle), friction m g sin/3; above it g (sin - mu cos).
  const double angle = 0.5;
  const Vec2 down(std::cos(angle), -std::sin(angle));
  const double time = 0.4;
  const State<2> rolls = run(spring_incline(angle, std::tan(angle) / 3 * 1.05));
  EXPECT_EQ(rolls.contacts.at(0).status, ContactStatus::kStick);
  EXPECT_NEAR(rolls.bodies[0].v.dot(down) / (2.0 / 3 * kGravity * std::sin(angle) * time), 1, 2e-3);
  EXPECT_NEAR(rolls.contacts[0].s_t / (2 * kGravity * 1e-3 * std::sin(angle) / 3), 1, 1e-3);
  const double mu = std::tan(angle) / 3 * 0.95;
  const State<2> slips = run(spring_incline(angle, mu));
  EXPECT_EQ(slips.contacts.at(0).status, ContactStatus::kSlip);
  EXPECT_NEAR(
      slips.bodies[0].v.dot(down) / (kGravity * (std::sin(angle) - mu * std::cos(angle)) * time), 1,
      2e-3);
}

TEST(SpringDashpot, AStickingContactHoldsItsPlaceAndPullsBack) {
  // A disk that cannot turn (huge inertia) is pulled aside by 0.3 of its weight on mu = 0.5: the
  // tangential spring carries it, x = F/k_t, and it stays there.
  Scene<2> scene = on_floor(spring_scene(0.5, 0.2), 0.1, 2);
  scene.bodies[0].inertia = 1e9;
  scene.gravity = Vec2(0.3 * kGravity, -kGravity);
  const State<2> end = run(scene, 2000);
  const SpringDashpotSetup setup = spring_dashpot_setup(scene);
  const double pull = 2 * 0.3 * kGravity;
  EXPECT_EQ(end.contacts.at(0).status, ContactStatus::kStick);
  EXPECT_NEAR(end.contacts.at(0).s_t / scene.step / pull, 1, 1e-9);
  EXPECT_NEAR(end.contacts.at(0).spring / (-pull / setup.tangential_stiffness), 1, 1e-9);
  EXPECT_NEAR(end.bodies[0].v.norm(), 0, 1e-9);
  // t = e3 x n points to -x; the disk's own way is in the spring, but for what slipped before the
  // disk was pressed on.
  EXPECT_GT(end.bodies[0].x[0], 0.99 * -end.contacts[0].spring);
}

TEST(SpringDashpot, ATangentialOscillationIsDampedByItsDashpot) {
  // Without slip m_t x'' = -k_t x - c_t x', where 1/m_t = 1/m + a²/I: m_t = m/3 for a disk, 2m/7 for
  // a sphere. c_t = 2 zeta √(k_t m_t), so that x' is exp(-2 pi zeta/d) of its first value after the
  // period 2 pi √(m_t/k_t)/d, d = √(1 - zeta²). The spring is slack then.
  const auto expect_decay = []<int D>(Scene<D> scene, double m_t) {
    scene.dem.stiffness = 1e5;
    scene.bodies[0].x[D - 1] -= 2 * kGravity / 1e5;  // carried from the start
    const double zeta = damping_of_restitution(0.5), d = std::sqrt(1 - zeta * zeta);
    const double k_t = spring_dashpot_setup(scene).tangential_stiffness;
    scene.step = 2 * kPi * std::sqrt(m_t / k_t) / d;
    scene.dem.substep = scene.step / 4000;
    const State<D> end = run(scene, 1);
    const double left = std::exp(-2 * kPi * zeta / d);
    EXPECT_NEAR(magnitude(end.contacts.at(0).u_t) / (1e-3 * left), 1, 0.01);
    EXPECT_NEAR(end.friction_loss / (0.5 * m_t * 1e-6 * (1 - left * left)), 1, 0.01);
  };
  expect_decay(on_floor(spring_scene(100, 0.5), 0.1, 2, Vec2(1e-3, 0)), 2.0 / 3);
  expect_decay(on_floor(spring_scene<3>(100, 0.5), 0.1, 2, Vec3(1e-3, 0, 0)), 4.0 / 7);
}

Scene<2> lattice(int columns, int rows, double mu) {
  Scene<2> scene = spring_scene(mu, 0.1);
  for (const Disk& d : rectangular_lattice(columns, rows, 0.01, Vec2::Zero())) {
    scene.bodies.push_back(round_body<2>(d.x, d.radius, 0.6));
  }
  scene.walls = trough(0.02 * columns);
  return scene;
}

TEST(SpringDashpot, SquareLatticeCarriesTheWeightAboveEachDisk) {
  Scene<2> scene = lattice(3, 8, 0);
  const State<2> end = run(scene, 500);
  int columns = 0;
  for (const ContactOutcome<2>& c : end.contacts) {
    if (std::abs(c.contact.n[1]) < 0.5) continue;
    // The disk above the contact and those on it: rows of height 0.02 m.
    const double top = std::max(end.bodies[c.contact.i].x[1],
                                c.contact.j < 24 ? end.bodies[c.contact.j].x[1] : 0.0);
    const double above = 8 - std::floor(top / 0.02);
    EXPECT_NEAR(c.s_n / scene.step / (above * 0.6 * kGravity), 1, 1e-6);
    EXPECT_LT(-c.contact.gap, 1.2e-3 * 0.01);  // the overlap aimed at is that of the floor
    ++columns;
  }
  EXPECT_EQ(columns, 24);
}

TEST(SpringDashpot, TheCriticalStepIsStable) {
  // One undamped disk on a plane: 2/w = 2 √(m/k). Pressed lattices with friction at 0.99 of the
  // critical step come to rest with the right weight: the bound holds for six contacts at once.
  Scene<2> one = on_floor(spring_scene(0, 1), 0.1, 2);
  one.dem.stiffness = 1e5;
  EXPECT_NEAR(spring_dashpot_setup(one).critical_step, 2 * std::sqrt(2 / 1e5), 1e-15);
  for (const bool triangular : {false, true}) {
    Scene<2> scene = lattice(6, 6, 0.4);
    if (triangular) {
      scene.bodies.clear();
      for (const Disk& d : triangular_lattice(6, 6, 0.01, Vec2::Zero())) {
        scene.bodies.push_back(round_body<2>(d.x, d.radius, 0.6));
      }
    }
    scene.dem.substep = 0.99 * spring_dashpot_setup(scene).critical_step;
    scene.step = scene.dem.substep;
    scene.num_steps = 15000;
    double kinetic = 0;
    const State<2> end =
        run(scene, [&](const State<2>&, const StepReport<2>& r) { kinetic = r.energy.kinetic; });
    EXPECT_LT(kinetic, 1e-12);
    double carried = 0;
    for (const ContactOutcome<2>& c : end.contacts) {
      const int wall = c.contact.j - static_cast<int>(scene.bodies.size());
      if (wall == 0) carried += c.s_n / scene.step;
      if (wall > 0) carried += c.s_t * c.contact.n[0] / scene.step;  // by friction
    }
    EXPECT_NEAR(carried / (0.6 * kGravity * static_cast<double>(scene.bodies.size())), 1, 1e-6);
  }
}

/// 60 disks fall into a box; lengths, masses and times in other units.
Scene<2> springs_in_a_falling_box(double length, double mass, double time) {
  Scene<2> scene = spring_scene(0.3, 0.3, 0.5);
  scene.gravity = Vec2(0, -kGravity * length / (time * time));
  scene.step = 5e-4 * time;
  for (const Disk& d : random_filling(60, {{0.01, 1}, {0.007, 1}}, 0.2, 0.02, 5, Vec2::Zero())) {
    scene.bodies.push_back(
        round_body<2>(d.x * length, d.radius * length, 2 * mass, Vec2(0.1, -0.5) * length / time));
  }
  scene.walls = trough(0.2 * length);
  scene.num_steps = 300;
  return scene;
}

TEST(SpringDashpot, TheLedgerCloses) {
  const Scene<2> scene = springs_in_a_falling_box(1, 1, 1);
  const State<2> start = initial_state(scene);
  const double initial = kinetic_energy(start) + potential_energy(start, scene.gravity);
  double shock = 0, friction = 0;
  int contacts = 0;
  run(scene, [&](const State<2>& state, const StepReport<2>& r) {
    const EnergyLedger& e = r.energy;
    EXPECT_LT(std::abs(e.imbalance), 1e-5 * initial);
    EXPECT_NEAR(e.kinetic + e.potential + e.elastic + e.friction_loss + e.shock_loss - e.wall_work,
                initial, 2e-4 * initial);
    EXPECT_LT(r.momentum_imbalance.norm(), 1e-12 * 60);
    EXPECT_GT(e.shock_loss, shock - 1e-4 * initial);
    EXPECT_GT(e.friction_loss, friction - 1e-4 * initial);
    shock = e.shock_loss;
    friction = e.friction_loss;
    for (const ContactOutcome<2>& c : state.contacts) {
      EXPECT_GE(c.s_n, 0);
      EXPECT_LE(std::abs(c.s_t), 0.3 * c.s_n * (1 + 1e-12));
    }
    contacts = r.contacts;
  });
  EXPECT_GT(shock, 0.1 * initial);
  EXPECT_GT(friction, 0.01 * initial);
  EXPECT_GT(contacts, 40);
}

TEST(SpringDashpot, ElasticDisksKeepTheirEnergy) {
  // No friction, e = 1: after 300 steps of 0.5 ms and hundreds of impacts, what the integration
  // itself lost stands in shock_loss.
  Scene<2> scene = springs_in_a_falling_box(1, 1, 1);
  scene.laws = {{.mu = 0, .e_n = 1, .e_t = 0}};
  const double kinetic = kinetic_energy(initial_state(scene));
  const State<2> end = run(scene);
  EXPECT_LT(std::abs(end.shock_loss), 0.01 * kinetic);
  EXPECT_EQ(end.friction_loss, 0);
}

TEST(SpringDashpot, UnitsDoNotChangeTheBits) {
  // Powers of two keep the mantissas (of time and length both even, for the square roots).
  const double length = 1024, mass = 0x1p-10, time = 128;
  const State<2> a = run(springs_in_a_falling_box(1, 1, 1)),
                 b = run(springs_in_a_falling_box(length, mass, time));
  ASSERT_EQ(a.contacts.size(), b.contacts.size());
  EXPECT_GT(a.contacts.size(), 40u);
  for (std::size_t k = 0; k < a.bodies.size(); ++k) {
    EXPECT_EQ(a.bodies[k].x * length, b.bodies[k].x);
    EXPECT_EQ(a.bodies[k].v * (length / time), b.bodies[k].v);
    EXPECT_EQ(a.bodies[k].spin / time, b.bodies[k].spin);
  }
  for (std::size_t k = 0; k < a.contacts.size(); ++k) {
    EXPECT_EQ(a.contacts[k].s_n * (mass * length / time), b.contacts[k].s_n);
  }
}

TEST(SpringDashpot, RestartGoesOnWithTheSameBits) {
  Scene<2> scene = springs_in_a_falling_box(1, 1, 1);
  scene.num_steps = 250;
  const State<2> end = expect_exact_restart(scene, 200);
  int stretched = 0;
  for (const ContactOutcome<2>& c : end.contacts) stretched += c.spring != 0;
  EXPECT_GT(stretched, 20);
}

TEST(SpringDashpot, MovingAndDrivenWallsDoTheirWork) {
  // A floor that moves up at 0.5 m/s lifts 2 kg by 0.5 m; 6 N on a wall of 1 kg and a disk of
  // 2 kg: a = 2 m/s², 4 N between them, and the wall's force does 6 N x 0.25 m in 0.5 s.
  Scene<2> lift = on_floor(spring_scene(0, 0.1), 0.1, 2, Vec2(0, 0.5));
  move_at(lift.walls[0], Vec2(0, 0.5));
  const State<2> lifted = run(lift, 1000);
  EXPECT_NEAR(lifted.walls[0].a[1], 0.5, 1e-12);
  EXPECT_NEAR(lifted.wall_work / (2 * kGravity * 0.5), 1, 1e-3);

  Scene<2> push = spring_scene(0, 0.1);
  push.gravity = Vec2::Zero();
  push.walls = {half_space<2>(Vec2::Zero(), Vec2(1, 0))};
  drive(push.walls[0], Vec2(1, 0), 1, 6);
  push.bodies = {round_body<2>(Vec2(0.1, 0), 0.1, 2)};
  const State<2> pushed = run(push, 500, [](const State<2>&, const StepReport<2>& r) {
    EXPECT_LT(r.momentum_imbalance.norm(), 1e-13);
    EXPECT_LT(std::abs(r.energy.imbalance), 1e-12);
  });
  EXPECT_NEAR(pushed.bodies[0].v[0], 1, 1e-3);
  EXPECT_NEAR(pushed.walls[0].v[0], 1, 1e-3);
  EXPECT_NEAR(pushed.contacts.at(0).s_n / push.step, 4, 1e-6);
  EXPECT_NEAR(pushed.wall_work, 6 * 0.25, 2e-3);
}

TEST(SpringDashpot, SegmentsArePushedOffOnBothSides) {
  Scene<2> scene = spring_scene(0, 0.5);
  scene.gravity = Vec2::Zero();
  scene.walls = {flat_floor<2>()};
  scene.walls[0].shape = Wall<2>::Shape::kSegment;
  scene.walls[0].a = Vec2(-1, 0);
  scene.walls[0].b = Vec2(1, 0);
  scene.bodies = {round_body<2>(Vec2(0, 0.11), 0.1, 2, Vec2(0, -1)),
                  round_body<2>(Vec2(0.5, -0.11), 0.1, 2, Vec2(0, 1))};
  const State<2> end = run(scene, 40);
  EXPECT_NEAR(end.bodies[0].v[1], 0.5, 0.01);
  EXPECT_NEAR(end.bodies[1].v[1], -0.5, 0.01);
}

TEST(SpringDashpot, AnUnstableSubstepIsRefused) {
  Scene<2> scene = head_on(0.5, 1e6);
  scene.dem.substep = 1.01 * spring_dashpot_setup(scene).critical_step;
  EXPECT_TRUE(
      says(refusal_of<std::invalid_argument>([&] { spring_dashpot_setup(scene); }), "unstable"));
  scene.dem.substep /= 1.02;
  EXPECT_LE(spring_dashpot_setup(scene).substep, scene.dem.substep);
}

// The same lid and the same floor, written with a factor of 100 and of 10.
TEST(SpringDashpot, TheDefaultStiffnessKnowsTheFactorsOfWalls) {
  const auto stiffness = [](const std::string& motion) {
    return spring_dashpot_setup(scene_of("gravity = [0, 0]\nmodel = 'dem'\n"
                                         "disks = [{position = [0, 0.1], radius = 0.1, mass = 1}]\n"
                                         "walls = [{point = [0, 0], normal = [0, 1]},\n"
                                         "{point = [0, 0.2], normal = [0, -1], " +
                                         motion + "}]\ntime = {step = 1e-3, steps = 9}\n"))
        .stiffness;
  };
  EXPECT_EQ(
      stiffness("direction = [0, -1], mass = 1, force = 1, times = [0, 1], factors = [2, -100]"),
      stiffness("direction = [0, -1], mass = 1, force = 100"));
  EXPECT_EQ(stiffness("velocity = [0, -1], times = [0, 1], factors = [10, 0]"),
            stiffness("velocity = [0, -10]"));
}

TEST(SpringDashpot, ASceneWithoutLoadNeedsAStiffness) {
  Scene<2> scene = head_on(0.5, 0);
  for (Disk& d : scene.bodies) d.v = Vec2::Zero();
  EXPECT_THROW(spring_dashpot_setup(scene), std::invalid_argument);
  scene.dem.stiffness = 1;
  EXPECT_EQ(spring_dashpot_setup(scene).stiffness, 1);
}

TEST(SpringDashpot, SaysWhatItCannotRepresent) {
  EXPECT_TRUE(spring_dashpot_setup(head_on(0.5, 1e6)).departures.empty());
  Scene<2> scene = head_on(0, 1e6);
  scene.laws[0].e_t = 0.7;
  const auto departures = spring_dashpot_setup(scene).departures;
  ASSERT_EQ(departures.size(), 2u);
  EXPECT_TRUE(says(departures[0], "e_n = 0"));
  EXPECT_TRUE(says(departures[1], "e_t = 0.7"));
}

void expect_failure(const Scene<2>& scene, double most_created, std::function<bool()> cut_short,
                    StepFailure::Kind kind, const std::string& message) {
  SpringDashpotStepper stepper(scene, std::move(cut_short), most_created);
  State<2> state = initial_state(scene);
  const auto failure = caught<StepFailure>([&] {
    for (int k = 0; k < scene.num_steps; ++k) stepper.advance(state);
  });
  ASSERT_TRUE(failure) << message;
  EXPECT_EQ(failure->kind, kind);
  EXPECT_TRUE(says(failure->what(), message));
  EXPECT_TRUE(says(failure->what(), "step " + std::to_string(state.step + 1) + " "));
}

TEST(SpringDashpot, FailuresNameTheRemedy) {
  // 2 m/s on 100 N/m: the overlap v √(m/k) would be 0.17 m.
  Scene<2> soft = head_on(0.5, 100);
  soft.step = 1e-3;
  expect_failure(soft, 0.1, {}, StepFailure::Kind::kNumerical, "too low for this load, raise it");
  // An elastic impact in few substeps makes and loses energy on its way.
  Scene<2> coarse = head_on(1, 1e6);
  coarse.step = coarse.dem.substep = 0.9 * spring_dashpot_setup(coarse).critical_step;
  coarse.bodies[1].x[0] = 0.2;
  expect_failure(coarse, 1e-3, {}, StepFailure::Kind::kNumerical, "shorten them");
  Scene<2> many = head_on(0.5, 1e6);
  many.step = 1e-3;
  many.dem.substep = 1e-6;
  expect_failure(
      many, 0.1, [] { return true; }, StepFailure::Kind::kCutShort, "64 of 1000");
}

// Disks of 0.1 m/s and 1e6 m/s, substeps of 1 us: 1 m in a substep, ten radii.
TEST(SpringDashpot, WhatGoesThroughInASubstepIsSeen) {
  Scene<2> scene = spring_scene(0, 0);
  scene.gravity = Vec2::Zero();
  scene.dem.stiffness = 1e4;
  scene.dem.substep = scene.step = 1e-6;
  scene.bodies = {round_body<2>(Vec2(-0.3, 0), 0.1, 1, Vec2(1e6, 0)),
                  round_body<2>(Vec2(0, 0), 0.1, 1)};
  SpringDashpotStepper takes(scene), refuses(scene);
  State<2> state = initial_state(scene), kept = state;
  const StepReport<2> report = takes.advance(state);
  EXPECT_EQ(report.passages, 1);
  EXPECT_EQ(report.passage, "disk 0 went through disk 1 at 1e+06 m/s");
  EXPECT_NEAR(report.travel, 10, 1e-9);
  refuses.refuse_passages();
  EXPECT_THROW(refuses.advance(kept), StepFailure);
  EXPECT_EQ(kept.bodies[0].x, scene.bodies[0].x);
  // In ten times shorter ones it is stopped, or fails for its overlap.
  scene.bodies[0].v = Vec2(1e5, 0);
  SpringDashpotStepper slower(scene);
  state = initial_state(scene);
  EXPECT_EQ(slower.advance(state).passages, 0);
}

TEST(SpringDashpot, SpheresMeetHeadOnAlongAnyDirection) {
  // As in the plane: 1 and 3 kg, 2 m/s, k = 1e6 N/m.
  for (const double e : {1.0, 0.5, 0.2}) {
    for (const Vec3& along : {Vec3(1, 0, 0), Vec3(0.6, 0, -0.8), Vec3(-2, 3, 6).normalized()}) {
      const State<3> end = run(head_on<3>(e, 1e6, along), 800);
      const double measured = (end.bodies[1].v - end.bodies[0].v).dot(along) / 2;
      EXPECT_NEAR(measured, e, 0.01);
      EXPECT_NEAR(end.shock_loss, 0.5 * 0.75 * 4 * (1 - measured * measured), 1e-9);
      EXPECT_NEAR(end.friction_loss, 0, 1e-15);
      EXPECT_TRUE(end.contacts.empty());
    }
  }
}

TEST(SpringDashpot, SlidingSphereRollsAtFiveSeventhsOfItsSpeed) {
  // m v - I w/a keeps its value and I = 2/5 m a²: v0 = v (1 + 2/5). It slides for 2 v0/(7 mu g) =
  // 0.058 s. Friction takes m v0²/2 (1 - 5/7) = m v0²/7. The axis of the spin is n x v.
  for (const Vec3& heading : {Vec3(1, 0, 0), Vec3(0.6, -0.8, 0)}) {
    Scene<3> scene = on_floor(spring_scene<3>(0.5, 0), 0.01, 1, heading);
    scene.step = 1e-4;
    const State<3> end = run(scene, 1500);
    EXPECT_NEAR((end.bodies[0].v - 5.0 / 7 * heading).norm(), 0, 1e-4);
    EXPECT_NEAR((0.01 * end.bodies[0].spin - 5.0 / 7 * Vec3(0, 0, 1).cross(heading)).norm(), 0,
                1e-4);
    EXPECT_NEAR(end.friction_loss, 1.0 / 7, 1e-4);
    EXPECT_EQ(end.contacts.at(0).status, ContactStatus::kStick);
  }
}

TEST(SpringDashpot, ASphereRollsRoundInAPipeForEver) {
  // Without gravity a sphere that rolls round inside a pipe of radius R goes on for ever: the
  // normal turns, and friction does no work. Its way is v t; elastic, so energy is kept.
  Scene<3> scene = spring_scene<3>(0.8, 1);
  scene.gravity.setZero();
  scene.dem.stiffness = 1e6;
  scene.walls = {{.shape = Wall<3>::Shape::kHollowCircle, .radius = 0.1}};
  const double a = 0.02, v = 1, arm = 0.08;
  // k d = m v²/(R - a + d): the overlap of the circular way.
  const double overlap = 2 * v * v / (1e6 * arm);
  scene.bodies = {
      round_body<3>(Vec3(arm + overlap, 0, 0), a, 2, Vec3(0, v, 0), Vec3(0, 0, -v / a))};
  scene.step = 1e-4;
  const State<3> end = run(scene, 5000);
  const double angle = v * 0.5 / (arm + overlap);
  EXPECT_NEAR(
      (end.bodies[0].x / (arm + overlap) - Vec3(std::cos(angle), std::sin(angle), 0)).norm(), 0,
      2e-3);
  EXPECT_NEAR(end.bodies[0].v.norm(), v, 1e-4);
  EXPECT_NEAR(end.friction_loss, 0, 1e-6);
}

TEST(SpringDashpot, SpheresHoldTheirPlaceAndGoOnWithTheSameBits) {
  // Four spheres carry a fifth; a restart from the files is the state itself.
  Scene<3> scene = spring_scene<3>(0.5, 0.3);
  scene.walls = {flat_floor<3>()};
  const double r = 0.1, up = r * std::sqrt(2.0);
  for (const double x : {-r, r}) {
    for (const double y : {-r, r}) scene.bodies.push_back(round_body<3>(Vec3(x, y, r), r, 1));
  }
  scene.bodies.push_back(round_body<3>(Vec3(0, 0, r + up), r, 1));
  scene.num_steps = 300;
  const State<3> state = expect_exact_restart(scene, 200);
  int stretched = 0;
  for (const ContactOutcome<3>& c : state.contacts) stretched += c.spring.norm() > 0;
  EXPECT_GE(stretched, 4);
  // Each floor contact carries 5/4 of a weight; the four upper ones the fifth sphere.
  double floor = 0;
  for (const ContactOutcome<3>& c : state.contacts) floor += c.contact.j == 5 ? c.s_n : 0;
  EXPECT_NEAR(floor / (5 * kGravity * scene.step), 1, 1e-3);
}

}  // namespace
}  // namespace bipot
