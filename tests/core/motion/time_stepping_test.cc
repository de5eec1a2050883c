#include "core/motion/time_stepping.h"

#include "core/base/portable_random.h"
#include "core/scene/generators.h"
#include "tests/support/scene_run.h"
#include "tests/support/small_scenes.h"

namespace bipot {
namespace {

Scene<2> one_material(double mu, double e_n = 0, double e_t = 0) {
  Scene<2> scene = heavy_scene({.mu = mu, .e_n = e_n, .e_t = e_t});
  scene.solver.name = "pgs";
  scene.solver.tol = 1e-10;
  return scene;
}

/// A disk that touches the floor.
template <class... Motion>
Scene<2> lying(double mu, const Motion&... motion) {
  Scene<2> scene = on_floor(one_material(mu), 0.1, 2, motion...);
  scene.contact_distance = 1e-6;
  return scene;
}

/// A cylinder on a plane at the given angle, gravity vertical; the plane falls to the right.
Scene<2> incline(double angle, double mu) {
  Scene<2> scene = one_material(mu);
  const Vec2 n(std::sin(angle), std::cos(angle));
  scene.walls = {half_space<2>(Vec2::Zero(), n)};
  scene.bodies = {round_body<2>(0.1 * n, 0.1, 2)};
  scene.contact_distance = 1e-6;
  scene.num_steps = 200;
  return scene;
}

TEST(TimeStepping, FreeFlightIsExact) {
  // The mid-point rule is exact for a parabola.
  Scene<2> scene = one_material(0.3);
  scene.bodies = {round_body<2>(Vec2(1, 2), 0.1, 2, Vec2(3, 4), 5)};
  const State<2> end = solved_run(scene, 1000);
  EXPECT_DOUBLE_EQ(end.time, 1);
  EXPECT_NEAR(end.bodies[0].x[0], 1 + 3, 1e-12);
  EXPECT_NEAR(end.bodies[0].x[1], 2 + 4 - kGravity / 2, 1e-12);
  EXPECT_NEAR(end.bodies[0].v[1], 4 - kGravity, 1e-12);
  EXPECT_NEAR(end.bodies[0].angle, 5, 1e-12);
  EXPECT_EQ(end.bodies[0].spin, 5);
}

TEST(TimeStepping, DiskLeavesThePlane) {
  Scene<2> scene = lying(0.5, Vec2(0, 1), 3);
  scene.contact_distance = 0.01;
  const State<2> end = solved_run(scene, 1, [](const State<2>&, const StepReport<2>& r) {
    EXPECT_EQ(r.contacts, 1);
    EXPECT_EQ(r.active, 0);
    EXPECT_EQ(r.iterations, 0);
  });
  EXPECT_EQ(end.contacts[0].status, ContactStatus::kTakeOff);
  EXPECT_DOUBLE_EQ(end.bodies[0].v[1], 1 - kGravity * 1e-3);
  EXPECT_EQ(end.bodies[0].spin, 3);
}

TEST(TimeStepping, CylinderRollsDownAShallowIncline) {
  // tan(angle) < 3 mu: a = 2/3 g sin(angle), friction g sin/3 per unit mass < mu g cos.
  const double angle = 0.5, mu = std::tan(angle) / 3 * 1.05;
  const State<2> end =
      solved_run(incline(angle, mu), [](const State<2>& state, const StepReport<2>&) {
        EXPECT_EQ(state.contacts.at(0).status, ContactStatus::kStick);
      });
  const Vec2 down(std::cos(angle), -std::sin(angle));
  const double speed = 2.0 / 3.0 * kGravity * std::sin(angle) * 0.2;
  EXPECT_NEAR(end.bodies[0].v.dot(down) / speed, 1, 1e-8);
  EXPECT_NEAR(end.bodies[0].spin * 0.1, -speed, 1e-8);  // clockwise, without slip
  // Force per step: s_n = m g h cos, s_t = m g h sin / 3 up the slope (t = e3 x n is up).
  EXPECT_NEAR(end.contacts[0].s_n / (2 * kGravity * 1e-3 * std::cos(angle)), 1, 1e-8);
  EXPECT_NEAR(end.contacts[0].s_t / (2 * kGravity * 1e-3 * std::sin(angle) / 3), 1, 1e-8);
}

TEST(TimeStepping, CylinderSlipsDownASteepIncline) {
  // tan(angle) > 3 mu: a = g (sin - mu cos), angular acceleration 2 mu g cos / radius.
  const double angle = 0.5, mu = std::tan(angle) / 3 * 0.95;
  const State<2> end =
      solved_run(incline(angle, mu), [](const State<2>& state, const StepReport<2>&) {
        EXPECT_EQ(state.contacts.at(0).status, ContactStatus::kSlip);
      });
  const Vec2 down(std::cos(angle), -std::sin(angle));
  EXPECT_NEAR(
      end.bodies[0].v.dot(down) / (kGravity * (std::sin(angle) - mu * std::cos(angle)) * 0.2), 1,
      1e-8);
  EXPECT_NEAR(end.bodies[0].spin / (-2 * mu * kGravity * std::cos(angle) / 0.1 * 0.2), 1, 1e-8);
}

TEST(TimeStepping, SpinningDiskSetOnAPlaneSpinsDownAndRollsOff) {
  // mu m g acts on the rim: a = mu g, spin falls by 2 mu g / radius; rolling at v = |w| radius / 3
  // after t = |w| radius / (3 mu g).
  double rolls_from = -1;
  const auto onlooker = [&](const State<2>& state, const StepReport<2>&) {
    const bool slips = state.contacts.at(0).status == ContactStatus::kSlip;
    if (!slips && rolls_from < 0) rolls_from = state.time;
    if (slips) {
      EXPECT_NEAR(state.bodies[0].v[0], 0.2 * kGravity * state.time, 1e-8);
    }
  };
  const State<2> end = solved_run<2>(lying(0.2, Vec2(0, 0), -20), 400, onlooker);
  EXPECT_NEAR(rolls_from, 20 * 0.1 / (3 * 0.2 * kGravity), 2e-3);
  EXPECT_NEAR(end.bodies[0].v[0], 2.0 / 3, 1e-8);
  EXPECT_NEAR(end.bodies[0].spin, -20.0 / 3, 1e-7);
}

Scene<2> row_of_disks(int count, double e_n, const Vec2& first_velocity) {
  Scene<2> scene = one_material(0, e_n);
  scene.gravity = Vec2::Zero();
  for (int k = 0; k < count; ++k) scene.bodies.push_back(round_body<2>(Vec2(0.2 * k, 0), 0.1, 2));
  scene.bodies[0].v = first_velocity;
  scene.contact_distance = 1e-6;
  return scene;
}

TEST(TimeStepping, RowJammedBetweenTwoWallsHasASolution) {
  // Fixed walls, one e: v⁺ = -e v⁻ solves every contact at once (all mean velocities vanish).
  for (const double e_n : {0.0, 0.5, 1.0}) {
    Scene<2> scene = row_of_disks(6, e_n, Vec2::Zero());
    scene.walls = {half_space<2>(Vec2(-0.1, 0), Vec2(1, 0)),
                   half_space<2>(Vec2(1.1, 0), Vec2(-1, 0))};
    PortableRandom draw(3);
    for (Disk& d : scene.bodies) d.v = Vec2(1e-4 * draw.symmetric(), 0);
    // A little overlap everywhere keeps all seven contacts candidates at mid-step.
    scene.contact_distance = 1e-5;
    const State<2> end = solved_run(scene, 1, [](const State<2>&, const StepReport<2>& r) {
      EXPECT_EQ(r.contacts, 7);
      EXPECT_LE(r.error.guarded(), 1e-10);
    });
    for (std::size_t k = 0; k < scene.bodies.size(); ++k) {
      EXPECT_NEAR(end.bodies[k].v[0], -e_n * scene.bodies[k].v[0], 1e-4 * 1e-6) << "e_n " << e_n;
    }
  }
}

TEST(TimeStepping, MovingWallCarriesADisk) {
  Scene<2> scene = lying(0, Vec2(0, 0.5));
  move_at(scene.walls[0], Vec2(0, 0.5));
  const State<2> end = solved_run(scene, 100);
  EXPECT_NEAR(end.bodies[0].x[1], 0.1 + 0.05, 1e-12);
  EXPECT_NEAR(end.walls[0].a[1], 0.05, 1e-14);
  EXPECT_NEAR(end.wall_work, 2 * kGravity * 0.05, 1e-8);  // lifts m g
}

TEST(TimeStepping, DrivenWallAcceleratesWithWhatItPushes) {
  // 6 N on a wall of 1 kg and a disk of 2 kg, no gravity: a = 2 m/s².
  Scene<2> scene = one_material(0);
  scene.gravity = Vec2::Zero();
  scene.walls = {half_space<2>(Vec2::Zero(), Vec2(1, 0))};
  drive(scene.walls[0], Vec2(1, 0), 1, 6);
  scene.bodies = {round_body<2>(Vec2(0.1, 0), 0.1, 2)};
  scene.contact_distance = 1e-6;
  const State<2> end = solved_run(scene, 500);
  EXPECT_NEAR(end.bodies[0].v[0], 1, 1e-8);
  EXPECT_NEAR(end.walls[0].v[0], 1, 1e-8);
  EXPECT_NEAR(end.bodies[0].x[0], 0.1 + 0.25, 1e-8);
  EXPECT_NEAR(end.wall_work, 6 * 0.25, 1e-7);
  EXPECT_NEAR(end.contacts[0].s_n / scene.step, 4, 1e-7);
}

TEST(TimeStepping, FrictionDissipatesWhatTheSlidingCylinderLoses) {
  // From v0 to 2/3 v0 with the rolling energy: loss m v0²/2 - 3/4 m (2/3 v0)² = m v0²/6.
  const State<2> end = solved_run<2>(lying(0.5, Vec2(1, 0)), 150);
  EXPECT_NEAR(end.friction_loss, 2.0 / 6, 1e-8);
  EXPECT_NEAR(end.shock_loss, 0, 1e-8);
}

TEST(TimeStepping, WarmStartIsCarriedByPair) {
  // The solver sees, at every step, the impulses of the step before at the contacts that stay:
  // also when others come and go and the contacts' numbers shift.
  Scene<2> scene = one_material(0.4, 0.2, 0.6);
  for (const Disk& d : random_filling(60, {{0.01, 1}, {0.007, 1}}, 0.2, 0.02, 3, Vec2::Zero())) {
    scene.bodies.push_back(round_body<2>(d.x, d.radius, 2, Vec2(0, -0.5)));
  }
  scene.walls = trough(0.2);
  State<2> state = initial_state(scene);
  Vector start;
  const StepSolver inner = make_step_solver(*find_solver("pgs"), {.tol = 1e-4});
  TimeStepper<2> stepper(scene, [&](const ContactProblem& p, const Vector& s0) {
    start = p.row_scale.size() == 0 ? s0 : Vector(s0.cwiseQuotient(p.row_scale));
    return inner(p, s0);
  });
  int carried = 0, fresh = 0, lost = 0;
  for (int step = 0; step < 150; ++step) {
    std::map<std::pair<int, int>, Vec2> before;
    for (const ContactOutcome<2>& c : state.contacts) {
      before[{c.contact.i, c.contact.j}] = Vec2(c.s_n, c.s_t);
    }
    stepper.advance(state);
    ASSERT_EQ(start.size(), 2 * static_cast<Eigen::Index>(state.contacts.size()));
    int found = 0;
    for (std::size_t c = 0; c < state.contacts.size(); ++c) {
      const Contact<2>& contact = state.contacts[c].contact;
      const auto it = before.find({contact.i, contact.j});
      const Vec2 expected = it == before.end() ? Vec2(0, 0) : it->second;
      EXPECT_LT((start.segment<2>(2 * static_cast<Eigen::Index>(c)) - expected).norm(),
                1e-15 * (1 + expected.norm()));
      if (it == before.end()) {
        ++fresh;
      } else {
        ++found;
        carried += expected[0] > 0;
      }
    }
    lost += static_cast<int>(before.size()) - found;
  }
  EXPECT_GT(carried, 100);
  EXPECT_GT(fresh, 30);
  EXPECT_GT(lost, 5);
}

TEST(TimeStepping, WithoutWarmStartTheSolverGetsNoStart) {
  Scene<2> scene = row_of_disks(2, 0, Vec2(1, 0));
  scene.solver.warm_start = false;
  State<2> state = initial_state(scene);
  TimeStepper<2> stepper(scene, [](const ContactProblem& p, const Vector& s0) {
    EXPECT_EQ(s0.size(), 0);
    return StepSolution{.converged = true, .s = Vector::Zero(p.num_rows())};
  });
  stepper.advance(state);
  stepper.advance(state);
}

TEST(TimeStepping, FailureLeavesTheStateAsItWas) {
  const Scene<2> scene = row_of_disks(3, 0, Vec2(1, 0));
  State<2> state = initial_state(scene);
  state.step = 7;
  const auto expect_failure = [&](const StepSolver& solver, const std::string& message) {
    TimeStepper<2> stepper(scene, solver);
    const std::string said = refusal_of<StepFailure>([&] { stepper.advance(state); });
    EXPECT_TRUE(says(said, message));
    EXPECT_TRUE(says(said, "step 8"));
    EXPECT_EQ(state.step, 7);
    EXPECT_EQ(state.time, 0);
    EXPECT_TRUE(state.contacts.empty());
    EXPECT_EQ(bits_of_bodies(state), bits_of_bodies(initial_state(scene)));
  };
  expect_failure(
      [](const ContactProblem&, const Vector&) {
        return StepSolution{.failed = true, .message = "the pivot broke"};
      },
      "the pivot broke");
  expect_failure(
      [](const ContactProblem& p, const Vector&) {
        return StepSolution{.converged = true, .s = Vector::Constant(p.num_rows(), kNaN)};
      },
      "no finite impulse");
  expect_failure([](const ContactProblem& p,
                    const Vector&) { return StepSolution{.s = Vector::Zero(p.num_rows() + 1)}; },
                 "no finite impulse");
}

TEST(TimeStepping, AStepThatDidNotConvergeIsTakenAndSaysSo) {
  Scene<2> scene = row_of_disks(8, 0, Vec2(1, 0));
  SolverOptions options{.max_iterations = 1};
  State<2> state = initial_state(scene);
  TimeStepper<2> stepper(scene, make_step_solver(*find_solver("pgs"), options));
  const StepReport<2> report = stepper.advance(state);
  EXPECT_FALSE(report.converged);
  EXPECT_TRUE(says(report.message, "iteration limit"));
  EXPECT_FALSE(says(report.message, "limit: iteration limit"));
  EXPECT_GT(report.error.guarded(), options.tol);
  EXPECT_EQ(state.step, 1);
}

/// 80 disks fall into a box; lengths, masses and times in other units.
Scene<2> falling_box(double length, double mass, double time) {
  Scene<2> scene = one_material(0.3, 0.2, 0.5);
  scene.gravity = Vec2(0, -kGravity * length / (time * time));
  scene.step = 5e-4 * time;
  for (const Disk& d : random_filling(80, {{0.01, 1}, {0.007, 1}}, 0.2, 0.02, 5, Vec2::Zero())) {
    scene.bodies.push_back(
        round_body<2>(d.x * length, d.radius * length, 2 * mass, Vec2(0, -0.5 * length / time)));
  }
  scene.walls = trough(0.2 * length);
  scene.contact_distance = 1e-8 * length;
  scene.num_steps = 120;
  scene.solver.tol = 1e-6;
  return scene;
}

TEST(TimeStepping, TheSameSceneGivesTheSameBits) {
  const Scene<2> scene = falling_box(1, 1, 1);
  const State<2> first = solved_run(scene);
  EXPECT_GT(first.contacts.size(), 50u);
  EXPECT_EQ(bits_of_state(first), bits_of_state(solved_run(scene)));
}

TEST(TimeStepping, UnitsDoNotChangeTheIterations) {
  // Powers of two: the same mantissas, hence the same bits in every decision.
  for (const char* solver : {"pgs", "uzawa"}) {
    std::vector<int> iterations[2];
    double energy[2] = {0, 0};
    const double length = 1024, mass = 0x1p-10, time = 128;
    for (int k : {0, 1}) {
      const Scene<2> scene = k == 0 ? falling_box(1, 1, 1) : falling_box(length, mass, time);
      solved_run(
          scene,
          [&](const State<2>&, const StepReport<2>& r) {
            iterations[k].push_back(r.iterations);
            energy[k] = r.energy.kinetic;
          },
          solver);
    }
    EXPECT_EQ(iterations[0], iterations[1]) << solver;
    EXPECT_GT(*std::max_element(iterations[0].begin(), iterations[0].end()), 20);
    EXPECT_NEAR(energy[1] / (mass * length * length / (time * time)), energy[0], 1e-12 * energy[0]);
  }
}

TEST(TimeStepping, UnitsOfAnotherBaseChangeTheIterationsByOneAtMost) {
  // m, kg, s -> mm, g, ms on the first, impact-rich steps, before rounding can grow.
  std::vector<int> iterations[2];
  for (int k : {0, 1}) {
    Scene<2> scene = k == 0 ? falling_box(1, 1, 1) : falling_box(1000, 1000, 1000);
    solved_run(scene, 30, [&](const State<2>&, const StepReport<2>& r) {
      iterations[k].push_back(r.iterations);
    });
  }
  for (std::size_t step = 0; step < iterations[0].size(); ++step) {
    EXPECT_NEAR(iterations[0][step], iterations[1][step], 1) << step;
  }
}

TEST(TimeStepping, PenetrationIsThatOfTheMidPoint) {
  Scene<2> scene = on_floor(one_material(0), 0.1, 2, Vec2(0, -1));
  scene.gravity = Vec2::Zero();
  solved_run(scene, 1, [](const State<2>&, const StepReport<2>& r) {
    EXPECT_NEAR(r.penetration, 5e-4, 1e-15);
  });
}

}  // namespace
}  // namespace bipot
