// How normal forces are distributed: a packing that is pressed from all sides against a deposit.
//
// Fig. 11 of the paper has 342 disks under their own weight; `bipot paper` fits exp(-β f/<f>) from
// 1.5 means on and finds β about 0.96. In an isotropic packing the mean force is the same
// everywhere; in a deposit it grows with depth, from 0 to twice its mean, so that the distribution is a mixture
// of scales. If every layer has a tail exp(-β f/mean of the layer), the mixture's tail falls more
// slowly than β and, as no layer has more than twice the mean, not more slowly than β/2. [ours] With forces over the
// mean of their own layer the mixture is undone.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/experiments/experiment_scene.h"
#include "bench/experiments/validation_experiments.h"
#include "bench/measure/statistics.h"
#include "bench/problems/compression_scene.h"
#include "bench/problems/scene_catalogue.h"
#include "core/scene_files/scene_file.h"

namespace bipot {
namespace {

const std::string kForces = "distribution of forces";
constexpr double kTailStart = 1.5;  // in means

/// Loaded normal forces over their mean, or over the mean of their layer (of equal height).
std::vector<double> scaled_forces(const State<2>& state, int layers) {
  double top = 0;
  for (const Disk& d : state.bodies) top = std::max(top, d.x[1]);
  std::vector<std::vector<double>> forces(to_size(layers));
  for (const ContactOutcome<2>& o : state.contacts) {
    if (!(o.s_n > 0)) continue;
    const Disk& d = state.bodies[to_size(o.contact.i)];
    const double y = d.x[1] - d.radius * o.contact.n[1];
    forces[to_size(std::clamp(static_cast<int>(layers * y / top), 0, layers - 1))].push_back(o.s_n);
  }
  std::vector<double> scaled;
  for (const std::vector<double>& layer : forces) {
    double sum = 0;
    for (const double f : layer) sum += f;
    for (const double f : layer) scaled.push_back(f * static_cast<double>(layer.size()) / sum);
  }
  return scaled;
}

ChartSeries density(const std::string& name, int style, const std::vector<double>& f) {
  constexpr double kBin = 0.3;
  std::vector<int> counts;
  for (const double x : f) {
    const auto bin = static_cast<std::size_t>(x / kBin);
    if (bin >= counts.size()) counts.resize(bin + 1);
    ++counts[bin];
  }
  ChartSeries series;
  series.name = name;
  series.style = style;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    if (counts[k] == 0) continue;
    series.points.push_back({(static_cast<double>(k) + 0.5) * kBin,
                             counts[k] / (kBin * static_cast<double>(f.size())), false,
                             fmt::format("{} forces", counts[k])});
  }
  return series;
}

ValidationExperiment force_tails() {
  ValidationExperiment e;
  e.rows = {
      validation_row(
          kForces, "tail_is_exponential",
          "Kolmogorov's distance of the tail from 1.5 means to the fitted exponential, times "
          "√points: isotropic packing, e_t = 0 (--quick: 300 disks, else 2000)",
          "exponential tails in contact dynamics (Radjai et al. 1996) and experiment (Løvoll, Måløy and Flekkøy "
          "1999, abstract); their exponents 1.4 and 1.8 are noted, not tested: other walls, 3D",
          "at most 1.36 (5 % level for independent forces)", Expectation::at_most(1.36, 1.36), 0,
          "none", "none: one packing"),
      validation_row(
          kForces, "tail_of_deposit",
          "exponent β of a deposit under gravity over that of the isotropic packing",
          "mixture of scales, derived in force_experiments.cc; Fig. 11 of the paper has the deposit",
          "1/2 to 1", Expectation::between(0.5, 1, 1), 0, "none", "95 % of both fits"),
      validation_row(kForces, "tail_of_layers",
                     "the same with the deposit's forces over the mean of their own layer (of 8)",
                     "the mixture undone (derived)",
                     "above the ratio without layers, which is subtracted: at least 0",
                     Expectation::at_least(0, 1), 0, "none", "95 % of the fit")};
  e.tols = {10, 1, 1e-1, 1e-2, 1e-3};
  e.quick_tols = {1, 1e-1, 1e-2};
  e.run = [](double tol, const ValidationContext& context) {
    ExperimentOutcome outcome;
    Scene<2> pressed = compression_scene({.count = context.quick ? 300 : 2000, .e_t = 0});
    pressed.solver = context.choice(tol);
    pressed.num_steps = 400;
    Scene<2> deposit = read_scene(find_scene(context.quick ? "compaction_100" : "compaction"));
    for (ContactLaw& law : deposit.laws) law.e_t = 0;
    deposit.solver = context.choice(tol);
    const auto isotropic = run_from_start<2>(pressed, context);
    if (!count_steps(isotropic, outcome)) return outcome;
    const auto heavy = run_from_start<2>(deposit, context);
    if (!count_steps(heavy, outcome)) return outcome;
    const std::vector<double> f = scaled_forces(isotropic.state, 1),
                              g = scaled_forces(heavy.state, 1),
                              layered = scaled_forces(heavy.state, 8);
    const ExponentialTail even = fit_exponential_tail(f, kTailStart),
                          mixed = fit_exponential_tail(g, kTailStart),
                          unmixed = fit_exponential_tail(layered, kTailStart);
    const double ratio = mixed.rate / even.rate;
    const double ratio_bar =
        ratio * std::hypot(mixed.confidence / mixed.rate, even.confidence / even.rate);
    outcome.seen = {
        {even.distance * std::sqrt(static_cast<double>(even.points)), 0,
         fmt::format("β = {:.2f} ± {:.2f} from {} forces", even.rate, even.confidence,
                     even.points)},
        {ratio, ratio_bar,
         fmt::format("the deposit's β = {:.2f} ± {:.2f}", mixed.rate, mixed.confidence)},
        {(unmixed.rate - mixed.rate) / even.rate, unmixed.confidence / even.rate,
         fmt::format("β = {:.2f} ± {:.2f} by layers", unmixed.rate, unmixed.confidence)}};
    ClaimFigure figure{.name = "forces", .chart = Chart{}};
    figure.caption = fmt::format(
        "Distribution of normal forces over their mean: {} disks pressed from all sides (e_t = 0, β = {:.2f} ± {:.2f}), a "
        "deposit of {} under its weight ({:.2f} ± {:.2f}), and the deposit by layers ({:.2f} ± {:.2f}). A deposit mixes "
        "depths with different mean forces, which is what flattens its tail.",
        pressed.bodies.size(), even.rate, even.confidence, deposit.bodies.size(), mixed.rate,
        mixed.confidence, unmixed.rate, unmixed.confidence);
    figure.chart->title = "Distribution of normal forces";
    figure.chart->x = {.label = "normal force over its mean"};
    figure.chart->y = {.label = "probability density", .kind = ChartAxis::Kind::kLog};
    figure.chart->series = {density("isotropic", 0, f), density("deposit", 1, g),
                            density("deposit, by layers", 2, layered)};
    outcome.figures = {figure};
    return outcome;
  };
  return e;
}

}  // namespace

std::vector<ValidationExperiment> force_experiments() { return {force_tails()}; }

}  // namespace bipot
