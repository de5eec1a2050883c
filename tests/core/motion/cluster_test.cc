// Disks that are joined rigidly: what is known by hand, and what must hold for any impulse.

#include "core/motion/force_balance.h"
#include "core/motion/midpoint.h"
#include "core/motion/sample_area.h"
#include "core/scene/cluster_motion.h"
#include "core/scene/disk_union.h"
#include "tests/support/refused_scene.h"
#include "tests/support/scene_run.h"
#include "tests/support/scene_text.h"
#include "tests/support/small_scenes.h"

namespace bipot {
namespace {

/// Joins circles to a cluster of a scene.
void add_cluster(Scene<2>& scene, const std::vector<Circle>& parts, double density, const Vec2& v,
                 double spin) {
  for (const Circle& part : parts) {
    scene.bodies.push_back({.x = part.centre, .radius = part.radius});
  }
  join_disks(scene, parts.size(), {.density = density});
  scene.clusters.bodies.back().v = v;
  scene.clusters.bodies.back().spin = spin;
  place_members(scene.clusters, scene.bodies);
}

TEST(Cluster, ADumbbellFallsOnAParabolaAndTurnsEvenly) {
  // Disks of 0.1 and 0.2 m, 0.25 m apart. Without contacts the mid-point scheme is exact: after
  // time t the centre of mass is at x0 + v0 t - g t²/2, the dumbbell turned by w t, and each disk
  // where a rigid body has it.
  Scene<2> scene = heavy_scene({.mu = 0.5}, 1e-2);
  add_cluster(scene, {{Vec2(0, 0), 0.1}, {Vec2(0.25, 0), 0.2}}, 100, Vec2(1, 3), 7);
  ASSERT_EQ(validate(scene), "");
  const Cluster<2> begin = scene.clusters.bodies[0];
  const State<2> first = initial_state(scene);
  const double energy = kinetic_energy(first) + potential_energy(first, scene.gravity);
  const State<2> state = solved_run(scene, 100, [&](const State<2>&, const StepReport<2>& r) {
    EXPECT_EQ(r.contacts, 0);
    EXPECT_NEAR(r.energy.kinetic + r.energy.potential, energy, 1e-11);
    EXPECT_LT(r.momentum_imbalance.norm(), 1e-12);
  });
  const Vec2 x = begin.x + Vec2(1, 3) + 0.5 * scene.gravity;
  EXPECT_LT((state.clusters.bodies[0].x - x).norm(), 1e-12);
  EXPECT_NEAR(state.clusters.bodies[0].angle, 7, 1e-12);
  for (std::size_t i = 0; i < 2; ++i) {
    const Vec2 arm = scene.bodies[i].x - begin.x;
    const Vec2 there = Eigen::Rotation2D<double>(7) * arm;
    EXPECT_LT((state.bodies[i].x - x - there).norm(), 1e-12);
    const Vec2 v = Vec2(1, 3) + scene.gravity + 7 * Vec2(-there[1], there[0]);
    EXPECT_LT((state.bodies[i].v - v).norm(), 1e-11);
  }
}

/// Clusters of three unequal disks, and single ones, with random velocities that fly at each other.
Scene<2> cloud_of_clusters(const ContactLaw& law) {
  Scene<2> scene = one_law<2>(law);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int k = 0; k < 16; ++k) {
    const Vec2 x(0.8 * (k % 4 - 1.5), 0.8 * (k / 4 - 1.5));
    const Vec2 v(unit(random), unit(random));
    if (k % 5 == 4) {
      scene.bodies.push_back(round_body<2>(x, 0.2, 3, v - 2 * x, unit(random)));
      if (!scene.clusters.empty()) scene.clusters.arms.emplace_back(Vec2::Zero());
      continue;
    }
    add_cluster(scene, {{x, 0.15}, {x + Vec2(0.15, 0.1), 0.12}, {x - Vec2(0.1, 0.15), 0.1}}, 50,
                v - 2 * x, 4 * unit(random));
  }
  scene.contact_distance = 1e-9;
  scene.step = 2e-3;
  scene.num_steps = 150;
  scene.solver.name = "pgs";
  scene.solver.tol = 1e-10;
  return scene;
}

// The velocities of the touching points, by v + w x r alone; H gives the same, with the masses of
// the bodies.
TEST(Cluster, RelativeVelocityIsThatOfTheTouchingPoints) {
  Scene<2> scene = cloud_of_clusters({.mu = 0.4, .e_n = 0.3, .e_t = 0.1});
  scene.contact_distance = 0.4;  // many candidates
  ASSERT_EQ(validate(scene), "");
  const Midpoint<2> mid = make_midpoint(scene, initial_state(scene));
  const AssembledStep step = assemble_step(scene, mid);
  const ContactProblem& p = step.problem;
  ASSERT_GT(mid.contacts.size(), 20u);
  Vector v = Vector::Zero(p.num_dofs());
  for (std::size_t i = 0; i < mid.bodies.size(); ++i) {
    const int k = step.dofs.disk[i];
    if (k < 0) continue;
    const int c = mid.bodies[i].cluster;
    const Cluster<2> body = c >= 0 ? mid.clusters.bodies[to_size(c)] : Cluster<2>{};
    v.segment<3>(k) << (c >= 0 ? body.v : mid.bodies[i].v), mid.bodies[i].spin;
    EXPECT_EQ(p.A.coeff(k, k), c >= 0 ? body.mass : mid.bodies[i].mass);
    EXPECT_EQ(p.A.coeff(k + 2, k + 2), c >= 0 ? body.inertia : mid.bodies[i].inertia);
  }
  const Vector u = p.H.transpose() * v;
  const Vector free = p.H.transpose() * p.v_free;
  for (std::size_t c = 0; c < mid.contacts.size(); ++c) {
    const Contact<2>& contact = mid.contacts[c];
    const Disk &a = mid.bodies[to_size(contact.i)], &b = mid.bodies[to_size(contact.j)];
    EXPECT_TRUE(a.cluster < 0 || a.cluster != b.cluster);
    const auto point_velocity = [&](const Disk& d, const Vec2& x) -> Vec2 {
      const bool joined = d.cluster >= 0;
      const Vec2 centre = joined ? mid.clusters.bodies[to_size(d.cluster)].x : d.x;
      const Vec2 of_centre = joined ? mid.clusters.bodies[to_size(d.cluster)].v : d.v;
      const Vec2 r = x - centre;
      return of_centre + d.spin * Vec2(-r[1], r[0]);
    };
    const Vec2 difference = point_velocity(a, a.x - a.radius * contact.n) -
                            point_velocity(b, b.x + b.radius * contact.n);
    const Vec2 t(-contact.n[1], contact.n[0]);
    const auto row = static_cast<Eigen::Index>(2 * c);
    EXPECT_NEAR(u[row] * std::sqrt(1.3), difference.dot(contact.n), 1e-12);
    EXPECT_NEAR(u[row + 1] * std::sqrt(1.1), difference.dot(t), 1e-12);
    EXPECT_NEAR(step.u_before[row], difference.dot(contact.n), 1e-12);
    EXPECT_NEAR(step.u_before[row + 1], difference.dot(t), 1e-12);
    // Without contacts the velocity is the free one: (free + e before) / sqrt(1 + e).
    EXPECT_NEAR(p.u_free[row], free[row] + 0.3 * difference.dot(contact.n) / std::sqrt(1.3), 1e-12);
  }
}

// Momentum is kept to rounding; angular momentum but for the couples that overlaps leave, gap · s_t
// each, because the two impulses of a contact act at the points of the two disks. In steps without
// walls the virial of contacts is that of the motion: V σ = Σ m (v⁺ - v⁻) ⊗ x / h, here the
// symmetric part; and the stress is symmetric.
TEST(Cluster, MomentumAngularMomentumAndVirialHoldToRounding) {
  for (const double mu : {0.0, 0.4}) {
    const Scene<2> scene = cloud_of_clusters({.mu = mu, .e_n = 0.5, .e_t = 0.2});
    State<2> before = initial_state(scene);
    const Vec2 whole = momentum(before);
    const double energy = kinetic_energy(before);
    int touched = 0;
    solved_run(scene, [&](const State<2>& state, const StepReport<2>& r) {
      EXPECT_LT(std::abs(r.energy.imbalance), 1e-11 * energy);
      double couples = 0;
      Mat2 virial = Mat2::Zero();
      for (const ContactOutcome<2>& o : state.contacts) {
        couples += o.contact.gap * o.s_t;
        touched += o.s_n > 0 ? 1 : 0;
      }
      EXPECT_NEAR(angular_momentum(state) - angular_momentum(before), couples, 1e-12);
      const auto add = [&](double mass, const Vec2& x, const Vec2& v, const Vec2& v_before) {
        const Vec2 middle = x - 0.5 * scene.step * v;
        virial += mass / scene.step * (v - v_before) * middle.transpose();
      };
      for (std::size_t i = 0; i < state.bodies.size(); ++i) {
        const Disk& d = state.bodies[i];
        if (d.cluster < 0) add(d.mass, d.x, d.v, before.bodies[i].v);
      }
      for (std::size_t c = 0; c < state.clusters.bodies.size(); ++c) {
        const Cluster<2>& b = state.clusters.bodies[c];
        add(b.mass, b.x, b.v, before.clusters.bodies[c].v);
      }
      const auto moments = contact_moments(state);
      const MeanStress<2> stress = sample_stress(state, scene.step, 1.0, moments);
      const double scale = 1 + virial.norm();
      EXPECT_LT((0.5 * (stress.contact + stress.contact.transpose() - virial - virial.transpose()))
                    .norm(),
                1e-11 * scale);
      EXPECT_LT(std::abs(stress.total()(0, 1) - stress.total()(1, 0)), 1e-11 * scale);
      // The disks' stresses, each cluster once, add up to the sample's.
      Mat2 sum = Mat2::Zero();
      const std::vector<MeanStress<2>> of_disks = disk_stresses(state, scene.step, moments);
      std::vector<bool> seen(state.clusters.bodies.size());
      for (std::size_t i = 0; i < state.bodies.size(); ++i) {
        const Disk& d = state.bodies[i];
        if (d.cluster >= 0 && seen[to_size(d.cluster)]) continue;
        if (d.cluster >= 0) seen[to_size(d.cluster)] = true;
        sum += of_disks[i].area * of_disks[i].total();
      }
      EXPECT_LT((sum - stress.total()).norm(), 1e-10 * (scale + energy));
      before = state;
    });
    EXPECT_GT(touched, 20);
    EXPECT_LT((momentum(before) - whole).norm(), 1e-12 * whole.norm() + 1e-11);
  }
}

/// Two disks of radius 0.1 side by side, b to both sides, touching the floor, and a third on top.
Scene<2> stool(double b, double top, double shift) {
  Scene<2> scene = one_law<2>({.mu = 3});
  scene.walls = {flat_floor<2>()};
  add_cluster(scene, {{Vec2(-b, 0.1), 0.1}, {Vec2(b, 0.1), 0.1}, {Vec2(shift, top), 0.12}}, 100,
              Vec2::Zero(), 0);
  scene.contact_distance = 1e-9;
  scene.step = 2e-3;
  scene.num_steps = 150;
  scene.solver.tol = 1e-11;
  return scene;
}

TEST(Cluster, ItTopplesIffItsCentreOfMassPassesTheSupport) {
  // On a slope of angle θ the line through the centre of mass, h above the floor, passes the lower
  // foot, at b, iff tan θ > b / h. Friction (μ = 3) is no limit there. Just below it stands, just
  // above it falls, to the lower side.
  Scene<2> scene = stool(0.1, 0.5, 0);
  const double h = scene.clusters.bodies[0].x[1];
  EXPECT_NEAR(scene.clusters.bodies[0].x[0], 0, 1e-15);
  EXPECT_GT(h, 0.2);
  for (const double side : {-1.0, 1.0}) {
    for (const double factor : {0.98, 1.02}) {
      const double tangent = factor * 0.1 / h;
      scene.gravity = kGravity / std::hypot(1, tangent) * Vec2(side * tangent, -1);
      const State<2> end = solved_run(scene);
      if (factor < 1) {
        EXPECT_LT(kinetic_energy(end), 1e-12);
        EXPECT_NEAR(end.clusters.bodies[0].angle, 0, 1e-9);
      } else {
        EXPECT_GT(-side * end.clusters.bodies[0].angle, 1e-3);
        EXPECT_LT(-side * end.clusters.bodies[0].angle, 0.5);
      }
    }
  }
}

TEST(Cluster, ThreeDisksStandOnTwoFeetWithTheForcesOfALever) {
  // Feet at ±0.3, centre of mass at x: the right foot carries (x + 0.3)/0.6 of the weight.
  Scene<2> scene = stool(0.3, 0.35, 0.2);
  scene.gravity = Vec2(0, -kGravity);
  const Cluster<2>& body = scene.clusters.bodies[0];
  EXPECT_GT(body.x[0], 0.02);
  const double weight = body.mass * kGravity;
  const State<2> end = solved_run(scene);
  ASSERT_EQ(end.contacts.size(), 2u);
  EXPECT_EQ(end.contacts[0].contact.i, 0);
  EXPECT_NEAR(end.contacts[1].s_n / scene.step, weight * (body.x[0] + 0.3) / 0.6, 1e-8 * weight);
  EXPECT_NEAR(end.contacts[0].s_n / scene.step, weight * (0.3 - body.x[0]) / 0.6, 1e-8 * weight);
  const ForceBalance<2> balance = force_balance(scene, end);
  EXPECT_LT(balance.force, 1e-8);
  EXPECT_LT(balance.moment, 1e-8);
  EXPECT_NEAR(balance.weight, weight, 1e-12 * weight);
}

TEST(Cluster, OneDiskJoinedToNothingIsThatDisk) {
  const std::string rest =
      "[contact]\nmu = 0.4\ne_n = 0.3\n[[walls]]\npoint = [0, 0]\nnormal = [0.1, 1]\n"
      "[time]\nstep = 1e-3\nsteps = 300\n[solver]\nname = 'pgs'\ntol = 1e-9\n";
  const std::string motion = "density = 300\nvelocity = [1, -0.3]\nspin = 4\n";
  const Scene<2> disk = scene_of("[[disks]]\nposition = [0, 0.31]\nradius = 0.2\n" + motion + rest);
  const Scene<2> cluster =
      scene_of("[[clusters]]\nposition = [0, 0.3]\nparts = [[0, 0.01, 0.2]]\n" + motion + rest);
  Scene<2> inside = disk;  // the same as a cluster with one member, which no file asks for
  const Disk& d = disk.bodies[0];
  inside.clusters.bodies = {{.x = d.x,
                             .v = d.v,
                             .spin = d.spin,
                             .mass = d.mass,
                             .inertia = d.inertia,
                             .size = std::numbers::pi * 0.04}};
  inside.clusters.arms = {Vec2::Zero()};
  inside.bodies[0].mass = inside.bodies[0].inertia = 0;
  inside.bodies[0].cluster = 0;
  ASSERT_EQ(validate(inside), "");
  const State<2> a = solved_run(disk), b = solved_run(cluster), c = solved_run(inside);
  EXPECT_EQ(a.bodies[0].x, b.bodies[0].x);
  EXPECT_EQ(a.bodies[0].v, b.bodies[0].v);
  EXPECT_EQ(a.bodies[0].angle, b.bodies[0].angle);
  EXPECT_EQ(a.friction_loss, b.friction_loss);
  EXPECT_EQ(a.bodies[0].x, c.bodies[0].x);
  EXPECT_EQ(a.bodies[0].spin, c.bodies[0].spin);
  EXPECT_GT(a.friction_loss, 0);
}

TEST(Cluster, ASceneFileSaysPartsAndPlaces) {
  const std::string time = "[time]\nstep = 1e-3\nsteps = 1\n";
  const auto refused = refused_scenes(time);
  const std::string two = "[[clusters]]\nparts = [[0, 0, 0.1], [0.3, 0, 0.1]]\n";
  // A quarter turn puts the second disk above the first.
  const Scene<2> turned =
      scene_of(two + "position = [1, 2]\ndegrees = 90\nmass = 3\ninertia = 5\n" + time);
  EXPECT_LT((turned.bodies[0].x - Vec2(1, 2)).norm(), 1e-15);
  EXPECT_LT((turned.bodies[1].x - Vec2(1, 2.3)).norm(), 1e-15);
  EXPECT_LT((turned.clusters.bodies[0].x - Vec2(1, 2.15)).norm(), 1e-15);
  EXPECT_EQ(turned.clusters.bodies[0].mass, 3);
  EXPECT_EQ(turned.clusters.bodies[0].inertia, 5);
  // By density, two disks apart: 2 ρ π a²; inertia of both, ½ m a² + m (0.15)².
  const Scene<2> dense = scene_of(two + "position = [0, 0]\ndensity = 100\n" + time);
  const double mass = 200 * std::numbers::pi * 0.01;
  EXPECT_NEAR(dense.clusters.bodies[0].mass, mass, 1e-13);
  EXPECT_NEAR(dense.clusters.bodies[0].inertia, mass * (0.005 + 0.0225), 1e-14);
  // A group in a lattice of cells that hold a cluster however it is turned: 0.5 m; nothing touches.
  const Scene<2> many =
      scene_of(two +
               "arrangement = 'random'\ncount = 20\nwidth = 3\nseed = 4\n"
               "density = 9\n[[disks]]\nposition = [9, 9]\nradius = 1\nmass = 1\n" +
               time);
  EXPECT_EQ(many.bodies.size(), 41u);
  EXPECT_EQ(many.clusters.arms.size(), 41u);
  EXPECT_EQ(many.bodies[0].cluster, -1);
  EXPECT_TRUE(detect_contacts(many.bodies, many.walls, 0).empty());
  EXPECT_NE(many.clusters.bodies[0].x, many.clusters.bodies[1].x);
  const Scene<2> rows =
      scene_of(two + "arrangement = 'rectangular'\ncolumns = 2\nrows = 3\nmass = 1\n" + time);
  EXPECT_EQ(rows.clusters.bodies.size(), 6u);
  EXPECT_LT((rows.clusters.bodies[1].x - Vec2(0.75, 0.25)).norm(), 1e-15);
  refused(two + "mass = 1\n", "position");
  refused(two + "position = [0, 0]\n", "either mass");
  refused(two + "position = [0, 0]\nmass = 1\nradius = 2\n", "radius");
  refused("[[clusters]]\nposition = [0, 0]\nmass = 1\n", "parts");
  refused("[[clusters]]\nposition = [0, 0]\nmass = 1\nparts = [[0, 0]]\n", "test.toml:4");
  refused("[[clusters]]\nposition = [0, 0]\nmass = 1\nparts = [[0, 0, 1], [0, 0, 2]]\n",
          "same centre");
  const std::string sound = two + "position = [0, 0]\nmass = 1\n";
  refused("model = 'dem'\n" + sound, "dem");
  refused("[cell]\nwidth = 0.44\n" + sound, "longer than the clusters");  // which is 0.45 m long
  refused("[contact]\noverlaps = 'project'\n" + sound, "project");
}

// Each contact counts by the share of the branch between the centres of mass, each body by its
// centre: what windows that tile the sample have adds up to what the sample has.
TEST(Cluster, WindowsThatTileTheSampleAddUpToItsStress) {
  const Scene<2> scene = cloud_of_clusters({.mu = 0.4, .e_n = 0.5, .e_t = 0.2});
  int loaded = 0;
  solved_run(scene, [&](const State<2>& state, const StepReport<2>&) {
    const auto moments = contact_moments(state);
    const MeanStress<2> whole = sample_stress(state, scene.step, 1.0, moments);
    if (whole.contact.norm() == 0) return;
    for (const ContactOutcome<2>& o : state.contacts) loaded += o.s_n > 0 ? 1 : 0;
    Mat2 contact = Mat2::Zero(), spin = Mat2::Zero();
    const double edge[] = {-9, -0.4, 0.1, 0.7, 9};
    for (int a = 0; a < 4; ++a) {
      for (int b = 0; b < 4; ++b) {
        const Box<2> window{.lower = Vec2(edge[a], edge[b]),
                            .upper = Vec2(edge[a + 1], edge[b + 1])};
        const MeanStress<2> part = window_stress(state, scene.step, window, moments);
        contact += part.area * part.contact;
        spin += part.area * part.spin;
      }
    }
    EXPECT_LT((contact - whole.contact).norm(), 1e-11 * whole.contact.norm());
    EXPECT_LT((spin - whole.spin).norm(), 1e-11 * (whole.contact.norm() + whole.spin.norm()));
  });
  EXPECT_GT(loaded, 20);
}

/// Clusters of three disks in a cell that is periodic in both directions, squeezed and sheared, so
/// many times side by side.
Scene<2> sheared_clusters(int copies, bool far_away) {
  Scene<2> scene = one_law<2>({});
  constexpr double kWidth = 1.35;
  scene.cell.in_x = scene.cell.in_y = true;
  scene.cell.width = {.motion = CellSide::Motion::kFixed, .length = copies * kWidth};
  scene.cell.height = {.motion = CellSide::Motion::kMoving, .length = 1.25, .speed = -0.4};
  scene.cell.offset = {.motion = CellSide::Motion::kMoving, .length = 0.1, .speed = 0.8};
  for (int copy = 0; copy < copies; ++copy) {
    for (int k = 0; k < 9; ++k) {
      Vec2 x(0.2 + 0.45 * (k % 3) + copy * kWidth, 0.2 + 0.4 * (k / 3));
      Vec2 v(0.3 * std::sin(5 * k), 0.3 * std::cos(3 * k));
      if (far_away && k % 2 == 0) {  // images of theirs, which move as these do
        x += scene.cell.shift(k - 3, 2);
        v += scene.cell.shift_velocity(k - 3, 2);
      }
      add_cluster(scene, {{x, 0.15}, {x + Vec2(0.1, 0.05), 0.12}, {x - Vec2(0.05, 0.1), 0.1}}, 50,
                  v, k - 4);
    }
  }
  scene.contact_distance = 1e-9;
  scene.step = 2e-3;
  scene.num_steps = 200;
  scene.solver = {.name = "pgs", .tol = 1e-11};
  return scene;
}

/// The velocity beyond that of the cell.
Vec2 homogeneous_free(const State<2>& state, const Cluster<2>& c) {
  return c.v - homogeneous_velocity(state.cell, c.x);
}

// Velocities without friction are unique. A run in two cells side by side is that of one, and so is
// a run whose clusters are given by images of theirs.
TEST(Cluster, InAPeriodicCellImagesAreAsGoodAsTheirs) {
  const Scene<2> one = sheared_clusters(1, false);
  ASSERT_EQ(validate(one), "");
  int loaded = 0;
  const State<2> end = solved_run(one, [&](const State<2>& state, const StepReport<2>&) {
    for (const ContactOutcome<2>& o : state.contacts) loaded += o.s_n > 0 && o.contact.with_image();
  });
  EXPECT_GT(loaded, 15);
  const State<2> twice = solved_run(sheared_clusters(2, false));
  const State<2> far = solved_run(sheared_clusters(1, true));
  const auto expect_same = [&](const Cluster<2>& a, const Cluster<2>& b, const State<2>& other) {
    EXPECT_LT((homogeneous_free(end, a) - homogeneous_free(other, b)).norm(), 1e-7);
    EXPECT_NEAR(a.spin, b.spin, 1e-6);
    EXPECT_NEAR(a.angle, b.angle, 1e-7);
  };
  for (std::size_t c = 0; c < 9; ++c) {
    expect_same(end.clusters.bodies[c], twice.clusters.bodies[c], twice);
    expect_same(end.clusters.bodies[c], twice.clusters.bodies[c + 9], twice);
    expect_same(end.clusters.bodies[c], far.clusters.bodies[c], far);
  }
  // The stress is the same in one cell and in two.
  const auto stress = [&](const State<2>& state, const Scene<2>& scene) {
    return sample_stress(state, scene.step, sample_measure(state, scene.step),
                         contact_moments(state))
        .total();
  };
  const Mat2 of_one = stress(end, one);
  EXPECT_GT(of_one.norm(), 1e-3);
  EXPECT_LT((of_one - stress(twice, sheared_clusters(2, false))).norm(), 1e-5 * of_one.norm());
  EXPECT_LT((of_one - stress(far, sheared_clusters(1, true))).norm(), 1e-5 * of_one.norm());
  EXPECT_LT(std::abs(of_one(0, 1) - of_one(1, 0)), 1e-10 * of_one.norm());
}

}  // namespace
}  // namespace bipot
