// Steps of a state that lies on several processes against those of one that does not.

#include "core/motion/time_stepping.h"
#include "core/scene/scene_parts.h"
#include "solvers/simulation/domain.h"
#include "solvers/simulation/step_solver.h"
#include "tests/solvers/parallel/mpi_group.h"
#include "tests/solvers/simulation/domain_scenes.h"
#include "tests/support/state_bits.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// Which solver, how exact: with exact sums apgd has the same bits for any number of processes.
struct Way {
  std::string solver = "apgd";
  double tol = 1e-5;
  bool exact = true;
};

SolverOptions options_of(const Way& way) {
  return SolverOptions{.tol = way.tol, .max_iterations = 20000};
}

/// A state on the processes of a group, and its steps.
template <int D>
struct Spread {
  Spread(const Scene<D>& scene, const State<D>& whole, ProcessGroup& group, const Way& way,
         const DomainOptions& options = {})
      : domain(
            scene, whole, group,
            [&group, way](const ProblemPiece& piece, const Vector& s0) {
              SolverOptions own = options_of(way);
              own.s0 = s0;
              return distributed_solve(way.solver, piece, own, group, {.reproducible = way.exact});
            },
            options),
        stepper(scene, domain) {}
  StepReport<D> advance() { return stepper.advance(domain.state()); }

  Domain<D> domain;
  TimeStepper<D> stepper;
};

/// The same with the state of the whole on one process.
template <int D>
TimeStepper<D> whole_stepper(const Scene<D>& scene, const Way& way) {
  return TimeStepper<D>(scene, [way](const ContactProblem& problem, const Vector& s0) {
    const auto lone = lone_process();
    SolverOptions options = options_of(way);
    options.s0 = s0;
    return to_step_solution(
        distributed_solve(way.solver, problem, options, *lone, {.reproducible = way.exact}).result);
  });
}

/// Steps of one scene on all processes and on one.
template <int D>
struct Both {
  Both(const Scene<D>& scene, const Way& way, const DomainOptions& options = {})
      : whole(initial_state(scene)),
        alone(whole_stepper<D>(scene, way)),
        spread(scene, whole, mpi_group(), way, options) {}
  /// The reports of both.
  std::pair<StepReport<D>, StepReport<D>> advance() {
    StepReport<D> several = spread.advance();
    return {several, alone.advance(whole)};
  }
  State<D> whole;
  TimeStepper<D> alone;
  Spread<D> spread;
};

template <int D>
void expect_same_bits(const State<D>& got, const State<D>& expected) {
  EXPECT_EQ(got.time, expected.time);
  EXPECT_EQ(got.step, expected.step);
  EXPECT_EQ(bits_of_bodies(got), bits_of_bodies(expected));
  EXPECT_EQ(bits_of_contacts(got), bits_of_contacts(expected));
  // Sums of the ledger depend on the number of processes in their last bits.
  EXPECT_NEAR(got.friction_loss, expected.friction_loss, 1e-12 * expected.shock_loss);
  EXPECT_NEAR(got.shock_loss, expected.shock_loss, 1e-12 * expected.shock_loss);
}

TEST(DomainRun, TwoHundredStepsWithMigrationAndNewCellsHaveTheBitsOfOneProcess) {
  const Scene<2> scene = breaking_dam(100);
  ProcessGroup& group = mpi_group();
  const Way way{.tol = 3e-2};  // bits are the same at any tolerance
  Both<2> run(scene, way, {.cut_every = 9});
  double most_energy = 0, contacts = 0;
  for (int step = 1; step <= 200; ++step) {
    const auto [r, one] = run.advance();
    ASSERT_TRUE(r.converged) << r.message;
    ASSERT_EQ(r.step, step);
    EXPECT_EQ(r.time, one.time);
    EXPECT_EQ(r.contacts, one.contacts);
    EXPECT_EQ(r.active, one.active);
    EXPECT_EQ(r.iterations, one.iterations);
    EXPECT_EQ(r.penetration, one.penetration);
    EXPECT_EQ(r.error.epsilon, one.error.epsilon);
    EXPECT_EQ(r.error.worst_epsilon, one.error.worst_epsilon);
    most_energy = std::max({most_energy, std::abs(r.energy.potential), r.energy.kinetic});
    contacts += r.contacts;
    // The ledger closes: energies and momentum are what they were, but for what contacts took.
    EXPECT_NEAR(r.energy.imbalance, 0, 1e-12 * most_energy) << step;
    EXPECT_NEAR(r.momentum_imbalance.norm(), 0, 1e-11 * most_energy) << step;
    EXPECT_NEAR(r.energy.kinetic, one.energy.kinetic, 1e-12 * most_energy);
    EXPECT_NEAR(r.energy.potential, one.energy.potential, 1e-12 * most_energy);
    EXPECT_NEAR(r.energy.friction_loss, one.energy.friction_loss, 1e-12 * most_energy);
    EXPECT_NEAR(r.energy.shock_loss, one.energy.shock_loss, 1e-12 * most_energy);
    EXPECT_NEAR((r.momentum - one.momentum).norm(), 0, 1e-11 * most_energy);
    if (testing::Test::HasFailure()) break;
  }
  EXPECT_GT(contacts, 200 * 50);  // it is no gas
  const State<2> gathered = run.spread.domain.gather();
  if (group.rank() == 0) expect_same_bits(gathered, run.whole);
  const DomainCounts counts = largest_counts(run.spread.domain.counts(), group);
  EXPECT_EQ(counts.steps, 200);
  EXPECT_GE(counts.cuts, 200 / 9);
  if (group.size() == 1) {
    EXPECT_EQ(counts.migrated, 0);
    EXPECT_EQ(counts.migration.messages + counts.detection.messages, 0);
  } else {
    EXPECT_GT(counts.migrated, 40);
    EXPECT_GT(counts.migration.bytes, counts.migrated * 12 * 8 / group.size());
    EXPECT_GT(counts.detection.messages, 200);
    EXPECT_LT(counts.most_bodies, 100);
  }
}

TEST(DomainRun, WithOrdinarySumsPlacesAgreeToTheTolerance) {
  // Impulses are off by about the tolerance of their energy, in another way on other processes;
  // a dam that has broken amplifies that, a pile at rest does not.
  const Scene<2> scene = pressed_box(6);
  ProcessGroup& group = mpi_group();
  for (const char* solver : {"apgd", "auto", "ipm"}) {
    const Way way{.solver = solver, .tol = 1e-9, .exact = false};
    Both<2> run(scene, way, {.cut_every = 7});
    for (int step = 0; step < 30; ++step) {
      const auto [r, one] = run.advance();
      ASSERT_TRUE(r.converged) << r.message;
      EXPECT_EQ(r.contacts, one.contacts);
      // With a driven lid: its work and its momentum are in the balance.
      EXPECT_NEAR(r.energy.imbalance, 0, 1e-9);
      EXPECT_NEAR(r.momentum_imbalance.norm(), 0, 1e-9);
      EXPECT_NEAR(r.energy.wall_work, one.energy.wall_work, 1e-4);
    }
    const State<2>& here = run.spread.domain.state();
    EXPECT_EQ(here.walls.size(), run.whole.walls.size());
    EXPECT_NEAR(here.walls[3].a[1], run.whole.walls[3].a[1], 1e-6) << solver;
    const State<2> gathered = run.spread.domain.gather();
    if (group.rank() == 0) {
      EXPECT_LE(farthest(gathered.bodies, run.whole.bodies), 1e-6) << solver;
    }
  }
}

TEST(DomainRun, WallsThatMoveAndCarryDisksAreTheSameEverywhere) {
  for (const NamedScene& s : domain_scenes()) {
    if (s.name != "sheared" && s.name != "two disks" && s.name != "no contact") continue;
    SCOPED_TRACE(s.name);
    Both<2> run(s.scene, {.tol = 1e-3}, {.cut_every = 3});
    for (int step = 0; step < 20; ++step) {
      const auto [r, one] = run.advance();
      EXPECT_EQ(r.contacts, one.contacts);
      EXPECT_NEAR(r.energy.wall_work, one.energy.wall_work, 1e-9);
      EXPECT_NEAR(r.energy.imbalance, 0, 1e-9);
    }
    const State<2> gathered = run.spread.domain.gather();
    if (mpi_group().rank() == 0) {
      EXPECT_LE(farthest(gathered.bodies, run.whole.bodies), 1e-9);
      EXPECT_NEAR(gathered.wall_work, run.whole.wall_work, 1e-9);
    }
  }
}

TEST(DomainRun, SpheresMoveAsOnOneProcess) {
  const Scene<3> scene = box_of_spheres();
  Both<3> run(scene, {.tol = 1e-2}, {.cut_every = 5});
  for (int step = 0; step < 25; ++step) EXPECT_NEAR(run.advance().first.energy.imbalance, 0, 1e-9);
  const State<3> gathered = run.spread.domain.gather();
  if (mpi_group().rank() == 0) expect_same_bits(gathered, run.whole);
}

TEST(DomainRun, ALoneProcessAndAStateCutAgainGoOnTheSame) {
  const Scene<2> scene = breaking_dam(60);
  ProcessGroup& group = mpi_group();
  const auto lone = lone_process();
  const Way way{.tol = 3e-2};
  const State<2> start = initial_state(scene);
  Spread<2> first(scene, start, group, way), alone(scene, start, *lone, way);
  for (int step = 0; step < 30; ++step) first.advance();
  for (int step = 0; step < 60; ++step) alone.advance();
  // As a restart does it: the whole from the first process to all, and cut there.
  const State<2> gathered = first.domain.gather();
  State<2> whole = initial_state(scene);
  TimeStepper<2> serial = whole_stepper<2>(scene, way);
  for (int step = 0; step < 30; ++step) serial.advance(whole);
  if (group.rank() == 0) expect_same_bits(gathered, whole);
  Spread<2> second(scene, whole, group, way);
  for (int step = 0; step < 30; ++step) second.advance();
  const State<2> last = second.domain.gather(), expected = alone.domain.gather();
  if (group.rank() == 0) expect_same_bits(last, expected);
}

TEST(DomainRun, ABodyThatIsLostOrTwiceIsSeen) {
  ProcessGroup& group = mpi_group();
  const Scene<2> scene = breaking_dam(40);
  const State<2> whole = initial_state(scene);
  DomainState<2> state = cut_state(whole, cut_cells(whole, group.size()), group.rank());
  DomainState<2> lost = state, twice = state;
  if (!lost.numbers.empty() && group.rank() == group.size() - 1) {
    lost.numbers.pop_back();
    lost.here.bodies.pop_back();
    twice.numbers.push_back(twice.numbers.front());
    twice.here.bodies.push_back(twice.here.bodies.front());
  }
  EXPECT_NO_THROW(gather_state(state, group));
  EXPECT_THROW(gather_state(lost, group), CommonFailure);
  EXPECT_THROW(gather_state(twice, group), CommonFailure);
}

TEST(DomainRun, AStepThatCannotBeTakenLeavesTheState) {
  ProcessGroup& group = mpi_group();
  const Scene<2> scene = breaking_dam(40);
  State<2> whole = initial_state(scene);
  for (Disk& d : whole.bodies) d.x[1] *= 0.97;  // in touch
  Domain<2> domain(scene, whole, group, [&](const ProblemPiece& piece, const Vector& s0) {
    SolverOptions options{.s0 = s0, .cancelled = [&] { return group.rank() == group.size() - 1; }};
    return distributed_solve("apgd", piece, options, group);
  });
  TimeStepper<2> stepper(scene, domain);
  const auto bodies = domain.own().numbers;
  EXPECT_THROW(stepper.advance(domain.state()), StepFailure);
  EXPECT_EQ(domain.own().numbers, bodies);
  EXPECT_EQ(domain.state().step, 0);
  EXPECT_EQ(domain.gather_problem().num_contacts() > 0, group.rank() == 0);
}

/// A disk flies through a row of a lattice, 290 mm a step: it passes some disks of each process, and
/// meets one in the middle of the second step.
TEST(DomainRun, PassagesOverlapsAndTravelAreThoseOfOneProcess) {
  ProcessGroup& group = mpi_group();
  Scene<2> scene = one_law<2>({});
  scene.step = 1e-3;
  scene.bodies = {round_body<2>(Vec2(-0.12, 0.21), 0.01, 1, Vec2(290, 0))};
  for (int k = 0; k < 200; ++k) {
    scene.bodies.push_back(round_body<2>(Vec2(0.05 * (k % 20), 0.05 * (k / 20)), 0.012, 1));
  }
  State<2> whole = initial_state(scene);
  TimeStepper<2> one = whole_stepper(scene, {});
  Spread<2> several(scene, whole, group, {});
  for (int step = 1; step <= 2; ++step) {
    const StepReport<2> expected = one.advance(whole), got = several.advance();
    EXPECT_GT(expected.passages, 0);
    EXPECT_EQ(got.passages, expected.passages);
    EXPECT_EQ(got.passage, expected.passage);
    EXPECT_EQ(got.travel, expected.travel);
    EXPECT_NEAR(got.overlap, expected.overlap, 1e-9);
    EXPECT_EQ(got.overlap_pair, expected.overlap_pair);
    EXPECT_EQ(expected.overlap_pair.empty(), step == 1);
  }
}

}  // namespace
}  // namespace bipot
