// Fig. 12: 2470 disks pressed by four walls that are driven by forces.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "bench/experiments/compression_run.h"
#include "bench/experiments/paper_item.h"
#include "bench/report/labels.h"
#include "core/pictures/force_picture.h"

namespace bipot {
namespace {

Compression compressed(const CompressionOptions& options, double step_factor, double tol, int cap,
                       const PaperItem::Context& context) {
  Scene<2> scene = compression_scene(options);
  scene.step *= step_factor;
  scene.solver.tol = tol;
  scene.solver.max_iterations = cap;
  return run_compression(scene, context.interrupted);
}

double at_lag(const Compression::Phase& phase, std::size_t lag) {
  return lag < phase.correlation.size() ? phase.correlation[lag] : std::nan("");
}

double overlap(const Compression& c) {
  double largest = 0;
  for (const ContactOutcome<2>& o : c.state.contacts) largest = std::max(largest, -o.contact.gap);
  return largest / 0.8e-3;
}

double mean_overlap(const Compression& c) {
  double sum = 0;
  int loaded = 0;
  for (const ContactOutcome<2>& o : c.state.contacts) {
    if (!(o.s_n > 0)) continue;
    sum += std::max(0.0, -o.contact.gap);
    ++loaded;
  }
  return sum / std::max(loaded, 1) / 0.8e-3;
}

/// A row of the table of variations.
std::vector<std::string> row(const std::string& name, const Compression& c) {
  const Compression::Phase& j = c.jammed;
  return {name,
          fmt::format("{:.4f}", c.solid_fraction),
          fmt::format("{:.2f}", c.coordination),
          fmt::format("{:.4f}", j.wall_pressure / j.applied_pressure),
          fmt::format("{:.4f}", 0.5 * j.stress.trace() / j.wall_pressure),
          fmt::format("{:.3f}", anisotropy(j.stress)),
          fmt::format("{:.3f}", at_lag(j, 1)),
          fmt::format("{:.3f}", at_lag(j, 2)),
          fmt::format("{:.2f}", overlap(c)),
          fmt::format("{} of {}", c.jammed_run.converged, c.jammed_run.steps),
          error_label(c.jammed_run.mean_error),
          fmt::format("{}", c.run.iterations)};
}

constexpr double kCompressionTol = 1e-2;
constexpr const char* kBarOfBlocks = "95 % over 8 blocks of time";
constexpr const char* kBarOfSolver = "discretisation: the solver's tolerance, 1e-2";
constexpr const char* kBarOfStarts = "difference of two starts";
constexpr int kCap = 3000;  // iterations

struct WantedVariation {
  const char* name;
  CompressionOptions options;
  double step_factor = 1, tol = kCompressionTol;
};

/// Excess of the correlation over two steps above that over one.
double turn(const Compression& c) { return at_lag(c.jammed, 2) - at_lag(c.jammed, 1); }

double stress_anisotropy(const Compression& c) { return anisotropy(c.jammed.stress); }

void pictures(const PaperItem::Context& context, const Compression& main, Findings& result) {
  const State<2> mean = main.jammed.contacts.in(main.state);
  double largest = 0;
  for (const State<2>* state : {&main.previous, &main.state, &mean}) {
    for (const ContactOutcome<2>& o : state->contacts) {
      largest = std::max(largest, o.s_n / main.scene.step);
    }
  }
  // About as large as the page shows it.
  const ForcePictureOptions options{.width = 600, .full_force = largest, .take_off = false};
  const auto draw = [&](const char* name, const State<2>& state, const std::string& caption) {
    draw_force_picture(context.out / fmt::format("{}.svg", name), main.scene, state, "", options);
    result.show(name, caption, 1);
  };
  draw("fig12_before", main.previous, "Force chains after 299 steps.");
  draw("fig12_end", main.state, "Force chains after 300 steps, one later. Same scale.");
  draw("fig12_mean", mean,
       fmt::format("Mean forces of the last {} steps, drawn at the disks' last places. Same "
                   "scale. Stick and slip are those of the last step of each contact.",
                   main.jammed.steps));
}

void falling_numbers(const Compression& main, Findings& result) {
  const Compression::Phase& flow = main.flow;
  result.state("disks", main.state.bodies.size(), "",
               "disks; density 7800 kg/m³, a wall has 20 kg for 2470 disks");
  result.state("solid_fraction", main.solid_fraction, "", "solid fraction at the end");
  result.state("coordination", main.coordination, "",
               "loaded contacts of a disk, mean of the last 100 steps", 3);
  result.state("flow_steps", flow.steps, "",
               "steps of the fall: kinetic energy above a tenth of its largest value");
  result.state("flow_lag1", at_lag(flow, 1), "",
               "correlation of the forces of consecutive steps, during the fall", 2);
  result.state("flow_variation", flow.variation, "",
               "variation of the pressure over 8 × 8 windows, single steps of the fall, mean", 2);
  result.test("flow_variation_mean", flow.mean_windows.variation, "",
              "the same of the mean over the fall", "less than of the single steps",
              Expectation::at_most(flow.variation), flow.variation_bar, kBarOfBlocks, 2);
  result.state("flow_side", flow.horizontal, "",
               "(right half − left half)/sum of the pressure, rms over the steps of the fall", 2);
  result.test("flow_side_mean", std::abs(flow.mean_windows.horizontal), "",
              "the same of the mean over the fall, absolute", "less than of the single steps",
              Expectation::at_most(flow.horizontal), flow.horizontal_bar, kBarOfBlocks, 2);
}

void jammed_numbers(const Compression& main, Findings& result) {
  const Compression::Phase& jam = main.jammed;
  result.state("jam_lag1", at_lag(jam, 1), "",
               "correlation of the forces of consecutive steps, last 100 steps", 3);
  result.test("jam_lag2", at_lag(jam, 2), "", "of steps that are two apart",
              "above that of consecutive steps: e_t = 1 repeats every second step",
              Expectation::at_least(at_lag(jam, 1)), kCompressionTol, kBarOfSolver, 3);
  result.state("stress_anisotropy", jam.anisotropy, "",
               "(σ₁ − σ₂)/(σ₁ + σ₂) of single steps, mean of the last 100", 2);
  result.test("stress_anisotropy_mean", anisotropy(jam.stress), "",
              "of the mean stress of the last 100 steps", "at most that of the single steps",
              Expectation::at_most(jam.anisotropy), kCompressionTol * jam.anisotropy, kBarOfSolver,
              2);
  const double mean_fabric = anisotropy(fabric_tensor(jam.contacts.in(main.state)));
  result.state("fabric_anisotropy", jam.fabric_anisotropy, "",
               "the same of the fabric Σ n ⊗ n / N of the loaded contacts, single steps", 2);
  result.state("fabric_anisotropy_mean", mean_fabric, "",
               "of all contacts that were loaded in the last 100 steps", 2);
  result.state("jam_variation", jam.variation, "",
               "variation of the pressure over the windows, single steps, last 100", 3);
  result.test("jam_variation_mean", jam.mean_windows.variation, "", "of the mean over them",
              "less than of the single steps", Expectation::at_most(jam.variation),
              kCompressionTol * jam.variation, kBarOfSolver, 3);
  result.state("jam_side", jam.horizontal, "",
               "(right half − left half)/sum, single steps, rms of the last 100", 2);
  result.state("jam_side_mean", std::abs(jam.mean_windows.horizontal), "",
               "of the mean over them, absolute", 2);
}

void homogeneity_text(Findings& result) {
  result.ours.emplace_back(
      "There are two regimes. While the walls fall inwards ({flow_steps} steps) the forces of "
      "one step have little to do with those of the next (correlation {flow_lag1}); the "
      "windows' pressures vary by {flow_variation} of their mean in a single step, by "
      "{flow_variation_mean} in the average; one half of the sample carries {flow_side} more "
      "than the other (relative to both, rms), in the average {flow_side_mean}. That is what the "
      "paper describes.");
  result.ours.emplace_back(
      "Once the sample is jammed (solid fraction {solid_fraction}, coordination {coordination}), "
      "the chains still change from one step to the next, correlation {jam_lag1}, but two steps "
      "on they are back, {jam_lag2}: e_t = 1 turns the tangential velocity of sticking contacts "
      "round at each step, and with it the frictional forces, so that two networks take turns. "
      "An average over an even number of steps removes that; the variation over the windows "
      "falls from {jam_variation} to {jam_variation_mean} only, because the packing itself is "
      "uneven. Stress and fabric are isotropic to {stress_anisotropy} and {fabric_anisotropy} "
      "at each step, to {stress_anisotropy_mean} and {fabric_anisotropy_mean} in the average.");
}

void correlation_chart(const Compression& main, Findings& result) {
  Chart chart{.title = "Correlation of the contact forces against the number of steps between",
              .x = {"steps between", Chart::Axis::Kind::kLinear, 0.0, 20.0},
              .y = {"correlation", Chart::Axis::Kind::kLinear, {}, 1.0}};
  const auto series = [&](const std::string& name, int style, const Compression::Phase& phase) {
    Chart::Series s{name, style, {}};
    for (std::size_t lag = 0; lag < phase.correlation.size() && lag <= 20; ++lag) {
      s.points.push_back({static_cast<double>(lag), phase.correlation[lag]});
    }
    return s;
  };
  chart.series = {series("falling", 0, main.flow), series("jammed", 1, main.jammed)};
  result.draw("fig12_correlation",
              "Correlation of the normal forces of two steps, pair by "
              "pair, mean over all such steps.",
              chart, 1);
}

void walls(const Compression& main, Findings& result) {
  const Compression::Phase& jam = main.jammed;
  result.check("wall_balance", main.wall_balance, "",
               "largest |contact force on a wall − (5000 N − mass × acceleration)| over the "
               "applied force, all steps",
               "round-off", main.wall_balance <= 1e-9, 2);
  const double normal = jam.wall_pressure / jam.applied_pressure;
  result.check("wall_pressure", normal, "",
               "normal contact force of the walls over the applied force, mean of the last "
               "100 steps",
               "1 within 1 %", std::abs(normal - 1) <= 0.01, 5);
  const double asymmetry = std::max(main.flow.asymmetry, jam.asymmetry);
  result.check("asymmetry", asymmetry, "",
               "largest |σ_xy − σ_yx|/(σ_xx + σ_yy) of a step, falling and jammed",
               "round-off: below 1e-12", asymmetry < 1e-12, 2);
  const double traction = (jam.stress - jam.walls).norm() / jam.walls.norm();
  result.check("traction_difference", traction, "",
               "mean stress against the walls' forces, normal and tangential, Σ f ⊗ p / V: "
               "relative difference, last 100 steps",
               "at most 1 %", traction <= 0.01, 2);
  const double ratio = 0.5 * jam.stress.trace() / jam.wall_pressure;
  result.check("pressure_ratio", ratio, "",
               "pressure in the sample over the walls' normal pressure, last 100 steps",
               "within 5 % = μ/2, what friction along the walls can add",
               std::abs(ratio - 1) <= 0.05, 5);
  result.ours.emplace_back(
      "Wall pressure. Applied force, contact force and inertia of the walls balance to "
      "{wall_balance}. At the end the walls carry {wall_pressure} of the applied force, and the "
      "mean stress, symmetric to {asymmetry}, equals what the walls do to the sample to "
      "{traction_difference}. Its pressure is {pressure_ratio} of the normal pressure alone, "
      "because friction along the walls presses the sample as well; without friction there it is "
      "{ratio_smooth} (table).");
  result.state("jam_met", main.jammed_run.converged, "",
               "of the last 100 steps, those that met the tolerance 1e-2 within 3000 iterations");
  result.state("jam_error", main.jammed_run.mean_error, "",
               "ε of the last 100 steps, geometric mean", 2);
  result.state("far_starts", main.run.far_starts, "",
               "steps whose solve began with the impulses of two steps before");
  result.state("overlap", overlap(main), "", "largest overlap at the end over the smallest radius",
               2);
  result.state("overlap_mean", mean_overlap(main), "",
               "mean overlap of the loaded contacts over the smallest radius", 2);
  result.ours.emplace_back(
      "Cost. Jammed steps with e_t = 1 are hard: {jam_met} of the last 100 met 1e-2 within 3000 "
      "iterations of `apgd`, the others reached ε = {jam_error} (mean of all). A solve begins "
      "with the impulses of two steps before where the last forces are more like those than like "
      "the ones of one step before ({far_starts} of 300 steps). The walls arrive fast, so that "
      "disks overlap by {overlap_mean} of the smallest radius in the mean, {overlap} at most; "
      "overlaps are not pushed back.");
  Chart chart{.title = "Pressure against time",
              .x = {"time (s)", Chart::Axis::Kind::kLinear, 0.0, {}},
              .y = {"pressure (Pa)", Chart::Axis::Kind::kLinear, 0.0, {}}};
  const auto series = [&](const char* name, int style, const std::vector<double>& values) {
    Chart::Series s{name, style, {}, Chart::Series::Kind::kLine};
    for (std::size_t k = 0; k < values.size(); ++k) {
      s.points.push_back({main.time[k], values[k], false, "", false});
    }
    return s;
  };
  chart.series = {series("mean stress", 0, main.pressure),
                  series("walls, contact forces", 1, main.wall_pressure),
                  series("walls, applied forces", 2, main.applied_pressure)};
  result.draw("fig12_pressure",
              "Pressure in the sample (contacts and velocity "
              "fluctuations), of the contacts on the walls, and of the "
              "driving forces.",
              chart, 2);
}

/// The paper's open choices, of density and mass, then solver and restitution, one changed at a
/// time.
std::vector<WantedVariation> wanted_variations(int count) {
  const CompressionOptions base = {.count = count};
  const auto with = [&](auto&& change) {
    CompressionOptions options = base;
    change(options);
    return options;
  };
  return {{"7800 kg/m³, 20 kg, 7e-5 s, 1e-2", base},
          {"walls' mass / 4", with([](auto& o) { o.wall_mass /= 4; })},
          {"walls' mass × 4", with([](auto& o) { o.wall_mass *= 4; })},
          {"density / 4, step / 2", with([](auto& o) { o.density /= 4; }), 0.5},
          {"density / 4", with([](auto& o) { o.density /= 4; })},
          {"density × 4", with([](auto& o) { o.density *= 4; })},
          {"another start", with([](auto& o) { o.seed = 2; })},
          {"tolerance 1e-1", base, 1, 1e-1},
          {"tolerance 1e-3", base, 1, 1e-3},
          {"e_t = 0", with([](auto& o) { o.e_t = 0; })},
          {"smooth walls", with([](auto& o) { o.smooth_walls = true; })}};
}
constexpr std::size_t kChoices = 4;  // the open choices among them

/// With its first row, the run of the figure.
Findings::Table variations_table(const Compression& main, int count) {
  return {.name = "fig12_variations",
          .caption = fmt::format(
              "First row: as above, {} disks. The others: {} disks, box and forces half as large "
              "for a quarter of the disks (the same pressure), masses of the walls in the ratio "
              "of the disks' number, {} iterations at most. Means of the last 100 steps.",
              main.state.bodies.size(), count, kCap),
          .columns = {"", "solid fraction", "coordination", "wall / applied force",
                      "pressure / wall pressure", "stress anisotropy of the mean",
                      "correlation, 1 step", "2 steps", "largest overlap / smallest radius",
                      "steps that met the tolerance", "ε, geometric mean", "iterations, all steps"},
          .rows = {row(fmt::format("{} disks", main.state.bodies.size()), main)}};
}

void variation_numbers(const std::map<std::string, Compression>& made,
                       const std::vector<const Compression*>& choices, const Compression& main,
                       int count, Findings& result) {
  const Compression::Phase& smooth = made.at("smooth walls").jammed;
  const double ratio_smooth = 0.5 * smooth.stress.trace() / smooth.wall_pressure;
  const double inelastic = at_lag(made.at("e_t = 0").jammed, 1);
  const double light = made.at("density / 4").solid_fraction,
               heavy = made.at("density × 4").solid_fraction;
  const auto ends = [&](const auto& value) {
    std::vector<double> values;
    for (const Compression* c : choices) values.push_back(std::invoke(value, *c));
    return std::ranges::minmax(values);
  };
  const auto fractions = ends(&Compression::solid_fraction),
             coordinations = ends(&Compression::coordination);
  // What two starts differ by.
  const Compression &a = *choices.front(), &b = made.at("another start");
  result.check("ratio_smooth", ratio_smooth, "",
               fmt::format("pressure in the sample over the walls' normal pressure, smooth "
                           "walls, {} disks",
                           count),
               "1 within 1 %", std::abs(ratio_smooth - 1) <= 0.01, 5);
  result.test("fraction_spread", (fractions.max - fractions.min) / fractions.max, "",
              "spread of the solid fraction over density and walls' mass, each by 1/4 and 4",
              "at most 2 %", Expectation::at_most(0.02),
              std::abs(a.solid_fraction / b.solid_fraction - 1), kBarOfStarts, 2);
  result.state("fraction_step", std::abs(heavy - light) / light, "",
               "change of the solid fraction from density / 4 to density × 4 with the same "
               "step of 7e-5 s",
               2);
  result.test("coordination_spread", (coordinations.max - coordinations.min) / coordinations.max,
              "", "the same of the coordination", "at most 10 %", Expectation::at_most(0.1),
              std::abs(a.coordination / b.coordination - 1), kBarOfStarts, 2);
  result.test("anisotropy_most", ends(&stress_anisotropy).max, "",
              "largest anisotropy of the mean stress among them", "at most 0.1",
              Expectation::at_most(0.1), std::abs(stress_anisotropy(a) - stress_anisotropy(b)),
              kBarOfStarts, 2);
  result.test("turn_least", ends(&turn).min, "",
              "least excess of the correlation over two steps over that of one, among them",
              "above 0: networks take turns", Expectation::at_least(0), std::abs(turn(a) - turn(b)),
              kBarOfStarts, 2);
  result.test(
      "inelastic_lag1", inelastic, "",
      fmt::format("correlation of the forces of consecutive steps, e_t = 0, {} disks", count),
      "above that with e_t = 1", Expectation::at_least(at_lag(main.jammed, 1)), kCompressionTol,
      kBarOfSolver, 4);
}

/// Density, walls' mass, tolerance and restitution at a quarter of the size.
void variations(const PaperItem::Context& context, const Compression& main, Findings& result) {
  const int count = context.quick ? 154 : 617;
  Findings::Table table = variations_table(main, count);
  std::map<std::string, Compression> made;
  std::vector<const Compression*> choices;
  for (const WantedVariation& w : wanted_variations(count)) {
    context.report(fmt::format("{} disks: {}", count, w.name));
    const Compression& c = made[w.name] =
        compressed(w.options, w.step_factor, w.tol, kCap, context);
    table.rows.push_back(row(w.name, c));
    if (choices.size() < kChoices) choices.push_back(&c);
  }
  variation_numbers(made, choices, main, count, result);
  result.tables.push_back(std::move(table));
  result.ours.emplace_back(
      "Choices. Steel-like 7800 kg/m³ and walls of 20 kg. With the walls' mass by factors 1/4 "
      "and 4 the solid fraction changes by {fraction_spread}, the coordination by "
      "{coordination_spread}, the mean stress is isotropic to {anisotropy_most}, and the "
      "networks take turns in all. Density sets the unit of time: with the step in proportion to "
      "its root, a change of density is one of the walls' mass (two rows of the table are "
      "equal). With the same step for all densities the solid fraction changes by "
      "{fraction_step} from density / 4 to density × 4: a faster fall overlaps more in a step. "
      "Another start, and tolerances from 1e-1 to 1e-3, lead to other networks but the same "
      "picture. With e_t = 0 the jammed network stands still, correlation {inelastic_lag1}.");
}

}  // namespace

Findings run_fig12(const PaperItem::Context& context) {
  Findings result;
  result.paper =
      "2470 disks (25 % of radius 0.8 mm, 50 % of 0.9 mm, 25 % of 1.0 mm; μ = 0.1, e_n = 0, "
      "e_t = 1) between four movable walls, each pushed by 5000 N, 300 steps of 7e-5 s. After "
      "the last step the large forces stand on the right-hand side of the sample; an average "
      "over a longer time is homogeneous, because the configuration of forces changes very "
      "fast. Density, walls' mass and the start are not given, the average is not shown.";
  const int count = context.quick ? 617 : 2470;
  context.report(fmt::format("{} disks", count));
  const Compression main = compressed({.count = count}, 1, kCompressionTol, kCap, context);
  pictures(context, main, result);
  falling_numbers(main, result);
  jammed_numbers(main, result);
  homogeneity_text(result);
  correlation_chart(main, result);
  walls(main, result);
  variations(context, main, result);
  return result;
}

}  // namespace bipot
