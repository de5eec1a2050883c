// Cohesion: s_n >= -c h, friction on the shifted cone |s_t| <= mu (s_n + c h).

#include "core/motion/midpoint.h"
#include "tests/support/converged.h"
#include "tests/support/refused_scene.h"
#include "tests/support/scene_run.h"
#include "tests/support/scene_text.h"
#include "tests/support/small_scenes.h"

namespace bipot {
namespace {

constexpr double kGrainStep = 0.01, kGrainMass = 2;

template <int D>
Scene<D> sticky(const ContactLaw& law) {
  Scene<D> scene = heavy_scene<D>(law, kGrainStep);
  scene.contact_distance = 1e-9;
  scene.solver.tol = 1e-13;
  return scene;
}

/// n bodies of 0.5 m, each below the one before, the first touching a ceiling at height 0.
template <int D>
Scene<D> hanging_chain(int n, double cohesion, double e_n = 0) {
  Scene<D> scene = sticky<D>({.mu = 0.3, .e_n = e_n, .cohesion = cohesion});
  scene.walls = {half_space<D>(Vec<D>::Zero(), -Vec<D>::Unit(D - 1))};
  for (int k = 0; k < n; ++k) {
    scene.bodies.push_back(round_body<D>(-(0.5 + k) * Vec<D>::Unit(D - 1), 0.5, kGrainMass));
  }
  return scene;
}

// Contact k of a hanging chain carries the bodies below it, (n - k) m g: it breaks, at the top, iff
// c < n m g. With c = 3.5 m g three hang and four fall. In the step in which the top opens it still
// pulls with c: the chain of four gets the acceleration g (1 - 3.5/4) = g/8, then g.
template <int D>
void hang_chain() {
  const double weight = kGrainMass * kGravity;
  for (const double e_n : {0.0, 0.5}) {
    const State<D> held = after_steps(hanging_chain<D>(3, 3.5 * weight, e_n), 50);
    ASSERT_EQ(held.contacts.size(), 3u);
    for (const ContactOutcome<D>& c : held.contacts) {
      const int above = to_size(c.contact.j) >= held.bodies.size() ? 0 : c.contact.j;
      EXPECT_NEAR(c.s_n / kGrainStep, -(3 - above) * weight, 1e-9);
      EXPECT_EQ(c.status, ContactStatus::kStick);
    }
    for (const Body<D>& b : held.bodies) EXPECT_LT(b.v.norm(), 1e-12);
    EXPECT_NEAR(held.cohesion_loss, 0, 1e-12) << "nothing moved";
  }
  State<D> falls = initial_state(hanging_chain<D>(4, 3.5 * weight));
  balanced_steps(hanging_chain<D>(4, 3.5 * weight), falls, 1);
  for (const Body<D>& b : falls.bodies) EXPECT_NEAR(b.v[D - 1], -kGrainStep * kGravity / 8, 1e-12);
  // Its work while it opened: c times the mean speed times h.
  EXPECT_NEAR(falls.cohesion_loss, 3.5 * weight * kGrainStep * kGravity * kGrainStep / 16, 1e-12);
  balanced_steps(hanging_chain<D>(4, 3.5 * weight), falls, 9);
  EXPECT_EQ(falls.contacts.size(), 3u);
  EXPECT_NEAR(falls.bodies[0].v[D - 1], -kGrainStep * kGravity * (9 + 1.0 / 8), 1e-12);
}

TEST(Cohesion, AChainOfDisksHangsUpToTheDerivedNumber) { hang_chain<2>(); }
TEST(Cohesion, AChainOfSpheresHangsUpToTheDerivedNumber) { hang_chain<3>(); }

// A plate of mass M is pulled off a disk that hangs from a ceiling, without gravity: it holds up to
// F = c. With F = 1.5 c it moves by itself, and the contact takes c for a step: speed (F - c) h / M,
// work of cohesion c h (F - c) h / 2 M. Nothing else is lost.
TEST(Cohesion, APullTestBreaksAtTheForceAndCostsTheWorkOfCohesion) {
  Scene<2> scene = hanging_chain<2>(1, 10);
  scene.gravity.setZero();
  Wall<2> plate{.name = "plate", .shape = Wall<2>::Shape::kSegment};
  drive(plate, Vec2(0, -1), 4);
  plate.a = Vec2(-1, -1);
  plate.b = Vec2(1, -1);
  scene.walls.push_back(plate);
  scene.walls[1].force = 9.9;
  EXPECT_LT(after_steps(scene, 20).walls[1].v.norm(), 1e-12);
  scene.walls[1].force = 15;
  const State<2> off = after_steps(scene, 20);
  EXPECT_NEAR(off.walls[1].v[1], -(5 * kGrainStep + 19 * 15 * kGrainStep) / 4, 1e-12);
  EXPECT_NEAR(off.cohesion_loss, 10 * kGrainStep * 5 * kGrainStep / 8, 1e-14);
  EXPECT_LT(std::abs(off.shock_loss) + std::abs(off.friction_loss), 1e-13);
}

// Over a range r the force c acts on, whatever the step: leaving takes c r, but for the part of a
// step in which the disk leaves the range.
TEST(Cohesion, OverARangeItTakesForceTimesRange) {
  for (const double step : {1e-3, 2.5e-4}) {
    Scene<2> scene = hanging_chain<2>(1, 10);
    scene.step = step;
    scene.gravity.setZero();
    scene.cohesion_range = 0.01;
    scene.bodies[0].v = Vec2(0, -0.02);
    // ½ m v² = 0.4 mJ < c r = 0.1 J: it comes back after 2 m v/c = 8 ms, and stays.
    State<2> state = initial_state(scene);
    balanced_steps(scene, state, static_cast<int>(0.02 / step));
    EXPECT_NEAR(state.bodies[0].v[1], 0, 1e-12);
    EXPECT_NEAR(state.bodies[0].x[1], -0.5, 1e-9);
    EXPECT_NEAR(state.cohesion_loss, 0, 1e-12) << "what it took it gave back";
    // ½ m v² = 0.16 J: it leaves with v² = 0.16 - 2 c r/m = 0.06.
    scene.bodies[0].v = Vec2(0, -0.4);
    state = initial_state(scene);
    balanced_steps(scene, state, static_cast<int>(0.05 / step));
    const double leaves = std::sqrt(0.06);
    EXPECT_NEAR(state.cohesion_loss, 0.1, 10 * step * 0.4);
    EXPECT_NEAR(-state.bodies[0].v[1], leaves, 10 * step * 0.4 / (kGrainMass * leaves));
  }
}

// On a slope a body that does not turn is held iff m g sin t <= mu (m g cos t + c). With mu = 0.5
// and 45 degrees: c >= m g / sqrt 2. Else it slides with g sin t - mu (g cos t + c/m).
template <int D>
void stick_on_slope() {
  const double part = kGravity / std::sqrt(2);
  for (const double share : {0.9, 1.1}) {
    const ContactLaw law{.mu = 0.5, .cohesion = share * kGrainMass * part};
    Scene<D> scene = on_floor(sticky<D>(law), 0.5, kGrainMass);
    scene.gravity = part * (Vec<D>::Unit(0) - Vec<D>::Unit(D - 1));
    scene.bodies[0].inertia = 1e9;
    const State<D> state = after_steps(scene, 20);
    const double slides = std::max(0.0, part * (1 - 0.5 * (1 + share)));
    EXPECT_NEAR(state.bodies[0].v[0], slides * 20 * kGrainStep, 1e-8);
    EXPECT_NEAR(state.contacts.at(0).s_n / kGrainStep, kGrainMass * part, 1e-9) << "the true force";
  }
}

TEST(Cohesion, FrictionActsOnTheShiftedCone) {
  stick_on_slope<2>();
  stick_on_slope<3>();
}

// A triangle of three disks on a smooth floor: the top one presses the lower ones apart, with
// N = W/(2 sin 60°) at each side and the tension N cos 60° = W/(2 sqrt 3) between them. A column of
// k disks on it has the weight W = k m g: with c = 2.5 m g/(2 sqrt 3) two stand, three fall.
TEST(Cohesion, AHeapStandsOnASmoothFloorUpToTheDerivedHeight) {
  for (const int column : {2, 3}) {
    Scene<2> scene = sticky<2>({.cohesion = 2.5 * kGrainMass * kGravity / (2 * std::sqrt(3.0))});
    scene.materials = {"grain", "floor"};
    scene.laws = {scene.laws[0], {}, {}, {}};
    scene.walls = {flat_floor<2>()};
    scene.walls[0].material = 1;
    scene.bodies = {round_body<2>(Vec2(-0.5, 0.5), 0.5, kGrainMass),
                    round_body<2>(Vec2(0.5, 0.5), 0.5, kGrainMass)};
    const double top = 0.5 + std::sqrt(0.75);
    for (int k = 0; k < column; ++k) {
      scene.bodies.push_back(round_body<2>(Vec2(0, top + k), 0.5, kGrainMass));
    }
    State<2> state = initial_state(scene);
    balanced_steps(scene, state, 30);
    const double apart = state.bodies[1].x[0] - state.bodies[0].x[0] - 1;
    if (column == 2) {
      EXPECT_LT(std::abs(apart), 1e-8);
    } else {
      EXPECT_GT(apart, 1e-2);
    }
  }
}

// Two disks that turn about each other at w need the tension m w² a. In a range the gap that the
// straight ways of a step open is closed again; without one they part.
TEST(Cohesion, ARangeHoldsBodiesThatTurnAboutEachOther) {
  for (const double range : {0.0, 1e-3}) {
    Scene<2> scene = sticky<2>({.mu = 0.3, .cohesion = 10});
    scene.gravity.setZero();
    scene.cohesion_range = range;
    scene.bodies = {round_body<2>(Vec2(-0.5, 0), 0.5, kGrainMass, Vec2(0, -0.5), 1),
                    round_body<2>(Vec2(0.5, 0), 0.5, kGrainMass, Vec2(0, 0.5), 1)};
    State<2> state = initial_state(scene);
    const double turning = angular_momentum(state);
    balanced_steps(scene, state, 628);
    const double distance = (state.bodies[0].x - state.bodies[1].x).norm();
    EXPECT_NEAR(angular_momentum(state), turning, 1e-6);
    if (range > 0) {
      EXPECT_LT(distance, 1 + range);
      EXPECT_NEAR(state.contacts.at(0).s_n / kGrainStep, -kGrainMass * 0.5, 0.02);
    } else {
      EXPECT_GT(distance, 2);
    }
  }
}

// A cluster of two disks below a ceiling hangs on both, up to m g = 2 c.
TEST(Cohesion, HoldsAClusterAtBothOfItsDisks) {
  for (const double share : {0.9, 1.1}) {
    const std::string text = R"(
contact = {cohesion = 10}
clusters = [{parts = [[-0.5, 0, 0.5], [0.5, 0, 0.5]], position = [0, -0.5], density = 1}]
walls = [{point = [0, 0], normal = [0, -1]}]
time = {step = 0.01, steps = 10}
)";
    Scene<2> scene = scene_of(text);
    scene.solver.tol = 1e-13;
    scene.gravity = Vec2(0, -share * 20 / scene.clusters.bodies[0].mass);
    const double v = after_steps(scene, 1).clusters.bodies[0].v[1];
    EXPECT_NEAR(v, share < 1 ? 0 : -0.1 * 20 / scene.clusters.bodies[0].mass * kGrainStep, 1e-9);
  }
}

// Disks in a row across a cell whose width the stress pulls at with the force F: they hold to F = c.
TEST(Cohesion, HoldsTheSideOfACell) {
  for (const double share : {0.9, 1.1}) {
    Scene<2> scene = sticky<2>({.cohesion = 6});
    scene.gravity.setZero();
    scene.cell.in_x = scene.cell.in_y = true;
    scene.cell.width = {.motion = CellSide::Motion::kDriven, .length = 3};
    scene.cell.height.length = 3;
    scene.cell.width.stress = -share * 6 / 3;  // F = -stress × height
    scene.cell.width.mass = 5;
    for (int k = 0; k < 3; ++k) {
      scene.bodies.push_back(round_body<2>(Vec2(0.5 + k, 1.5), 0.5, kGrainMass));
    }
    const State<2> state = after_steps(scene, 10);
    if (share < 1) {
      EXPECT_NEAR(state.cell.width.speed, 0, 1e-10);
      for (const auto& c : state.contacts) EXPECT_NEAR(c.s_n / kGrainStep, -5.4, 1e-8);
    } else {
      EXPECT_GT(state.cell.width.speed, 0.01);
    }
  }
}

// A disk lies on a floor, is thrown up, and lands again. Then gravity points upwards, and the disk
// is held, c > m g, unless its bond broke in the throw.
TEST(Cohesion, ABondThatBrokeDoesNotComeBack) {
  for (const bool heal : {true, false}) {
    const ContactLaw law{.cohesion = 2 * kGrainMass * kGravity};
    Scene<2> scene = on_floor(sticky<2>(law), 0.5, kGrainMass);
    scene.heal = heal;
    State<2> state = after_steps(scene, 3);
    EXPECT_TRUE(state.contacts.at(0).bonded);
    const auto flip = [&] { scene.gravity = -scene.gravity; };
    flip();
    balanced_steps(scene, state, 3);
    EXPECT_NEAR(state.bodies[0].v[1], 0, 1e-12) << "the bond holds";
    flip();
    state.bodies[0].v = Vec2(0, 0.5);
    balanced_steps(scene, state, 30);
    EXPECT_NEAR(state.bodies[0].v[1], 0, 1e-12) << "landed";
    EXPECT_EQ(state.contacts.at(0).bonded, heal);
    flip();
    balanced_steps(scene, state, 1);
    EXPECT_NEAR(state.bodies[0].v[1], heal ? 0 : kGrainStep * kGravity, 1e-12);
  }
}

/// A heap in which some contacts are in tension: a triangle as above beside a chain.
Scene<2> sticky_heap() {
  Scene<2> scene = hanging_chain<2>(3, 3.2 * kGrainMass * kGravity);
  scene.walls.push_back(half_space<2>(Vec2(0, -5), Vec2(0, 1)));
  for (const Vec2& x : {Vec2(3, -4.5), Vec2(4, -4.5), Vec2(3.5, -4.5 + std::sqrt(0.75))}) {
    scene.bodies.push_back(round_body<2>(x, 0.5, kGrainMass, Vec2(1, 0)));
  }
  return scene;
}

TEST(Cohesion, EverySolverFindsTheSameStep) {
  const Scene<2> scene = sticky_heap();
  const ContactProblem p = step_problem(scene, initial_state(scene));
  const SolveResult exact = converged(solve("pgs", p, {.tol = 1e-13}));
  for (const std::string& name : solver_names()) {
    const SolverEntry& entry = require_solver(name);
    if (p.dim > entry.max_dim || p.num_contacts() > entry.max_contacts) continue;
    const SolveResult r = converged(solve(name, p, {.tol = 1e-9, .max_iterations = 200000}), name);
    EXPECT_LT((r.u - exact.u).norm(), 1e-6) << name;
    EXPECT_LT((p.H * (r.s - exact.s)).norm(), 1e-6) << name;
  }
}

TEST(Cohesion, ARestartContinuesBitForBit) {
  for (const bool heal : {true, false}) {
    Scene<2> scene = sticky_heap();
    scene.heal = heal;
    scene.laws[0].cohesion *= 0.9;  // the chain breaks
    scene.num_steps = 40;
    EXPECT_NE(expect_exact_restart(scene, 23).cohesion_loss, 0);
  }
}

TEST(Cohesion, IsReadAndRefusedWithItsReason) {
  const std::string rest = "\n[time]\nstep = 0.01\nsteps = 1\n";
  const Scene<2> scene = scene_of(
      "materials = [\"a\", \"b\"]\n[contact]\ncohesion = 2\ncohesion_range = 0.1\nheal = false\n"
      "[[pairs]]\nbetween = [\"a\", \"b\"]\ncohesion = 0\n" +
      rest);
  EXPECT_EQ(scene.law(0, 0).cohesion, 2);
  EXPECT_EQ(scene.law(0, 1).cohesion, 0);
  EXPECT_EQ(scene.cohesion_range, 0.1);
  EXPECT_FALSE(scene.heal);
  const auto refused = refused_scenes(rest);
  refused("[contact]\ncohesion = -1", "cohesion");
  refused("[contact]\nheal = false", "need cohesion");
  refused("[contact]\ncohesion = 1\ncohesion_range = 0.1\ne_n = 0.5", "e_n = 0 alone");
  refused("model = \"dem\"\n[contact]\ncohesion = 1", "dem");
  refused_scenes(rest + "accuracy = 0.1\n")("[contact]\ncohesion = 1", "needs a cohesion_range");
}

}  // namespace
}  // namespace bipot
