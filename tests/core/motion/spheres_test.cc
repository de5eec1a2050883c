// Spheres: what is known by hand, and what must hold for any impulse.

#include "core/motion/assembly.h"
#include "core/motion/force_balance.h"
#include "core/motion/midpoint.h"
#include "core/motion/sample_volume.h"
#include "core/motion/warm_start.h"
#include "tests/support/scene_run.h"
#include "tests/support/small_scenes.h"

namespace bipot {
namespace {

/// A sphere of radius 0.5 m that touches the plane z = 0.
Scene<3> sphere_on_floor(double mu) {
  Scene<3> scene = on_floor(heavy_scene<3>({.mu = mu}), 0.5, 2);
  scene.contact_distance = 1e-9;
  scene.solver.tol = 1e-12;
  return scene;
}

/// Spheres of two sizes with random velocities and spins that fly at each other about the origin.
Scene<3> cloud_that_collides(int count, const ContactLaw& law) {
  Scene<3> scene = one_law<3>(law);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto any = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  for (int k = 0; k < count; ++k) {
    // Cells of 0.5 m around the origin, spheres of at most 0.2 m.
    const Vec3 x = 0.5 * Vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1) + 0.04 * any();
    scene.bodies.push_back(
        round_body<3>(x, k % 2 == 0 ? 0.2 : 0.15, 1 + k % 3, any() - 3 * x, 5 * any()));
  }
  scene.step = 2e-3;
  scene.num_steps = 150;
  scene.solver.tol = 1e-10;
  return scene;
}

// The velocities of the touching points, by v + w x r alone, in the frame of the contact; H gives
// the same.
TEST(Spheres, RelativeVelocityIsThatOfTheTouchingPoints) {
  Scene<3> scene = one_law<3>({.mu = 0.4, .e_n = 0.3, .e_t = 0.1});
  scene.bodies = {round_body<3>(Vec3(0.1, 0.2, 0.3), 0.5, 2, Vec3(1, -2, 3), Vec3(4, 5, -6)),
                  round_body<3>(Vec3(0.9, -0.1, 0.7), 0.4, 3, Vec3(-1, 0.5, 2), Vec3(-3, 2, 1))};
  Wall<3> lid = half_space<3>(Vec3(0, 0, 1.2), Vec3(0.6, 0, -0.8));
  move_at(lid, Vec3(0.2, 0.3, -0.1));
  scene.walls = {lid};
  scene.contact_distance = 1;
  scene.step = 1e-9;
  const auto mid = make_midpoint(scene, initial_state(scene));
  const AssembledStep step = assemble_step(scene, mid);
  ASSERT_EQ(mid.contacts.size(), 3u);
  Vector v(12);
  for (int k = 0; k < 2; ++k) {
    v.segment<3>(6 * k) = scene.bodies[to_size(k)].v;
    v.segment<3>(6 * k + 3) = scene.bodies[to_size(k)].spin;
  }
  const Vector from_h = step.problem.H.transpose() * v;
  for (std::size_t c = 0; c < mid.contacts.size(); ++c) {
    const Contact<3>& contact = mid.contacts[c];
    const Sphere& a = scene.bodies[to_size(contact.i)];
    Vec3 u = a.v + a.spin.cross(-a.radius * contact.n);
    if (contact.j < 2) {
      const Sphere& b = scene.bodies[to_size(contact.j)];
      u -= b.v + b.spin.cross(b.radius * contact.n);
    } else {
      u -= lid.v;
    }
    const auto frame = contact_frame<3>(contact.n);
    for (int k = 0; k < 3; ++k) {
      const int row = 3 * static_cast<int>(c) + k;
      EXPECT_NEAR(step.u_before[row], frame[to_size(k)].dot(u), 1e-14);
      if (contact.j == 2) continue;  // H knows nothing of what is prescribed
      EXPECT_NEAR(from_h[row], frame[to_size(k)].dot(u) / std::sqrt(k == 0 ? 1.3 : 1.1), 1e-14);
    }
  }
}

// Thrown without spin it slides, then rolls. About any point of its track no force has a moment: m
// a v0 = m a v + I v/a, I = 2/5 m a², hence v = 5/7 v0. Rolling towards +x turns about +y. Friction
// takes ½ m v0² (1 - 5/7) = m v0²/7.
TEST(Spheres, AThrownSphereEndsRollingAtFiveSevenths) {
  Scene<3> scene = sphere_on_floor(0.3);
  scene.bodies[0].v = Vec3(0.7, 0, 0);
  scene.num_steps = 120;  // it slides for 2 v0 / (7 mu g) = 0.068 s
  StepReport<3> last;
  const auto end = solved_run(scene, [&](const auto&, const auto& r) { last = r; });
  EXPECT_NEAR(end.bodies[0].v[0], 0.5, 1e-9);
  EXPECT_NEAR(end.bodies[0].spin[1], 0.5 / 0.5, 1e-9);
  EXPECT_LT(Vec3(end.bodies[0].v[1], end.bodies[0].v[2], end.bodies[0].spin[0]).norm(), 1e-9);
  EXPECT_NEAR(last.energy.friction_loss, 2 * 0.49 / 7, 1e-9);
  EXPECT_EQ(end.contacts[0].status, ContactStatus::kStick);
  // It has turned about y by the way over the radius once it rolls: the orientation follows.
  const Vec3 top = end.bodies[0].orientation * Vec3::UnitZ();
  EXPECT_GT(top[0], 0.01);
  EXPECT_NEAR(top[1], 0, 1e-12);
}

// Friction that holds: m a = m g sin - F, I a/r = F r, hence a = 5/7 g sin and F = 2/7 m g sin <=
// mu m g cos while tan <= 7/2 mu. Beyond that it slides with g (sin - mu cos).
TEST(Spheres, OnASlopeTheyRollUpToSevenHalvesMu) {
  const double mu = 0.2, limit = std::atan(3.5 * mu);
  for (const double angle : {0.5 * limit, 0.99 * limit, 1.01 * limit, 1.3 * limit}) {
    Scene<3> scene = sphere_on_floor(mu);
    scene.gravity = kGravity * Vec3(0.6 * std::sin(angle), 0.8 * std::sin(angle), -std::cos(angle));
    const auto end = solved_run(scene, 100);
    const double rolling = 5.0 / 7 * kGravity * std::sin(angle);
    const double sliding = kGravity * (std::sin(angle) - mu * std::cos(angle));
    const double expected = angle < limit ? rolling : sliding;
    EXPECT_LT((end.bodies[0].v - 0.1 * expected * Vec3(0.6, 0.8, 0)).norm(), 1e-9) << angle;
    EXPECT_EQ(end.contacts[0].status, angle < limit ? ContactStatus::kStick : ContactStatus::kSlip);
  }
}

/// Three touching spheres on a floor and one in their hollow.
Scene<3> tetrahedron(double mu_between, double mu_floor) {
  Scene<3> scene{.gravity = Vec3(0, 0, -kGravity),
                 .walls = {half_space<3>(Vec3::Zero(), Vec3::UnitZ())},
                 .materials = {"sphere", "floor"},
                 .laws = {{.mu = mu_between}, {.mu = mu_floor}, {.mu = mu_floor}, {.mu = 0}}};
  scene.walls[0].material = 1;
  const double a = 0.5, ring = 2 * a / std::sqrt(3.0);
  for (int k = 0; k < 3; ++k) {
    const double angle = 2 * std::numbers::pi / 3 * k;
    scene.bodies.push_back(
        round_body<3>(Vec3(ring * std::cos(angle), ring * std::sin(angle), a), a, 2));
  }
  scene.bodies.push_back(round_body<3>(Vec3(0, 0, a + 2 * a * std::sqrt(2.0 / 3)), a, 2));
  scene.contact_distance = 1e-9;
  scene.step = 1e-3;
  scene.num_steps = 200;
  scene.solver.tol = 1e-10;
  scene.solver.name = "ipm";
  return scene;
}

// The edges of a regular tetrahedron lean by phi from the vertical, cos phi = √(2/3), phi =
// 35.264°. Three forces act on a lower sphere: its weight and the floor's force meet in the floor
// point Q, so the force of the upper sphere must pass through Q as well (contacts between the lower
// spheres can only push them apart, which helps nothing). The triangle of the centre, Q and the
// upper contact has two sides a, so that force makes the angle phi/2 with the normal there, and
// with the vertical: it holds while mu >= tan(phi/2) = 0.3178. It brings W/3 down and W/3
// tan(phi/2) outwards, the floor carries 4/3 W: mu >= tan(phi/2)/4 = 0.0795 there.
TEST(Spheres, FourSpheresStandFromTheFrictionThatGeometryAsksFor) {
  const double phi = std::acos(std::sqrt(2.0 / 3));
  const double between = std::tan(phi / 2), floor = between / 4;
  EXPECT_NEAR(between, 0.3178, 1e-4);
  EXPECT_NEAR(floor, 0.0795, 1e-4);
  const auto drop = [](const Scene<3>& scene) {
    return scene.bodies[3].x[2] - solved_run(scene).bodies[3].x[2];
  };
  EXPECT_LT(std::abs(drop(tetrahedron(1.01 * between, 1.01 * floor))), 1e-7);
  EXPECT_GT(drop(tetrahedron(0.98 * between, 1.5 * floor)), 1e-4);
  EXPECT_GT(drop(tetrahedron(1.5 * between, 0.98 * floor)), 1e-4);
}

// The forces of the pile that stands: the floor's normal force on each is 4/3 of a weight, friction
// makes the rest hold. Newton and Euler of every sphere, from the contacts alone.
TEST(Spheres, ForcesOfTheTetrahedronBalance) {
  Scene<3> scene = tetrahedron(0.5, 0.2);
  const auto end = solved_run(scene);
  const auto balance = force_balance(scene, end);
  EXPECT_LT(balance.force, 1e-6);
  EXPECT_LT(balance.moment, 1e-6);
  EXPECT_NEAR(balance.walls[2], 4 * 2 * kGravity, 1e-6);
  int on_floor = 0;
  for (const auto& c : end.contacts) {
    if (c.contact.j != 4) continue;
    ++on_floor;
    EXPECT_NEAR(c.s_n / scene.step, 4.0 / 3 * 2 * kGravity, 1e-4);
  }
  EXPECT_EQ(on_floor, 3);
}

// Without gravity and walls. Momentum and energy close to rounding, whatever the impulses are.
// Angular momentum as well, but for the couple gap n x s_t of a contact that acts at the arms a_i
// and a_j while the centres are a_i + a_j + gap apart (core/motion/stress_tensor.h): without
// friction there is none.
TEST(Spheres, MomentaAndEnergyCloseToRounding) {
  for (const double mu : {0.0, 0.6}) {
    Scene<3> scene = cloud_that_collides(27, {.mu = mu, .e_n = 0.4, .e_t = 0.2});
    State<3> before = initial_state(scene);
    int struck = 0;
    double couples = 0;
    solved_run(scene, [&](const State<3>& state, const StepReport<3>& report) {
      Vec3 couple = Vec3::Zero();
      for (const auto& c : state.contacts) couple += c.contact.gap * c.contact.n.cross(c.s_t);
      EXPECT_LT((momentum(state) - momentum(before)).norm(), 1e-13 * 100);
      EXPECT_LT(report.momentum_imbalance.norm(), 1e-13 * 100);
      EXPECT_LT((angular_momentum(state) - angular_momentum(before) - couple).norm(), 1e-13 * 100);
      EXPECT_LT(std::abs(report.energy.imbalance), 1e-13 * 300);
      if (report.active > 0) ++struck;
      couples += couple.norm();
      before = state;
    });
    EXPECT_GT(struck, 30);
    EXPECT_EQ(couples > 0, mu > 0);
    const double start = kinetic_energy(initial_state(scene));
    EXPECT_LT(kinetic_energy(before), 0.9 * start);
    EXPECT_NEAR(kinetic_energy(before), start - before.friction_loss - before.shock_loss,
                1e-12 * start);
  }
}

// A pile in a corner under gravity, then all of it turned: the same iterations, and bodies, spins
// and impulses that are turned as well. Tangents of contacts do not turn with it, so this also says
// that nothing depends on them.
TEST(Spheres, TurningTheWholeSceneChangesNothing) {
  Scene<3> scene = cloud_that_collides(27, {.mu = 0.5, .e_n = 0.2, .e_t = 0.2});
  scene.gravity = Vec3(0, 0, -kGravity);
  scene.walls = {half_space<3>(Vec3(0, 0, -0.9), Vec3::UnitZ()),
                 half_space<3>(Vec3(-0.8, 0, 0), Vec3::UnitX()),
                 half_space<3>(Vec3(0, 0.8, 0), -Vec3::UnitY())};
  Wall<3> plate = half_space<3>(Vec3(0.8, 0, 0), -Vec3::UnitX());
  drive(plate, plate.normal, 2, 30);
  scene.walls.push_back(plate);
  scene.step = 5e-3;
  scene.num_steps = 60;
  scene.solver.name = "pgs";
  scene.solver.tol = 1e-6;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(1.1, Vec3(1, 2, -3).normalized()));
  Scene<3> turned = scene;
  turned.gravity = turn * scene.gravity;
  for (Sphere& s : turned.bodies) {
    s.x = turn * s.x;
    s.v = turn * s.v;
    s.spin = turn * s.spin;
  }
  for (Wall<3>& w : turned.walls) {
    w.a = turn * w.a;
    w.normal = turn * w.normal;
    w.direction = turn * w.direction;
  }
  std::vector<int> iterations, iterations_turned;
  const auto end =
      solved_run(scene, [&](const auto&, const auto& r) { iterations.push_back(r.iterations); });
  const auto other = solved_run(
      turned, [&](const auto&, const auto& r) { iterations_turned.push_back(r.iterations); });
  EXPECT_EQ(iterations, iterations_turned);
  ASSERT_GT(end.contacts.size(), 10u);
  ASSERT_EQ(end.contacts.size(), other.contacts.size());
  for (std::size_t k = 0; k < end.bodies.size(); ++k) {
    EXPECT_LT((turn * end.bodies[k].x - other.bodies[k].x).norm(), 1e-9);
    EXPECT_LT((turn * end.bodies[k].v - other.bodies[k].v).norm(), 1e-7);
    EXPECT_LT((turn * end.bodies[k].spin - other.bodies[k].spin).norm(), 1e-6);
  }
  for (std::size_t k = 0; k < end.contacts.size(); ++k) {
    EXPECT_NEAR(end.contacts[k].s_n, other.contacts[k].s_n, 1e-7);
    EXPECT_LT((turn * end.contacts[k].s_t - other.contacts[k].s_t).norm(), 1e-7);
  }
}

// A plate of mass 3 kg pressed by 50 N on a sphere of 2 kg: at rest the floor bears 50 N and the
// sphere's weight (gravity does not act on plates), and the plate's force passes through the
// sphere. The mean stress over the space between the plates is F d / V along z, V the enclosed
// volume: walls around that do not touch.
TEST(Spheres, APlateIsDrivenByItsForce) {
  Scene<3> scene = sphere_on_floor(0.3);
  scene.gravity = Vec3::Zero();
  Wall<3> plate = half_space<3>(Vec3(0, 0, 1), -Vec3::UnitZ());
  drive(plate, -Vec3::UnitZ(), 3, 50);
  scene.walls.push_back(plate);
  for (const Vec3& n : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0)}) {
    scene.walls.push_back(half_space<3>(-2 * n, n));
  }
  const auto end = solved_run(scene, 20);
  EXPECT_LT(end.bodies[0].v.norm(), 1e-12);
  ASSERT_EQ(end.contacts.size(), 2u);
  for (const auto& c : end.contacts) EXPECT_NEAR(c.s_n / scene.step, 50, 1e-9);
  const double volume = sample_measure(end, scene.step);
  EXPECT_NEAR(volume, 4 * 4 * 1, 1e-9);
  const auto stress = sample_stress(end, scene.step, volume, contact_moments(end));
  Eigen::Matrix3d expected = Eigen::Matrix3d::Zero();
  expected(2, 2) = 50 * 1 / volume;
  EXPECT_LT((stress.total() - expected).norm(), 1e-9);
  EXPECT_NEAR(stress.pressure(), 50 / volume / 3, 1e-9);
}

// The sum of all parts is symmetric at every step, for any impulses (the spins follow from the
// contacts' moments), and the stresses of the single spheres, weighted by their volumes, add up to
// the sample's: contacts between spheres only.
TEST(Spheres, StressIsSymmetricAndAddsUp) {
  Scene<3> scene = cloud_that_collides(27, {.mu = 0.6, .e_n = 0.4, .e_t = 0.2});
  State<3> before = initial_state(scene);
  int seen = 0;
  solved_run(scene, [&](const State<3>& state, const StepReport<3>& report) {
    const auto moments = spin_changes(before, state);
    const auto sample = sample_stress(state, scene.step, 2.0, moments);
    const Eigen::Matrix3d total = sample.total();
    const double scale = std::max(total.norm(), sample.contact.norm());
    EXPECT_LT((total - total.transpose()).norm(), 1e-11 * scale);
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const auto& s : disk_stresses(state, scene.step, moments)) sum += s.area * s.total();
    EXPECT_LT((sum - 2.0 * total).norm(), 1e-11 * scale);
    if (report.active > 0) {
      ++seen;
      EXPECT_GT((sample.contact - sample.contact.transpose()).norm(), 1e-9 * scale);
    }
    before = state;
  });
  EXPECT_GT(seen, 30);
}

// A cylinder about the y axis that turns with w: its surface moves with w y x r. A sphere that is
// held by friction in the drum's bottom, r = -R z, sees w R along -x; on top of a roller, r = R z,
// along +x. Gaps: R - |r| - a inside, |r| - R - a outside, |r| the distance from the axis.
TEST(Spheres, CylindersTouchAndTurnAboutTheirAxes) {
  Scene<3> scene = one_law<3>({.mu = 0.5});
  Wall<3> drum{
      .shape = Wall<3>::Shape::kHollowCircle, .normal = Vec3::UnitY(), .radius = 3, .spin = 0.7};
  Wall<3> roller = drum;
  roller.shape = Wall<3>::Shape::kSolidCircle;
  roller.radius = 1;
  scene.walls = {drum, roller};
  scene.bodies = {round_body<3>(Vec3(0, 77, -2.5), 0.5, 2),
                  round_body<3>(Vec3(0, -5, 1.5), 0.5, 2)};
  scene.contact_distance = 1e-9;
  scene.step = 1e-9;
  const auto mid = make_midpoint(scene, initial_state(scene));
  const AssembledStep step = assemble_step(scene, mid);
  ASSERT_EQ(mid.contacts.size(), 2u);
  EXPECT_EQ(mid.contacts[0].j, 2);
  EXPECT_EQ(mid.contacts[1].j, 3);
  const Vec3 expected[] = {Vec3(-0.7 * 3, 0, 0), Vec3(0.7 * 1, 0, 0)};
  for (int c = 0; c < 2; ++c) {
    const Contact<3>& contact = mid.contacts[to_size(c)];
    EXPECT_LT((contact.n - Vec3::UnitZ()).norm(), 1e-15);
    EXPECT_NEAR(contact.gap, 0, 1e-15);
    const auto frame = contact_frame<3>(contact.n);
    Vec3 u = Vec3::Zero();
    for (int k = 0; k < 3; ++k) u += step.u_before[3 * c + k] * frame[to_size(k)];
    EXPECT_LT((u + expected[c]).norm(), 1e-14);  // of the sphere at rest against the surface
  }
}

// What a contact carries goes on to the next step though its tangents jump where n_z changes its
// sign: the start is the last impulse, turned into the new frame.
TEST(Spheres, AWarmStartKeepsTheImpulseWhereTheFrameJumps) {
  Scene<3> scene = sphere_on_floor(0.5);
  scene.bodies[0].x = Vec3(0.5, 0, 0);
  scene.gravity = Vec3(-kGravity, 2, 1);
  scene.walls[0].normal = Vec3(1, 0, 1e-12).normalized();
  State<3> state = solved_run(scene, 3);
  ASSERT_EQ(state.contacts.size(), 1u);
  EXPECT_GT(state.contacts[0].s_t.norm(), 1e-4);
  std::vector<Contact<3>> contacts = {state.contacts[0].contact};
  contacts[0].n = Vec3(1, 0, -1e-12).normalized();
  ContactProblem p{.dim = 3, .u_free = Vector::Zero(3), .mu = Vector::Constant(1, 0.5)};
  const std::vector<const Wall<3>*> walls = {&scene.walls[0]};
  const Vector s0 = warm_start<3>(state.contacts, contacts, walls, p);
  const auto frame = contact_frame<3>(contacts[0].n);
  const Vec3 start = s0[1] * frame[1] + s0[2] * frame[2];
  EXPECT_NEAR(s0[0], state.contacts[0].s_n, 1e-15);
  EXPECT_LT((start - state.contacts[0].s_t).norm(), 1e-12);
}

}  // namespace
}  // namespace bipot
