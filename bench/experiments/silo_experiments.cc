// Grains in a narrow silo: load on the walls by friction, and rate of discharge.
//
// Balance of a layer at depth z in a plane silo of width L: dQ/dz = ρ g L - 2 τ, with the wall's
// shear stress τ = m σ_x, m <= μ (Coulomb), and σ_x = K Q/L. Hence Q = ρ g L λ (1 - exp(-z/λ)), λ =
// L/(2 m K). While the floor sinks slowly, grains slide down along the walls and m is near μ. Since
// τ >= 0 there and 2 τ <= 2 μ σ_x, the floor's load lies between the weight less μ times the walls'
// normal force, and the weight: exact.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/experiments/experiment_scene.h"
#include "bench/experiments/validation_row.h"
#include "bench/measure/statistics.h"
#include "core/motion/force_balance.h"

namespace bipot {
namespace {

constexpr double kSiloMu = 0.5, kSiloWidth = 8;

/// Means while the floor sinks.
struct SiloLoad {
  double weight = 0, height = 0;
  MeanValue floor = {0, 0};           ///< upward force of the floor, over blocks              [N]
  double drag = 0;                    ///< upward friction of both walls                       [N]
  double normal = 0;                  ///< of both walls                                       [N]
  std::vector<double> depths, loads;  ///< Q below the depth, from the walls' forces above it
};

SiloLoad silo_load(int count, std::uint64_t seed, Experiment::Trial& trial) {
  Scene<2> scene = experiment_scene<2>({.mu = kSiloMu}, 5e-3, trial);
  const double top = fill_box(scene, count, kSiloWidth, 0, seed);
  SiloLoad load;
  for (const Disk& d : scene.bodies) load.weight += kGravity * d.mass;
  const double settle = 1 + std::sqrt(2 * top / kGravity);
  constexpr double kSink = 0.2, kSinks = 5;  // [m/s], [s]
  move_at(scene.walls[0], Vec2(0, -kSink));
  scene.walls[0].starts = settle;
  scene.num_steps = static_cast<int>((settle + kSinks) / scene.step);
  constexpr int kBlocks = 6, kLayers = 12;
  std::vector<double> floor_blocks[kBlocks];
  std::vector<double> above(kLayers, 0.0);
  std::vector<double> weights(kLayers, 0.0);
  long samples = 0;
  const double begin = settle + 1;
  run_from_start<2>(scene, trial, [&](const SceneStep<2>& step) {
    const State<2>& state = step.state;
    if (state.time < begin) return true;
    const std::vector<Vec2> walls = wall_reactions(state, scene.step);
    const Vec2 &floor = walls[0], &left = walls[1], &right = walls[2];
    const auto block = to_size(std::clamp(
        static_cast<int>(kBlocks * (state.time - begin) / (kSinks - 1)), 0, kBlocks - 1));
    floor_blocks[block].push_back(-floor[1]);
    load.drag -= left[1] + right[1];
    load.normal += std::abs(left[0]) + std::abs(right[0]);
    const double bottom = state.walls[0].a[1];
    double surface = bottom;
    for (const Disk& d : state.bodies) surface = std::max(surface, d.x[1] + d.radius);
    load.height += surface - bottom;
    const auto layer_of = [&](double y) {
      return std::clamp(static_cast<int>(kLayers * (surface - y) / (surface - bottom)), 0,
                        kLayers - 1);
    };
    const int disks = static_cast<int>(state.bodies.size());
    for (const Disk& d : state.bodies) weights[to_size(layer_of(d.x[1]))] += kGravity * d.mass;
    for (const ContactOutcome<2>& o : state.contacts) {
      if (o.contact.j != disks + 1 && o.contact.j != disks + 2) continue;
      const Vec2& n = o.contact.n;
      const double up = (o.s_n * n[1] + o.s_t * n[0]) / scene.step;
      above[to_size(layer_of(state.bodies[to_size(o.contact.i)].x[1]))] += up;
    }
    ++samples;
    return true;
  });
  if (samples == 0) return load;
  const double n = static_cast<double>(samples);
  load.drag /= n;
  load.normal /= n;
  load.height /= n;
  load.floor = mean_of_blocks(floor_blocks);
  double carried = 0;
  for (int k = 0; k < kLayers; ++k) {
    carried += (weights[to_size(k)] - above[to_size(k)]) / n;
    load.depths.push_back(load.height * (k + 1) / kLayers);
    load.loads.push_back(carried);
  }
  return load;
}

/// λ of Q = q λ (1 - exp(-z/λ)) by least squares in λ, with q the slope at the surface (weight over
/// height).
double screening_length(const SiloLoad& load, double& rms) {
  const double slope = load.weight / load.height;
  const auto misfit = [&](double length) {
    double sum = 0;
    for (std::size_t k = 0; k < load.depths.size(); ++k) {
      const double janssen = slope * length * (1 - std::exp(-load.depths[k] / length));
      sum += std::pow((load.loads[k] - janssen) / load.loads.back(), 2);
    }
    return std::sqrt(sum / static_cast<double>(load.depths.size()));
  };
  // Golden section in the logarithm; the misfit has one minimum there.
  double low = std::log(0.05 * load.height), high = std::log(50 * load.height);
  const double golden = 0.5 * (std::sqrt(5.0) - 1);
  while (high - low > 1e-6) {
    const double a = high - golden * (high - low), b = low + golden * (high - low);
    (misfit(std::exp(a)) < misfit(std::exp(b)) ? high : low) =
        misfit(std::exp(a)) < misfit(std::exp(b)) ? b : a;
  }
  const double length = std::exp(0.5 * (low + high));
  rms = misfit(length);
  return length;
}

void janssen(Experiment& e) {
  e.rows = {
      ValidationRow("silo_balance",
                    "floor and walls together over the weight, while the floor sinks slowly",
                    "momentum in the mean", "1", Expectation::equal(1),
                    {1e-2, "finite time", "95 % over 6 blocks of time"}),
      ValidationRow("silo_coulomb", "upward friction of the walls over μ times their normal force",
                    "Coulomb at every contact (exact)", "at most 1", Expectation::at_most(1, 1),
                    {1e-6, "rounding; impulses are admissible by construction",
                     "discretisation: it holds at every instant"}),
      ValidationRow(
          "janssen_saturates",
          "floor load of the tallest filling (4 to 6 widths) over that of half its height",
          "Janssen 1895: Q saturates (from memory; with K between 0 and ∞ the ratio is between 1 and 2)",
          "1 to 2", Expectation::between(1, 2, 1), {0, "none", "95 % over blocks of both runs"}),
      ValidationRow(
          "janssen_length",
          "screening length fitted to the load against depth, over L/(2 m K) with the walls' own m and K "
          "measured independently",
          "balance of a layer, derived in silo_experiments.cc", "1", Expectation::equal(1),
          {0.2, "m and K are not the same at all depths", "discretisation: one fit"})};
  e.tols = {10, 1, 1e-1, 1e-2, 1e-3};
  e.quick_tols = {1, 1e-1};
  e.run = [](Experiment::Trial& trial) {
    const int tall = trial.context.quick ? 160 : 360;
    const SiloLoad half = silo_load(tall / 2, 1, trial);
    const SiloLoad full = silo_load(tall, 1, trial);
    const MeanValue &floor = full.floor, &half_floor = half.floor;
    const double ratio = floor.mean / half_floor.mean;
    double rms = kNaN;
    const double length = screening_length(full, rms);
    // K over the whole height: mean wall pressure over the mean vertical stress.
    double vertical = 0;
    for (const double q : full.loads) {
      vertical += q / kSiloWidth / static_cast<double>(full.loads.size());
    }
    const double wall_pressure = 0.5 * full.normal / full.height;
    const double k = wall_pressure / vertical, m = full.drag / full.normal;
    trial.seen = {
        {(floor.mean + full.drag) / full.weight, floor.confidence / full.weight,
         fmt::format("the walls carry {:.2f} of it", full.drag / full.weight)},
        {full.drag / (kSiloMu * full.normal)},
        {ratio,
         ratio * std::hypot(floor.confidence / floor.mean, half_floor.confidence / half_floor.mean),
         fmt::format("{:.1f} and {:.1f} widths high", full.height / kSiloWidth,
                     half.height / kSiloWidth)},
        {length / (kSiloWidth / (2 * m * k)), 0,
         fmt::format("λ = {:.2f} widths, K = {:.2f}, m = {:.2f}, rms misfit {:.1f} %",
                     length / kSiloWidth, k, m, 100 * rms)}};
    Chart chart{.title = "Load in a silo",
                .x = {.label = "depth over width"},
                .y = {.label = "vertical load over the weight"}};
    const std::string caption =
        "Vertical load against depth in a silo 8 disks wide whose floor sinks slowly: weight above less the walls' "
        "friction above. Line: Janssen's exponential with the fitted length; dashes: the weight alone.";
    Chart::Series points{"measured", 0, {}, Chart::Series::Kind::kPoints};
    Chart::Series fit{"Janssen, fitted", 1, {}, Chart::Series::Kind::kLine};
    Chart::Series weight{"weight above", 2, {}, Chart::Series::Kind::kLine};
    for (std::size_t i = 0; i < full.depths.size(); ++i) {
      const double z = full.depths[i];
      points.points.push_back({z / kSiloWidth, full.loads[i] / full.weight});
      fit.points.push_back({z / kSiloWidth, length / full.height * (1 - std::exp(-z / length))});
      weight.points.push_back({z / kSiloWidth, z / full.height});
    }
    chart.series = {points, fit, weight};
    trial.draw("janssen", caption, std::move(chart));
  };
}

/// Mass flow out of a hole of width `hole` in the middle of a silo's floor, in the two halves of
/// the time in which the filling decreases from 9 to 6 tenths.
struct Discharge {
  double first = kNaN, second = kNaN;  ///< [kg/s]
};

Discharge discharge(double hole, int count, std::uint64_t seed, Experiment::Trial& trial) {
  constexpr double kWidth = 18;
  Scene<2> scene = experiment_scene<2>({.mu = kSiloMu}, 5e-3, trial);
  const double top = fill_box(scene, count, kWidth, 0, seed);
  double whole = 0;
  for (const Disk& d : scene.bodies) whole += d.mass;
  const double edges[] = {0, 0.5 * (kWidth - hole), 0.5 * (kWidth + hole), kWidth};
  scene.walls.erase(scene.walls.begin());
  for (int k = 0; k < 3; ++k) {
    Wall<2> part{.name = k == 1 ? "plug" : "floor",
                 .shape = Wall<2>::Shape::kSegment,
                 .a = Vec2(edges[k], 0),
                 .b = Vec2(edges[k + 1], 0)};
    if (k == 1) part.removed = 1 + std::sqrt(2 * top / kGravity);
    scene.walls.push_back(part);
  }
  scene.outlets = {{.name = "below", .point = Vec2(0, -3), .normal = Vec2(0, 1)}};
  constexpr double kLongest = 60;  // [s]; a hole that clogs gives no rate
  scene.num_steps = static_cast<int>((scene.walls[3].removed + kLongest) / scene.step);
  const double shares[] = {0.1, 0.25, 0.4};
  double times[3] = {kNaN, kNaN, kNaN};
  std::size_t next = 0;
  run_from_start<2>(scene, trial, [&](const SceneStep<2>& step) {
    double inside = 0;
    for (const Disk& d : step.state.bodies) inside += d.x[1] > 0 ? d.mass : 0;
    while (next < 3 && whole - inside >= shares[next] * whole) times[next++] = step.state.time;
    return next < 3;
  });
  return {0.15 * whole / (times[1] - times[0]), 0.15 * whole / (times[2] - times[1])};
}

void beverloo(Experiment& e) {
  e.rows = {
      ValidationRow(
          "discharge_exponent",
          "exponent of the discharge rate against D - 1.4 d, holes of 5 to 9 mean diameters",
          "Beverloo, Leniger and van de Velde 1961; in the plane √g D^(3/2) is what dimensions "
          "leave (free fall from a height of the order of D). k d is fitted elsewhere, k from 1 to 2, "
          "which moves the exponent by 0.15 (from memory)",
          "3/2", Expectation::equal(1.5),
          {0.1, "k is not known better",
           "95 % of the fit over holes, seeds and halves of the time"}),
      ValidationRow(
          "discharge_steady",
          "discharge rate while the filling goes from 75 to 60 % over that from 90 to 75 %",
          "Hagen 1852: the rate does not depend on the height of the filling", "1",
          Expectation::equal(1),
          {0.05, "few disks", "95 % over holes and seeds that do not clog"})};
  e.tols = {1, 1e-1, 1e-2};
  e.quick_tols = {1, 1e-1};
  e.run = [](Experiment::Trial& trial) {
    const int count = trial.context.quick ? 260 : 500, seeds = 3;
    const double holes[] = {5, 6.5, 9};
    std::vector<double> widths, rates, ratios;
    int clogged = 0;
    Chart::Series points{"measured", 0, {}, Chart::Series::Kind::kPoints};
    for (const double hole : holes) {
      for (int seed = 1; seed <= seeds; ++seed) {
        const Discharge seen = discharge(hole, count, to_size(seed), trial);
        if (!std::isfinite(seen.second)) {
          ++clogged;
          continue;
        }
        ratios.push_back(seen.second / seen.first);
        for (const double rate : {seen.first, seen.second}) {
          widths.push_back(hole - 1.4);
          rates.push_back(rate);
          points.points.push_back({hole, std::pow(rate, 2.0 / 3)});
        }
      }
    }
    const PowerLaw law = fit_power_law(widths, rates);
    const MeanValue ratio = mean_value(ratios);
    trial.seen = {
        {law.exponent, law.confidence,
         fmt::format("{:.2f} √g ρ (D - 1.4 d)^{:.2f}",
                     law.prefactor * std::numbers::pi / std::sqrt(kGravity), law.exponent)},
        {ratio.mean, ratio.confidence,
         fmt::format("{} runs flow, {} clog and have no rate", ratios.size(), clogged)}};
    Chart chart{.title = "Discharge of a silo",
                .x = {.label = "hole over mean diameter"},
                .y = {.label = "rate^(2/3)"}};
    const std::string caption =
        "Discharge rate to the power 2/3 against the width of the hole: Beverloo's law is a straight line that meets zero at k d. "
        "Line: through k = 1.4 with the exponent 3/2.";
    Chart::Series line{"k = 1.4", 1, {}, Chart::Series::Kind::kLine};
    double slope = 0;
    for (std::size_t k = 0; k < rates.size(); ++k) {
      slope += std::pow(rates[k], 2.0 / 3) / widths[k] / static_cast<double>(rates.size());
    }
    for (const double hole : {1.4, 10.0}) line.points.push_back({hole, slope * (hole - 1.4)});
    chart.series = {points, line};
    trial.draw("beverloo", caption, std::move(chart));
  };
}

}  // namespace

std::vector<Experiment> silo_experiments() { return made_by({&janssen, &beverloo}); }

}  // namespace bipot
