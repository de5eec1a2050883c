// Undetermined forces: the range of the admissible ones.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/experiments/experiment_scene.h"
#include "bench/experiments/force_range.h"
#include "bench/experiments/validation_row.h"
#include "bench/measure/statistics.h"
#include "core/base/portable_random.h"
#include "core/scene/generators.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

constexpr double kWeight = 9.81;

/// A disk of 1 kg in a groove of two planes that rise by 45° to both sides. By symmetry of moments
/// the two frictions T are equal, as are the forces N: 2 (N cos α + T sin α) = w with |T| <= mu N
/// leaves N in w/2 [1/(cos α + mu sin α), 1/(cos α - mu sin α)].
Scene<2> groove(double mu, const Experiment::Trial& trial) {
  Scene<2> scene = experiment_scene<2>({.mu = mu}, 1e-2, trial);
  const double half = std::sqrt(0.5);
  scene.gravity = Vec2(0, -kWeight);
  scene.bodies = {round_body<2>(Vec2(0, std::sqrt(2.0)), 1, 1)};
  scene.walls = {half_space<2>(Vec2(0, 0), Vec2(half, half), "left"),
                 half_space<2>(Vec2(0, 0), Vec2(-half, half), "right")};
  return scene;
}

constexpr double kGrooveMu = 0.3;
double groove_end(double sign) {
  return 0.5 * std::sqrt(2.0) / (1 + sign * kGrooveMu);  // over the weight
}

void groove_forces(Experiment& e) {
  e.rows = {
      ValidationRow("groove_interval",
                    "width of the interval of admissible normal forces of a disk in a groove of "
                    "90°, μ = 0.3, over the weight",
                    "statics, derived in indeterminacy_experiments.cc; measured by linear "
                    "programmes (CLP): no tolerance of a solver enters",
                    "[1/(cos α − μ sin α) − 1/(cos α + μ sin α)]/2 = 0.466",
                    Expectation::equal(groove_end(-1) - groove_end(1)),
                    {1e-7, "tolerance of the programmes, 1e-9", "discretisation: 1e-9"}),
      ValidationRow(
          "groove_force",
          "how far outside that interval a solver's force is, over the weight; worst of "
          "random starts",
          "the same interval", "at most 0", Expectation::at_most(0, 1),
          {1e-6, "a hundred times the tightest tolerance", "discretisation: the worst of all"})};
  e.run = [](Experiment::Trial& trial) {
    const Scene<2> scene = groove(kGrooveMu, trial);
    const ContactProblem problem = step_problem(scene, initial_state(scene));
    const double weight = kWeight * scene.step;
    const std::vector<ForceRange> ranges = admissible_forces(problem);
    if (ranges.size() != 2) throw std::runtime_error("the groove has two contacts");
    trial.seen = {{(ranges[0].high - ranges[0].low) / weight}};
    const int starts = trial.context.quick ? 30 : 300;
    double outside = 0, least = kInfinity, most = 0;
    PortableRandom random(1);
    SolverOptions options{.tol = trial.tol,
                          .max_iterations = trial.context.max_iterations,
                          .parameters = {{"islands", "off"}}};
    for (int k = 0; k < starts; ++k) {
      options.s0 = Vector::Zero(4);
      for (const int row : {0, 2}) {
        options.s0[row] = 2 * weight * random.uniform();
        options.s0[row + 1] = kGrooveMu * options.s0[row] * random.symmetric();
      }
      const SolveResult result = solve(trial.context.solver, problem, options);
      ++trial.steps;
      if (!is_success(result.status)) ++trial.unsolved;
      for (const int row : {0, 2}) {
        const double force = result.s[row] / weight;
        outside = std::max({outside, groove_end(1) - force, force - groove_end(-1)});
        least = std::min(least, force);
        most = std::max(most, force);
      }
    }
    trial.seen.push_back(
        {outside, 0, fmt::format("{} starts gave {:.3f} to {:.3f}", starts, least, most)});
  };
}

/// Disks that fell into a box without friction and came to rest; walls and disks of law 0.
Scene<2> small_pile(int count, std::uint64_t seed, double mu, const Experiment::Trial& trial) {
  Scene<2> scene = experiment_scene<2>({.mu = mu}, 5e-3, trial);
  fill_box(scene, count, 6, 0.05, seed);
  scene.num_steps = 1500;
  return scene;
}

/// Spread of the admissible forces that hold a settled pile, at its contacts but with friction
/// `mu`.
double spread_of(Scene<2> scene, State<2> state, double mu) {
  scene.laws[0].mu = mu;
  for (Disk& d : state.bodies) {
    d.v.setZero();
    d.spin = 0;
  }
  return force_spread(admissible_forces(step_problem(scene, state)));
}

/// Without friction a generic pile has as many contacts as equations, so that its forces are
/// determined. With a small mu the tangential forces are free within mu n, and the normal ones
/// respond linearly: spread ~ mu. A larger mu allows all that a smaller one does: for a given
/// geometry the spread never decreases.
void spread(Experiment& e) {
  e.rows = {
      ValidationRow("spread_small_mu",
                    "exponent of the spread of admissible forces against μ (1e-4 to 1e-2), in a "
                    "pile that came to rest without friction",
                    "as many contacts as equations at μ = 0, linear beside it (derived); Unger, "
                    "Kertész and Wolf, PRL 94, 178001 (2005): spread → 0 with μ",
                    "1", Expectation::equal(1),
                    {0.05, "the least μ is not 0", "95 % over piles (seeds)"}),
      ValidationRow(
          "spread_nested",
          "largest fall of that spread from one μ to a larger one (1e-4 to 1), over "
          "the larger spread",
          "sets of admissible forces are nested (derived)", "at most 0", Expectation::at_most(0, 1),
          {1e-6, "tolerance of the linear programmes", "discretisation: the worst of all"})};
  e.tols = {10, 1, 1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8};
  e.quick_tols = {10, 1, 1e-1, 1e-4};
  e.run = [](Experiment::Trial& trial) {
    const std::vector<double> small = {1e-4, 1e-3, 1e-2}, large = {0.03, 0.1, 0.3, 1};
    const int seeds = trial.context.quick ? 2 : 6;
    std::vector<double> exponents;
    double fall = kNaN;  // of nothing compared
    std::string extra;
    Chart chart{.title = "Spread of admissible forces",
                .x = {.label = "μ", .kind = Chart::Axis::Kind::kLog},
                .y = {.label = "spread", .kind = Chart::Axis::Kind::kLog}};
    const std::string caption =
        "Spread of the admissible normal forces (mean width of their intervals over the mean force) in piles "
        "of 25 disks that came to rest without friction, against the friction that is then allowed.";
    for (int seed = 1; seed <= seeds; ++seed) {
      const Scene<2> scene = small_pile(25, to_size(seed), 0, trial);
      const auto end = run_from_start<2>(scene, trial);
      std::vector<double> mus, spreads;
      Chart::Series series{fmt::format("pile {}", seed), seed - 1, {}};
      for (const std::vector<double>* some : {&small, &large}) {
        for (const double mu : *some) {
          const double s = spread_of(scene, end, mu);
          if (!std::isfinite(s)) {
            extra = fmt::format("pile {}: no bounded equilibrium at μ = {}", seed, mu);
            continue;
          }
          if (!spreads.empty()) fall = std::fmax(std::fmax(fall, 0), 1 - s / spreads.back());
          mus.push_back(mu);
          spreads.push_back(s);
          series.points.push_back({mu, s});
        }
      }
      chart.series.push_back(std::move(series));
      const std::size_t few = std::min(small.size(), mus.size());
      exponents.push_back(fit_power_law({mus.begin(), mus.begin() + static_cast<long>(few)},
                                        {spreads.begin(), spreads.begin() + static_cast<long>(few)})
                              .exponent);
    }
    const MeanValue mean = mean_value(exponents);
    trial.seen = {{mean.mean, mean.confidence, extra}, {fall, 0, extra}};
    trial.draw("spread", caption, std::move(chart));
  };
}

}  // namespace

std::vector<Experiment> indeterminacy_experiments() { return made_by({&groove_forces, &spread}); }

}  // namespace bipot
