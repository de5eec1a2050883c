// Does the number of sweeps saturate with the depth of a column?

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "bench/experiments/experiment_scene.h"
#include "bench/report/labels.h"
#include "bench/study/study.h"
#include "core/motion/force_balance.h"
#include "core/scene/generators.h"
#include "solvers/simulation/step_solver.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

const std::string kDepth = "depth", kDepthMethod = "pgs", kSinkMethod = "pgs_warm", kFast = "apgd";
constexpr double kDrawnTol = 1e-2;
constexpr double kGrainMu = 0.5;
constexpr int kMostSweeps = 400000, kMostIterations = 40000;  // of pgs, of apgd
constexpr int kMostWarmSweeps = 20000;

/// A column of grains at rest between two walls.
struct Column {
  std::vector<Disk> disks;
  double width = 0;
  double contact_distance = 1e-6;
};

Scene<2> grains_and_walls(double wall_mu) {
  Scene<2> scene;
  scene.materials = {"grain", "wall"};
  scene.laws = {{.mu = kGrainMu}, {.mu = wall_mu}, {.mu = wall_mu}, {.mu = wall_mu}};
  return scene;
}

Column crystalline_column(int width, double height) {
  const int rows = 1 + static_cast<int>(height * width / (0.5 * std::numbers::sqrt3));
  Column column{triangular_lattice(width, rows, 0.5, Vec2::Zero()), static_cast<double>(width),
                1e-4};
  for (Disk& d : column.disks) give_mass(d, d.radius * d.radius);
  std::erase_if(column.disks, [&](const Disk& d) { return d.x[1] > height * width; });
  return column;
}

/// Poured between walls of that friction, and taken when it is at rest.
Column random_column(int width, double height, double wall_mu, int seed,
                     const Study::Stopped& stopped) {
  // The disks fill some 0.8 of the area; 0.26 is their mean area over π.
  const int count = static_cast<int>(0.82 * height * width * width / (0.257 * std::numbers::pi));
  Scene<2> scene = grains_and_walls(wall_mu);
  const double top = fill_box(scene, count, width, 0, to_size(seed));
  for (std::size_t k = 1; k < 3; ++k) scene.walls[k].material = 1;
  scene.step = 5e-3;
  scene.contact_distance = 1e-6;
  scene.num_steps = static_cast<int>((3 + std::sqrt(2 * top / kGravity)) / scene.step);
  scene.solver = {.name = "auto", .tol = 1e-2};
  State<2> state = initial_state(scene);
  const SceneRun<2> run = run_scene<2>(scene, state, {.cancelled = stopped});
  if (run.end == SceneRun<2>::End::kFailed) throw *run.failure;
  return {state.bodies, static_cast<double>(width)};
}

/// The step of a column from rest, with this friction of the walls.
Scene<2> column_scene(const Column& column, double wall_mu) {
  Scene<2> scene = grains_and_walls(wall_mu);
  scene.gravity = Vec2(0, -kGravity);
  scene.step = 5e-3;
  scene.contact_distance = column.contact_distance;
  scene.walls = {flat_floor<2>(), half_space<2>(Vec2(0, 0), Vec2(1, 0), "left"),
                 half_space<2>(Vec2(column.width, 0), Vec2(-1, 0), "right")};
  for (int k = 1; k < 3; ++k) scene.walls[to_size(k)].material = 1;
  for (Disk d : column.disks) {
    d.v.setZero();
    d.spin = 0;
    scene.bodies.push_back(d);
  }
  return scene;
}

/// The first step of a scene, solved from zero.
Study::Values solve_column(const Scene<2>& scene, const std::string& method, double tol,
                           const Study::Stopped& stopped) {
  SolveResult result;
  State<2> state = initial_state(scene);
  const SceneRun<2> run = run_scene<2>(
      scene, state,
      {.steps = 1, .solver = [&](const ContactProblem& problem, const Vector&) {
         result = solve(method, problem,
                        {.tol = tol,
                         .max_iterations = method == kDepthMethod ? kMostSweeps : kMostIterations,
                         .cancelled = stopped});
         return to_step_solution(result);
       }});
  if (run.end == SceneRun<2>::End::kFailed) throw *run.failure;
  double weight = 0;
  for (const Disk& d : scene.bodies) weight += kGravity * d.mass;
  Study::Values values{{"disks", static_cast<double>(scene.bodies.size())},
                       {"contacts", run.totals.contacts},
                       {"floor_share", -wall_reactions(state, scene.step)[0][1] / weight}};
  values["iterations"] = result.iterations;
  values["unsolved"] = is_success(result.status) ? 0 : 1;
  return values;
}

/// Mean sweeps of a step, each from the impulses of the step before, while the floor sinks slowly.
Study::Values sink_column(Scene<2> scene, double tol, const Study::Stopped& stopped) {
  constexpr int kSteps = 80, kFirst = 20;  // counted from the first on
  move_at(scene.walls[0], Vec2(0, -0.1));
  scene.contact_distance = 1e-6;
  scene.solver = {.name = kDepthMethod, .tol = tol, .max_iterations = kMostWarmSweeps};
  State<2> state = initial_state(scene);
  double sweeps = 0, missed = 0, carried = 0, weight = 0;
  for (const Disk& d : scene.bodies) weight += kGravity * d.mass;
  const SceneRun<2> run = run_scene<2>(
      scene, state,
      {.steps = kSteps, .cancelled = stopped, .on_step = [&](const SceneStep<2>& step) {
         if (step.state.step <= kFirst) return true;
         sweeps += step.report.iterations;
         missed += step.report.converged ? 0 : 1;
         carried -= wall_reactions(step.state, scene.step)[0][1] / weight;
         return true;
       }});
  if (run.end == SceneRun<2>::End::kFailed) throw *run.failure;
  constexpr double kCounted = kSteps - kFirst;
  return {{"disks", static_cast<double>(scene.bodies.size())},
          {"iterations", sweeps / kCounted},
          {"unsolved", missed / kCounted},
          {"floor_share", carried / kCounted}};
}

/// A crystal is seed 0. Each random column is poured for its own height: the part that is left of a
/// taller one is not at rest, and its sweeps tell of the way to a new rest.
std::vector<Study::Job> depth_jobs(bool quick) {
  const int width = quick ? 4 : 6;
  using Solves = std::vector<std::pair<std::string, std::vector<double>>>;
  std::vector<Study::Job> jobs;
  for (int seed = 0; seed <= (quick ? 2 : 20); ++seed) {
    const bool crystal = seed == 0;
    const std::vector<double> heights = quick     ? std::vector<double>{1, 2, 4}
                                        : crystal ? std::vector<double>{1, 2, 3, 5, 7, 10, 14, 20}
                                                  : std::vector<double>{1, 2, 5, 10, 20};
    const Solves solves =
        crystal
            ? Solves{{kDepthMethod, {1e-2, 1e-4, 1e-6}}, {kFast, {1e-2, 1e-4}}}
            : Solves{{kDepthMethod, {1e-1, 1e-2, 1e-4}}, {kFast, {1e-2}}, {kSinkMethod, {1e-1}}};
    for (const double mu : {0.0, 0.1, 0.3, 0.5}) {
      for (const double height : heights) {
        const auto column = std::make_shared<Column>();
        for (const auto& [method, tols] : solves) {
          for (const double tol : tols) {
            const std::string scene =
                fmt::format("{}:mu_wall={}", crystal ? "crystalline" : "poured", mu);
            jobs.push_back({{kDepth, scene, width, seed, method, tol, height},
                            [=, method = method](const Study::Stopped& stopped) {
                              if (column->disks.empty()) {
                                *column = crystal ? crystalline_column(width, height)
                                                  : random_column(width, height, mu, seed, stopped);
                              }
                              const Scene<2> at_rest = column_scene(*column, mu);
                              return method == kSinkMethod
                                         ? sink_column(at_rest, tol, stopped)
                                         : solve_column(at_rest, method, tol, stopped);
                            }});
          }
        }
      }
    }
  }
  return jobs;
}

/// λ/H of Janssen's law from the floor's share of the weight, λ/H (1 - exp(-H/λ)): bisection.
double janssen_length(double share) {
  double low = 1e-3, high = 1e3;
  for (int k = 0; k < 60; ++k) {
    const double middle = std::sqrt(low * high);
    (middle * (1 - std::exp(-1 / middle)) < share ? low : high) = middle;
  }
  return low;
}

Document depth_report(const Study::Measured& measured) {
  Document part;
  Table table{.columns = {{"scene", "column"},
                          {"method", "solver"},
                          {"tol", "ε", &tolerance_label},
                          {"at_1", "h = w", &count_label},
                          {"at_5", "5 w", &count_label},
                          {"at_10", "10 w", &count_label},
                          {"at_20", "20 w", &count_label},
                          {"low_20", "from", &count_label},
                          {"high_20", "to", &count_label},
                          {"exponent", "exponent from 5 w on", &ratio_label},
                          {"exponent_bar", "±", &ratio_label},
                          {"growth", "20 w over 10 w", &ratio_label},
                          {"growth_low", "from", &ratio_label},
                          {"growth_high", "to", &ratio_label},
                          {"unsolved", "at the limit", &share_label},
                          {"floor_20", "floor's share of the weight at 20 w", &ratio_label},
                          {"screening", "screening length over w", &ratio_label},
                          {"screening_bar", "±", &ratio_label}},
              .key = "depth"};
  const auto scenes = distinct(measured, kDepth, &Study::Case::scene);
  const auto widths = distinct(measured, kDepth, &Study::Case::size);
  const auto heights = distinct(measured, kDepth, &Study::Case::x);
  const auto tols = distinct(measured, kDepth, &Study::Case::tol);
  for (const std::string& method : distinct(measured, kDepth, &Study::Case::method)) {
    for (const char* kind : {"poured", "crystalline"}) {
      for (const double tol : tols) {
        Chart chart{
            .title = fmt::format("{} to {}, {} columns", method, tolerance_label(tol), kind),
            .x = {.label = "height over width", .kind = Chart::Axis::Kind::kLog},
            .y = {.label = method == kDepthMethod  ? "sweeps"
                           : method == kSinkMethod ? "sweeps a step"
                                                   : "iterations",
                  .kind = Chart::Axis::Kind::kLog}};
        int style = 0;
        for (const std::string& scene : scenes) {
          if (!scene.starts_with(kind)) continue;
          Chart::Series line{
              fmt::format("μ of the walls {}", scene.substr(scene.find('=') + 1)), style++, {}};
          std::vector<double> x5, sweeps5;  // from 5 w on
          std::map<double, Study::Geometric> at;
          std::map<int, double> lengths;
          double unsolved = 0, solves = 0, floor = kNaN;
          for (const double x : heights) {
            const Study::Case of{kDepth, scene, widths.back(), 0, method, tol, x};
            const auto sweeps = by_seed(measured, of, "iterations");
            at[x] = geometric_mean(sweeps);
            if (at[x].seeds == 0) continue;
            line.points.push_back(
                {.x = x, .y = at[x].mean, .note = {}, .y_low = at[x].low, .y_high = at[x].high});
            for (const auto& [seed, missed] : by_seed(measured, of, "unsolved")) {
              unsolved += missed;
              ++solves;
            }
            const auto shares = by_seed(measured, of, "floor_share");
            floor = over_seeds(shares).mean;
            lengths.clear();
            for (const auto& [seed, share] : shares) lengths[seed] = janssen_length(share) * x;
            for (const auto& [seed, count] : sweeps) {
              if (x < 5) continue;
              x5.push_back(x);
              sweeps5.push_back(count);
            }
          }
          const PowerLaw law = fit_power_law(x5, sweeps5);
          const double growth = at[20].mean / at[10].mean;
          const double spread = std::exp(
              std::hypot(std::log(at[20].high / at[20].mean), std::log(at[10].high / at[10].mean)));
          if (solves == 0) continue;
          const MeanValue length = over_seeds(lengths);  // of the tallest
          table.add({scene, method, tol, at[1].mean, at[5].mean, at[10].mean, at[20].mean,
                     at[20].low, at[20].high, law.exponent, law.confidence, growth, growth / spread,
                     growth * spread, unsolved / solves, floor, length.mean, length.confidence});
          chart.series.push_back(std::move(line));
        }
        if (tol != (method != kFast && kind[0] == 'p' ? 1e-1 : kDrawnTol) ||
            (method == kSinkMethod && kind[0] == 'c')) {
          continue;
        }
        part.add(Figure{.chart = std::move(chart),
                        .file = fmt::format("depth_{}_{}.svg", method, kind),
                        .caption = fmt::format(
                            "{} to ε = {}, {} columns of {} grains across{}.", method,
                            tolerance_label(tol), kind, widths.back(),
                            method == kSinkMethod ? ", while the floor sinks" : ", from zero")});
      }
    }
  }
  part.add(std::move(table));
  return part;
}

}  // namespace

Study::Part depth_part() {
  return {kDepth, "Depth: does the number of sweeps saturate?", &depth_jobs, &depth_report};
}

}  // namespace bipot
