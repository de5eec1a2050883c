// What is known as a trend alone: heaps of grains that roll badly are steeper, and a large grain
// rises in a shaken box (Rosato, Strandburg, Prinz, Swendsen, Phys. Rev. Lett. 58, 1987). Each row is
// the lower end of the 95 % interval of a growth over seeds: what chance alone may do is below 0.

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "bench/experiments/experiment_scene.h"
#include "bench/experiments/validation_row.h"
#include "bench/measure/statistics.h"

namespace bipot {
namespace {

const std::string kGrows = "it grows: above 0";
const Expectation kAboveZero = Expectation::at_least(0, 0.1);

ValidationRow::Margin end_over(const std::string& seeds) {
  return {0, "none", "the row is the lower end of the 95 % over " + seeds};
}

Observation lower_end(const std::vector<double>& growths, const std::string& of) {
  const MeanValue growth = mean_value(growths);
  return {growth.mean - growth.confidence, 0,
          fmt::format("{} {:.3f} ± {:.3f}", of, growth.mean, growth.confidence)};
}

/// Slope of the heap of a column whose side walls are taken away: a triangle of height h and half
/// width b has its centroid at h/3, and the mean distance from its middle is b/3.
double heap_slope(double mu_r, std::uint64_t seed, Experiment::Trial& trial) {
  Scene<2> scene = experiment_scene<2>({.mu = 0.5, .mu_r = mu_r}, 5e-3, trial);
  const double top = fill_box(scene, trial.context.quick ? 30 : 60, 4, 0, seed);
  const double settled = 1 + std::sqrt(2 * top / kGravity);
  scene.walls[1].removed = scene.walls[2].removed = settled;
  scene.num_steps = static_cast<int>((settled + 5) / scene.step);
  const auto end = run_from_start<2>(scene, trial);
  const auto bodies = static_cast<double>(end.bodies.size());
  double middle = 0, height = 0, aside = 0;
  for (const Disk& d : end.bodies) middle += d.x[0] / bodies;
  for (const Disk& d : end.bodies) {
    height += (d.x[1] - d.radius) / bodies;
    aside += std::abs(d.x[0] - middle) / bodies;
  }
  return height / aside;
}

void rolling_heap(Experiment& e) {
  for (const auto& [name, range] :
       {std::pair("heap_rolls", "0 to 0.1"), std::pair("heap_rolls_less", "0.1 to 0.3")}) {
    e.rows.emplace_back(
        name, fmt::format("logarithm of the growth of a heap's slope from μ_r/a = {}", range),
        "rolling friction carries a moment: no grain rolls below its bound (method.md)", kGrows,
        kAboveZero, end_over("4 columns"));
  }
  e.tols = {1, 1e-1, 1e-2, 1e-3};
  e.quick_tols = {1, 1e-1};
  e.run = [](Experiment::Trial& trial) {
    std::vector<double> first, second;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      const double flat = heap_slope(0, seed, trial), steep = heap_slope(0.05, seed, trial);
      first.push_back(std::log(steep / flat));
      second.push_back(std::log(heap_slope(0.15, seed, trial) / steep));
    }
    trial.seen = {lower_end(first, "growth"), lower_end(second, "growth")};
  };
}

/// How far a grain of three times the radius rises while the box is shaken, over the mean height of
/// the grains. It begins at the floor.
double rise(std::uint64_t seed, Experiment::Trial& trial) {
  constexpr double kFrequency = 1.25, kLargest = 3, kTime = 30;
  Scene<2> scene = experiment_scene<2>({.mu = 0.5}, 5e-3, trial);
  fill_box(scene, 60, 8, 3.2, seed);
  const double radius = 1.5;
  for (Disk& d : scene.bodies) d.x[1] += 2 * radius;
  scene.bodies.push_back(round_body<2>(Vec2(4, radius), radius, radius * radius));
  for (Wall<2>& wall : scene.walls) {
    wall.motion = Wall<2>::Motion::kMoving;
    // Its acceleration is three times that of gravity.
    wall.v = Vec2(0, kLargest * kGravity / (2 * std::numbers::pi * kFrequency));
    wall.time_factor.frequency = kFrequency;
    wall.starts = 3;
  }
  scene.num_steps = static_cast<int>((3 + kTime) / scene.step);
  double before = kNaN, late = 0;
  long samples = 0;
  run_from_start<2>(scene, trial, [&](const SceneStep<2>& step) {
    const State<2>& state = step.state;
    const double floor = state.walls[0].a[1];
    double mean = 0;
    for (std::size_t i = 0; i < 60; ++i) mean += (state.bodies[i].x[1] - floor) / 60;
    const double place = (state.bodies[60].x[1] - floor) / mean;
    if (state.time < 3) before = place;
    if (state.time > 3 + 0.75 * kTime) {
      late += place;
      ++samples;
    }
    return true;
  });
  return late / static_cast<double>(samples) - before;
}

void brazil_nut(Experiment& e) {
  e.rows = {ValidationRow(
      "brazil_nut",
      "rise of a grain of three radii in a shaken box (3 g, 1.25 Hz), over the mean "
      "height of the grains",
      "Rosato et al. 1987: the large grain rises", kGrows, kAboveZero, end_over("4 fillings"))};
  e.tols = {1e-1, 1e-2};
  e.quick_tols = {};
  e.run = [](Experiment::Trial& trial) {
    std::vector<double> rises;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) rises.push_back(rise(seed, trial));
    trial.seen = {lower_end(rises, "rise")};
  };
}

}  // namespace

std::vector<Experiment> trend_experiments() { return made_by({&rolling_heap, &brazil_nut}); }

}  // namespace bipot
