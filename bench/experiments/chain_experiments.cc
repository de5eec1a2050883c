// A row of disks between a fixed wall and one driven by a force: all rigid, so that nothing may
// move. A Gauss-Seidel sweep propagates impulses a limited distance. Stopped early it leaves the
// chain soft, with a finite speed of sound (Unger, Brendel, Wolf and Kertész, Phys. Rev. E 65,
// 061305, 2002).
//
// Without friction the matrix of the n + 1 contacts is (-1, 2, -1)/m, at the fixed wall (1, -1)/m:
// half of a chain of 2n + 1 contacts that is symmetric about that wall. Jacobi's iteration
// contracts by cos(π/(2n + 2)), a sweep by its square. A factor of e needs 4 (n + 1)²/π² sweeps, so
// that the exponent in n + 1 is 2.

#include <fmt/format.h>

#include "bench/experiments/experiment_scene.h"
#include "bench/experiments/validation_row.h"
#include "bench/measure/statistics.h"
#include "core/problem/delassus.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

constexpr int kSteps = 200;
constexpr double kChainStep = 1e-3, kForce = 1000;

/// `n` disks of radius 0.5 m and 1 kg, solved by sweeps; driven wall 1 of 1 kg.
Scene<2> chain_scene(int n, int sweeps, const Experiment::Trial& trial) {
  Scene<2> scene = experiment_scene<2>({}, kChainStep, trial);
  scene.solver.name = "pgs";
  scene.solver.max_iterations = sweeps;
  for (int k = 0; k < n; ++k) scene.bodies.push_back(round_body<2>(Vec2(0.5 + k, 0), 0.5, 1));
  scene.walls = {half_space<2>(Vec2(0, 0), Vec2(1, 0), "left"),
                 half_space<2>(Vec2(n, 0), Vec2(-1, 0), "right")};
  Wall<2>& driven = scene.walls[1];
  drive(driven, driven.normal, 1, kForce);
  // Contacts with overlaps left by sweeps are kept; gaps of a rebound must keep theirs.
  scene.contact_distance = 1e-6;
  scene.num_steps = kSteps;
  return scene;
}

/// The wall's displacement over that of the chain's mass under the force alone, ½ F t²/m.
double shortening(const State<2>& state, int n) {
  const double mass = n + 1;
  return (n - state.walls[1].a[0]) / (0.5 * kForce / mass * state.time * state.time);
}

void stiffness(Experiment& e) {
  e = {.rows = {ValidationRow(
           "chain_is_rigid",
           "way of the wall that presses a row of 40 disks, over that of free masses "
           "under the force",
           "rigid bodies: the force is balanced at once", "0", Expectation::equal(0),
           {1e-6, "a hundred times the tightest tolerance",
            "discretisation: one deterministic run, Gauss–Seidel (`pgs`), warm start"})},
       .quick_tols = {10, 1, 1e-1, 1e-2, 1e-4, 1e-8}};
  e.run = [](Experiment::Trial& trial) {
    constexpr int kDisks = 40;
    const auto end = run_from_start<2>(chain_scene(kDisks, 1000000, trial), trial);
    trial.seen = {{shortening(end, kDisks)}};
  };
}

/// A fixed number of Gauss-Seidel sweeps from the impulses of the previous step, for any remaining
/// error: as in codes that bound the work of a step. Frictionless problems with W.
StepSolver plain_sweeps(int sweeps) {
  return [sweeps](const ContactProblem& problem, const Vector& start) {
    StepSolution solution{
        .s = start.size() == problem.num_rows() ? start : Vector::Zero(problem.num_rows())};
    const SparseRows W = assemble_delassus(problem.A, problem.H, problem.dim);
    for (int k = 0; k < sweeps; ++k) {
      for (int row = 0; row < problem.num_rows(); ++row) {
        const double u = W.row(row).dot(solution.s) + problem.u_free[row];
        solution.s[row] = std::max(0.0, solution.s[row] - u / W.coeff(row, row));
      }
    }
    solution.converged = true;
    solution.iterations = sweeps;
    return solution;
  };
}

/// A smooth mode of impulses keeps ρ^k = 1 - κ of its error in k sweeps, κ about k θ², θ = π/(2n +
/// 2) for the slowest. With warm start the mode's impulse and velocity obey, step by step,
///   s' = s + κ (w + F h - s),  w' = w + F h - s':   an oscillator of frequency √κ/h,
/// like a bar of n + 1 diameters with speed of sound c = √k d/h: the wall turns back after 2 (n +
/// 1) d/c.
void speed_of_sound(Experiment& e) {
  e.rows = {
      ValidationRow(
          "chain_sound",
          "speed of sound of a row of 40 disks with 1 Gauss–Seidel sweep a step, over "
          "d/h, by the time at which the pressing wall turns back",
          "Unger, Brendel, Wolf and Kertész 2002 (abstract: unconverged chains are elastic, "
          "sound is finite); c = √k d/h for k sweeps derived in chain_experiments.cc",
          "1", Expectation::equal(1), {0.05, "damping by the higher modes, 40 disks", kOneRun}),
      ValidationRow("chain_sound_sweeps", "exponent of that speed against the sweeps, 1 to 16",
                    "the same", "1/2", Expectation::equal(0.5),
                    {0.05, "k θ² is not small for many sweeps", "95 % of the fit of a power law"})};
  for (ValidationRow& row : e.rows) row.takes_tolerance = false;
  e.tols = e.quick_tols = {1};
  e.run = [](Experiment::Trial& trial) {
    constexpr int kDisks = 40;
    Chart chart{.title = "Way of the wall, by sweeps a step",
                .x = {.label = "time [s]"},
                .y = {.label = "way of the wall [m]"}};
    const std::string caption =
        "The way of the wall that presses a row of 40 disks, with a fixed number of Gauss–Seidel "
        "sweeps a step (warm start, no tolerance): the row yields and springs back like an elastic "
        "bar, stiffer with more sweeps, and stays shortened; both vanish as sweeps grow beyond n². "
        "Rigid disks do not move at all. An artefact of the solver (Unger, Brendel, Wolf and "
        "Kertész 2002).";
    std::vector<double> counts, speeds;
    for (const int sweeps : {1, 4, 16, 64, 256, 1600}) {
      Scene<2> scene = chain_scene(kDisks, 1, trial);
      // The wall presses on the row all the time: no contact opens until it is back.
      scene.num_steps = 200;
      Chart::Series series{fmt::format("{} sweeps", sweeps),
                           static_cast<int>(chart.series.size()),
                           {},
                           Chart::Series::Kind::kLine};
      State<2> state = initial_state(scene);
      double farthest = 0, turns = 0;
      SceneRunOptions<2> options{.solver = plain_sweeps(sweeps),
                                 .cancelled = trial.context.stopped};
      options.on_step = [&](const SceneStep<2>& step) {
        const double way = kDisks - step.state.walls[1].a[0];
        series.points.push_back({step.state.time, way});
        if (turns == 0 && way < farthest) turns = step.state.time - 1.5 * kChainStep;
        farthest = std::max(farthest, way);
        return true;
      };
      const SceneRun<2> run = run_scene(scene, state, options);
      if (run.failure) throw *run.failure;
      trial.go_on();
      trial.steps += run.totals.steps;
      chart.series.push_back(std::move(series));
      if (sweeps > 16) continue;
      counts.push_back(sweeps);
      speeds.push_back(turns > 0 ? 2 * (kDisks + 1) * kChainStep / turns : kNaN);
    }
    const PowerLaw law = fit_power_law(counts, speeds);
    trial.seen = {{speeds[0]}, {law.exponent, law.confidence}};
    trial.draw("chain_sweeps", caption, std::move(chart));
  };
}

void sweeps_needed(Experiment& e) {
  e.rows = {ValidationRow(
      "chain_sweeps",
      "exponent of the sweeps from ε to ε/100, in one step from nothing, against n + 1, n disks (20 to "
      "160)",
      "spectral radius of a sweep, cos²(π/(2n + 2)), derived in "
      "chain_experiments.cc; Unger et al. 2002 ask for sweeps ≫ n²",
      "2", Expectation::equal(2),
      {0.05, "the slowest mode alone is left only at small ε", "95 % of the fit of a power law"})};
  e.quick_tols = {1, 1e-1, 1e-2, 1e-4, 1e-6};
  e.run = [](Experiment::Trial& trial) {
    std::vector<double> lengths, counts;
    for (const int n : {20, 40, 80, 160}) {
      trial.go_on();
      const Scene<2> scene = chain_scene(n, 1, trial);
      const ContactProblem problem = step_problem(scene, initial_state(scene));
      int sweeps[2] = {0, 0};
      for (const int k : {0, 1}) {
        const SolveResult result = solve(
            "pgs", problem,
            {.tol = k == 0 ? trial.tol : 1e-2 * trial.tol, .parameters = {{"islands", "off"}}});
        ++trial.steps;
        if (!is_success(result.status)) ++trial.unsolved;
        sweeps[k] = result.iterations;
      }
      lengths.push_back(n + 1);
      counts.push_back(sweeps[1] - sweeps[0]);
    }
    const PowerLaw law = fit_power_law(lengths, counts);
    trial.seen = {{law.exponent, law.confidence}};
  };
}

}  // namespace

std::vector<Experiment> chain_experiments() {
  return made_by({&stiffness, &speed_of_sound, &sweeps_needed});
}

}  // namespace bipot
