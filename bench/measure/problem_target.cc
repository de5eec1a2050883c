#include "bench/measure/problem_target.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <variant>

#include "bench/measure/moving_problems.h"
#include "bench/problems/scene_catalogue.h"
#include "bench/problems/settled_pile.h"
#include "bench/problems/sphere_problems.h"
#include "bench/report/labels.h"
#include "core/base/interrupt.h"
#include "core/base/nearest_name.h"
#include "core/base/number_text.h"
#include "core/motion/time_stepping.h"
#include "core/problem_files/problem_file.h"
#include "core/scene/scene_family.h"
#include "core/scene/scene_parts.h"
#include "core/scene_files/scene_file.h"
#include "solvers/registry.h"
#include "solvers/simulation/scene_run.h"
#include "solvers/simulation/scene_start.h"
#include "solvers/simulation/step_solver.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

// Series, so that growth with size shows. They are regular packings, tilted for uneven loads; one
// of uneven masses; packings that friction alone holds; piles at rest. Further, piles that begin to
// flow because gravity turned, one hit by a fast disk, and steps of runs in which everything moves.
// Then the shipped problems, and those of the folder BIPOT_PROBLEMS.
constexpr const char* kBenchmark =
    "square:10:tilt=10 square:18:tilt=10 square:32:tilt=10 square:56:tilt=10 square:100:tilt=10 "
    "triangular:10:tilt=10 triangular:18:tilt=10 triangular:32:tilt=10 triangular:56:tilt=10 "
    "triangular:100:tilt=10 triangular:20:ratio=1e4 pyramid:10 pyramid:20 pyramid:30 "
    "pile:18:mu=0.1 pile:18:mu=0.5 pile:18 pile:32 pile:56 pile:100 pile:18:tilt=25 "
    "pile:32:tilt=25 pile:56:tilt=25 pile:100:tilt=25 impact:32 pour:18 pour:32 collapse:32 "
    "tilt:32:angle=30 strike:32 pour3d:8 pipe:8 shear3d:8";
constexpr const char* kQuickBenchmark =
    "square:10:tilt=10 square:18:tilt=10 square:32:tilt=10 triangular:10:tilt=10 "
    "triangular:18:tilt=10 triangular:32:tilt=10 triangular:20:ratio=1e4 pyramid:5 pyramid:10 "
    "pile:18 pile:18:tilt=25 impact:18 pour:18 tilt:18:angle=30";
constexpr const char* kSharedProblems = "BIPOT_PROBLEMS";

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  for (char c : text) {
    if (c == separator) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

double parse_number(const std::string& target, const std::string& text) {
  const auto value = whole_number<double>(text);
  if (!value || !std::isfinite(*value)) {
    throw std::invalid_argument(fmt::format("target {}: '{}' is not a number", target, text));
  }
  return *value;
}

/// NaN (not known) for a scene without bodies.
template <int D>
double smallest_radius_of(const Scene<D>& scene) {
  return scene.bodies.empty() ? kNaN : smallest_radius(scene);
}

/// Settling takes longer than most solves: each pile settles once.
class Piles {
 public:
  const SettledPile& get(const SettledPile::Options& options) {
    const std::tuple key{options.count, options.mu, options.seed};
    if (!piles_.contains(key)) piles_[key] = settle_pile(options);
    return piles_[key];
  }

 private:
  std::map<std::tuple<int, double, std::uint64_t>, SettledPile> piles_;
};

struct Family {
  std::string name;
  int side = 0;
  FamilyOptions options;
};

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

bool is_moving(const Family& family) { return contains(moving_families(), family.name); }

bool is_of_spheres(const Family& family) { return contains(sphere_family_names(), family.name); }

bool is_pile(const Family& family) { return family.name == "pile" || family.name == "impact"; }

/// Names of the options that a family takes.
std::vector<std::string> options_of(const Family& family) {
  if (is_of_spheres(family)) return {"mu", "tilt"};
  if (is_pile(family)) return {"mu", "tilt", "seed"};
  if (family.name == "tilt") return {"mu", "angle", "tilt", "e", "seed"};  // tilt: the same angle
  if (is_moving(family)) return {"mu", "tilt", "e", "seed"};
  return {"mu", "tilt", "ratio", "e", "seed"};
}

Family parse_family(const std::string& target) {
  const std::vector<std::string> parts = split(target, ':');
  Family family{.name = parts[0]};
  const double side = parse_number(target, parts[1]);
  if (side < 1 || side > 2000 || side != std::floor(side)) {
    throw std::invalid_argument(
        fmt::format("target {}: side = {}, expected an integer in [1, 2000]", target, parts[1]));
  }
  family.side = static_cast<int>(side);
  const std::vector<std::string> known = options_of(family);
  std::set<std::string> given;
  for (std::size_t i = 2; i < parts.size(); ++i) {
    const std::size_t equals = parts[i].find('=');
    const std::string key = parts[i].substr(0, equals);
    const double value = parse_number(
        target, equals == std::string::npos ? std::string() : parts[i].substr(equals + 1));
    FamilyOptions& o = family.options;
    if (!contains(known, key)) {
      throw std::invalid_argument(fmt::format("target {}: {} takes {}, not '{}'", target,
                                              family.name, fmt::join(known, ", "), key));
    }
    if (!given.insert(key == "angle" ? "tilt" : key).second) {
      throw std::invalid_argument(fmt::format("target {}: {} is given twice", target, key));
    }
    if (key == "mu" && value >= 0) {
      o.mu = value;
    } else if ((key == "tilt" || key == "angle") && std::abs(value) <= 180) {
      o.tilt_degrees = value;
    } else if (key == "ratio" && value >= 1) {
      o.mass_ratio = value;
    } else if (key == "seed" && value >= 0 && value < 1e15 && value == std::floor(value)) {
      o.seed = static_cast<std::uint64_t>(value);
    } else if (key == "e" && value >= 0 && value <= 1) {
      o.e_n = o.e_t = value;
    } else {
      throw std::invalid_argument(fmt::format(
          "target {}: '{}'; expected mu >= 0, an angle in [-180, 180] degrees, ratio >= 1, e in "
          "[0, 1], or seed, an integer of at least 0",
          target, parts[i]));
    }
  }
  if (is_moving(family) && bodies_in(family.name, family.side) > 1e6) {
    throw std::invalid_argument(fmt::format("target {}: more than a million bodies", target));
  }
  if (is_of_spheres(family) && family.side > 50) {
    throw std::invalid_argument(
        fmt::format("target {}: a lattice of spheres has a side of at most 50", target));
  }
  return family;
}

/// A disk like the others that hits the middle of a settled pile at 20 m/s, in the middle of the
/// coming step. Positions and velocities of the state; the scene has the disk.
void throw_disk(Scene<2>& scene, State<2>& state) {
  constexpr double kSpeed = 20;
  Disk disk = state.bodies.front();
  disk.radius = 0.5;
  give_mass(disk, 1);
  disk.v = Vec2(0, -kSpeed);
  disk.angle = disk.spin = 0;
  double left = kInfinity, right = -left;
  for (const Disk& d : state.bodies) {
    left = std::min(left, d.x.x());
    right = std::max(right, d.x.x());
  }
  disk.x.x() = 0.5 * (left + right);
  double height = 0;
  for (const Disk& d : state.bodies) {
    const double reach = disk.radius + d.radius, aside = d.x.x() - disk.x.x();
    if (std::abs(aside) < reach) {
      height = std::max(height, d.x.y() + std::sqrt(reach * reach - aside * aside));
    }
  }
  disk.x.y() = height + 0.5 * scene.step * kSpeed;
  state.bodies.push_back(disk);
  scene.bodies.push_back(disk);
}

TestProblem make_family_problem(const Family& family, Piles& piles,
                                const std::function<bool()>& cancelled) {
  const FamilyOptions& o = family.options;
  TestProblem made;
  if (is_of_spheres(family)) {
    made.origin =
        fmt::format("family {}, {} spheres, first step, mu = {:g}, tilt {:g} degrees", family.name,
                    spheres_in(family.name, family.side), o.mu, o.tilt_degrees);
    made.problem = sphere_family(family.name, family.side, o.mu, o.tilt_degrees);
    made.step = 0.01;  // sphere_problems.h
    made.bodies = to_size(std::lround(spheres_in(family.name, family.side)));
    made.smallest_radius = 0.5;
    return made;
  }
  Scene<2> scene;
  State<2> state;
  if (is_pile(family)) {
    const SettledPile& pile = piles.get(
        {.count = family.side * family.side, .mu = o.mu, .seed = o.seed, .cancelled = cancelled});
    scene = pile.scene;
    state = pile.state;
    made.origin = fmt::format("{} disks {} after {} steps", scene.bodies.size(),
                              pile.at_rest ? "at rest" : "still moving", pile.steps);
    // A tilted pile settles without tilt; then gravity turns and the pile starts to flow.
    const double angle = o.tilt_degrees * std::acos(-1.0) / 180;
    if (angle != 0) {
      scene.gravity = Eigen::Rotation2Dd(angle) * scene.gravity;
      made.origin += ", beginning to flow as gravity turns";
    }
    if (family.name == "impact") {
      throw_disk(scene, state);
      made.origin += ", hit by one more at 20 m/s";
    }
  } else {
    scene = make_family_scene(family.name, family.side, o);
    state = initial_state(scene);
    made.origin = fmt::format("family {}, {} disks, first step", family.name, scene.bodies.size());
  }
  made.origin += fmt::format(", mu = {:g}, tilt {:g} degrees, mass ratio {:g}, e = {:g}, seed {}",
                             o.mu, o.tilt_degrees, o.mass_ratio, o.e_n, o.seed);
  made.problem = step_problem(scene, state);
  made.step = scene.step;
  made.bodies = scene.bodies.size();
  made.smallest_radius = smallest_radius_of(scene);
  return made;
}

/// Contact problems along one run, which is made when the first of them is requested.
template <int D>
class ProblemRun {
 public:
  ProblemRun(Scene<D> scene, std::vector<int> steps, std::function<bool()> cancelled)
      : scene_(std::move(scene)), steps_(std::move(steps)), cancelled_(std::move(cancelled)) {}

  TestProblem at(int step) {
    if (problems_.empty() && !failure_) run();
    if (const auto made = problems_.find(step); made != problems_.end()) return made->second;
    if (failure_) throw *failure_;
    return problems_.at(step);
  }

 private:
  void run() {
    SolverOptions options{.tol = scene_.solver.tol, .cancelled = cancelled_};
    State<D> state = initial_state(scene_);
    SceneRunOptions<D> to_last{.steps = steps_.back(),
                               .solver = make_step_solver(require_solver("auto"), options),
                               .cancelled = options.cancelled};
    to_last.on_step = [this](const SceneStep<D>& step) {
      const int k = step.report.step;
      if (!std::binary_search(steps_.begin(), steps_.end(), k)) return true;
      TestProblem& made = problems_[k];
      made.origin = fmt::format("scene {}, step {} at t = {:g} s of a run with auto to {}",
                                fs::path(scene_.source).filename().string(), k, step.report.time,
                                tolerance_label(scene_.solver.tol));
      made.problem = step.problem;
      made.start = step.start;
      made.step = scene_.step;
      made.smallest_radius = smallest_radius_of(scene_);
      return true;
    };
    const SceneRun<D> run = run_scene(scene_, state, to_last);
    if (cancelled_()) throw Interrupted();
    failure_ = run.failure;  // of steps after those that it made
  }

  Scene<D> scene_;
  std::vector<int> steps_;
  std::function<bool()> cancelled_;
  std::map<int, TestProblem> problems_;
  std::optional<StepFailure> failure_;
};

/// The target without its size.
std::string series_of(const std::string& target) {
  const std::size_t begin = target.find(':'), end = target.find(':', begin + 1);
  return target.substr(0, begin) + (end == std::string::npos ? "" : target.substr(end));
}

/// Steps of one run of a moving family, which is made when the first of them is requested.
void add_moving(const std::string& target, const Family& family, const TargetOptions& options,
                std::vector<ProblemSource>& sources) {
  const auto request = std::make_shared<const MovingRunRequest>(MovingRunRequest{
      family.name, family.side, family.options,
      options.step ? std::vector{*options.step}
                   : moving_steps(family.name, family.side, options.scene_problems),
      options.cancelled});
  const auto made = std::make_shared<std::vector<TestProblem>>();
  for (std::size_t k = 0; k < request->steps.size(); ++k) {
    const auto load = [request, made, k] {
      if (made->empty()) *made = moving_problems(*request);
      made->at(k).bodies = to_size(std::lround(bodies_in(request->family, request->side)));
      return made->at(k);
    };
    sources.push_back({fmt::format("{}@{}", target, request->steps[k]), target, load,
                       fmt::format("{}@{}/{}", series_of(target), k + 1, request->steps.size()),
                       static_cast<double>(family.side)});
  }
}

ProblemSource file_source(const fs::path& path) {
  return {path.stem().string(), path.string(), [path] {
            TestProblem made;
            ProblemFile file = read_problem(path);
            made.problem = std::move(file.problem);
            if (!file.guesses.empty()) made.start = std::move(file.guesses.front());
            made.origin = fmt::format("file {}", path.filename().string());
            return made;
          }};
}

/// By its name; without an ending by its content: problems are HDF5 or begin with a number.
bool is_scene_file(const fs::path& path) {
  if (path.has_extension()) return path.extension() == ".toml";
  char first = 0;
  std::ifstream(path) >> first;
  return (first >= 'a' && first <= 'z') || first == '#' || first == '[';
}

void add_folder(const std::string& target, std::vector<ProblemSource>& sources) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(target)) {
    const fs::path extension = entry.path().extension();
    if (extension == ".hdf5" || extension == ".h5" || extension == ".dat") {
      files.push_back(entry.path());
    }
  }
  if (files.empty()) {
    throw std::invalid_argument(target + ": the folder has no .hdf5, .h5 or .dat file");
  }
  std::ranges::sort(files);
  for (const fs::path& file : files) sources.push_back(file_source(file));
}

template <int D>
void add_steps(const std::string& target, const SceneOfLength& file, Scene<D>&& scene,
               const TargetOptions& options, std::vector<ProblemSource>& sources) {
  check_start(scene, options.warn);
  const int cut = options.step ? scene.num_steps : std::min(scene.num_steps, options.scene_steps);
  const int last = file.steps.value_or(cut);
  std::set<int> steps;
  if (options.step) steps = {*options.step};
  if (options.step > last) {
    throw std::invalid_argument(
        fmt::format("target {}@{}: the run has {} steps", target, *options.step, last));
  }
  for (int i = 1; i <= options.scene_problems && !options.step; ++i) {
    steps.insert(std::max(
        1, static_cast<int>(std::lround(static_cast<double>(last) * i / options.scene_problems))));
  }
  const auto run = std::make_shared<ProblemRun<D>>(
      std::move(scene), std::vector<int>(steps.begin(), steps.end()), options.cancelled);
  for (int step : steps) {
    sources.push_back({fmt::format("{}@{}", file.path.stem().string(), step), target,
                       [run, step] { return run->at(step); }});
  }
}

void add_scene(const std::string& target, const TargetOptions& options,
               std::vector<ProblemSource>& sources) {
  const SceneOfLength file = find_scene_of_length(target);
  std::visit([&](auto&& scene) { add_steps(target, file, std::move(scene), options, sources); },
             read_any_scene(file.path));
}

void add_benchmark(const TargetOptions& options, const std::shared_ptr<Piles>& piles,
                   std::vector<ProblemSource>& sources);

void add_target(const std::string& target, const TargetOptions& options,
                const std::shared_ptr<Piles>& piles, std::vector<ProblemSource>& sources);

/// The step behind '@'.
void add_step(const std::string& target, std::size_t at, TargetOptions options,
              const std::shared_ptr<Piles>& piles, std::vector<ProblemSource>& sources) {
  options.step = whole_number<int>(target.substr(at + 1));
  if (!options.step || *options.step < 1) {
    throw std::invalid_argument(target + ": no such file, and no step, from 1 on, behind '@'");
  }
  const std::size_t before = sources.size();
  add_target(target.substr(0, at), options, piles, sources);
  const std::string step = fmt::format("@{}", *options.step);
  if (sources.size() != before + 1 || !sources.back().name.ends_with(step)) {
    throw std::invalid_argument(target + ": only the run of a scene or a moving family has steps");
  }
  sources.back().target = target;
  sources.back().series.clear();
}

void add_target(const std::string& target, const TargetOptions& options,
                const std::shared_ptr<Piles>& piles, std::vector<ProblemSource>& sources) {
  if (const std::size_t at = target.rfind('@'); at != std::string::npos && !fs::exists(target)) {
    return add_step(target, at, options, piles, sources);
  }
  if (fs::is_directory(target)) return add_folder(target, sources);
  if (fs::is_regular_file(target)) {
    if (is_scene_file(target)) return add_scene(target, options, sources);
    sources.push_back(file_source(target));
    return;
  }
  const std::vector<std::string> names = target_families();
  if (const std::size_t colon = target.find(':'); colon != std::string::npos) {
    if (target.substr(colon).starts_with(":steps=") ||
        fs::is_regular_file(target.substr(0, target.rfind(':')))) {
      return add_scene(target, options, sources);
    }
    const std::string family = target.substr(0, colon);
    if (!contains(names, family)) {
      throw std::invalid_argument(target + ": no such file; " +
                                  unknown_name_message("family", family, names));
    }
    const Family f = parse_family(target);
    if (is_moving(f)) return add_moving(target, f, options, sources);
    sources.push_back({target, target,
                       [f, piles, cancelled = options.cancelled] {
                         return make_family_problem(f, *piles, cancelled);
                       },
                       series_of(target), static_cast<double>(f.side)});
    return;
  }
  if (target == "benchmark") return add_benchmark(options, piles, sources);
  if (contains(names, target)) {
    for (const fs::path& scene : shipped_scenes()) {
      if (scene.stem() == target) return add_scene(target, options, sources);
    }
    throw std::invalid_argument(
        fmt::format("target {}: a family needs a size, as in {}:20", target, target));
  }
  const fs::path shipped = find_problem(target);
  if (fs::exists(shipped)) return sources.push_back(file_source(shipped));
  add_scene(target, options, sources);
}

void add_benchmark(const TargetOptions& options, const std::shared_ptr<Piles>& piles,
                   std::vector<ProblemSource>& sources) {
  for (const std::string& target : split(options.quick ? kQuickBenchmark : kBenchmark, ' ')) {
    add_target(target, options, piles, sources);
  }
  if (options.quick) return;
  add_folder((data_folder() / "problems").string(), sources);
  if (const char* shared = std::getenv(kSharedProblems); shared != nullptr && *shared != 0) {
    add_folder(shared, sources);
  }
}

}  // namespace

std::vector<std::string> target_families() {
  std::vector<std::string> names = family_names();
  names.insert(names.end(), {"pile", "impact"});
  for (const std::string& name : moving_families()) names.push_back(name);
  for (const std::string& name : sphere_family_names()) names.push_back(name);
  return names;
}

std::vector<ProblemSource> expand_targets(const std::vector<std::string>& targets,
                                          const TargetOptions& options) {
  std::vector<ProblemSource> sources;
  const auto piles = std::make_shared<Piles>();
  for (const std::string& target : targets) add_target(target, options, piles, sources);
  std::set<std::string> names;
  for (const ProblemSource& source : sources) {
    if (!names.insert(source.name).second) {
      throw std::invalid_argument(
          fmt::format("two problems are called {}; rename one or compare them apart", source.name));
    }
  }
  return sources;
}

}  // namespace bipot
