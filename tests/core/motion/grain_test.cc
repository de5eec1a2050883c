// Plates whose friction depends on the direction: mu along the grain, ratio mu across it.

#include "core/motion/contact_axes.h"
#include "core/motion/midpoint.h"
#include "tests/support/converged.h"
#include "tests/support/scene_run.h"
#include "tests/support/scene_text.h"

namespace bipot {
namespace {

constexpr double kMu = 0.5, kRatio = 0.4;

/// Three joined spheres whose lowest points lie on the plane z = 0.
Scene<3> tripod(const std::string& velocity = "[0, 0, 0]", double step = 1e-2) {
  return scene_of<3>(
      "dim = 3\n[contact]\nmu = 0.5\n[[clusters]]\nposition = [0, 0, 0.2]\nmass = 3\n"
      "parts = [[1, 0, 0, 0.2], [-0.5, 0.8660254037844386, 0, 0.2], "
      "[-0.5, -0.8660254037844386, 0, 0.2]]\nvelocity = " +
      velocity +
      "\n[[walls]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\ngrain = [2, 0, 0]\n"
      "grain_ratio = 0.4\n[time]\nsteps = 1\nstep = " +
      std::to_string(step) + "\n[solver]\ntol = 1e-12\n");
}

/// Gravity on a slope that falls towards the angle `degrees` from the grain.
void set_slope(Scene<3>& scene, double tangent, double degrees) {
  const double slope = std::atan(tangent), to = degrees * std::numbers::pi / 180;
  scene.gravity = kGravity * Vec3(std::sin(slope) * std::cos(to), std::sin(slope) * std::sin(to),
                                  -std::cos(slope));
}

// The pull T = N tan θ towards φ is held iff (T cos φ / mu)² + (T sin φ / (ratio mu))² <= N².
TEST(Grain, APlateHoldsUpToTheEllipse) {
  for (const double degrees : {0.0, 30.0, 60.0, 90.0}) {
    const double to = degrees * std::numbers::pi / 180;
    const double bound = kMu / std::hypot(std::cos(to), std::sin(to) / kRatio);
    Scene<3> scene = tripod();
    set_slope(scene, 0.99 * bound, degrees);
    EXPECT_LT(solved_run(scene).clusters.bodies[0].v.norm(), 1e-10) << degrees;
    set_slope(scene, 1.01 * bound, degrees);
    EXPECT_GT(solved_run(scene).clusters.bodies[0].v.norm(), 1e-4) << degrees;
  }
}

// Slip follows the normal of the ellipse: s_y / s_x = ratio² u_y / u_x. All contacts slip alike, so
// d v_y / d v_x = ratio² v_y / v_x, and v_y = v_x^(ratio²) from (1, 1) on, to the order of the step.
TEST(Grain, SlipFollowsTheNormalOfTheEllipse) {
  Scene<3> scene = tripod("[1, 1, 0]", 1e-3);
  scene.num_steps = 150;
  int slips = 0;
  const State<3> end = solved_run(scene, [&](const State<3>& state, const StepReport<3>& report) {
    EXPECT_LT(std::abs(report.energy.imbalance), 1e-10);
    for (const ContactOutcome<3>& c : state.contacts) {
      if (c.s_n <= 0) continue;
      EXPECT_EQ(c.status, ContactStatus::kSlip);
      EXPECT_NEAR(std::hypot(c.s_t[0], c.s_t[1] / kRatio), kMu * c.s_n, 1e-9);
      EXPECT_NEAR(c.s_t[1] * c.u_t[0], kRatio * kRatio * c.s_t[0] * c.u_t[1], 1e-9);
      EXPECT_LT(c.s_t.dot(c.u_t), 0);
      ++slips;
    }
  });
  const Vec3 v = end.clusters.bodies[0].v;
  EXPECT_GE(slips, 300);
  EXPECT_LT(v[0], 0.5);
  EXPECT_NEAR(v[1], std::pow(v[0], kRatio * kRatio), 2e-3);
}

// Forces are carried from step to step in space, not in rows that are scaled.
TEST(Grain, AWarmStartOfABodyAtRestNeedsNoIteration) {
  Scene<3> scene = tripod();
  scene.solver.name = "pgs";
  scene.solver.tol = 1e-9;
  set_slope(scene, 0.9 * kMu * kRatio, 80);
  solved_run(scene, 3, [](const State<3>& state, const StepReport<3>& report) {
    if (state.step > 1) {
      EXPECT_EQ(report.iterations, 0) << state.step;
    }
  });
}

TEST(Grain, ARatioOfOneIsCoulombsLaw) {
  Scene<3> with = tripod("[0.3, -0.8, -0.1]"), without = with;
  with.walls[0].grain = Vec3(0.6, 0.8, 0);
  with.walls[0].grain_ratio = 1;
  without.walls[0].grain.setZero();
  const Vec3 difference =
      solved_run(with, 5).clusters.bodies[0].v - solved_run(without, 5).clusters.bodies[0].v;
  EXPECT_LT(difference.norm(), 1e-9);
}

TEST(Grain, EverySolverAgrees) {
  Scene<3> scene = tripod("[0.3, 0.2, 0]");
  set_slope(scene, 0.3, 70);
  const ContactProblem p = step_problem(scene, initial_state(scene));
  EXPECT_FALSE(sphere_structure(p));
  const Vector u = solve("pgs", p, {.tol = 1e-12}).u;
  int able = 0;
  for (const SolverEntry& entry : solver_table()) {
    // "convex" solves another law where contacts slip.
    if (entry.max_dim < 3 || std::string(entry.name) == "convex") continue;
    const SolveResult r =
        converged(solve(entry.name, p, {.tol = 1e-9, .max_iterations = 100000}), entry.name);
    EXPECT_LT((r.u - u).norm(), 1e-6) << entry.name;
    ++able;
  }
  EXPECT_GE(able, 10);
}

// Both sets of axes are dual, also where the normal leans on the edge of a polygon.
TEST(Grain, AxesOfForcesAndVelocitiesAreDual) {
  Wall<3> wall = flat_floor<3>();
  wall.grain = Vec3::UnitX();
  wall.grain_ratio = kRatio;
  for (const Vec3& n : {Vec3(0, 0, 1), Vec3(0.6, 0, 0.8), Vec3(0, 0.6, -0.8), Vec3(1, 0, 0)}) {
    const auto axes = contact_axes<3>(n, &wall), dual = dual_axes<3>(n, &wall);
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t l = 0; l < 3; ++l) EXPECT_NEAR(axes[k].dot(dual[l]), k == l, 1e-14);
    }
    EXPECT_EQ(axes[0], n);
    EXPECT_NEAR(axes[2].norm(), n[0] == 1 ? 1 : kRatio, 1e-14);
  }
}

TEST(Grain, SpringsRefuseIt) {
  Scene<3> scene = tripod();
  scene.clusters = {};
  scene.bodies = {round_body<3>(Vec3(0, 0, 1), 1, 1)};
  scene.model = Model::kSpringDashpot;
  EXPECT_TRUE(says(validate(scene), "grain")) << validate(scene);
}

}  // namespace
}  // namespace bipot
