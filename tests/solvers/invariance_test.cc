// Units and the direction of a scene must not matter: every registered solver, the same number of
// iterations to the same error.

#include <Eigen/Geometry>

#include "core/motion/time_stepping.h"
#include "core/scene/scene_family.h"
#include "solvers/registry.h"
#include "solvers/solve.h"
#include "tests/support/siconos_limits.h"
#include "tests/support/test.h"
#include "tests/support/test_name.h"

namespace bipot {
namespace {

/// A tilted triangular lattice with restitution: stick, slip and take-off. Small enough for lemke.
Scene<2> lattice() {
  return make_family_scene("triangular", 6, {.mu = 0.3, .e_n = 0.2, .tilt_degrees = 10});
}

/// The same scene with all lengths, masses and times given in other units.
Scene<2> in_units(Scene<2> scene, double length, double mass, double time) {
  scene.gravity *= length / (time * time);
  scene.step *= time;
  scene.contact_distance *= length;
  for (Disk& d : scene.bodies) {
    d.x *= length;
    d.radius *= length;
    d.mass *= mass;
    d.inertia *= mass * length * length;
  }
  for (Wall<2>& w : scene.walls) w.a *= length;
  return scene;
}

Scene<2> turned(Scene<2> scene, double degrees) {
  const Eigen::Rotation2D<double> turn(degrees * std::numbers::pi / 180);
  scene.gravity = turn * scene.gravity;
  for (Disk& d : scene.bodies) d.x = turn * d.x;
  for (Wall<2>& w : scene.walls) {
    w.a = turn * w.a;
    w.normal = turn * w.normal;
  }
  return scene;
}

SolveResult solve_first_step(const std::string& solver, const Scene<2>& scene) {
  return solve(solver, step_problem(scene, initial_state(scene)), {.tol = 1e-6});
}

class Invariance : public testing::TestWithParam<std::string> {};

void expect_same(const std::string& solver, const SolveResult& a, const SolveResult& b) {
  ASSERT_EQ(a.status, SolveStatus::kConverged) << a.message;
  ASSERT_EQ(b.status, SolveStatus::kConverged) << b.message;
  if (!kDecidedByRounding.contains(solver)) {
    EXPECT_NEAR(a.iterations, b.iterations, 1);
  }
  EXPECT_LE(b.error.guarded(), 1e-6);
}

TEST_P(Invariance, UnitsDoNotMatter) {
  // mm, g, ms: a length of 1 m is 1000, a mass of 1 kg is 1000, a time of 1 s is 1000.
  const Scene<2> scene = lattice();
  expect_same(GetParam(), solve_first_step(GetParam(), scene),
              solve_first_step(GetParam(), in_units(scene, 1e3, 1e3, 1e3)));
}

TEST_P(Invariance, DirectionDoesNotMatter) {
  const Scene<2> scene = lattice();
  expect_same(GetParam(), solve_first_step(GetParam(), scene),
              solve_first_step(GetParam(), turned(scene, 37)));
}

INSTANTIATE_TEST_SUITE_P(, Invariance, testing::ValuesIn(solver_names()),
                         [](const auto& tested) { return test_name(tested.param); });

}  // namespace
}  // namespace bipot
