// A row of disks between a fixed wall and one that a force drives: rigid, so nothing may move. A
// Gauss-Seidel sweep carries impulses only so far; stopped early it leaves the chain soft, with a
// finite speed of sound (Unger, Brendel, Wolf and Kertész, Phys. Rev. E 65, 061305, 2002).
//
// Without friction the matrix of the n + 1 contacts is (-1, 2, -1)/m, at the fixed wall (1, -1)/m: half
// of a chain of 2n + 1 contacts that is symmetric about that wall. Jacobi's iteration contracts by
// cos(π/(2n + 2)), a sweep by its square: 4 (n + 1)²/π² sweeps for a factor of e, so that the exponent in n + 1 is 2.

#include <fmt/format.h>

#include <cmath>

#include "bench/measure/statistics.h"
#include "bench/validate/scene_parts.h"
#include "bench/validate/validation_experiments.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

const std::string kChain = "exact cases: a chain and its sweeps";
constexpr int kSteps = 200;
constexpr double kChainStep = 1e-3, kForce = 1000;

/// `n` disks of radius 0.5 m and 1 kg, solved by sweeps; driven wall 1 of 1 kg.
Scene chain_scene(int n, double tol, int sweeps, const ValidationContext& context) {
  Scene scene = empty_scene<2>({}, kChainStep, tol, context);
  scene.solver.name = "pgs";
  scene.solver.max_iterations = sweeps;
  for (int k = 0; k < n; ++k) scene.disks.push_back(round_body<2>(Vec2(0.5 + k, 0), 0.5, 1));
  scene.walls = {plane_wall("left", Vec2(0, 0), Vec2(1, 0)),
                 plane_wall("right", Vec2(n, 0), Vec2(-1, 0))};
  Wall& driven = scene.walls[1];
  driven.motion = Wall::Motion::kDriven;
  driven.direction = driven.normal;
  driven.force = kForce;
  driven.mass = 1;
  // Overlaps that sweeps leave keep their contacts; gaps of a rebound must not lose theirs.
  scene.contact_distance = 1e-6;
  scene.num_steps = kSteps;
  return scene;
}

/// The wall's way over that of the chain's mass under the force alone, ½ F t²/m.
double shortening(const State& state, int n) {
  const double mass = n + 1;
  return (n - state.walls[1].a[0]) / (0.5 * kForce / mass * state.time * state.time);
}

ValidationExperiment stiffness() {
  ValidationExperiment e;
  e.rows = {{.name = "chain_is_rigid",
             .group = kChain,
             .quantity = "way of the wall that presses a row of 40 disks, over that of free masses "
                         "under the force",
             .source = "rigid bodies: the force is balanced at once",
             .formula = "0",
             .expected = Expectation::equal(0),
             .allowed = 1e-6,
             .allowed_why = "a hundred times the tightest tolerance",
             .bar = "none: one deterministic run, Gauss–Seidel (`pgs`), warm start"}};
  e.tols = decades(-1, 8);
  e.quick_tols = {10, 1, 1e-1, 1e-2, 1e-4, 1e-8};
  e.run = [](double tol, const ValidationContext& context) {
    constexpr int kDisks = 40;
    ExperimentOutcome outcome;
    const auto run = run_from_start<2>(chain_scene(kDisks, tol, 1000000, context), context);
    if (!count_steps(run, outcome)) return outcome;
    outcome.seen = {{shortening(run.state, kDisks)}};
    ValidationFigure figure;
    figure.name = "chain_sweeps";
    figure.group = kChain;
    figure.caption =
        "The way of the pressing wall against time, 40 disks, with a fixed number of Gauss–Seidel sweeps a step (warm "
        "start) whatever their error: the chain yields and springs back like an elastic bar, the less the more sweeps. Rigid "
        "disks do not move at all. An artefact of the solver (Unger, Brendel, Wolf and Kertész 2002).";
    figure.chart.title = "Way of the wall, by sweeps a step";
    figure.chart.x = {.label = "time [s]"};
    figure.chart.y = {.label = "way of the wall [m]"};
    int style = 0;
    for (const int sweeps : {1, 3, 10, 30, 100, 300}) {
      ChartSeries series;
      series.name = fmt::format("{} sweeps", sweeps);
      series.style = style++;
      series.kind = ChartSeries::Kind::kLine;
      run_from_start<2>(
          chain_scene(kDisks, 1e-12, sweeps, context), context, [&](const SceneStep& step) {
            series.points.push_back({step.state.time, kDisks - step.state.walls[1].a[0]});
            return true;
          });
      figure.chart.series.push_back(std::move(series));
    }
    outcome.figures = {figure};
    return outcome;
  };
  return e;
}

ValidationExperiment sweeps_needed() {
  ValidationExperiment e;
  e.rows = {
      {.name = "chain_sweeps",
       .group = kChain,
       .quantity =
           "exponent of the sweeps from ε to ε/100, in one step from nothing, against n + 1, n disks (20 to "
           "160)",
       .source = "spectral radius of a sweep, cos²(π/(2n + 2)), derived in "
                 "chain_experiments.cc; Unger et al. 2002 ask for sweeps ≫ n²",
       .formula = "2",
       .expected = Expectation::equal(2),
       .allowed = 0.05,
       .allowed_why = "the slowest mode alone is left only at small ε",
       .bar = "95 % of the fit of a power law"}};
  e.tols = decades(-1, 8);
  e.quick_tols = {1, 1e-1, 1e-2, 1e-4, 1e-6};
  e.run = [](double tol, const ValidationContext& context) {
    ExperimentOutcome outcome;
    std::vector<double> lengths, counts;
    for (const int n : {20, 40, 80, 160}) {
      if (context.interrupted()) break;
      const Scene scene = chain_scene(n, tol, 1, context);
      const ContactProblem problem = step_problem(scene, initial_state(scene), false);
      int sweeps[2] = {0, 0};
      for (const int k : {0, 1}) {
        SolverOptions options;
        options.tol = k == 0 ? tol : 1e-2 * tol;
        options.parameters = {{"islands", "off"}};
        const SolveResult result = solve("pgs", problem, options);
        ++outcome.steps;
        if (!is_success(result.status)) ++outcome.unsolved;
        sweeps[k] = result.iterations;
      }
      lengths.push_back(n + 1);
      counts.push_back(sweeps[1] - sweeps[0]);
    }
    const PowerLaw law = fit_power_law(lengths, counts);
    outcome.seen = {{law.exponent, std::isfinite(law.confidence) ? law.confidence : 0}};
    return outcome;
  };
  return e;
}

}  // namespace

std::vector<ValidationExperiment> chain_experiments() { return {stiffness(), sweeps_needed()}; }

}  // namespace bipot
