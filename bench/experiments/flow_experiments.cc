// Flows: plane shear under constant pressure, and columns that collapse.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bench/experiments/experiment_scene.h"
#include "bench/experiments/validation_row.h"
#include "bench/measure/statistics.h"
#include "bench/problems/scene_catalogue.h"
#include "core/observables/observables.h"
#include "core/scene_files/scene_file.h"

namespace bipot {
namespace {

/// Means over the second half of a shear.
struct Sheared {
  double inertial = 0;
  MeanValue friction, fraction;  ///< over blocks, as the others
  MeanValue pressure;            ///< over the one that is imposed
  MeanValue power;               ///< of the mean shear stress over the dissipation of contacts
};

/// The shipped plane_shear at another speed, over the shear strain `strain` in steps of at most
/// 1e-3 of it.
Sheared shear(double speed, double strain, Experiment::Trial& trial) {
  Scene<2> scene = read_scene(find_scene("plane_shear"));
  scene.solver = trial.choice();
  scene.cell.offset.speed = speed;
  const double height = 0.9;                            // about, once it is dense
  const double duration = 1 + strain * height / speed;  // compression first
  scene.step = std::clamp(1e-3 / speed, 1e-3, 4e-3);
  scene.num_steps = static_cast<int>(duration / scene.step);
  const int from = scene.num_steps / 2;
  constexpr int kBlocks = 8;
  std::vector<double> friction[kBlocks], fraction[kBlocks], pressure[kBlocks];
  double inertial = 0, work[kBlocks] = {}, losses[kBlocks] = {}, loss = kNaN;
  long samples = 0;
  run_from_start<2>(scene, trial, [&](const SceneStep<2>& step) {
    const State<2>& state = step.state;
    if (state.step < from) return true;
    const auto block = to_size(
        std::min(kBlocks - 1, kBlocks * (state.step - from) / std::max(1, scene.num_steps - from)));
    const double lost = state.friction_loss + state.shock_loss;
    if (!std::isnan(loss)) losses[block] += lost - loss;
    loss = lost;
    if (state.step % 5 != 0) return true;
    const Observables<2> seen = observe(scene, state, {});
    const Mat2 stress = seen.stress.total();
    friction[block].push_back(std::abs(stress(0, 1)) / stress(1, 1));
    fraction[block].push_back(seen.solid_fraction);
    pressure[block].push_back(stress(1, 1) / scene.cell.height.stress);
    inertial += seen.inertial_number();
    work[block] +=
        std::abs(stress(0, 1)) * std::abs(speed) * state.cell.width.length * 5 * scene.step;
    ++samples;
    return true;
  });
  // The ratio of the sums; its bar from the blocks, each with the losses of all.
  const double mean_loss = std::accumulate(losses, losses + kBlocks, 0.0) / kBlocks;
  std::vector<double> excess(kBlocks);
  for (int b = 0; b < kBlocks; ++b) excess[to_size(b)] = (work[b] - losses[b]) / mean_loss;
  const MeanValue over_losses = mean_value(excess);
  return {.inertial = inertial / static_cast<double>(samples),
          .friction = mean_of_blocks(friction),
          .fraction = mean_of_blocks(fraction),
          .pressure = mean_of_blocks(pressure),
          .power = {1 + over_losses.mean, over_losses.confidence}};
}

/// Slope against the inertial number from the two ends of the range, with its bar.
Observation slope(const Sheared& slow, const Sheared& fast, MeanValue Sheared::*of,
                  const std::string& symbol) {
  const MeanValue &low = slow.*of, &high = fast.*of;
  const double span = fast.inertial - slow.inertial;
  return {(high.mean - low.mean) / span, std::hypot(low.confidence, high.confidence) / span,
          fmt::format("{} = {:.3f} at I = {:.3f}, {:.3f} at {:.3f}", symbol, low.mean,
                      slow.inertial, high.mean, fast.inertial)};
}

void plane_shear(Experiment& e) {
  const std::string memory =
      "da Cruz, Emam, Prochnow, Roux and Chevoir, PRE 72, 021309 (2005): τ/P = .26 + 1.0 I, "
      "ν = .81 − .3 I are from memory, so only the trend is tested";
  e.rows = {
      ValidationRow(
          "shear_pressure",
          "mean normal stress across the layers (Love and Weber, with the kinetic part) over the "
          "pressure that is imposed; slowest shear",
          "momentum of the cell's side in a steady state", "1", Expectation::equal(1),
          {2e-2, "finite time: the side still moves", "95 % over 8 blocks of time"}),
      ValidationRow(
          "shear_power",
          "work of the mean shear stress over what friction and shocks dissipate; slowest shear",
          "energy in a steady state: stress from branches and forces, loss from the ledger", "1",
          Expectation::equal(1),
          {5e-2, "finite time; the height's work and one sample in five steps",
           "95 % over 8 blocks of time"}),
      ValidationRow("shear_friction", "rise of τ/P with the inertial number", memory, "above 0",
                    Expectation::at_least(0, 1), {0, "none", "95 % over 8 blocks of time"}),
      ValidationRow("shear_fraction", "rise of the solid fraction with the inertial number", memory,
                    "below 0", Expectation::at_most(0, 1),
                    {0, "none", "95 % over 8 blocks of time"})};
  e.tols = {10, 1, 1e-1, 1e-2, 1e-3};
  e.quick_tols = {1, 1e-1};
  e.run = [](Experiment::Trial& trial) {
    const std::vector<double> speeds =
        trial.context.quick ? std::vector<double>{0.5, 2} : std::vector<double>{0.1, 0.3, 1, 2.5};
    std::vector<Sheared> runs;
    for (const double speed : speeds) {
      runs.push_back(shear(speed, trial.context.quick ? 2 : 6, trial));
    }
    const Sheared &slow = runs.front(), &fast = runs.back();
    trial.seen = {
        {slow.pressure.mean, slow.pressure.confidence, fmt::format("I = {:.3f}", slow.inertial)},
        {slow.power.mean, slow.power.confidence},
        slope(slow, fast, &Sheared::friction, "τ/P"),
        slope(slow, fast, &Sheared::fraction, "ν")};
    Chart chart{.title = "Plane shear",
                .x = {.label = "inertial number", .kind = Chart::Axis::Kind::kLog},
                .y = {.label = "τ/P and solid fraction", .low = 0, .high = 1}};
    const std::string caption =
        "Plane shear of 120 disks (μ = 0.4) in a periodic cell under constant pressure: τ/P and solid fraction against "
        "the inertial number, bars over blocks of time; lines: the laws of da Cruz et al. (2005) as remembered, not tested.";
    Chart::Series friction{"τ/P", 0, {}};
    Chart::Series fraction{"solid fraction", 1, {}};
    Chart::Series law{".26 + 1.0 I", 2, {}, Chart::Series::Kind::kLine};
    Chart::Series density{".81 − .3 I", 3, {}, Chart::Series::Kind::kLine};
    const auto add = [](Chart::Series& series, double x, const MeanValue& y) {
      Chart::Point& point = series.points.emplace_back(Chart::Point{x, y.mean});
      point.y_low = y.mean - y.confidence;
      point.y_high = y.mean + y.confidence;
    };
    for (const Sheared& r : runs) {
      add(friction, r.inertial, r.friction);
      add(fraction, r.inertial, r.fraction);
      law.points.push_back({r.inertial, 0.26 + r.inertial});
      density.points.push_back({r.inertial, 0.81 - 0.3 * r.inertial});
    }
    chart.series = {friction, fraction, law, density};
    trial.draw("shear", caption, std::move(chart));
  };
}

/// Runout of a column of disks, its corner wall at the left as a plane of symmetry: (r - r0)/r0.
/// Within r lies 97 % of the mass at the end, within r0 at the start.
double runout(double aspect, int width, std::uint64_t seed, Experiment::Trial& trial) {
  constexpr double kDiameter = 1, kMu = 0.5;
  Scene<2> scene = experiment_scene<2>({.mu = kMu}, 5e-3, trial);
  const int count = static_cast<int>(std::lround(width * width * aspect * 1.05));
  const double top = fill_box(scene, count, width * kDiameter, 0, seed);
  const double settle = 2 + std::sqrt(2 * top / kGravity);
  scene.walls[2].removed = settle;
  scene.num_steps =
      static_cast<int>((settle + 3 + 2.5 * std::sqrt(2 * top / kGravity)) / scene.step);
  const auto edge = [](const State<2>& state) {
    std::vector<std::pair<double, double>> mass;
    double total = 0;
    for (const Disk& d : state.bodies) {
      mass.emplace_back(d.x[0] + d.radius, d.mass);
      total += d.mass;
    }
    std::ranges::sort(mass);
    double inside = 0;
    for (const auto& [x, m] : mass) {
      inside += m;
      if (inside >= 0.97 * total) return x;
    }
    return kNaN;
  };
  double start = kNaN;
  const auto end = run_from_start<2>(scene, trial, [&](const SceneStep<2>& step) {
    if (step.state.time < settle) start = edge(step.state);
    return true;
  });
  return (edge(end) - start) / start;
}

void column_collapse(Experiment& e) {
  e.rows = {ValidationRow(
      "column_collapse",
      "exponent of the runout of a column against its aspect ratio, above 2 (within which 97 % of "
      "the mass comes to rest)",
      "Staron and Hinch 2005 (contact dynamics: a power law; 0.7), Lube et al. and Lajeunesse et al. "
      "2005 (2/3), and a plane experiment with rods (abstract of arXiv 1512.05180: 3.80 a^0.73 above "
      "1.5); prefactors not tested",
      "2/3 to 0.73", Expectation::between(2.0 / 3, 0.73, 0.7),
      {0.15, "columns of 6 to 8 disks across", "95 % of the fit over aspect ratios and seeds"})};
  e.tols = {10, 1, 1e-1, 1e-2, 1e-3};
  e.quick_tols = {1, 1e-1};
  e.run = [](Experiment::Trial& trial) {
    const std::vector<double> aspects =
        trial.context.quick ? std::vector<double>{2, 3.5, 6} : std::vector<double>{2, 3, 4.5, 7};
    const int seeds = trial.context.quick ? 2 : 4, width = trial.context.quick ? 5 : 7;
    std::vector<double> a, r;
    Chart::Series series{"columns", 0, {}, Chart::Series::Kind::kPoints};
    for (const double aspect : aspects) {
      for (int seed = 1; seed <= seeds; ++seed) {
        a.push_back(aspect);
        r.push_back(runout(aspect, width, to_size(seed), trial));
        series.points.push_back({a.back(), r.back()});
      }
    }
    const PowerLaw law = fit_power_law(a, r);
    trial.seen = {{law.exponent, law.confidence,
                   fmt::format("runout {:.2f} a^{:.2f}", law.prefactor, law.exponent)}};
    Chart chart{.title = "Column collapse",
                .x = {.label = "aspect ratio", .kind = Chart::Axis::Kind::kLog},
                .y = {.label = "runout over the first width", .kind = Chart::Axis::Kind::kLog}};
    const std::string caption =
        "Runout of columns against their aspect ratio, with the fitted power law; grey: 3.80 a^0.73 of rods on a plane "
        "(arXiv 1512.05180, whose front counts the last rod).";
    Chart::Series fit{fmt::format("{:.2f} a^{:.2f}", law.prefactor, law.exponent),
                      1,
                      {},
                      Chart::Series::Kind::kLine};
    Chart::Series rods{"3.80 a^0.73", 2, {}, Chart::Series::Kind::kLine};
    for (const double aspect : {aspects.front(), aspects.back()}) {
      fit.points.push_back({aspect, law.prefactor * std::pow(aspect, law.exponent)});
      rods.points.push_back({aspect, 3.8 * std::pow(aspect, 0.73)});
    }
    chart.series = {series, fit, rods};
    trial.draw("collapse", caption, std::move(chart));
  };
}

/// Action of the drum on the grains, by their angular momentum L about its axis. Its moment is the
/// change of L less the moment of their weight, its work that times its speed. The work is lost in
/// contacts or goes into the grains' energy: two sums that share only the states.
void turning_drum(Experiment& e) {
  e = {
      .rows = {ValidationRow(
          "drum_power",
          "rotating drum (shipped scene): work of the wall by the grains' angular momentum and weight, "
          "over what contacts dissipate and the grains gain",
          "angular momentum and energy (derived)", "1", Expectation::equal(1),
          {5e-3, "overlaps: the arms of the wall and of a grain that overlap by δ differ by δ",
           "discretisation: one run"})},
      .tols = {10, 1, 1e-1, 1e-2, 1e-3},
      .quick_tols = {1, 1e-1}};
  e.run = [](Experiment::Trial& trial) {
    Scene<2> scene = read_scene(find_scene("drum"));
    scene.solver = trial.choice();
    if (trial.context.quick) scene.bodies.resize(90);
    scene.num_steps = trial.context.quick ? 800 : 3000;
    const auto energy = [&](const State<2>& state) {
      return kinetic_energy(state) + potential_energy(state, scene.gravity) + state.friction_loss +
             state.shock_loss;
    };
    const State<2> start = initial_state(scene);
    double weight_moment = 0;
    const auto end = run_from<2>(scene, start, trial, [&](const SceneStep<2>& step) {
      for (const Disk& d : step.state.bodies) {
        // Gravity acts at the middle of the step, before its impulses: x - h/2 v⁺.
        weight_moment += d.mass * scene.gravity[1] * (d.x[0] - 0.5 * scene.step * d.v[0]);
      }
      return true;
    });
    const double moment =
        angular_momentum(end) - angular_momentum(start) - scene.step * weight_moment;
    const double gained = energy(end) - energy(start);
    trial.seen = {
        {moment * scene.walls[0].spin / gained, 0,
         fmt::format("wall work in the ledger over the same: {:.5f}", end.wall_work / gained)}};
  };
}

}  // namespace

std::vector<Experiment> flow_experiments() {
  return made_by({&plane_shear, &column_collapse, &turning_drum});
}

}  // namespace bipot
