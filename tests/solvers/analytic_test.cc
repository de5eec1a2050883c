// Scenes with a solution by hand: Tables 1 and 2 and the square lattice of Fig. 10 of the paper,
// bars with joints.

#include "core/problem/equality_rows.h"
#include "core/scene_files/scene_file.h"
#include "tests/support/converged.h"
#include "tests/support/scene_run.h"
#include "tests/support/siconos_limits.h"
#include "tests/support/small_problems.h"
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
  const State<2> end = solved_run(scene, 1);
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

// The pins as equality rows, and as pairs of opposite contacts without friction, two pairs a pin.
TEST(FourBars, JointsAreEqualityRowsOrPairsOfOppositeContacts) {
  const FourBars bars = four_bars();
  const ContactProblem rows = with_equality_rows(bars.problem, bars.G, Vector::Zero(8));
  ContactProblem pairs = bars.problem;
  const Eigen::MatrixXd G = bars.G.toDense();
  Eigen::MatrixXd wrenches = Eigen::MatrixXd::Zero(12, 2 * 17);
  wrenches.leftCols(2) = bars.problem.H.toDense();
  for (int pin = 0; pin < 4; ++pin) {
    const auto x = G.row(2 * pin).transpose(), y = G.row(2 * pin + 1).transpose();
    auto columns = wrenches.middleCols<8>(2 + 8 * pin);
    columns << x, y, -x, -y, y, -x, -y, x;
  }
  pairs.H = wrenches.sparseView();
  pairs.u_free = wrenches.transpose() * pairs.v_free;
  pairs.mu = Vector::Zero(17);
  pairs.mu[0] = bars.problem.mu[0];
  for (const SolverEntry& entry : solver_table()) {
    for (const ContactProblem* p : {&rows, &std::as_const(pairs)}) {
      const bool beyond = p == &pairs && is_beyond_siconos(entry.name, "four bars");
      const SolveResult result =
          ended(beyond ? SolveStatus::kStalled : SolveStatus::kConverged,
                solve(entry, *p, {.tol = 1e-10, .time_limit = 20}), entry.name);
      if (beyond) continue;
      EXPECT_LE((result.s.head<2>() - bars.s).norm(), 1e-7 * bars.s.norm()) << entry.name;
      EXPECT_NEAR(result.u[1], bars.slides_at, 1e-8) << entry.name;
      const Vector v = body_velocities(*p, result.s);
      EXPECT_NEAR(v[2], bars.turns_at[0], 1e-7) << entry.name;
      EXPECT_NEAR(v[11], bars.turns_at[1], 1e-7) << entry.name;
      // Both ends of a pin have one velocity: exactly with rows.
      EXPECT_LE((bars.G * v).cwiseAbs().maxCoeff(), p == &rows ? 1e-15 : 1e-7) << entry.name;
    }
  }
}

// A point of 1 kg on a plane is led along at 0.3 m/s: it stops falling, and all friction opposes.
TEST(Guide, LeavesAContactWithoutTangentialMotion) {
  ContactProblem p =
      unit_masses(2, Eigen::Matrix2d::Identity(), Vec2(-2, 0), Vector::Constant(1, 0.5));
  const Eigen::MatrixXd G = Eigen::RowVector2d(0, 1);
  p = with_equality_rows(p, G.sparseView(), Vector::Constant(1, 0.3));
  for (const SolverEntry& entry : solver_table()) {
    const bool beyond = is_beyond_siconos(entry.name, "guide");
    const SolveResult result = ended(beyond ? SolveStatus::kStalled : SolveStatus::kConverged,
                                     solve(entry, p, {.tol = 1e-10, .time_limit = 5}), entry.name);
    if (beyond) continue;
    EXPECT_LE((result.s - Vec2(2, -1)).norm(), 1e-5) << entry.name << ": " << result.s.transpose();
  }
}

// A rod of mass m and length l hangs at a pin and leans with its end on a plane without friction,
// at an angle a. At rest the moments about the pin, s_n l cos a = m g h l/2 cos a, give s_n = m g
// h/2, and the pin carries the other half. Turning down at w it is stopped by s_n l cos a = m l²/3
// w. Then the momentum of its middle, m w l/2 (-sin a, -cos a) before, gives the impulse of the pin.
TEST(Rod, IsCarriedAndStoppedByAPlaneAndAPin) {
  const double m = 2, l = 3, angle = 0.7, h = 1e-3, w = 0.4;
  const double c = std::cos(angle), s = std::sin(angle);
  ContactProblem p{.dim = 2};
  Vector mass(3);
  mass << m, m, m * l * l / 12;
  p.A = Eigen::MatrixXd(mass.asDiagonal()).sparseView();
  const Vec2 arm = 0.5 * l * Vec2(c, -s);  // from the middle to the end; to the pin: -arm
  Eigen::MatrixXd H(3, 2), G(2, 3);
  H << 0, -1, 1, 0, arm[0], arm[1];  // n = (0, 1), t = (-1, 0)
  G << 1, 0, arm[1], 0, 1, -arm[0];  // velocity of the pin
  p.H = H.sparseView();
  p.mu = Vector::Zero(1);
  const auto answer = [&](const Vec2& v, double spin) {
    ContactProblem q = p;
    q.v_free = Eigen::Vector3d(v[0], v[1], spin);
    q.u_free = H.transpose() * q.v_free;
    q = with_equality_rows(q, G.sparseView(), Vec2::Zero());
    const SolveResult result = converged(solve("auto", q, {.tol = 1e-12}));
    EXPECT_LE(body_velocities(q, result.s).norm(), 1e-12);
    Vector all(4);
    all << result.s, multipliers(q, result.s);
    return all;
  };
  const double weight = m * kG * h;
  EXPECT_LE((answer({0, -kG * h}, 0) - Eigen::Vector4d(weight / 2, 0, 0, weight / 2)).norm(),
            1e-12 * weight);
  const double blow = m * l * w / (3 * c);
  const Eigen::Vector4d stop(blow, 0, m * w * l / 2 * s, m * w * l / 2 * c - blow);
  EXPECT_LE((answer(w * 0.5 * l * Vec2(-s, -c), -w) - stop).norm(), 1e-12 * blow);
}

TEST(Ledger, EnergyAndMomentumCloseToRoundOff) {
  // A loose sample falls, shocks and slides between a fixed, a moving and a driven wall.
  Scene<2> scene = shipped("compaction");
  scene.num_steps = 150;
  scene.solver.tol = 1e-3;
  move_at(scene.walls[1], Vec2(0.02, 0.0));
  drive(scene.walls[2], Vec2(-1, 0), 0.5, 3.0);
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
