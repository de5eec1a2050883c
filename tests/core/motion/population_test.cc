#include "core/motion/population.h"

#include "core/run_files/frame_entries.h"
#include "core/scene/cluster_motion.h"
#include "core/scene/contact_detection.h"
#include "tests/support/refused_scene.h"
#include "tests/support/scene_run.h"
#include "tests/support/scene_text.h"
#include "tests/support/source_folder.h"

namespace bipot {
namespace {

constexpr double kPopulationStep = 0.01;  // s

template <int D>
Scene<D> falling_scene() {
  Scene<D> scene = one_law<D>({});
  scene.gravity = -10 * Vec<D>::Unit(D - 1);
  scene.step = kPopulationStep;
  scene.solver = {.name = "pgs", .tol = 1e-6};
  return scene;
}

template <int D>
Outlet<D> below(double height) {
  return Outlet<D>{.name = "bottom", .point = height * Vec<D>::Unit(D - 1)};
}

/// Bodies of 1, 2, 3 kg fall freely from 0.2, 0.45 and 0.8 m into an outlet below 0: under 10 m/s²
/// after 0.2, 0.3 and 0.4 s (the mid-point scheme is exact), that is at the end of steps 20, 30,
/// 40, so that they are missing from the states after steps 21, 31, 41. Each takes m g y0 of energy
/// and -m g t of momentum.
template <int D>
void bodies_leave_when_and_as_they_should() {
  Scene<D> scene = falling_scene<D>();
  // A hair below, so that rounding does not decide.
  const double heights[] = {0.2 - 1e-6, 0.45 - 1e-6, 0.8 - 1e-6};
  for (int k = 0; k < 3; ++k) {
    const Vec<D> x = heights[k] * Vec<D>::Unit(D - 1) + k * Vec<D>::Unit(0);
    scene.bodies.push_back(round_body<D>(x, 0.05, k + 1));
  }
  scene.outlets = {below<D>(0)};
  const double initial = potential_energy<D>(initial_state(scene), scene.gravity);
  Vec<D> pushed = Vec<D>::Zero();
  const State<D> end = solved_run(scene, 50, [&](const State<D>& state, const StepReport<D>& r) {
    const int left = state.step > 40 ? 3 : state.step > 30 ? 2 : state.step > 20 ? 1 : 0;
    const GateFlow<D>& out = state.population.outlets[0];
    ASSERT_EQ(out.count, left) << state.step;
    ASSERT_EQ(state.bodies.size(), to_size(3 - left)) << state.step;
    if (left < 3) {
      EXPECT_EQ(body_number(state, 0), left);
      EXPECT_EQ(body_index(state, left), 0);
    }
    if (left > 0) {
      EXPECT_EQ(body_index(state, 0), -1);
    }
    EXPECT_EQ(out.last_mass, state.step == 21   ? 1.0
                             : state.step == 31 ? 2.0
                             : state.step == 41 ? 3.0
                                                : 0.0);
    for (const Body<D>& b : state.bodies) pushed += kPopulationStep * b.mass * scene.gravity;
    EXPECT_LT((momentum(state) - pushed - passed(state).momentum).norm(), 1e-12);
    EXPECT_NEAR(r.energy.kinetic + r.energy.potential, initial + r.energy.passed, 1e-12);
  });
  const GateFlow<D>& out = end.population.outlets[0];
  EXPECT_EQ(out.mass, 6);
  double taken = 0;
  for (int k = 0; k < 3; ++k) taken += (k + 1) * 10 * heights[k];
  EXPECT_NEAR(out.energy, taken, 1e-12);
  EXPECT_NEAR(out.momentum[D - 1], -10 * (1 * 0.2 + 2 * 0.3 + 3 * 0.4), 1e-12);
}

TEST(Population, DisksLeaveWhenAndAsTheyShould) { bodies_leave_when_and_as_they_should<2>(); }
TEST(Population, SpheresLeaveWhenAndAsTheyShould) { bodies_leave_when_and_as_they_should<3>(); }

// Two disks of 0.1 m, joined to a cluster of 4 kg that turns, fall from 0.2 m: the centre of mass
// decides, as for one body. A heavy disk higher up stays.
TEST(Population, AClusterLeavesAsAWhole) {
  Scene<2> scene = falling_scene<2>();
  scene.bodies = {round_body<2>(Vec2(2, 5), 0.1, 8)};
  for (const double x : {-0.1, 0.1}) scene.bodies.push_back({.x = Vec2(x, 0.2), .radius = 0.1});
  join_disks(scene, 2, {.mass = 4});
  scene.clusters.bodies[0].spin = 5;
  scene.outlets = {below<2>(1e-6)};
  const double inertia = scene.clusters.bodies[0].inertia;
  StepReport<2> r;
  const State<2> state = solved_run(scene, 21, [&](const State<2>& now, const StepReport<2>& last) {
    EXPECT_EQ(now.bodies.size(), now.step < 21 ? 3u : 1u);
    r = last;
  });
  ASSERT_EQ(state.bodies.size(), 1u);
  EXPECT_TRUE(state.clusters.empty());
  EXPECT_EQ(body_number(state, 0), 0);
  EXPECT_EQ(body_index(state, 2), -1);
  const GateFlow<2>& out = state.population.outlets[0];
  EXPECT_EQ(out.count, 1);
  EXPECT_EQ(out.mass, 4);
  // m g y0 and the energy of its turning; m g t of momentum with t = 0.2 s.
  EXPECT_NEAR(out.energy, 4 * 10 * 0.2 + 0.5 * inertia * 25, 1e-12);
  EXPECT_NEAR(out.momentum[1], -4 * 10 * 0.2, 1e-12);
  EXPECT_LT(std::abs(r.energy.imbalance), 1e-12);
}

TEST(Population, AnOutletIsAHalfPlaneOrABoxAndHoldsItsEdge) {
  Outlet<2> plane{.point = Vec2(1, 0)};
  plane.normal = Vec2(1, 0);  // out of the outlet: what is left of x = 1 leaves
  EXPECT_TRUE(plane.takes(Vec2(1, 7)));
  EXPECT_TRUE(plane.takes(Vec2(0.9, -7)));
  EXPECT_FALSE(plane.takes(Vec2(1.1, 0)));
  Outlet<2> box{.box = true, .lower = Vec2(0, 0), .upper = Vec2(2, 1)};
  EXPECT_TRUE(box.takes(Vec2(2, 0.5)));
  EXPECT_FALSE(box.takes(Vec2(2.1, 0.5)));
  EXPECT_FALSE(box.takes(Vec2(1, -0.1)));
}

Inlet<2> square_inlet(double side, double rate) {
  return {.name = "inlet",
          .upper = Vec2(side, side),
          .rate = rate,
          .radii = {0.1},
          .shares = {1},
          .density = 100};
}

// A cluster falls out, and a disk comes in later: the run can be continued from its frames.
TEST(Population, ADiskThatComesInAfterAllClustersLeftContinuesARun) {
  const TemporaryFolder folder;
  const Scene<2> scene = scene_of(R"(
gravity = [0, -10]
clusters = [{parts = [[0, 0, 0.1], [0.15, 0, 0.1]], mass = 1, position = [0, 0.1]}]
outlets = [{point = [0, 0], normal = [0, 1]}]
inlets = [{lower = [0, 1], upper = [1, 2], rate = 1, radii = [0.1], density = 1, starts = 0.25}]
time = {step = 0.01, steps = 40}
)");
  RunWriter<2> writer(folder / "out", scene, "");
  const State<2> end = solved_run(scene, [&](const State<2>& state, const StepReport<2>& r) {
    if (r.step == 20) {
      EXPECT_TRUE(state.bodies.empty());
    }
  });
  ASSERT_EQ(end.bodies.size(), 1u);
  writer.frame(end);
  writer.close();
  EXPECT_EQ(read_state<2>(folder / "out").bodies[0].x, end.bodies[0].x);
}

TEST(Population, BodiesComeInAtTheirTimes) {
  // Body k is due at 0.05 s + k / 20: those of t = 0.05, 0.10, ... appear in the steps that start
  // there, so after step n there are floor((n - 1 - 5) / 5) + 1 of them, no more than 6 in all.
  // They then fall freely: after its step of 0.01 s a body has v = v0 - 10 · 0.01.
  Scene<2> scene = falling_scene<2>();
  Inlet<2> inlet = square_inlet(9, 20);
  inlet.starts = 0.05;
  inlet.count = 6;
  inlet.v = Vec2(0.5, -1);
  inlet.spin = 3;
  scene.inlets = {inlet};
  ASSERT_EQ(validate(scene), "");
  const State<2> end = solved_run(scene, 60, [&](const State<2>& state, const StepReport<2>&) {
    const int due = state.step < 6 ? 0 : std::min(6, (state.step - 6) / 5 + 1);
    ASSERT_EQ(state.bodies.size(), to_size(due)) << state.step;
    ASSERT_EQ(state.population.inlets[0].count, due);
    if (state.step == 6) {
      EXPECT_LT((state.bodies[0].v - Vec2(0.5, -1.1)).norm(), 1e-15);
      EXPECT_EQ(state.bodies[0].spin, 3);
    }
  });
  EXPECT_EQ(end.population.inlets[0].waiting, 0);
  const double mass = 100 * std::numbers::pi * 0.01;
  EXPECT_NEAR(end.population.inlets[0].mass, 6 * mass, 1e-12);
  EXPECT_NEAR(end.bodies[3].inertia, 0.5 * mass * 0.01, 1e-15);
  EXPECT_NEAR(end.population.inlets[0].momentum[0], 6 * mass * 0.5, 1e-12);
}

TEST(Population, WhatFindsNoRoomWaits) {
  // The box has room for one disk alone, in its middle. It moves out with 1 m/s, without gravity;
  // the next fits when the first has gone by more than its diameter, 0.2 m (plus the contact
  // distance): after 21 steps of 0.01 s. One is due in every step, so from the second on somebody
  // always waits.
  Scene<2> scene = falling_scene<2>();
  scene.gravity.setZero();
  scene.contact_distance = 1e-6;
  Inlet<2> inlet = square_inlet(0.2, 100);
  inlet.v = Vec2(1, 0);
  scene.inlets = {inlet};
  std::vector<int> entered_at;
  const State<2> end = solved_run(scene, 64, [&](const State<2>& state, const StepReport<2>& r) {
    entered_at.resize(to_size(state.population.inlets[0].count), r.step);
  });
  EXPECT_EQ(entered_at, (std::vector<int>{1, 22, 43, 64}));
  EXPECT_EQ(end.population.inlets[0].waiting, 63);
}

TEST(Population, AnInletMindsWallsAndDrawsItsClassesByTheirShares) {
  // The floor cuts the box: no disk lies less than its radius above it. Of 400 draws with
  // probability 1/4 a share of 100 ± 4 · sqrt(400 · 3/16) = 100 ± 35 is the smaller class.
  Scene<2> scene = falling_scene<2>();
  scene.gravity.setZero();
  scene.walls = {half_space<2>(Vec2(0, 10), Vec2(0, 1))};
  Inlet<2> inlet = square_inlet(20, 40000);
  inlet.radii = {0.1, 0.05};
  inlet.shares = {3, 1};
  inlet.count = 400;
  scene.inlets = {inlet};
  State<2> state = initial_state(scene);
  change_population(scene, state);  // one is due at time 0
  EXPECT_EQ(state.bodies.size(), 1u);
  state.time = kPopulationStep;
  change_population(scene, state);
  ASSERT_EQ(state.bodies.size(), 400u);
  int small = 0;
  std::set<double> places;
  for (const Disk& d : state.bodies) {
    small += d.radius == 0.05 ? 1 : 0;
    EXPECT_GT(d.x[1] - d.radius, 10);
    EXPECT_LE(d.x[1] + d.radius, 20);
    EXPECT_GE(d.x[0] - d.radius, 0);
    places.insert(d.x[0]);
  }
  EXPECT_EQ(places.size(), 400u);
  EXPECT_NEAR(small, 100, 35);
  EXPECT_TRUE(detect_contacts(state.bodies, state.walls, 0).empty());
  // Another seed draws other places, the same seed the same.
  State<2> other = initial_state(scene), same = initial_state(scene);
  change_population(scene, same);
  EXPECT_EQ(same.bodies[0].x, state.bodies[0].x);
  scene.inlets[0].seed = 2;
  change_population(scene, other);
  EXPECT_NE(other.bodies[0].x, state.bodies[0].x);
}

/// A small silo: disks in a funnel fall out of it and are gone, others come in at the top.
constexpr const char* kSilo =
    R"(
contact = {mu = 0.3}
walls = [{from = [-0.3, 0.3], to = [-0.14, 0]}, {from = [0.3, 0.3], to = [0.14, 0]},
  {point = [-0.3, 0], normal = [1, 0]}, {point = [0.3, 0], normal = [-1, 0]}]
outlets = [{name = "hole", point = [0, -0.1], normal = [0, 1]}]
time = {step = 4e-3, steps = 200}
output = {every = 20}
solver = {name = "pgs", tol = 1e-6}
)"
    "disks = [{arrangement = 'random', count = 25, radii = [0.04, 0.05], width = 0.6, spacing = 0, "
    "corner = [-0.3, 0.2], density = 100}]\n"
    "inlets = [{name = 'belt', lower = [-0.25, 1.2], upper = [0.25, 1.4], rate = 40, "
    "radii = [0.04, 0.05], fractions = [1, 2], density = 100, velocity = [0, -1]}]\n";

TEST(Population, WhatCameInIsInsideOrHasLeftAndTheBooksClose) {
  const Scene<2> scene = scene_of(kSilo);
  double mass0 = 0;
  for (const Disk& d : scene.bodies) mass0 += d.mass;
  const double initial = potential_energy(initial_state(scene), scene.gravity);
  const State<2> end = solved_run(scene, [&](const State<2>& state, const StepReport<2>& r) {
    double mass = 0;
    for (const Disk& d : state.bodies) mass += d.mass;
    const GateFlow<2>&out = state.population.outlets[0], &in = state.population.inlets[0];
    EXPECT_EQ(state.bodies.size(), to_size(25 + in.count - out.count));
    EXPECT_NEAR(mass0 + in.mass, mass + out.mass, 1e-12);
    EXPECT_LT(std::abs(r.energy.imbalance), 1e-12);
    EXPECT_LT(r.momentum_imbalance.norm(), 1e-12);
    EXPECT_NEAR(r.energy.kinetic + r.energy.potential,
                initial + r.energy.passed - r.energy.friction_loss - r.energy.shock_loss, 1e-11);
  });
  EXPECT_GT(end.population.outlets[0].count, 8);
  EXPECT_GT(end.population.inlets[0].count, 20);
}

TEST(Population, KeptContactsAndWarmStartsFollowTheNumbers) {
  // A stepper that forgets everything between steps, and one that keeps lists: the same bits. And
  // what the solver starts from are the impulses of the same two bodies in the step before.
  const Scene<2> scene = scene_of(kSilo);
  State<2> kept = initial_state(scene), fresh = kept;
  const StepSolver sweeps = make_step_solver(require_solver("pgs"), to_options(scene.solver));
  TimeStepper<2> stepper = stepper_of(scene, "pgs");
  int changes = 0, started = 0;
  while (kept.step < scene.num_steps) {
    stepper.advance(kept);
    const State<2> before = fresh;
    Vector start;
    TimeStepper<2> once(scene, [&](const ContactProblem& p, const Vector& s0) {
      start = s0;
      return sweeps(p, s0);
    });
    once.advance(fresh);
    ASSERT_EQ(bits_of_bodies(kept), bits_of_bodies(fresh));
    if (fresh.population.numbers == before.population.numbers) continue;
    ++changes;
    const auto name = [](const State<2>& s, int body) {
      const int disks = static_cast<int>(s.bodies.size());
      return body < disks ? body_number(s, body) : -1 - (body - disks);
    };
    for (std::size_t c = 0; c < fresh.contacts.size(); ++c) {
      const Contact<2>& now = fresh.contacts[c].contact;
      double expected = 0;
      for (const ContactOutcome<2>& old : before.contacts) {
        if (name(before, old.contact.i) == name(fresh, now.i) &&
            name(before, old.contact.j) == name(fresh, now.j)) {
          expected = old.s_n;
        }
      }
      EXPECT_EQ(start[2 * static_cast<Eigen::Index>(c)], expected);
      started += expected > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(changes, 20);
  EXPECT_GT(started, 100);
}

TEST(Population, AClusterInsideCountsOnceWithItsMass) {
  const Scene<3> scene = scene_of<3>(R"(
dim = 3
walls = [{point = [0, 0, 0], normal = [0, 0, 1], name = "floor"}]
outlets = [{name = "hole", point = [0, 0, -1], normal = [0, 0, 1]}]
spheres = [{position = [3, 3, 1], radius = 0.1, mass = 1}]
clusters = [{position = [0, 0, 1], mass = 2, parts = [[0, 0, 0, 0.1], [0.1, 0, 0, 0.1]]}]
time = {step = 1e-3, steps = 1}
)");
  const std::string row = gates_row(scene, initial_state(scene));
  EXPECT_TRUE(row.starts_with("0,0,2,3,")) << row;
}

TEST(Population, ARunGoesOnBitForBitAndItsFramesSayWhoIsThere) {
  const Scene<2> scene = scene_of(kSilo);
  const TemporaryFolder folder;
  const auto run = [&](State<2> state, int until, RunWriter<2>& writer) {
    TimeStepper<2> stepper = stepper_of(scene, "pgs");
    writer.frame(state);
    while (state.step < until) {
      writer.step(state, stepper.advance(state));
      if (state.step % 20 == 0) writer.frame(state);
    }
    writer.close();
    return state;
  };
  RunWriter<2> whole(folder / "whole", scene, kSilo);
  const State<2> end = run(initial_state(scene), 200, whole);
  RunWriter<2> first(folder / "parts", scene, kSilo);
  run(initial_state(scene), 100, first);
  const State<2> middle = read_state(folder / "parts");
  EXPECT_EQ(middle.step, 100);
  EXPECT_EQ(restart_mismatch(scene, middle), "");
  EXPECT_GT(middle.population.outlets[0].count, 0);
  RunWriter<2> second(folder / "parts", scene, kSilo, 100);
  const State<2> again = run(middle, 200, second);
  EXPECT_EQ(bits_of_bodies(end), bits_of_bodies(again));
  EXPECT_EQ(end.population.numbers, again.population.numbers);
  for (const char* file : {"gates.csv", "ledger.csv", "run.xdmf", "frames/00000200.h5"}) {
    EXPECT_EQ(file_text(folder / "whole" / file), file_text(folder / "parts" / file)) << file;
  }
  // The index has as many points a frame as there are bodies.
  const std::string index = file_text(folder / "whole" / "run.xdmf");
  for (const int step : {0, 100, 200}) {
    const State<2> frame = read_state(folder / "whole", step);
    EXPECT_TRUE(says(index, "NumberOfElements=\"" + std::to_string(frame.bodies.size()) +
                                "\" NodesPerElement=\"1\"><DataItem Dimensions=\"" +
                                std::to_string(frame.bodies.size())));
  }
  State<2> wrong = again;
  wrong.population.outlets.clear();
  EXPECT_NE(restart_mismatch(scene, wrong), "");
}

TEST(Population, ASceneFileSaysWhereAndContradictionsAreRefused) {
  const std::string time = "[time]\nstep = 1e-3\nsteps = 1\n";
  const auto refused = refused_scenes(time);
  const std::string inlet =
      "[[inlets]]\nlower = [0, 0]\nupper = [1, 1]\nrate = 5\nradii = [0.1]\nmass = 2\n";
  EXPECT_EQ(scene_of(inlet + time).contact_distance, 1e-7);
  refused(inlet + "seeds = 1\n", "seed");
  refused("[[inlets]]\nlower = [0, 0]\nupper = [1, 1]\nrate = 1e9\nradii = [0.1]\nmass = 2\n",
          "1e+06 bodies a step");
  refused(inlet + "mass_of_all = 1\n", "mass");
  refused(inlet + "stops = 0\n", "starts");
  refused("[[inlets]]\nlower = [0, 0]\nupper = [0.1, 1]\nrate = 5\nradii = [0.1]\nmass = 2\n",
          "no room");
  refused("[cell]\nwidth = 3\n" + inlet, "periodic");
  refused("model = 'dem'\n" + inlet, "dem");
  refused("rotate_degrees = 3\n" + inlet, "rotate_degrees");
  refused("[[outlets]]\npoint = [0, 0]\n", "both point and normal");
  refused("[[outlets]]\n", "test.toml:1: [outlets[0]]");
  refused("[[outlets]]\nlower = [0, 0]\nupper = [1, 1]\nnormal = [0, 1]\n", "a box");
  refused("[[outlets]]\nlower = [0, 0]\nupper = [1, 0]\n", "test.toml:3");
  refused("[[outlets]]\nname = 'a'\npoint = [0, 0]\nnormal = [0, 1]\n" + inlet + "name = 'a'\n",
          "must differ");
  const Scene<2> turned =
      scene_of("rotate_degrees = 90\n[[outlets]]\npoint = [1, 0]\nnormal = [0, 2]\n" + time);
  EXPECT_LT((turned.outlets[0].point - Vec2(0, 1)).norm(), 1e-15);
  EXPECT_LT((turned.outlets[0].normal - Vec2(-1, 0)).norm(), 1e-15);
  const auto space = scene_of<3>(
      "dim = 3\n[[inlets]]\nlower = [0, 0, 0]\nupper = [1, 1, 1]\nrate = 5\nradii = [0.1]\n"
      "density = 3\nspin = [0, 1, 0]\n" +
      time);
  State<3> state = initial_state(space);
  change_population(space, state);
  ASSERT_EQ(state.bodies.size(), 1u);
  EXPECT_NEAR(state.bodies[0].mass, 3 * 4 / 3.0 * std::numbers::pi * 1e-3, 1e-15);
  EXPECT_NEAR(state.bodies[0].inertia, 0.4 * state.bodies[0].mass * 0.01, 1e-18);
  EXPECT_EQ(state.bodies[0].spin, Vec3(0, 1, 0));
}

/// One disk in a cell 0.1 m wide and high, whose upper images move to the right at 0.2 m/s; a box
/// that lets out.
Scene<2> in_a_cell(const Vec2& x, const Vec2& v, const Vec2& lower, const Vec2& upper) {
  Scene<2> scene = falling_scene<2>();
  scene.gravity = Vec2::Zero();
  scene.step = 1e-3;
  scene.cell.in_x = scene.cell.in_y = true;
  scene.cell.width.length = scene.cell.height.length = 0.1;
  scene.cell.offset = {.motion = CellSide::Motion::kMoving, .speed = 0.2};
  scene.bodies = {round_body<2>(x, 0.005, 1)};
  scene.bodies[0].v = v;
  scene.outlets = {{.name = "slot", .box = true, .lower = lower, .upper = upper}};
  return scene;
}
int let_out_in_30_steps(const Scene<2>& scene) {
  return solved_run(scene, 30).population.outlets[0].count;
}

// The disk goes 5 mm a step: from the right edge back to the box at the left one, or into a box
// beyond the edge, which is one of the images.
TEST(Population, BoxesAtAndBeyondTheEdgeOfACellAct) {
  const Vec2 x(0.064, 0.05), left(-5, 0);
  for (const double at : {0.0, 0.05, -0.1, 0.1, 0.3}) {
    const Vec2 lower(at, 0), upper(at + 5e-4, 0.1);
    EXPECT_EQ(let_out_in_30_steps(in_a_cell(x, left, lower, upper)), 1) << at;
    EXPECT_EQ(let_out_in_30_steps(in_a_cell(x, Vec2::Zero(), lower, upper)), 0) << at;
  }
  EXPECT_EQ(let_out_in_30_steps(in_a_cell(x, left, Vec2(-0.029, 0), Vec2(-0.001, 0.1))), 1);
}

// At rest 1 mm beside the box, in whatever image it is written.
TEST(Population, ABoxInADeformingCellTakesABodyInAnyImageAlike) {
  for (const int k : {0, 1, 20}) {
    const Vec2 x = Vec2(0.03, 0.02 + 0.1 * k), v(0.2 * k, 0);
    EXPECT_EQ(let_out_in_30_steps(in_a_cell(x, v, Vec2(0.031, 0), Vec2(0.0313, 0.05))), 0) << k;
    EXPECT_EQ(let_out_in_30_steps(in_a_cell(x, v, Vec2(0.029, 0), Vec2(0.031, 0.05))), 1) << k;
  }
}

// A disk at rest in its cell: its image in the fifth row above moves at 1 m/s, 1 mm a step, and
// comes by every half second.
TEST(Population, AThinBoxTakesAnImageThatMovesWithItsCell) {
  Scene<2> scene = in_a_cell(Vec2(0.03, 0.02), Vec2::Zero(), Vec2(0.0771, 0.5), Vec2(0.0774, 0.55));
  scene.num_steps = 100;
  int taken = 0;
  solved_run(scene, [&](const State<2>& state, const StepReport<2>&) {
    if (taken == 0 && state.population.outlets[0].count > 0) taken = state.step;
  });
  EXPECT_NEAR(taken, 48, 1.5);  // (77.2 - 30) mm, and out before the next step
}

// All images that may reach a thin box are among the few, also where sides move against each other.
TEST(Population, TheFewImagesOfABoxHoldOneThatItTakes) {
  PeriodicCell cell{.in_x = true, .in_y = true};
  cell.width = {.motion = CellSide::Motion::kMoving, .length = 0.1, .speed = -0.2};
  cell.height = {.length = 0.1};
  cell.offset = {.motion = CellSide::Motion::kMoving, .length = 0.03, .speed = 0.2};
  constexpr double kHalf = 5e-3;
  const Vec2 x(0.09, 0.004);
  Box<2> at;
  at.include(x);
  for (int kx = -6; kx <= 6; ++kx) {
    for (int ky = -6; ky <= 6; ++ky) {
      const Vec2 way = kHalf * cell.shift_velocity(kx, ky), image = x + cell.shift(kx, ky);
      for (const double part : {-0.99, 0.0, 0.99}) {
        const Vec2 place = image + part * way;
        Outlet<2> outlet{.name = "thin", .box = true};
        outlet.lower = place - Vec2(1e-6, 2e-3);
        outlet.upper = place + Vec2(1e-6, 2e-3);
        ASSERT_TRUE(outlet.takes(image, way));
        const auto images = first_images_over(cell, at, kHalf, {outlet.lower, outlet.upper});
        EXPECT_TRUE(std::ranges::any_of(images,
                                        [&](const CellNumber& k) {
                                          return outlet.takes(
                                              x + cell.shift(k.kx, k.ky),
                                              kHalf * cell.shift_velocity(k.kx, k.ky));
                                        }))
            << kx << ' ' << ky;
      }
    }
  }
}

TEST(Population, ABoxFarWiderThanTheCellActsAtOnce) {
  const Scene<2> scene =
      in_a_cell(Vec2(0.03, 0.02), Vec2::Zero(), Vec2(-1e12, -1e12), Vec2(1e12, 1e12));
  EXPECT_EQ(let_out_in_30_steps(scene), 1);
  const Scene<2> beside =
      in_a_cell(Vec2(0.03, 0.02), Vec2::Zero(), Vec2(-1e9, 0.05), Vec2(1e9, 0.06));
  EXPECT_EQ(let_out_in_30_steps(beside), 0);
}

TEST(Population, ABoxIsNotJumpedOver) {
  // 1 cm thick; 10 m/s in steps of 10 ms are 10 cm.
  Outlet<2> outlet{.name = "slot", .box = true, .lower = Vec2(0, 0), .upper = Vec2(0.01, 1)};
  const Vec2 way(0.05, 0);  // half a step
  EXPECT_TRUE(outlet.takes(Vec2(0.04, 0.5), way));
  EXPECT_TRUE(outlet.takes(Vec2(-0.04, 0.5), way));
  EXPECT_FALSE(outlet.takes(Vec2(0.07, 0.5), way));
  EXPECT_FALSE(outlet.takes(Vec2(0.04, 1.5), way));
  EXPECT_FALSE(outlet.takes(Vec2(0.012, 0.5), Vec2(0.004, 0)));  // slow: where it is at the end
}

}  // namespace
}  // namespace bipot
