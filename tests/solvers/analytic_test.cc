// Scenes with a solution by hand: Tables 1 and 2 and the square lattice of Fig. 10 of the paper,
// bars with joints.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/scene_files/scene_file.h"
#include "solvers/registry.h"
#include "solvers/solve.h"
#include "tests/support/scene_run.h"
#include "tests/support/source_folder.h"

namespace bipot {
namespace {

constexpr double kG = 9.81;

Scene<2> shipped(const std::string& name) {
  return read_scene(source_folder().string() + "/data/scenes/" + name + ".toml");
}

/// Bounces of a dropped ball, measured as on a film: each flight is the parabola through the state
/// after the impact, its height and its duration between the two crossings of the gap's zero.
struct Bounces {
  std::vector<double> height, flight_time;
  int max_iterations = 0;
};

Bounces bounce(double e_n, double h) {
  Scene<2> scene = shipped("bouncing_ball");
  scene.laws[0].e_n = e_n;
  scene.step = h;
  scene.num_steps = static_cast<int>(std::ceil(0.5 / h));
  Bounces result;
  bool touched = false;
  solved_run(scene, [&](const State<2>& state, const StepReport<2>& report) {
    const Disk& ball = state.bodies[0];
    const double gap = ball.x[1] - ball.radius;
    if (report.active > 0) {
      touched = true;
      result.max_iterations = std::max(result.max_iterations, report.iterations);
    } else if (touched) {
      touched = false;
      const double v = ball.v[1];
      const double rise = gap + v * v / (2 * kG);
      result.height.push_back(rise);
      result.flight_time.push_back(2 * std::sqrt(2 * rise / kG));
    }
  });
  return result;
}

// h_p = h0 e^{2p}, t_p = 2 e^p sqrt(2 h0 / g) with h0 = 0.1 m.
void expect_table_1(double e_n) {
  const Bounces measured = bounce(e_n, 1e-4);
  ASSERT_GE(measured.height.size(), e_n == 1 ? 1u : 2u);
  for (std::size_t p = 1; p <= std::min<std::size_t>(2, measured.height.size()); ++p) {
    const double height = 0.1 * std::pow(e_n, 2.0 * p);
    const double time = 2 * std::pow(e_n, p) * std::sqrt(0.2 / kG);
    EXPECT_NEAR(measured.height[p - 1] / height, 1, 5e-4) << "bounce " << p;
    EXPECT_NEAR(measured.flight_time[p - 1] / time, 1, 5e-4) << "bounce " << p;
  }
  EXPECT_LE(measured.max_iterations, 2);
  EXPECT_GE(measured.max_iterations, 1);
}

TEST(Table1, ElasticBallBouncesToItsHeight) { expect_table_1(1.0); }
TEST(Table1, InelasticBallLosesItsShare) { expect_table_1(0.9); }

TEST(Table1, HeightConvergesWithTheTimeStep) {
  // The impact is placed within a step of |v| h of the plane: first order in h, erratic in sign.
  const double exact = 0.1 * 0.81;
  for (const double h : {1e-3, 1e-4, 1e-5, 1e-6}) {
    const double error = std::abs(bounce(0.9, h).height.at(0) / exact - 1);
    EXPECT_LT(error, 0.35 * 1.4 * h / 0.1) << "h = " << h;
  }
}

TEST(Table2, CylinderSlidesThenRollsAtTwoThirds) {
  Scene<2> scene = shipped("sliding_cylinder");
  double rolls_from = -1;
  const State<2> end = solved_run(scene, [&](const State<2>& state, const StepReport<2>&) {
    if (rolls_from < 0 && state.contacts.at(0).status == ContactStatus::kStick) {
      rolls_from = state.time;
    }
  });
  EXPECT_NEAR(end.bodies[0].v[0], 2.0 / 3.0, 1e-6);
  EXPECT_NEAR(end.bodies[0].v[0], -end.bodies[0].spin * 0.01, 1e-9);  // rolling: v = -a w
  EXPECT_NEAR(rolls_from, 1 / (3 * 0.5 * kG), 1e-4);
}

TEST(SquareLattice, FrictionlessColumnsCarryTheirWeight) {
  const Scene<2> scene = shipped("square_lattice");
  const double weight = scene.bodies[0].mass * kG;
  const State<2> end = solved_run(scene, [&](const State<2>& state, const StepReport<2>& report) {
    EXPECT_EQ(report.contacts, 10 * 10 + 10 * 9 + 2 * 10);
    for (const ContactOutcome<2>& c : state.contacts) {
      const bool vertical = std::abs(c.contact.n[1]) > 0.5;
      if (!vertical) continue;
      // Contact i of row r (from the bottom) carries the disks of rows r.. above it.
      const int upper = c.contact.j < 100 ? std::max(c.contact.i, c.contact.j) : c.contact.i;
      const int carried = 10 - upper / 10;
      EXPECT_NEAR(c.s_n / scene.step / (carried * weight), 1, 1e-6) << "disk " << upper;
    }
  });
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    EXPECT_LT((end.bodies[i].x - scene.bodies[i].x).norm(), 1e-9 * scene.bodies[i].radius);
  }
}

TEST(SquareLattice, WithFrictionEveryDiskIsInEquilibrium) {
  Scene<2> scene = shipped("square_lattice");
  scene.laws[0].mu = 0.3;
  scene.num_steps = 1;
  const State<2> end = solved_run(scene);
  const double load = scene.bodies[0].mass * kG * scene.step;
  std::vector<Vec2> force(scene.bodies.size(), Vec2(0, -load));
  std::vector<double> moment(scene.bodies.size(), 0.0);
  Vec2 walls = Vec2::Zero();
  for (const ContactOutcome<2>& c : end.contacts) {
    const Vec2 t(-c.contact.n[1], c.contact.n[0]);
    const Vec2 impulse = c.s_n * c.contact.n + c.s_t * t;
    force[c.contact.i] += impulse;
    moment[c.contact.i] -= c.s_t;
    if (c.contact.j < 100) {
      force[c.contact.j] -= impulse;
      moment[c.contact.j] -= c.s_t;
    } else {
      walls += impulse;
    }
    EXPECT_LE(std::abs(c.s_t), 0.3 * c.s_n * (1 + 1e-12));
  }
  for (std::size_t i = 0; i < force.size(); ++i) {
    EXPECT_LT(force[i].norm(), 1e-6 * load) << i;
    EXPECT_LT(std::abs(moment[i]), 1e-6 * load) << i;
  }
  EXPECT_NEAR(walls[1] / (100 * load), 1, 1e-7);
  EXPECT_NEAR(walls[0] / (100 * load), 0, 1e-7);
}

// Four bars of 1 kg and 1 m are pinned to a square, which stands on a corner and slides at 0.5 m/s.
// By symmetry s_n moves it by V and changes the angle of its bars by a', the friction mu s_n against
// the motion slows it by U and turns it by w. Both rotations have the inertia 4 (1/12 + 1/4) = 4/3
// kg m², and the corner the lever r = 1/√2 m. So W is diagonal, 1/4 + r²/(4/3) = 5/8 twice, and
// s_n = 8/5 g h. The bars at the corner turn by w ± a' = -(mu ± 1) s_n r/(4/3).
// A pin forbids motion in both directions: two pairs of opposite contacts without friction.
TEST(FourBars, JointsArePairsOfOppositeContacts) {
  const double impulse = 1.6 * kG * 1e-3, mu = 0.3, r = std::sqrt(0.5);
  const Vec2 vertices[] = {{0, -r}, {r, 0}, {0, r}, {-r, 0}};  // bar k ends at k and k + 1
  Eigen::MatrixXd wrenches = Eigen::MatrixXd::Zero(12, 2 * 17);
  const auto add = [&](int contact, int bar, int vertex, const Vec2& normal) {
    const Vec2 arm = vertices[vertex] - 0.5 * (vertices[bar] + vertices[(bar + 1) % 4]);
    const Vec2 axes[] = {normal, Vec2(-normal[1], normal[0])};
    for (int k = 0; k < 2; ++k) {
      wrenches.col(2 * contact + k).segment<3>(3 * bar) =
          Eigen::Vector3d(axes[k][0], axes[k][1], arm[0] * axes[k][1] - arm[1] * axes[k][0]);
    }
  };
  add(0, 0, 0, Vec2(0, 1));
  int contact = 0;
  for (int k = 0; k < 4; ++k) {
    for (const Vec2& normal : {Vec2(1, 0), Vec2(-1, 0), Vec2(0, 1), Vec2(0, -1)}) {
      add(++contact, k, k, normal);
      add(contact, (k + 3) % 4, k, -normal);
    }
  }
  Vector mass(12);
  ContactProblem p;
  p.v_free.resize(12);
  for (int bar = 0; bar < 4; ++bar) {
    mass.segment<3>(3 * bar) << 1, 1, 1.0 / 12;
    p.v_free.segment<3>(3 * bar) << 0.5, -kG * 1e-3, 0;
  }
  p.A = Eigen::MatrixXd(mass.asDiagonal()).sparseView();
  p.H = wrenches.sparseView();
  p.u_free = wrenches.transpose() * p.v_free;
  p.mu = Vector::Zero(17);
  p.mu[0] = mu;
  for (const SolverEntry& entry : solver_table()) {
    const SolveResult result = solve(entry, p, {.tol = 1e-10, .time_limit = 20});
    EXPECT_EQ(result.status, SolveStatus::kConverged) << entry.name << ": " << result.message;
    EXPECT_NEAR(result.s[0], impulse, 1e-7 * impulse) << entry.name;
    EXPECT_NEAR(result.s[1], mu * impulse, 1e-7 * impulse) << entry.name;
    EXPECT_NEAR(result.u[1], -(0.5 - 0.625 * mu * impulse), 1e-8) << entry.name;
    const Vector v = p.v_free + mass.cwiseInverse().cwiseProduct(wrenches * result.s);
    EXPECT_NEAR(v[2], -(mu + 1) * impulse * r * 0.75, 1e-7) << entry.name;
    EXPECT_NEAR(v[11], -(mu - 1) * impulse * r * 0.75, 1e-7) << entry.name;
    // Both ends of a pin have one velocity.
    const Vector u = wrenches.transpose() * v;
    EXPECT_LE(u.tail(32).cwiseAbs().maxCoeff(), 1e-7) << entry.name;
  }
}

TEST(Ledger, EnergyAndMomentumCloseToRoundOff) {
  // A loose sample falls, shocks and slides between a fixed, a moving and a driven wall.
  Scene<2> scene = shipped("compaction");
  scene.num_steps = 150;
  scene.solver.tol = 1e-3;
  scene.walls[1].motion = Wall<2>::Motion::kMoving;
  scene.walls[1].v = Vec2(0.02, 0.0);
  scene.walls[2].motion = Wall<2>::Motion::kDriven;
  scene.walls[2].direction = Vec2(-1, 0);
  scene.walls[2].mass = 0.5;
  scene.walls[2].force = 3.0;
  double scale = 0, momentum_scale = 0;
  int active = 0;
  const State<2> start = initial_state(scene);
  double initial = 0;
  for (const Disk& d : start.bodies) initial += d.mass * kG * d.x[1];
  solved_run(scene, [&](const State<2>&, const StepReport<2>& r) {
    scale = std::max({scale, r.energy.kinetic, std::abs(r.energy.potential)});
    momentum_scale = std::max(momentum_scale, r.momentum.norm());
    active = std::max(active, r.active);
    EXPECT_LT(std::abs(r.energy.imbalance), 1e-13 * scale);
    EXPECT_LT(r.momentum_imbalance.norm(), 1e-12 * momentum_scale);
    EXPECT_NEAR(r.energy.kinetic + r.energy.potential + r.energy.friction_loss +
                    r.energy.shock_loss - r.energy.wall_work,
                initial, 1e-11 * scale);
  });
  EXPECT_GT(active, 100);
}

}  // namespace
}  // namespace bipot
