#include "core/motion/assembly.h"

#include <Eigen/Dense>
#include <Eigen/Geometry>

#include "core/problem/delassus.h"
#include "core/scene/contact_detection.h"
#include "core/scene/scene_parts.h"
#include "tests/support/converged.h"
#include "tests/support/random_vector.h"

namespace bipot {
namespace {

Scene<2> unit_step_scene(double mu, double e_n, double e_t) {
  Scene<2> scene = one_law<2>({.mu = mu, .e_n = e_n, .e_t = e_t});
  scene.step = 1;
  return scene;
}

Disk disk_at(double x, double y, double radius, const Vec2& v = Vec2::Zero(), double spin = 0) {
  Disk d;
  d.x = Vec2(x, y);
  d.v = v;
  d.spin = spin;
  d.radius = radius;
  d.mass = 1 + radius;
  d.inertia = 0.5 * d.mass * radius * radius;
  return d;
}

SolverOptions tolerance(double tol) { return SolverOptions{.tol = tol}; }

struct Bodies {
  std::vector<Disk> bodies;
  std::vector<Wall<2>> walls;
  std::vector<Vec2> v_free;
  std::vector<double> wall_free;

  AssembledStep assemble(Scene<2> scene, double eta = 0) {
    scene.walls = walls;
    if (v_free.empty()) {
      for (const Disk& d : bodies) v_free.push_back(d.v);
    }
    if (wall_free.empty()) {
      for (const Wall<2>& w : walls) wall_free.push_back(w.v.dot(w.direction));
    }
    const std::vector<Contact<2>> contacts = detect_contacts(bodies, walls, eta);
    return assemble_step<2>({scene, bodies, walls, contacts, v_free, wall_free});
  }
};

/// Overlapping bodies between a fixed half-plane, a driven half-plane and a driven segment.
Bodies crowd(unsigned seed) {
  PortableRandom draw(seed);
  Bodies b;
  for (int k = 0; k < 25; ++k) {
    b.bodies.push_back(disk_at(draw.uniform(), draw.uniform(), draw.between(0.08, 0.16),
                               Vec2(draw.symmetric(), draw.symmetric()), draw.symmetric()));
    b.bodies.back().mass = draw.between(0.5, 2);
    b.v_free.emplace_back(b.bodies.back().v + Vec2(0, -0.2));
  }
  b.walls.push_back(half_space<2>(Vec2(0, 0.1), Vec2(0, 1)));
  b.walls.push_back(half_space<2>(Vec2(0.1, 0), Vec2(0.8, 0.6)));
  drive(b.walls[1], Vec2(0.8, 0.6), 4);
  b.walls[1].v = 0.3 * b.walls[1].direction;
  b.walls.push_back(b.walls[1]);
  b.walls[2].shape = Wall<2>::Shape::kSegment;
  b.walls[2].a = Vec2(0.9, -1);
  b.walls[2].b = Vec2(0.95, 2);
  b.walls[2].direction = Vec2(-0.6, 0.8);
  b.walls[2].v = -0.1 * b.walls[2].direction;
  b.wall_free = {0, 0.35, -0.2};
  return b;
}

/// Moves every body by the rates in v over a small time.
Bodies moved(const Bodies& b, const DofMap& dofs, const Vector& v, double dt) {
  Bodies out = b;
  for (std::size_t i = 0; i < out.bodies.size(); ++i) {
    const int k = dofs.disk[i];
    if (k < 0) continue;
    out.bodies[i].x += dt * v.segment<2>(k);
    if (dofs.per_disk == 3) out.bodies[i].angle += dt * v[k + 2];
  }
  for (std::size_t w = 0; w < out.walls.size(); ++w) {
    if (dofs.wall[w] < 0) continue;
    out.walls[w].a += dt * v[dofs.wall[w]] * out.walls[w].direction;
    out.walls[w].b += dt * v[dofs.wall[w]] * out.walls[w].direction;
  }
  return out;
}

TEST(Assembly, NormalRowIsTheRateOfTheGap) {
  const Scene<2> scene = unit_step_scene(0.3, 0, 0);
  Bodies b = crowd(1);
  const AssembledStep step = b.assemble(scene);
  const int contacts = step.problem.num_contacts();
  ASSERT_GT(contacts, 25);
  const Vector v = random_vector(step.problem.num_dofs(), 2);
  const Vector u = step.problem.H.transpose() * v;
  const double dt = 1e-6;
  const Bodies before = moved(b, step.dofs, v, -dt), after = moved(b, step.dofs, v, dt);
  const auto gaps_before = detect_contacts(before.bodies, before.walls, 1e-3);
  const auto gaps_after = detect_contacts(after.bodies, after.walls, 1e-3);
  const auto gap_of = [](const std::vector<Contact<2>>& all, const Contact<2>& c) {
    for (const Contact<2>& other : all) {
      if (other.i == c.i && other.j == c.j) return other.gap;
    }
    ADD_FAILURE() << "contact lost";
    return 0.0;
  };
  const auto now = detect_contacts(b.bodies, b.walls, 0);
  for (int c = 0; c < contacts; ++c) {
    const double rate = (gap_of(gaps_after, now[c]) - gap_of(gaps_before, now[c])) / (2 * dt);
    EXPECT_NEAR(u[2 * c], rate, 1e-8) << now[c].i << ' ' << now[c].j;
  }
}

TEST(Assembly, TangentialRowIsTheRateOfTheContactPointsShift) {
  // Material points fixed to the two bodies at the contact, turned and shifted with them.
  const Scene<2> scene = unit_step_scene(0.3, 0, 0);
  Bodies b = crowd(1);
  const AssembledStep step = b.assemble(scene);
  const Vector v = random_vector(step.problem.num_dofs(), 2);
  const Vector u = step.problem.H.transpose() * v;
  const double dt = 1e-6;
  const auto now = detect_contacts(b.bodies, b.walls, 0);
  const int num_disks = static_cast<int>(b.bodies.size());
  for (std::size_t c = 0; c < now.size(); ++c) {
    const Vec2 t(-now[c].n[1], now[c].n[0]);
    const auto material_point = [&](const Bodies& at, int body, const Vec2& arm) -> Vec2 {
      if (body >= num_disks) return at.walls[body - num_disks].a;
      const Eigen::Rotation2D<double> turn(at.bodies[body].angle - b.bodies[body].angle);
      return at.bodies[body].x + turn * arm;
    };
    const auto shift = [&](double time) {
      const Bodies at = moved(b, step.dofs, v, time);
      const Vec2 arm_i = -b.bodies[now[c].i].radius * now[c].n;
      const Vec2 arm_j =
          now[c].j < num_disks ? Vec2(b.bodies[now[c].j].radius * now[c].n) : Vec2(0, 0);
      return t.dot(material_point(at, now[c].i, arm_i) - material_point(at, now[c].j, arm_j));
    };
    EXPECT_NEAR(u[2 * c + 1], (shift(dt) - shift(-dt)) / (2 * dt), 1e-8);
  }
}

TEST(Assembly, PowerOfImpulsesIsPowerOfWrenches) {
  // u·s = v·(H s), Hᵀ v formed contact by contact from the bodies' velocities.
  const Scene<2> scene = unit_step_scene(0.3, 0.5, 0.2);
  Bodies b = crowd(3);
  b.v_free.clear();
  b.wall_free = {0, 0.3, -0.1};  // the velocities before the step: u_free = (1 + e)/r u⁻ = r u⁻
  const AssembledStep step = b.assemble(scene);
  const ContactProblem& p = step.problem;
  const Vector s = random_vector(p.num_rows(), 4);
  EXPECT_NEAR(step.u_before.dot(s.cwiseProduct(p.row_scale.cwiseInverse())), p.v_free.dot(p.H * s),
              1e-13 * s.size());
  EXPECT_LT((p.u_free - step.u_before.cwiseProduct(p.row_scale)).norm(), 1e-13);
}

TEST(Assembly, OneDiskOnAFloorHasItsKnownOperator) {
  // m = 2, a = 0.5, I = m a²/2: W = diag(1/m, 1/m + a²/I) = diag(1, 3)/m.
  const Scene<2> scene = unit_step_scene(0.3, 0, 0);
  Bodies b{.bodies = {disk_at(0, 0.5, 0.5, Vec2(3, -1), 4)}};
  b.bodies[0].mass = 2;
  b.bodies[0].inertia = 0.25;
  b.walls = {half_space<2>(Vec2(0, 0), Vec2(0, 1))};
  const ContactProblem p = b.assemble(scene).problem;
  Eigen::MatrixXd W(2, 2), H(3, 2);
  W << 0.5, 0, 0, 1.5;
  H << 0, -1, 1, 0, 0, -0.5;  // n = (0, 1), t = e3 x n = (-1, 0)
  EXPECT_EQ(Eigen::MatrixXd(assemble_delassus(p.A, p.H, p.dim)), W);
  EXPECT_EQ(Eigen::MatrixXd(p.H), H);
  EXPECT_EQ(p.u_free, Vector(Vec2(-1, -3 - 0.5 * 4)));
  EXPECT_EQ(p.row_scale.size(), 0);
  EXPECT_EQ(p.mu[0], 0.3);
  EXPECT_FALSE(p.has_delassus());
}

/// A disk slides along a wall with the velocity 1: of an approach below 2^-52 nothing is left.
TEST(Assembly, AnApproachBelowTheRoundingOfTheSlipIsNone) {
  const Scene<2> scene = unit_step_scene(0.3, 0, 0);
  for (const double approach : {1e-12, 1e-15, 1e-17, 1e-60}) {
    Bodies b{.bodies = {disk_at(0.5, 0, 0.5, Vec2(-approach, 1))},
             .walls = {half_space<2>(Vec2(0, 0), Vec2(1, 0))}};
    const ContactProblem p = b.assemble(scene).problem;
    EXPECT_EQ(p.u_free[0], approach > 0x1p-52 ? -approach : 0);
    EXPECT_EQ(p.u_free[1], 1);
  }
}

TEST(Assembly, RestitutionReversesOneContact) {
  // u_n⁺ = -e_n u_n⁻ for a head-on shock of two disks, whatever the masses.
  for (const double e_n : {0.0, 0.3, 1.0}) {
    const Scene<2> scene = unit_step_scene(0, e_n, 0);
    Bodies b{.bodies = {disk_at(0, 0, 0.5, Vec2(2, 0)), disk_at(1.2, 0, 0.7, Vec2(-1, 0))}};
    const AssembledStep step = b.assemble(scene);
    const SolveResult r = converged(solve("pgs", step.problem, tolerance(1e-12)));
    const Vector v = body_velocities(step.problem, r.s);
    EXPECT_DOUBLE_EQ(step.u_before[0], -3);
    EXPECT_NEAR(v[2] - v[0], 3 * e_n, 1e-11);  // from -3 to +3 e_n, n = (-1, 0)
    EXPECT_NEAR(b.bodies[0].mass * v[0] + b.bodies[1].mass * v[2], 1.5 * 2 - 1.7, 1e-12);
  }
}

TEST(Assembly, UnequalRestitutionsSolveThePhysicalLaw) {
  // Solve the symmetric form, go back, and check Moreau's law on (36) in physical variables.
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const double e_n = 0.2, e_t = 0.9, mu = 0.4;
    const Scene<2> scene = unit_step_scene(mu, e_n, e_t);
    Bodies b;
    PortableRandom draw(seed);
    for (int k = 0; k < 5; ++k) {  // a chain on a floor
      b.bodies.push_back(disk_at(k * 0.98, 0.5 + 0.1 * (k % 2), 0.5,
                                 Vec2(draw.symmetric(), -draw.uniform()), 3 * draw.symmetric()));
    }
    b.walls = {half_space<2>(Vec2(0, 0.12), Vec2(0.0, 1.0))};
    const AssembledStep step = b.assemble(scene);
    const ContactProblem& p = step.problem;
    const SolveResult r = converged(solve("pgs", p, tolerance(1e-11)));
    const Vector v = body_velocities(p, r.s);
    const Vector s = r.s.cwiseQuotient(p.row_scale);
    const auto contacts = detect_contacts(b.bodies, b.walls, 0);
    int touching = 0;
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      // u⁺ from the body velocities, by the formulas of the header.
      const Vec2 n = contacts[c].n, t(-n[1], n[0]);
      const int i = contacts[c].i, j = contacts[c].j;
      Vec2 relative = v.segment<2>(step.dofs.disk[i]);
      double spins = b.bodies[i].radius * v[step.dofs.disk[i] + 2];
      if (j < 5) {
        relative -= v.segment<2>(step.dofs.disk[j]);
        spins += b.bodies[j].radius * v[step.dofs.disk[j] + 2];
      }
      const double after_n = n.dot(relative), after_t = t.dot(relative) - spins;
      const double u_n = (after_n + e_n * step.u_before[2 * c]) / (1 + e_n);
      const double u_t = (after_t + e_t * step.u_before[2 * c + 1]) / (1 + e_t);
      const double s_n = s[2 * c], s_t = s[2 * c + 1];
      EXPECT_GE(u_n, -1e-9);
      EXPECT_GE(s_n, 0);
      EXPECT_NEAR(u_n * s_n, 0, 1e-9);
      EXPECT_LE(std::abs(s_t), mu * s_n * (1 + 1e-12));
      EXPECT_NEAR(mu * s_n * std::abs(u_t) + s_t * u_t, 0, 1e-9);
      touching += s_n > 0;
    }
    EXPECT_GT(touching, 2);
  }
}

TEST(Assembly, MovingWallsStandInTheRightHandSide) {
  const Scene<2> scene = unit_step_scene(0.5, 0.25, 0);
  Bodies b{.bodies = {disk_at(0, 0.5, 0.5, Vec2(1, -2))},
           .walls = {half_space<2>(Vec2(0, 0), Vec2(0, 1))},
           .v_free = {Vec2(1, -3)}};
  move_at(b.walls[0], Vec2(4, 5));
  const AssembledStep step = b.assemble(scene);
  EXPECT_EQ(step.problem.num_dofs(), 3);
  EXPECT_EQ(step.dofs.wall[0], -1);
  // u⁻_n = -2 - 5, free -3 - 5; t = (-1, 0): u_t = -(1 - 4).
  const double r = std::sqrt(1.25);
  EXPECT_DOUBLE_EQ(step.u_before[0], -7);
  EXPECT_DOUBLE_EQ(step.problem.u_free[0], (-8 + 0.25 * -7) / r);
  EXPECT_DOUBLE_EQ(step.u_before[1], 3);
  EXPECT_DOUBLE_EQ(step.problem.u_free[1], 3);
  EXPECT_DOUBLE_EQ(step.problem.mu[0], 0.5 / r);
}

TEST(Assembly, DrivenWallsHaveOneDegreeOfFreedom) {
  const Scene<2> scene = unit_step_scene(0.5, 0, 0);
  Bodies b{.bodies = {disk_at(0, 0.5, 0.5, Vec2(1, -2))},
           .walls = {half_space<2>(Vec2(0, 0), Vec2(0, 1))}};
  drive(b.walls[0], Vec2(0.6, 0.8), 4);
  b.walls[0].v = 5 * b.walls[0].direction;
  b.wall_free = {6};
  const AssembledStep step = b.assemble(scene);
  const ContactProblem& p = step.problem;
  ASSERT_EQ(p.num_dofs(), 4);
  EXPECT_EQ(step.dofs.wall[0], 3);
  EXPECT_EQ(p.A.coeff(3, 3), 4);
  EXPECT_EQ(p.v_free[3], 6);
  EXPECT_DOUBLE_EQ(p.H.coeff(3, 0), -0.8);
  EXPECT_DOUBLE_EQ(p.H.coeff(3, 1), 0.6);  // -t·direction, t = (-1, 0)
  EXPECT_DOUBLE_EQ(step.u_before[0], -2 - 0.8 * 5);
  EXPECT_DOUBLE_EQ(p.u_free[0], -2 - 0.8 * 6);
  EXPECT_DOUBLE_EQ(p.u_free[1], -1 + 0.6 * 6);
}

TEST(Assembly, WithoutFrictionThereAreNoTangentsAndNoSpins) {
  const Scene<2> scene = unit_step_scene(0, 0.5, 0.7);
  Bodies b = crowd(1);
  const AssembledStep step = b.assemble(scene);
  EXPECT_EQ(step.problem.dim, 1);
  EXPECT_EQ(step.dofs.per_disk, 2);
  EXPECT_EQ(step.problem.num_rows(), step.problem.num_contacts());
  EXPECT_EQ(step.problem.num_dofs(), 2 * 25 + 2);
  EXPECT_EQ(validate(step.problem), "");
  // The normal rows are those of the problem with friction.
  const AssembledStep rough = crowd(1).assemble(unit_step_scene(0.3, 0.5, 0.7));
  EXPECT_EQ(rough.problem.dim, 2);
  for (int c = 0; c < step.problem.num_contacts(); ++c) {
    EXPECT_EQ(step.problem.u_free[c], rough.problem.u_free[2 * c]);
  }
}

TEST(Assembly, BodiesWithoutContactsDoNotEnter) {
  const Scene<2> scene = unit_step_scene(0.3, 0, 0);
  Bodies b{
      .bodies = {disk_at(50, 50, 0.5), disk_at(0, 0, 0.5), disk_at(-50, 7, 0.5),
                 disk_at(1, 0, 0.5)},
      .walls = {half_space<2>(Vec2(0, -80), Vec2(0, 1)), half_space<2>(Vec2(0, -90), Vec2(0, 1))}};
  drive(b.walls[1], Vec2(0, 1), 1);
  const AssembledStep step = b.assemble(scene);
  EXPECT_EQ(step.problem.num_dofs(), 6);
  EXPECT_EQ(step.dofs.disk, (std::vector<int>{-1, 0, -1, 3}));
  EXPECT_EQ(step.dofs.wall, (std::vector<int>{-1, -1}));
  b.bodies = {disk_at(0, 0, 0.5)};
  b.v_free.clear();
  const AssembledStep none = b.assemble(scene);
  EXPECT_EQ(none.problem.num_contacts(), 0);
  EXPECT_EQ(none.problem.num_dofs(), 0);
  EXPECT_EQ(validate(none.problem), "");
}

TEST(Assembly, EveryPairOfMaterialsHasItsLaw) {
  Scene<2> scene = unit_step_scene(0.3, 0, 0);
  scene.materials = {"steel", "wood"};
  const ContactLaw steel{.mu = 0.1, .e_n = 1}, mixed{.mu = 0.2, .e_n = 0.5},
      wood{.mu = 0.4, .e_n = 0};
  scene.laws = {steel, mixed, mixed, wood};
  Bodies b{
      .bodies = {disk_at(0, 0, 0.5), disk_at(1, 0, 0.5), disk_at(2, 0, 0.5), disk_at(3, 0, 0.5)}};
  b.bodies[2].material = b.bodies[3].material = 1;
  const ContactProblem p = b.assemble(scene).problem;
  ASSERT_EQ(p.num_contacts(), 3);
  EXPECT_DOUBLE_EQ(p.mu[0] * std::sqrt(2.0), 0.1);
  EXPECT_DOUBLE_EQ(p.mu[1] * std::sqrt(1.5), 0.2);
  EXPECT_DOUBLE_EQ(p.mu[2], 0.4);
  EXPECT_DOUBLE_EQ(p.row_scale[0], std::sqrt(2.0));
  EXPECT_DOUBLE_EQ(p.row_scale[1], 1);
  EXPECT_DOUBLE_EQ(p.row_scale[4], 1);
}

}  // namespace
}  // namespace bipot
