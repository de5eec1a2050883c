#include "bench/tradeoff/trade.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>
#include <stdexcept>

#include "bench/measure/stopwatch.h"
#include "bench/problems/scene_catalogue.h"
#include "bench/report/labels.h"
#include "core/base/portable_random.h"
#include "core/base/types.h"
#include "core/motion/spring_dashpot_setup.h"
#include "core/scene/cluster_motion.h"
#include "core/scene_files/scene_file.h"
#include "solvers/registry.h"
#include "solvers/simulation/scene_run.h"
#include "solvers/simulation/scene_start.h"
#include "solvers/simulation/step_solver.h"

namespace bipot {
namespace {

constexpr double kPerturbation = 1e-3;  // of √(a r)

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

TradeScene load_target(const std::string& target, const TradeOptions& options) {
  TradeScene made;
  made.target = target;
  std::string file = target;
  std::optional<int> steps;
  const std::string option = ":steps=";
  if (const std::size_t at = target.rfind(option); at != std::string::npos) {
    file = target.substr(0, at);
    const std::string number = target.substr(at + option.size());
    int n = 0;
    const auto [end, failure] = std::from_chars(number.data(), number.data() + number.size(), n);
    if (failure != std::errc() || end != number.data() + number.size() || n < 1) {
      throw std::invalid_argument(target + ": expected a positive number of steps");
    }
    steps = n;
  }
  const std::filesystem::path path = find_scene(file);
  made.name = path.stem().string();
  made.scene = read_scene(path);
  check_start(made.scene, {}, 1);
  if (steps) made.scene.num_steps = *steps;
  if (made.scene.bodies.empty() || made.scene.num_steps == 0) {
    throw std::invalid_argument(target + ": a run needs disks and steps");
  }
  if (made.scene.has_gates()) {
    throw std::invalid_argument(
        target + ": bodies come or go by inlets and outlets; runs are compared body by body");
  }
  made.title = made.scene.title.empty() ? made.name : made.scene.title;
  const bool free = made.scene.bodies.size() > 1 &&
                    !supported_by_walls(made.scene, 1e-3 * smallest_radius(made.scene));
  made.replicas = free ? std::max(1, options.replicas) : 1;
  made.quantities = OutcomeRecorder(made.scene).quantities();
  return made;
}

/// Adds small random velocities: they show whether nearby runs stay together.
void perturb(Scene<2>& scene, int replica) {
  if (replica == 0) return;
  double mass = 0, force = 0;
  for (const Disk& d : scene.bodies) mass += d.mass;
  for (const Cluster& c : scene.clusters.bodies) mass += c.mass;
  for (const Wall<2>& w : scene.walls) {
    if (w.motion == Wall<2>::Motion::kDriven) force += std::abs(w.force);
  }
  const double acceleration = std::max(scene.gravity.norm(), force / mass);
  double speed = std::sqrt(acceleration * smallest_radius(scene));
  for (const Disk& d : scene.bodies) speed = std::max(speed, d.v.norm());
  PortableRandom random(static_cast<std::uint64_t>(replica));
  for (Disk& d : scene.bodies) {
    if (d.cluster >= 0) continue;
    const double x = random.symmetric(), y = random.symmetric();
    d.v += kPerturbation * speed * Vec2(x, y);
  }
  for (Cluster& c : scene.clusters.bodies) {
    const double x = random.symmetric(), y = random.symmetric();
    c.v += kPerturbation * speed * Vec2(x, y);
  }
  place_members(scene.clusters, scene.bodies);
}

class Runner {
 public:
  Runner(const TradeOptions& options, Trade& trade) : options_(options), trade_(trade) {}

  bool stopped() const { return options_.interrupted && options_.interrupted(); }

  /// Runs all replicas of a setting. True if all were completed.
  bool run(const TradeScene& scene, const TradeSetting& setting) {
    for (int replica = 0; replica < scene.replicas && !stopped(); ++replica) {
      add(run_one(scene, setting, replica));
      if (trade_.rows.back().completed()) continue;
      for (++replica; replica < scene.replicas; ++replica) {
        skip(scene, setting, replica, "another replica of this setting was not completed");
      }
      return false;
    }
    return !stopped();
  }

  void skip(const TradeScene& scene, const TradeSetting& setting, int replica,
            const std::string& why) {
    TradeRow row = blank(scene, setting, replica);
    row.message = why;
    add(std::move(row));
  }
  void skip_all(const TradeScene& scene, const TradeSetting& setting, const std::string& why) {
    for (int replica = 0; replica < scene.replicas; ++replica) skip(scene, setting, replica, why);
  }

 private:
  void add(TradeRow row) {
    trade_.rows.push_back(std::move(row));
    if (options_.on_row) options_.on_row(trade_.rows.back());
  }

  static TradeRow blank(const TradeScene& scene, const TradeSetting& setting, int replica) {
    TradeRow row;
    row.scene = scene.name;
    row.setting = setting;
    row.replica = replica;
    row.step = scene.scene.step * setting.step_factor;
    row.steps_planned =
        std::max(1, static_cast<int>(std::lround(scene.scene.num_steps / setting.step_factor)));
    row.values.assign(scene.quantities.size(), kNaN);
    return row;
  }

  TradeRow run_one(const TradeScene& trade_scene, const TradeSetting& setting, int replica) {
    TradeRow row = blank(trade_scene, setting, replica);
    Scene<2> scene = trade_scene.scene;
    scene.step = row.step;
    scene.num_steps = row.steps_planned;
    scene.model = setting.model;
    if (std::isfinite(setting.overlap)) scene.dem.overlap = setting.overlap;
    scene.dem.stiffness = std::isfinite(setting.stiffness) ? setting.stiffness : 0;
    perturb(scene, replica);

    // CPU time: other work on the machine must not decide which rows there are.
    const CpuStopwatch watch;
    const auto out_of_time = [&, polls = 0]() mutable {
      if (stopped()) return true;
      // On a few contacts, reading the clock costs more than an iteration.
      return ++polls % 16 == 0 && watch.seconds() > options_.time_limit;
    };
    SceneRunOptions<2> run_options;
    run_options.cancelled = out_of_time;
    if (!setting.dem()) {
      const SolverEntry& entry = require_solver(setting.solver);
      SolverOptions solver;
      solver.tol = setting.tol;
      // The scene's parameters belong to its own solver.
      if (setting.solver == scene.solver.name) solver.parameters = scene.solver.parameters;
      solver.cancelled = out_of_time;
      run_options.solver = make_step_solver(entry, solver);
      run_options.explicit_delassus = entry.needs_delassus;
    }
    OutcomeRecorder recorder(scene);
    run_options.on_step = [&](const SceneStep<2>& step) {
      recorder.step(step.state, step.report);
      const double guarded = step.report.error.guarded();
      if (std::isfinite(guarded)) row.worst_guarded = std::fmax(row.worst_guarded, guarded);
      return ++row.steps == scene.num_steps || watch.seconds() <= options_.time_limit;
    };
    State<2> state = initial_state(scene);
    SceneRun<2> run;
    try {
      run = run_scene(scene, state, run_options);
    } catch (const std::invalid_argument& e) {  // springs that the scene does not allow
      row.status = "failed";
      row.message = e.what();
      return row;
    }
    if (run.springs) row.stiffness = run.springs->stiffness;
    row.steps_converged = run.totals.converged;
    describe_end(run, row);
    row.cpu = watch.seconds();
    row.simulated = state.time;
    if (row.steps > 0) {
      row.iterations = static_cast<double>(run.totals.iterations) / row.steps;
      row.penetration = run.totals.penetration / smallest_radius(scene);
    }
    if (row.steps == scene.num_steps) row.values = recorder.values();
    return row;
  }

  /// Status and message.
  void describe_end(const SceneRun<2>& run, TradeRow& row) const {
    row.message = run.totals.message;
    if (run.end == SceneRun<2>::End::kCompleted) {
      row.status = row.steps_converged < row.steps ? "not converged" : "completed";
    } else if (run.end == SceneRun<2>::End::kFailed) {
      row.status = "failed";
      row.message = run.failure->what();
    } else if (stopped()) {
      row.status = "interrupted";
      if (run.failure) row.message = run.failure->what();
    } else {
      row.status = "time limit";
      row.message = time_limit_message();
    }
  }

  std::string time_limit_message() const {
    return fmt::format("{:g} s of CPU time were up", options_.time_limit);
  }

  const TradeOptions& options_;
  Trade& trade_;
};

double mean_cpu(const Trade& trade, const std::string& scene, const TradeSetting& setting) {
  double sum = 0;
  int count = 0;
  for (const TradeRow& row : trade.rows) {
    if (row.scene != scene || !(row.setting == setting) || !row.completed()) continue;
    sum += row.cpu;
    ++count;
  }
  return count > 0 ? sum / count : std::numeric_limits<double>::infinity();
}

void trade_scene(const TradeScene& scene, const TradeOptions& options, Runner& runner,
                 Trade& trade) {
  // 1. Tolerances.
  std::vector<double> tols = options.tols;
  std::sort(tols.rbegin(), tols.rend());
  std::vector<double> completed;  // by the first solver
  for (const std::string& solver : options.solvers) {
    bool gave_up = false;
    for (const double tol : tols) {
      if (runner.stopped()) return;
      const TradeSetting setting{.solver = solver, .tol = tol};
      if (gave_up) {
        runner.skip_all(scene, setting, "a looser tolerance was not completed");
      } else if (!runner.run(scene, setting)) {
        gave_up = true;
      } else if (solver == options.solvers.front()) {
        completed.push_back(tol);
      }
    }
  }
  const auto& solvers = options.solvers;
  const bool known = std::find(solvers.begin(), solvers.end(), options.witness) != solvers.end();
  if (!options.witness.empty() && !known && !completed.empty()) {
    runner.run(scene, {.solver = options.witness, .tol = completed.back()});
  }
  // 2. Time steps.
  std::vector<double> factors = options.step_factors;
  std::sort(factors.rbegin(), factors.rend());
  const double shortest = factors.empty() ? 1 : factors.back();
  double tol = completed.empty() ? kNaN : completed.front();
  for (const double t : completed) {
    const double cost = mean_cpu(trade, scene.name, {.solver = options.solvers.front(), .tol = t});
    if (1.5 * cost / shortest <= options.time_limit) tol = t;
  }
  for (const double factor : factors) {
    if (runner.stopped()) return;
    if (factor == 1) continue;
    const TradeSetting setting{
        .solver = options.solvers.front(), .tol = tol, .step_factor = factor};
    if (completed.empty()) {
      runner.skip_all(scene, setting, "no tolerance was completed at the scene's step");
    } else {
      runner.run(scene, setting);
    }
  }
  // 3. Springs, soft to stiff.
  std::vector<TradeSetting> springs;
  for (const double k : options.stiffness) {
    springs.push_back({.model = Model::kSpringDashpot, .stiffness = k});
  }
  if (springs.empty()) {
    for (const double o : options.overlaps) {
      springs.push_back({.model = Model::kSpringDashpot, .overlap = o});
    }
  }
  std::sort(springs.begin(), springs.end(), [](const TradeSetting& a, const TradeSetting& b) {
    return std::isfinite(a.stiffness) ? a.stiffness < b.stiffness : a.overlap > b.overlap;
  });
  bool out_of_time = false;
  for (const TradeSetting& setting : springs) {
    if (runner.stopped()) return;
    if (!scene.scene.clusters.empty()) {
      runner.skip_all(scene, setting, "springs and dashpots have no clusters");
      continue;
    }
    if (out_of_time) {
      runner.skip_all(scene, setting, "softer springs ran out of time");
      continue;
    }
    runner.run(scene, setting);
    for (const TradeRow& row : trade.rows) {
      out_of_time |=
          row.scene == scene.name && row.setting == setting && row.status == "time limit";
    }
  }
}

}  // namespace

bool TradeSetting::operator==(const TradeSetting& other) const {
  return model == other.model && solver == other.solver && same(tol, other.tol) &&
         step_factor == other.step_factor && same(overlap, other.overlap) &&
         same(stiffness, other.stiffness);
}

std::string TradeSetting::label() const {
  if (dem()) {
    return std::isfinite(stiffness) ? fmt::format("springs, k_n = {:.3g} N/m", stiffness)
                                    : fmt::format("springs, overlap {}", tolerance_label(overlap));
  }
  const std::string step = step_factor == 1  ? "h"
                           : step_factor < 1 ? fmt::format("h/{:g}", 1 / step_factor)
                                             : fmt::format("{:g} h", step_factor);
  return fmt::format("{}, tol {}, {}", solver, tolerance_label(tol), step);
}

std::vector<std::string> trade_targets(bool quick) {
  if (quick) {
    return {"bouncing_ball", "sliding_cylinder", "square_lattice:steps=100",
            "triangular_lattice:steps=100", "compaction_100"};
  }
  return {"bouncing_ball",
          "sliding_cylinder",
          "square_lattice:steps=300",
          "triangular_lattice:steps=300",
          "compaction_100",
          "compaction"};
}

Trade run_trade(const TradeOptions& options) {
  for (const std::string& solver : options.solvers) require_solver(solver);
  if (!options.witness.empty()) require_solver(options.witness);
  if (options.solvers.empty() || options.tols.empty()) {
    throw std::invalid_argument("a comparison of runs needs a solver and a tolerance");
  }
  Trade trade;
  trade.accuracy = options.accuracy;
  std::set<std::string> names;
  for (const std::string& target : options.targets) {
    trade.scenes.push_back(load_target(target, options));
    if (!names.insert(trade.scenes.back().name).second) {
      throw std::invalid_argument(
          fmt::format("two scenes are called {}", trade.scenes.back().name));
    }
  }
  Runner runner(options, trade);
  for (const TradeScene& scene : trade.scenes) trade_scene(scene, options, runner, trade);
  trade.complete = !runner.stopped();
  return trade;
}

}  // namespace bipot
