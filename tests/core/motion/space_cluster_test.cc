// Spheres that are joined rigidly: what is known by hand, and what must hold for any impulse.

#include "core/motion/force_balance.h"
#include "core/motion/midpoint.h"
#include "core/scene/cluster_motion.h"
#include "tests/support/converged.h"
#include "tests/support/refused_scene.h"
#include "tests/support/scene_run.h"
#include "tests/support/scene_text.h"

namespace bipot {
namespace {

Scene<3> space_scene(const std::string& text) { return scene_of<3>("dim = 3\n" + text); }

/// A body of principal moments 1, 2 and 3 kg m² along x, y and z, with this spin at the start.
Cluster<3> asymmetric_top(const Vec3& spin) {
  return {.v = Vec3(1, 2, 3), .spin = spin, .mass = 2, .inertia = Vec3(1, 2, 3), .size = 1};
}

Cluster<3> drifted(Cluster<3> body, double time, int steps) {
  for (int k = 0; k < steps; ++k) drift(body, time / steps);
  return body;
}

TEST(SpaceCluster, ATumblingBodyKeepsEnergyAndAngularMomentum) {
  for (const double h : {1e-3, 1e-2, 0.3, 3.0}) {  // the longest steps are cut
    Cluster<3> body = asymmetric_top(Vec3(1, 2, -0.5));
    const double energy = turning_energy(body);
    const Vec3 momentum = own_momentum(body);
    for (int k = 0; k < 300; ++k) drift(body, h);
    EXPECT_NEAR(turning_energy(body), energy, 1e-12 * energy) << h;
    EXPECT_LT((own_momentum(body) - momentum).norm(), 1e-12 * momentum.norm()) << h;
    EXPECT_LT((body.x - 300 * h * body.v).norm(), 1e-9);
  }
}

// Half the step: a quarter of the error, in the rotation and in the spin.
TEST(SpaceCluster, TheRotationIsOfTheSecondOrder) {
  const Cluster<3> start = asymmetric_top(Vec3(1, 2, -0.5)), exact = drifted(start, 2, 20000);
  double before = 0;
  for (const int steps : {50, 100, 200}) {
    const Cluster<3> end = drifted(start, 2, steps);
    const double error = end.orientation.angularDistance(exact.orientation);
    EXPECT_LT(error, 1e-2);
    EXPECT_LT((end.spin - exact.spin).norm(), 3 * error + 1e-12);
    if (before > 0) {
      EXPECT_NEAR(before / error, 4, 0.1) << steps;
    }
    before = error;
  }
  // The way back is the same.
  Cluster<3> back = drifted(start, 2, 50);
  for (int k = 0; k < 50; ++k) drift(back, -2.0 / 50);
  EXPECT_LT(back.orientation.angularDistance(start.orientation), 1e-13);
}

// A symmetric top with the moments J about its axis and I across turns about L at the rate |L|/I, and
// its axis keeps the angle to L.
TEST(SpaceCluster, ASymmetricTopPrecessesAboutItsAngularMomentum) {
  Cluster<3> top{.spin = Vec3(0.6, 0, 2), .mass = 1, .inertia = Vec3(1, 1, 1.5), .size = 1};
  const Vec3 momentum = own_momentum(top);
  const double period = 2 * std::numbers::pi * 1 / momentum.norm();
  const Cluster<3> once = drifted(top, period, 4000);
  const Vec3 axis = once.orientation * Vec3::UnitZ();
  EXPECT_LT((axis - Vec3::UnitZ()).norm(), 1e-6);
  const Vec3 half = drifted(top, period / 2, 2000).orientation * Vec3::UnitZ();
  EXPECT_NEAR(half.dot(momentum), Vec3::UnitZ().dot(momentum), 1e-12);
  EXPECT_LT(half[0] * momentum[0], 0.5 * momentum[0]);  // on the other side of L
}

// About the intermediate axis a rotation is unstable: a disturbance grows at the rate
// ω √((I₂-I₁)(I₃-I₂)/(I₁I₃)) = 3/√3, and the body turns over (Dzhanibekov). About the others it stays.
TEST(SpaceCluster, TheIntermediateAxisIsUnstable) {
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 spin = Vec3::Constant(1e-6);
    spin[axis] = 3;
    Cluster<3> body = asymmetric_top(spin);
    double least = 3, early = 0, grown = 0;
    for (int k = 0; k < 2000; ++k) {
      drift(body, 1e-2);
      const Vec3 own = own_spin(body);
      least = std::min(least, own[axis]);
      Vec3 off = own;
      off[axis] = 0;
      if (k == 299) early = off.norm();
      if (k == 499) grown = off.norm() / early;
    }
    if (axis == 1) {
      EXPECT_LT(least, -2.99);
      EXPECT_NEAR(std::log(grown) / 2, std::sqrt(3), 0.01);  // e^(λ t) from 3 to 5 s
    } else {
      EXPECT_GT(least, 3 - 1e-9);
      EXPECT_LT(grown, 5);
    }
  }
}

const std::string kSpaceSteps = "solver = {tol = 1e-12}\ntime = {step = 1e-3, steps = 100}\n";

TEST(SpaceCluster, ATripodStandsOnThreeFeetByTheRuleOfTheLever) {
  // Feet of radius 0.1 at (0, 0), (1, 0) and (0, 1), and a heavy head above (0.25, 0.5): the mass is
  // given, so that all of it counts at the centre of the union. With v_k the volumes, the loads F_k have
  // the sum m g and the moments of the weight: F₁ = m g x_c, F₂ = m g y_c.
  const Scene<3> scene = space_scene(
      kSpaceSteps +
      R"(
contact = {mu = 0.5}
walls = [{point = [0, 0, 0], normal = [0, 0, 1]}]
)"
      "clusters = [{parts = [[0, 0, 0, 0.1], [1, 0, 0, 0.1], [0, 1, 0, 0.1], [0.25, 0.5, 0.6, 0.3]], "
      "position = [0, 0, 0.1], mass = 7}]\n");
  const Vec3 centre = scene.clusters.bodies[0].x;
  const State<3> end = solved_run(scene);
  ASSERT_EQ(end.contacts.size(), 3u);
  EXPECT_LT((end.clusters.bodies[0].x - centre).norm(), 1e-9);
  const double weight = 7 * 9.81;
  EXPECT_NEAR(end.contacts[1].s_n / 1e-3, weight * centre[0], 1e-6);
  EXPECT_NEAR(end.contacts[2].s_n / 1e-3, weight * centre[1], 1e-6);
  EXPECT_NEAR(end.contacts[0].s_n / 1e-3, weight * (1 - centre[0] - centre[1]), 1e-6);
  const ForceBalance<3> balance = force_balance(scene, end);
  EXPECT_LT(balance.force, 1e-8);
  EXPECT_LT(balance.moment, 1e-8);
}

// A bar falls with v on a step under one end, at c from its centre of mass: the point stops, so that
// s = v/(1/m + c²/I), v' = -v + s/m and ω' = c s/I.
TEST(SpaceCluster, ABarThatFallsOnOneEndTurns) {
  const Scene<3> scene = space_scene(
      R"(
gravity = [0, 0, 0]
walls = [{corners = [[0.5, -1, 0], [3, -1, 0], [3, 1, 0], [0.5, 1, 0]]}]
solver = {tol = 1e-12}
time = {step = 1e-3, steps = 1}
)"
      "clusters = [{parts = [[-1, 0, 0, 0.2], [1, 0, 0, 0.2]], position = [0, 0, 0.2001], mass = 3, "
      "inertia = [0.4, 2, 1.7], velocity = [0, 0, -2]}]\n");
  const Cluster<3> end = solved_run(scene).clusters.bodies[0];
  const double s = 2 / (1.0 / 3 + 1 / 2.0);
  EXPECT_NEAR(end.v[2], -2 + s / 3, 1e-9);
  EXPECT_NEAR(end.spin[1], -s / 2.0, 1e-9);
}

// In a plane of symmetry nothing but the plane's motion is left: a dumbbell of spheres moves as one of
// disks with the same mass and moment.
TEST(SpaceCluster, InAPlaneItMovesAsAClusterOfDisks) {
  const std::string both =
      "contact = {mu = 0.3, e_n = 0.4}\ntime = {step = 1e-3, steps = 700}\nsolver = {tol = 1e-13}\n";
  const Scene<3> spheres = space_scene(
      both +
      R"(
walls = [{point = [0, 0, 0], normal = [0, 0, 1]}]
)"
      "clusters = [{parts = [[0, 0, 0, 0.1], [0.5, 0, 0, 0.2]], position = [0, 0, 0.6], axis = [0, 1, 0], "
      "degrees = -20, mass = 2, inertia = [0.1, 0.3, 0.3], velocity = [1, 0, 0.5], spin = [0, -3, 0]}]\n");
  const Vec3 centre = spheres.clusters.bodies[0].x;
  Scene<2> disks =
      scene_of(both + R"(
walls = [{point = [0, 0], normal = [0, 1]}]
)"
                      "clusters = [{parts = [[0, 0, 0.1], [0.5, 0, 0.2]], position = [0, 0.6], "
                      "degrees = 20, mass = 2, inertia = 0.3, velocity = [1, 0.5], spin = 3}]\n");
  // The centre of mass of spheres is not that of disks: the arms are set to the former.
  disks.clusters.bodies[0].x = Vec2(centre[0], centre[2]);
  for (std::size_t i = 0; i < 2; ++i) {
    const Vec3& x = spheres.bodies[i].x;
    disks.clusters.arms[i] = Vec2(x[0], x[2]) - disks.clusters.bodies[0].x;
  }
  place_members(disks.clusters, disks.bodies);
  const Cluster<3> a = solved_run(spheres).clusters.bodies[0];
  const Cluster<2> b = solved_run(disks).clusters.bodies[0];
  // Turns by w h deviate by (w h)³/12, 2e-9 a step.
  EXPECT_LT((Vec2(a.x[0], a.x[2]) - b.x).norm(), 1e-6);
  EXPECT_LT((Vec2(a.v[0], a.v[2]) - b.v).norm(), 5e-6);
  EXPECT_NEAR(a.spin[1], -b.spin, 5e-6);
  EXPECT_LT(std::abs(a.x[1]) + std::abs(a.spin[0]) + std::abs(a.spin[2]), 1e-12);
}

const std::string kHeap =
    R"(
contact = {mu = 0.4, mu_r = 0.002}
walls = [{from = [0, 0, -0.5], to = [0, 0, 1.5], radii = [0.05, 1.6]}]
time = {step = 2e-3, steps = 150}
solver = {tol = 1e-9}
)"
    "clusters = [{parts = [[0, 0, 0, 0.1], [0.12, 0, 0, 0.08], [0, 0.1, 0.04, 0.09]], "
    "arrangement = 'random', count = 24, width = 0.9, spacing = 0, corner = [-0.45, -0.45, 0.35], "
    "density = 1000, velocity = [0, 0, -5]}]\n";

TEST(SpaceCluster, EnergyAndMomentumBalanceWhereClumpsCollide) {
  int contacts = 0;
  const State<3> end = solved_run(space_scene(kHeap), [&](const State<3>&, const StepReport<3>& r) {
    contacts = std::max(contacts, r.contacts);
    EXPECT_LT(std::abs(r.energy.imbalance), 1e-9 * (1 + r.energy.kinetic));
    EXPECT_LT(r.momentum_imbalance.norm(), 1e-9);
  });
  EXPECT_GT(contacts, 15);
  // Each is one body for the stress: the means of its spheres are the same.
  const auto stresses = disk_stresses<3>(end, 2e-3, contact_moments(end));
  EXPECT_EQ(stresses[0].total(), stresses[2].total());
}

TEST(SpaceCluster, SolversAgreeOnClumps) {
  Scene<3> scene = space_scene(kHeap);
  for (ContactLaw& law : scene.laws) law.mu_r = 0;
  const ContactProblem problem = step_problem(scene, solved_run(scene, 100));
  ASSERT_GT(problem.num_contacts(), 5);
  EXPECT_FALSE(sphere_structure(problem).has_value());
  EXPECT_EQ(validate(problem), "");
  SolverOptions options{.tol = 1e-10};
  const SolveResult first = converged(solve("pgs", problem, options));
  for (const char* name : {"auto", "apgd", "admm", "ipm", "anderson"}) {
    const SolveResult other = converged(solve(name, problem, options), name);
    EXPECT_LT((other.u - first.u).norm(), 1e-6 * (1 + first.u.norm())) << name;
  }
}

TEST(SpaceCluster, WhatDoesNotGoWithClumpsIsRefused) {
  const std::string two =
      "clusters = [{parts = [[0, 0, 0, 0.1], [0.1, 0, 0, 0.1]], position = [0, 0, 1], mass = 1}]\n";
  const auto refused = refused_scenes("", "dim = 3\n");
  refused(two + "time = {step = 1e-3, steps = 1, accuracy = 0.01}\n",
          "clusters of spheres do not go with accuracy");
  refused(
      "clusters = [{parts = [[0, 0, 0, 0.1], [0, 0, 0, 0.2]], position = [0, 0, 1], mass = 1}]\n" +
          kSpaceSteps,
      "two spheres of a cluster have the same centre");
}

}  // namespace
}  // namespace bipot
