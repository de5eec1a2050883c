#include "bench/tradeoff/trade.h"

#include <fmt/format.h>

#include <functional>
#include <set>

#include "bench/measure/statistics.h"
#include "bench/problems/scene_catalogue.h"
#include "core/base/portable_random.h"
#include "core/motion/spring_dashpot_setup.h"
#include "core/scene/cluster_motion.h"
#include "solvers/registry.h"
#include "solvers/simulation/scene_start.h"

namespace bipot {
namespace {

constexpr double kPerturbation = 1e-3;  // of √(a r)

/// Adds small random velocities: they show whether nearby runs stay together.
template <int D>
void perturb(Scene<D>& scene, int replica) {
  if (replica == 0 || scene.bodies.empty()) return;
  double mass = 0, force = 0;
  for (const Body<D>& d : scene.bodies) mass += d.mass;
  for (const Cluster<D>& c : scene.clusters.bodies) mass += c.mass;
  for (const Wall<D>& w : scene.walls) {
    if (w.motion == Wall<D>::Motion::kDriven) force += std::abs(w.force);
  }
  const double acceleration = std::max(scene.gravity.norm(), force / mass);
  double speed = std::sqrt(acceleration * smallest_radius(scene));
  for (const Body<D>& d : scene.bodies) speed = std::max(speed, d.v.norm());
  PortableRandom random(static_cast<std::uint64_t>(replica));
  const auto push = [&](Vec<D>& v) {
    for (int axis = 0; axis < D; ++axis) v[axis] += kPerturbation * speed * random.symmetric();
  };
  for (Body<D>& d : scene.bodies) {
    if (d.cluster < 0) push(d.v);
  }
  for (Cluster<D>& c : scene.clusters.bodies) push(c.v);
  place_members(scene.clusters, scene.bodies);
}

/// Whether so many steps last as long as a whole number of steps that are `factor` times as long.
bool is_whole(int steps, double factor) {
  const double others = steps / factor;
  return others > 0.5 && std::abs(others - std::round(others)) <= std::min(1e-6 * others, 0.01);
}

/// Steps of Trade::Options::shorten.
template <int D>
int shortened(const Scene<D>& scene, const Trade::Options& options) {
  constexpr double kPart = 0.1, kLeast = 0.05, kReserve = 0.5;
  const double tol = *std::ranges::min_element(options.tols);
  double shortest = 1;
  for (const double factor : options.step_factors) shortest = std::min(shortest, factor);
  const RunLimits limits{.cpu_seconds = kPart * options.time_limit,
                         .cancelled = options.watch.interrupted};
  State<D> state = initial_state(scene);
  const RunRecord run =
      run_setting(scene, state, {.solver = options.solvers.front(), .tol = tol}, limits, {});
  const double fits = run.completed() ? scene.num_steps : kReserve * run.steps * shortest / kPart;
  int steps = std::clamp(static_cast<int>(fits),
                         std::max(1, static_cast<int>(kLeast * scene.num_steps)), scene.num_steps);
  // A factor that divides the scene's steps divides these.
  const auto fits_all = [&](int some) {
    return std::ranges::all_of(options.step_factors, [&](double factor) {
      return is_whole(some, factor) || !is_whole(scene.num_steps, factor);
    });
  };
  while (!fits_all(steps)) ++steps;
  return steps;
}

Trade::Scene load_target(const std::string& target, const Trade::Options& options) {
  Trade::Scene made{.target = target};
  const auto [path, steps] = find_scene_of_length(target);
  made.name = path.stem().string();
  made.scene = read_any_scene(path);
  std::visit(
      [&, steps = steps]<int D>(Scene<D>& scene) {
        check_start(scene, options.warn);
        if (steps) scene.num_steps = *steps;
        if ((scene.bodies.empty() && scene.inlets.empty()) || scene.num_steps == 0) {
          throw std::invalid_argument(target + ": a run needs bodies and steps");
        }
        made.whole_steps = scene.num_steps;
        if (options.shorten && !steps) scene.num_steps = shortened(scene, options);
        made.title = scene.title.empty() ? made.name : scene.title;
        bool free = scene.bodies.size() > 1 || scene.has_gates();
        free = free && !supported_by_walls(scene, 1e-3 * smallest_radius(scene));
        made.replicas = free ? std::max(1, options.replicas) : 1;
        made.quantities = OutcomeRecorder<D>(scene).quantities();
        made.step = scene.step;
        made.num_steps = scene.num_steps;
        made.bodies = static_cast<int>(scene.bodies.size());
      },
      made.scene);
  return made;
}

class Runner {
 public:
  Runner(const Trade::Options& options, Trade& trade) : options_(options), trade_(trade) {
    const std::size_t springs =
        options.stiffness.empty() ? options.overlaps.size() : options.stiffness.size();
    const std::size_t settings = options.solvers.size() * options.tols.size() +
                                 options.step_factors.size() + options.accuracies.size() + springs +
                                 (options.witness.empty() ? 0 : 1);
    total_ = static_cast<long>(settings * options.targets.size());
    options.watch.tell(0, total_, "");
  }

  bool stopped() const { return options_.watch.stopped(); }

  /// Runs all replicas of a setting. True if all were completed.
  bool run(const Trade::Scene& scene, const RunSetting& setting) {
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

  void skip(const Trade::Scene& scene, const RunSetting& setting, int replica,
            const std::string& why) {
    Trade::Row row = blank(scene, setting, replica);
    row.message = why;
    add(std::move(row));
  }
  void skip_all(const Trade::Scene& scene, const RunSetting& setting, const std::string& why) {
    for (int replica = 0; replica < scene.replicas; ++replica) skip(scene, setting, replica, why);
  }

 private:
  void add(Trade::Row row) {
    if (row.replica == 0) ++done_;
    options_.watch.tell(
        done_, total_,
        fmt::format("{}: {}, run {}", row.scene, row.setting.label(), row.replica + 1));
    trade_.rows.push_back(std::move(row));
  }

  static Trade::Row blank(const Trade::Scene& scene, const RunSetting& setting, int replica) {
    Trade::Row row;
    row.scene = scene.name;
    row.setting = setting;
    row.replica = replica;
    row.step = scene.step * setting.step_factor;
    row.steps_planned = steps_of(scene.num_steps, setting);
    row.values.assign(scene.quantities.size(), kNaN);
    return row;
  }

  Trade::Row run_one(const Trade::Scene& trade_scene, RunSetting setting, int replica) {
    Trade::Row row = blank(trade_scene, setting, replica);
    std::visit(
        [&]<int D>(Scene<D> scene) {
          perturb(scene, replica);
          // The scene's parameters belong to its own solver.
          if (setting.solver == scene.solver.name) setting.parameters = scene.solver.parameters;
          const Scene<D> as_run = with_setting(scene, setting);
          OutcomeRecorder<D> recorder(as_run);
          RunObserver<D> observer;
          observer.on_step = [&](const SceneStep<D>& step) {
            recorder.step(step.state, step.report);
            return true;
          };
          State<D> state = initial_state(scene);
          static_cast<RunRecord&>(row) = run_setting(
              scene, state, setting,
              {.cpu_seconds = options_.time_limit, .cancelled = options_.watch.interrupted},
              observer);
          if (row.steps == row.steps_planned) row.values = recorder.values();
        },
        trade_scene.scene);
    return row;
  }

  const Trade::Options& options_;
  Trade& trade_;
  long done_ = 0, total_ = 0;
};

double mean_cpu(const Trade& trade, const std::string& scene, const RunSetting& setting) {
  double sum = 0;
  int count = 0;
  for (const Trade::Row& row : trade.rows) {
    if (row.scene != scene || !(row.setting == setting) || !row.completed()) continue;
    sum += row.cpu;
    ++count;
  }
  return count > 0 ? sum / count : kInfinity;
}

/// Why a scene cannot be run with a setting; empty if it can.
std::string refusal(const Trade::Scene& scene, const RunSetting& setting) {
  return std::visit(
      [&](const auto& in) {
        if (!is_whole(in.num_steps, setting.step_factor)) {
          return fmt::format("{} steps of h are not a whole number of steps of {:g} h",
                             in.num_steps, setting.step_factor);
        }
        std::string refused = validate(with_setting(in, setting));
        return refused.empty() && setting.dem() ? no_springs(in) : refused;
      },
      scene.scene);
}

void trade_scene(const Trade::Scene& scene, const Trade::Options& options, Runner& runner,
                 Trade& trade) {
  // 1. Tolerances.
  std::vector<double> tols = options.tols;
  std::sort(tols.rbegin(), tols.rend());
  const std::vector<std::string>& solvers = options.solvers;
  std::vector<double> completed;  // by the first solver
  for (const std::string& solver : solvers) {
    bool gave_up = false;
    for (const double tol : tols) {
      if (runner.stopped()) return;
      const RunSetting setting{.solver = solver, .tol = tol};
      if (gave_up) {
        runner.skip_all(scene, setting, "a looser tolerance was not completed");
      } else if (!runner.run(scene, setting)) {
        gave_up = true;
      } else if (solver == solvers.front()) {
        completed.push_back(tol);
      }
    }
  }
  const bool known = std::ranges::find(solvers, options.witness) != solvers.end();
  if (!options.witness.empty() && !known && !completed.empty()) {
    runner.run(scene, {.solver = options.witness, .tol = completed.back()});
  }
  // 2. Time steps.
  std::vector<double> factors = options.step_factors;
  std::sort(factors.rbegin(), factors.rend());
  const double shortest = factors.empty() ? 1 : factors.back();
  double tol = completed.empty() ? kNaN : completed.front();
  for (const double t : completed) {
    const double cost = mean_cpu(trade, scene.name, {.solver = solvers.front(), .tol = t});
    if (1.5 * cost / shortest <= options.time_limit) tol = t;
  }
  std::vector<RunSetting> settings;
  for (const double factor : factors) {
    if (factor != 1) {
      settings.push_back({.solver = solvers.front(), .tol = tol, .step_factor = factor});
    }
  }
  // 3. Accuracies.
  for (const double accuracy : options.accuracies) {
    const double factor =
        std::visit([](const auto& in) { return longest_cut_step(in, in.num_steps); }, scene.scene);
    settings.push_back(
        {.solver = solvers.front(), .tol = tol, .step_factor = factor, .accuracy = accuracy});
  }
  // 4. Springs, soft to stiff.
  std::vector<RunSetting> springs;
  for (const double k : options.stiffness) {
    springs.push_back({.model = Model::kSpringDashpot, .stiffness = k});
  }
  if (springs.empty()) {
    for (const double o : options.overlaps) {
      springs.push_back({.model = Model::kSpringDashpot, .overlap = o});
    }
  }
  std::ranges::sort(springs, [](const RunSetting& a, const RunSetting& b) {
    return std::isfinite(a.stiffness) ? a.stiffness < b.stiffness : a.overlap > b.overlap;
  });
  settings.insert(settings.end(), springs.begin(), springs.end());
  bool out_of_time = false;  // with springs
  for (const RunSetting& setting : settings) {
    if (runner.stopped()) return;
    std::string why = refusal(scene, setting);
    if (why.empty() && !setting.dem() && completed.empty()) {
      why = "no tolerance was completed at the scene's step";
    }
    if (why.empty() && setting.dem() && out_of_time) why = "softer springs ran out of time";
    if (!why.empty()) {
      runner.skip_all(scene, setting, why);
      continue;
    }
    runner.run(scene, setting);
    for (const Trade::Row& row : trade.rows) {
      out_of_time |= setting.dem() && row.scene == scene.name && row.setting == setting &&
                     row.status == "time limit";
    }
  }
}

}  // namespace

Trade::Options trade_options(bool quick) {
  if (quick) {
    return {.targets = {"bouncing_ball", "sliding_cylinder", "square_lattice:steps=100",
                        "triangular_lattice:steps=100", "compaction_100"},
            .tols = {1e-1, 1e-3},
            .step_factors = {2, 1, 0.5},
            .accuracies = {0.1},
            .overlaps = {1e-2, 1e-3},
            .time_limit = 5,
            .shorten = true,
            .witness = "apgd",
            .replicas = 2};
  }
  return {.targets = {"bouncing_ball", "sliding_cylinder", "square_lattice:steps=300",
                      "triangular_lattice:steps=300", "compaction_100", "compaction"},
          .witness = "apgd"};
}

namespace {

/// The scenes, checked as the settings are.
Trade planned_trade(const Trade::Options& options) {
  require_solvers(options.solvers);
  if (!options.witness.empty()) require_solver(options.witness);
  if (options.solvers.empty() || options.tols.empty()) {
    throw std::invalid_argument("a comparison of runs needs a solver and a tolerance");
  }
  if (std::ranges::any_of(options.overlaps, [](double x) { return x >= 0.1; })) {
    throw std::invalid_argument("--overlaps: contacts that overlap by a tenth of the radius fail");
  }
  if (!std::ranges::all_of(options.accuracies, [](double x) { return x >= 1e-6 && x <= 0.3; })) {
    throw std::invalid_argument("--accuracies: of a radius, in [1e-6, 0.3]");
  }
  Trade trade{.negligible = options.negligible};
  std::set<std::string> names;
  for (const std::string& target : options.targets) {
    trade.scenes.push_back(load_target(target, options));
    if (!names.insert(trade.scenes.back().name).second) {
      throw std::invalid_argument(
          fmt::format("two scenes are called {}", trade.scenes.back().name));
    }
  }
  return trade;
}

}  // namespace

void check_trade(const Trade::Options& options) { planned_trade(options); }

Trade run_trade(const Trade::Options& given) {
  Trade::Options options = given;
  for (auto* values : {&options.tols, &options.step_factors, &options.accuracies, &options.overlaps,
                       &options.stiffness}) {
    *values = distinct_in_order(*values, std::identity());  // others would be further replicas
  }
  Trade trade = planned_trade(options);
  Runner runner(options, trade);
  for (const Trade::Scene& scene : trade.scenes) trade_scene(scene, options, runner, trade);
  trade.complete = !runner.stopped();
  return trade;
}

}  // namespace bipot
