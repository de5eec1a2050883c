// Fig. 11: 342 disks of three sizes fall into a box and come to rest.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>

#include "bench/experiments/packing.h"
#include "bench/experiments/paper_item.h"
#include "bench/measure/statistics.h"
#include "bench/problems/scene_catalogue.h"
#include "core/motion/force_balance.h"
#include "core/pictures/force_picture.h"
#include "core/scene/generators.h"
#include "core/scene/scene_parts.h"
#include "core/scene_files/scene_file.h"

namespace bipot {
namespace {

// Kinetic energy at rest, relative to the energy released by the fall.
constexpr double kRestEnergy = 1e-9;
constexpr int kQuietSteps = 100;        // at rest for as long
constexpr double kLatest = 0.5;         // time limit for a packing to come to rest     [s]
constexpr double kSample = 0.2;         // duration of packings that only give forces            [s]
constexpr double kDiameter = 1.525e-3;  // mean of the three sizes                               [m]

/// A packing on its way to rest.
struct Settling {
  Scene<2> scene;
  State<2> state;
  double initial = 0, final = 0;  ///< potential energy                                       [J]
  double kinetic = 0;             ///< mean of the last kQuietSteps steps                     [J]
  double displacement = 0;        ///< the same of displacement_energy()                      [J]
  double floor = 0, sides = 0;    ///< mean upward force in these steps over the weight
  double side_limit = 0;          ///< mu times the side walls' normal force over the weight
  bool at_rest = false;
  PackingRun run;
  std::vector<Chart::Point> history;  ///< kinetic energy over the energy released, against time

  double released() const { return initial - final; }
};

struct Variant {
  double e_t = 1;
  bool rough_sides = true;
  int seed = 1;
  double step = 1e-4;       // [s]
  double latest = kLatest;  // [s]
};

double weight(const Scene<2>& scene) {
  double sum = 0;
  for (const Disk& d : scene.bodies) sum -= d.mass * scene.gravity[1];
  return sum;
}

Scene<2> fig11_scene(const Variant& v) {
  Scene<2> scene = read_scene(find_scene("compaction"));
  const double density = scene.bodies[0].mass / std::pow(scene.bodies[0].radius, 2);
  scene.bodies = random_filling(static_cast<int>(scene.bodies.size()),
                                {{0.65e-3, 0.25}, {0.75e-3, 0.5}, {0.9e-3, 0.25}}, 0.03, 0.05,
                                static_cast<std::uint64_t>(v.seed), Vec2::Zero());
  for (Disk& d : scene.bodies) give_mass(d, density * d.radius * d.radius);
  scene.laws[0].e_t = v.e_t;
  if (!v.rough_sides) {
    ContactLaw smooth = scene.laws[0];
    smooth.mu = 0;
    scene.materials = {"disk", "smooth"};
    scene.laws = {scene.laws[0], smooth, smooth, smooth};
    for (Wall<2>& w : scene.walls) {
      if (w.name != "floor") w.material = 1;
    }
  }
  scene.step = v.step;
  scene.num_steps = static_cast<int>(std::lround(v.latest / v.step));
  scene.solver.name = "apgd";
  scene.solver.tol = 1e-4;
  scene.solver.max_iterations = 1000;
  return scene;
}

/// Continues until the mean energy of the last kQuietSteps steps is below kRestEnergy of the energy
/// released by the fall. The energy is that of the displacing velocities, or the kinetic one.
void settle(Settling& s, const PaperItem::Context& context, bool by_displacement) {
  const double total = weight(s.scene);
  double released = s.initial;
  struct Row {
    double kinetic, displacement, floor, sides, limit;
  };
  std::deque<Row> last;
  const auto mean = [&last](double Row::*member) {
    double sum = 0;
    for (const Row& row : last) sum += row.*member;
    return sum / static_cast<double>(last.size());
  };
  const double mu = s.scene.laws[0].mu;
  s.run = run_packing(
      s.scene, s.state, context.interrupted,
      [&](const State<2>& before, const State<2>& after, const StepReport<2>& r) {
        released = s.initial - r.energy.potential;
        if (r.step % 10 == 0) {
          s.history.push_back({r.time, r.energy.kinetic / released, false, "", false});
        }
        const std::vector<Vec2> walls = wall_reactions(after, s.scene.step);
        const double pressed = std::abs(walls[1][0]) + std::abs(walls[2][0]);
        last.push_back({r.energy.kinetic, displacement_energy(before, after), -walls[0][1] / total,
                        -(walls[1][1] + walls[2][1]) / total, mu * pressed / total});
        if (last.size() > kQuietSteps) last.pop_front();
        // The start is quiet too: nothing has fallen yet.
        if (last.size() < kQuietSteps || r.contacts < static_cast<int>(after.bodies.size())) {
          return true;
        }
        s.at_rest =
            mean(by_displacement ? &Row::displacement : &Row::kinetic) < kRestEnergy * released;
        return !s.at_rest;
      });
  s.final = s.initial - released;
  s.kinetic = mean(&Row::kinetic);
  s.displacement = mean(&Row::displacement);
  s.floor = mean(&Row::floor);
  s.sides = mean(&Row::sides);
  s.side_limit = mean(&Row::limit);
}

Settling settled(const Variant& v, const PaperItem::Context& context) {
  Settling s;
  s.scene = fig11_scene(v);
  s.state = initial_state(s.scene);
  for (const Disk& d : s.scene.bodies) s.initial -= d.mass * s.scene.gravity.dot(d.x);
  settle(s, context, v.e_t == 1);
  return s;
}

/// Bound of a period-two motion at rest: with stuck contacts (u_n = 0) and tangential velocities
/// that e_t = 1 reverses at every step, the alternating velocity w has w·A w = ½ Σ s_t u_t(w),
/// |s_t| <= mu s_n. By Cauchy and Schwarz ½ w·A w is at most ⅛ z·W z for tangential impulses z <=
/// mu s_n, and that at most 3/8 Σ_i (mu Σ_c s_n)² / m_i.
double alternating_bound(const Settling& s) {
  std::vector<double> normal(s.state.bodies.size(), 0.0);
  for (const ContactOutcome<2>& o : s.state.contacts) {
    for (const int body : {o.contact.i, o.contact.j}) {
      if (body < static_cast<int>(normal.size())) normal[static_cast<std::size_t>(body)] += o.s_n;
    }
  }
  double sum = 0;
  for (std::size_t k = 0; k < normal.size(); ++k) {
    sum += std::pow(s.scene.laws[0].mu * normal[k], 2) / s.state.bodies[k].mass;
  }
  return 0.375 * sum;
}

/// The fitted tail of a histogram of x.
Chart::Series tail_line(const std::string& name, int style, const std::vector<double>& x) {
  const ExponentialTail tail = fit_exponential_tail(x, kForceTail);
  Chart::Series series{name, style, {}, Chart::Series::Kind::kLine};
  const double share = tail.points / static_cast<double>(x.size());
  const double last = *std::ranges::max_element(x);
  for (const double at : {kForceTail, last}) {
    series.points.push_back({at, share * tail.rate * std::exp(-tail.rate * (at - kForceTail))});
  }
  return series;
}

double degrees(double radians) { return radians * 180 / std::numbers::pi; }

/// Measurements over several packings, one entry for each, and all their forces.
struct Samples {
  std::vector<double> roughness;           ///< rms deviation of the surface over kDiameter
  std::vector<double> slopes, heaps;       ///< of the surface, degrees
  std::vector<double> sides;               ///< upward friction of the side walls over the weight
  std::vector<double> rates, layer_rates;  ///< of the tails of the forces
  std::vector<double> forces, layered;     ///< over the mean of the packing, of the layer

  void add(const Settling& s) {
    const Surface surface = measure_surface(s.state, 0, 0.03, 20);
    roughness.push_back(surface.roughness / kDiameter);
    slopes.push_back(degrees(std::atan(surface.slope)));
    heaps.push_back(degrees(std::atan(surface.heap)));
    const std::vector<Vec2> walls = wall_reactions(s.state, s.scene.step);
    sides.push_back(-(walls[1][1] + walls[2][1]) / weight(s.scene));
    const std::vector<double> f = relative_forces(s.state, 1), g = relative_forces(s.state, 8);
    rates.push_back(fit_exponential_tail(f, kForceTail).rate);
    layer_rates.push_back(fit_exponential_tail(g, kForceTail).rate);
    forces.insert(forces.end(), f.begin(), f.end());
    layered.insert(layered.end(), g.begin(), g.end());
  }
};

double time_step(const PaperItem::Context& context) { return context.quick ? 2e-4 : 1e-4; }

/// A packing at rest with e_t = 1, continued with smaller and smaller steps.
struct GoingOn {
  /// Kinetic energy, and the bound by friction, over the energy released, against the step.
  Chart::Series levels{"kinetic energy at rest", 0, {}}, bounds{"bound", 1, {}};
  bool below = true;         ///< each level its bound
  double last = 0;           ///< kinetic energy with the smallest step                    [J]
  double smallest_step = 0;  // [s]

  void add(const Settling& s, double kinetic, double released) {
    last = kinetic;
    smallest_step = s.scene.step;
    below = below && kinetic <= alternating_bound(s);
    levels.points.push_back({s.scene.step, kinetic / released});
    bounds.points.push_back({s.scene.step, alternating_bound(s) / released});
  }
};

void picture(const PaperItem::Context& context, const Settling& main, Findings& result) {
  draw_force_picture(context.out / "fig11_forces.svg", main.scene, main.state,
                     fmt::format("342 disks at rest, t = {:.3f} s", main.state.time),
                     {.width = 600, .take_off = false});  // about as large as on the page
  result.show("fig11_forces",
              "Force chains at rest: segments between centres as wide as the normal force.", 0);
}

void load(const Settling& main, const Settling& smooth, Findings& result) {
  const double both = main.floor + main.sides;
  result.check("vertical_load", both, "",
               "floor and side walls together over the weight, mean of the last 100 steps",
               "1 within 1 % (momentum)", main.at_rest && std::abs(both - 1) <= 0.01, 6);
  result.state("floor_load", main.floor, "",
               "floor alone over the weight, side walls with μ = 0.1");
  result.state("side_load", main.sides, "",
               "upward friction of both side walls over the weight (negative: downward)");
  result.check(
      "side_limit", main.side_limit, "",
      "most that the side walls' friction could carry, μ times their normal force over the "
      "weight",
      "at least the side walls' share", std::abs(main.sides) <= main.side_limit);
  result.check("floor_load_smooth", smooth.floor, "",
               "floor over the weight, frictionless side walls", "1 within 1 %",
               smooth.at_rest && std::abs(smooth.floor - 1) <= 0.01, 6);
  result.ours.emplace_back(
      "Base load. Floor and side walls carry {vertical_load} of the weight together. Friction "
      "on the side walls takes {side_load} of it, the floor {floor_load}. In Janssen's theory "
      "the walls take load off the floor once the grains slide down along them; here they could "
      "take at most {side_limit}, and what they do take depends on how the packing came to rest "
      "({side_least} to {side_most} in {packings} packings; negative: they press it down). With "
      "frictionless side walls the floor carries {floor_load_smooth}.");
}

/// The packing of the figure and others from different random starts.
Samples sample(const PaperItem::Context& context, const Settling& main) {
  Samples samples;
  samples.add(main);
  const int seeds = context.quick ? 2 : 5;
  for (int seed = 2; seed <= seeds; ++seed) {
    context.report(fmt::format("packing {} of {}", seed, seeds));
    samples.add(settled({.seed = seed, .step = time_step(context), .latest = kSample}, context));
  }
  return samples;
}

/// `steepest`: slope that friction can hold, degrees.
void surface(const Samples& samples, double steepest, Findings& result) {
  const MeanValue rough = mean_value(samples.roughness), slope = mean_value(samples.slopes),
                  heap = mean_value(samples.heaps);
  result.state("packings", samples.roughness.size(), "", "packings, from different random starts");
  result.state(
      "side_least", *std::ranges::min_element(samples.sides), "",
      "least share of the side walls' upward friction in the weight, last step of the packings", 2);
  result.state("side_most", *std::ranges::max_element(samples.sides), "", "largest", 2);
  const char* packings = "95 % over packings (seeds)";
  result.test("roughness", rough.mean, "diameters",
              "rms deviation of the surface from its mean height", "flat: below one diameter",
              Expectation::at_most(1), rough.confidence, packings, 2);
  const Expectation flat = Expectation::between(-steepest, steepest, steepest);
  result.test("slope", slope.mean, "°", "slope of the surface, mean of the packings",
              fmt::format("below {:.1f}° = arctan μ; heaps are steeper", steepest), flat,
              slope.confidence, packings, 2);
  result.state("slope_confidence", slope.confidence, "°",
               "half width of its 95 % confidence interval", 2);
  result.test("heap", heap.mean, "°", "fall of the surface from the middle to the sides",
              fmt::format("no heap (the paper): below {:.1f}° = arctan μ", steepest), flat,
              heap.confidence, packings, 2);
  result.state("heap_confidence", heap.confidence, "°",
               "half width of its 95 % confidence interval", 2);
  result.ours.emplace_back(
      "Flat top. Over {packings} packings the surface deviates by {roughness} (rms) from its "
      "mean height; its slope is {slope} ± {slope_confidence}, its fall from the middle to the "
      "sides {heap} ± {heap_confidence}. The start may leave a slope to the right, where its "
      "last row has three free places.");
}

void forces(const Samples& samples, Findings& result) {
  const MeanValue rate = mean_value(samples.rates), layer_rate = mean_value(samples.layer_rates);
  const ExponentialTail pooled = fit_exponential_tail(samples.forces, kForceTail);
  // Lilliefors' test of an exponential with a fitted mean: 1 % points at 1.308 / sqrt(n).
  const double critical = 1.308 / std::sqrt(static_cast<double>(pooled.points));
  result.state("tail_rate", rate.mean, "",
               "β of P(f/⟨f⟩) ~ exp(−β f/⟨f⟩) for f ≥ 1.5 ⟨f⟩, mean of the packings", 2);
  result.state("tail_confidence", rate.confidence, "",
               "half width of its 95 % confidence interval, from the packings", 1);
  result.state("tail_forces", pooled.points, "", "forces in these tails");
  result.test("tail_distance", pooled.distance, "",
              "largest distance between the distributions of the tail and of the fit",
              fmt::format("at most {:.3f} (Lilliefors' test, 1 %)", critical),
              Expectation::at_most(critical),
              1.96 * 0.26 / std::sqrt(static_cast<double>(pooled.points)),
              "95 % of Kolmogorov's distribution", 2);
  result.state("tail_rate_layers", layer_rate.mean, "", "β with ⟨f⟩ of each of eight layers", 2);
  result.state("tail_layers_confidence", layer_rate.confidence, "",
               "half width of its 95 % confidence interval", 1);
  result.ours.emplace_back(
      "Forces. The normal forces above 1.5 times their mean fall off exponentially, β = "
      "{tail_rate} ± {tail_confidence}. Part of that spread is depth: relative to the mean of "
      "their layer, β is {tail_rate_layers} ± {tail_layers_confidence}, and weak forces are "
      "about equally frequent down to zero.");
}

void distribution_chart(const Samples& samples, Findings& result) {
  Chart chart{.title = "Distribution of the normal forces",
              .x = {"f/⟨f⟩", Chart::Axis::Kind::kLinear, 0.0, {}},
              .y = {"P(f/⟨f⟩)", Chart::Axis::Kind::kLog, {}, {}}};
  const auto add = [&chart](const char* name, int style, const std::vector<double>& x) {
    const double rate = fit_exponential_tail(x, kForceTail).rate;
    chart.series.push_back(force_histogram(name, style, x, 0.25));
    chart.series.back().kind = Chart::Series::Kind::kPoints;
    chart.series.push_back(tail_line(fmt::format("exp(−{:.2f} f/⟨f⟩)", rate), style + 1, x));
  };
  add("mean of the packing", 0, samples.forces);
  add("mean of the layer", 2, samples.layered);
  result.draw(
      "fig11_distribution",
      fmt::format(
          "Normal forces of {} packings, relative to their mean, and exponentials fitted from "
          "1.5 on.",
          samples.roughness.size()),
      chart, 2);
}

void energy_numbers(const Settling& main, const Settling& inelastic, Findings& result) {
  const double released = main.released();
  result.state("step", main.scene.step, "s", "time step h");
  result.state("kinetic", main.kinetic / released, "",
               "kinetic energy at rest over the energy that the fall released, e_t = 1", 2);
  result.check("moving", main.displacement / released, "",
               "the same of the velocities that displace the disks, e_t = 1", "below 1e-9",
               main.at_rest, 2);
  result.check("kinetic_inelastic", inelastic.kinetic / inelastic.released(), "",
               "kinetic energy over the energy released, mean of the last 100 steps, e_t = 0",
               "below 1e-9", inelastic.at_rest, 2);
}

GoingOn go_on(const PaperItem::Context& context, Settling& main) {
  GoingOn going_on;
  going_on.bounds.kind = Chart::Series::Kind::kLine;
  const double released = main.released();
  going_on.add(main, main.kinetic, released);
  const int rounds = context.quick ? 2 : 4;
  for (int k = 0; k < rounds; ++k) {
    main.scene.step /= 4;
    main.scene.num_steps = 120;
    context.report(fmt::format("at rest with h = {:.1e} s", main.scene.step));
    double kinetic = 0;
    int done = 0;
    run_packing(main.scene, main.state, context.interrupted,
                [&](const State<2>&, const State<2>&, const StepReport<2>& r) {
                  if (++done > main.scene.num_steps / 2) {
                    kinetic = std::max(kinetic, r.energy.kinetic);
                  }
                  return true;
                });
    going_on.add(main, kinetic, released);
  }
  return going_on;
}

void level_numbers(const PaperItem::Context& context, const GoingOn& going_on, double released,
                   Findings& result) {
  result.check("bound", going_on.bounds.points[0].y, "",
               "what friction can hold: 3/8 (μ h)² Σ (Σ f_n)²/m over the energy released",
               "above the kinetic energy at rest, for each step", going_on.below, 2);
  result.state("smallest_step", going_on.smallest_step, "s", "smallest step at rest", 2);
  Claim smallest{
      .name = "kinetic_smallest",
      .measured = going_on.last / released,
      .quantity = "kinetic energy at rest over the energy released, e_t = 1, smallest step",
      .digits = 2};
  if (!context.quick) {
    smallest.expected = "below 1e-9";
    smallest.holds = going_on.last < kRestEnergy * released;
  }
  result.claims.push_back(smallest);
}

void solve_numbers(const Settling& main, const Settling& inelastic, Findings& result) {
  double overlap = 0;
  for (const ContactOutcome<2>& o : main.state.contacts)
    overlap = std::max(overlap, -o.contact.gap);
  result.state(
      "overlap", overlap / 0.65e-3, "",
      "largest overlap at rest over the smallest radius (one step of the fall, never pushed "
      "back)",
      2);
  result.state("met", static_cast<double>(main.run.converged) / main.run.steps, "",
               "share of the steps that met the tolerance 1e-4 within 1000 iterations, e_t = 1", 2);
  result.state("error", main.run.mean_error, "", "ε of the steps, geometric mean, e_t = 1", 2);
  result.state("met_inelastic", static_cast<double>(inelastic.run.converged) / inelastic.run.steps,
               "", "share of the steps that met it, e_t = 0", 2);
}

void decay_chart(const std::vector<Chart::Point>& elastic,
                 const std::vector<Chart::Point>& inelastic, Findings& result) {
  Chart decay{.title = "Kinetic energy against time",
              .x = {"time (s)", Chart::Axis::Kind::kLinear, 0.0, {}},
              .y = {"kinetic energy / energy released", Chart::Axis::Kind::kLog, 1e-12, 1.0}};
  decay.series = {{"e_t = 1", 0, elastic}, {"e_t = 0", 1, inelastic}};
  for (Chart::Series& series : decay.series) series.kind = Chart::Series::Kind::kLine;
  decay.y_lines = {{kRestEnergy, "1e-9"}};
  result.draw("fig11_rest", "Kinetic energy over the energy that the fall has released so far.",
              decay, 3);
}

void level_chart(const GoingOn& going_on, Findings& result) {
  const Chart level{.title = "Kinetic energy at rest against time step, e_t = 1",
                    .x = {"time step h (s)", Chart::Axis::Kind::kLog},
                    .y = {"kinetic energy / energy released", Chart::Axis::Kind::kLog},
                    .series = {going_on.levels, going_on.bounds},
                    .y_lines = {{kRestEnergy, "1e-9"}}};
  result.draw(
      "fig11_level",
      "The packing with e_t = 1, at rest, taken further with smaller and smaller steps; bound: "
      "3/8 (μ h)² Σ (Σ f_n)²/m.",
      level, 3);
}

/// How the packing comes to rest; continues `main` with smaller steps.
void rest(const PaperItem::Context& context, Settling main, const Settling& inelastic,
          Findings& result) {
  energy_numbers(main, inelastic, result);
  const double released = main.released();
  const GoingOn going_on = go_on(context, main);
  level_numbers(context, going_on, released, result);
  solve_numbers(main, inelastic, result);
  result.ours.emplace_back(
      "Rest. With e_t = 0 the kinetic energy falls: the mean of the last 100 steps, with the "
      "end of its decay, is {kinetic_inelastic} of what the fall released. With e_t = 1 it stays "
      "at {kinetic}: e_t = 1 turns the tangential velocity of "
      "every sticking contact round at each step, which loses no energy, and friction can do so "
      "as long as the impulse is inside the cone. Only sliding dissipates, so what remains is "
      "bounded by μ h times the forces, {bound} here, in proportion to h². The disks do not "
      "move by it: the mean of the velocities before and after a step, which displaces them, "
      "has {moving}. Going on with smaller steps lowers the level, to {kinetic_smallest} for h "
      "= {smallest_step}.");
  result.ours.emplace_back(
      "Cost. Steps at rest with e_t = 1 are hard to solve: {met} of all steps met 1e-4 within "
      "1000 iterations of `apgd` (with e_t = 0: {met_inelastic}); the others were taken with "
      "what was reached, ε = {error} in the mean. Balance of momentum holds in any case. The "
      "largest overlap, {overlap} of the smallest radius, is the way of a falling disk during "
      "half a step of {step}.");
  decay_chart(main.history, inelastic.history, result);
  level_chart(going_on, result);
}

}  // namespace

Findings run_fig11(const PaperItem::Context& context) {
  Findings result;
  result.paper =
      "342 disks (25 % of radius 0.65 mm, 50 % of 0.75 mm, 25 % of 0.9 mm; μ = 0.1 everywhere, "
      "e_n = 0.1, e_t = 1) fall into a box. Force chains with large fluctuations from contact "
      "to contact; the top is flat, no conical heap.";
  context.report("e_t = 1 until at rest");
  Settling main = settled({.step = time_step(context)}, context);
  context.report("e_t = 0 until at rest");
  const Settling inelastic = settled({.e_t = 0, .step = time_step(context)}, context);
  context.report("smooth side walls");
  const Settling smooth = settled({.rough_sides = false, .step = time_step(context)}, context);
  picture(context, main, result);
  load(main, smooth, result);
  const Samples samples = sample(context, main);
  surface(samples, degrees(std::atan(main.scene.laws[0].mu)), result);
  forces(samples, result);
  distribution_chart(samples, result);
  rest(context, std::move(main), inelastic, result);
  return result;
}

}  // namespace bipot
