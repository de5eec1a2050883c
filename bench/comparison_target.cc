#include "bench/comparison_target.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>

#include "bench/scene_catalogue.h"
#include "bench/settled_pile.h"
#include "core/nearest_name.h"
#include "core/problem_file.h"
#include "core/scene_family.h"
#include "core/scene_file.h"
#include "core/time_stepping.h"
#include "solvers/registry.h"
#include "solvers/step_solver.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

// Regular packings of two sizes, tilted and loaded unevenly; packings that friction alone holds;
// piles at rest of three frictions; an impact-like first step of a loose filling.
const std::vector<std::string> kBenchmark = {"square:10",
                                             "square:30",
                                             "square:100:tilt=10",
                                             "triangular:10",
                                             "triangular:30",
                                             "triangular:100:tilt=10",
                                             "triangular:20:ratio=1e4",
                                             "pyramid:10",
                                             "pyramid:20",
                                             "pyramid:30",
                                             "pile:18:mu=0.1",
                                             "pile:18:mu=0.3",
                                             "pile:18:mu=0.5",
                                             "pile:32:mu=0.3",
                                             "pile:32:mu=0.3:tilt=25"};
const std::vector<std::string> kQuickBenchmark = {
    "square:10", "triangular:10", "triangular:20:tilt=10", "pyramid:5", "pyramid:10", "pile:10"};

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
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    throw std::invalid_argument(fmt::format("target {}: '{}' is not a number", target, text));
  }
  return value;
}

double smallest_radius(const Scene& scene) {
  double radius = std::numeric_limits<double>::infinity();
  for (const Disk& disk : scene.disks) radius = std::min(radius, disk.radius);
  return std::isfinite(radius) ? radius : ComparisonProblem::kNaN;
}

struct Family {
  std::string name;
  int side = 0;
  FamilyOptions options;
};

std::vector<std::string> families() {
  std::vector<std::string> names = family_names();
  names.emplace_back("pile");
  return names;
}

Family parse_family(const std::string& target) {
  const std::vector<std::string> parts = split(target, ':');
  Family family;
  family.name = parts[0];
  const double side = parse_number(target, parts[1]);
  if (side < 1 || side > 2000 || side != std::floor(side)) {
    throw std::invalid_argument(
        fmt::format("target {}: side = {}, expected an integer in [1, 2000]", target, parts[1]));
  }
  family.side = static_cast<int>(side);
  for (std::size_t i = 2; i < parts.size(); ++i) {
    const std::size_t equals = parts[i].find('=');
    const std::string key = parts[i].substr(0, equals);
    const double value = parse_number(
        target, equals == std::string::npos ? std::string() : parts[i].substr(equals + 1));
    FamilyOptions& o = family.options;
    if (key == "mu" && value >= 0) {
      o.mu = value;
    } else if (key == "tilt" && std::abs(value) <= 180) {
      o.tilt_degrees = value;
    } else if (key == "ratio" && value >= 1) {
      o.mass_ratio = value;
    } else if (key == "seed" && value >= 0 && value < 1e15 && value == std::floor(value)) {
      o.seed = static_cast<std::uint64_t>(value);
    } else if (key == "e" && value >= 0 && value <= 1) {
      o.e_n = o.e_t = value;
    } else {
      throw std::invalid_argument(fmt::format(
          "target {}: '{}'; expected mu >= 0, tilt in degrees, ratio >= 1, seed or e in [0, 1]",
          target, parts[i]));
    }
  }
  if (family.name == "pile" && (family.options.mass_ratio != 1 || family.options.e_n != 0)) {
    throw std::invalid_argument(
        fmt::format("target {}: a settled pile takes mu, tilt and seed alone", target));
  }
  return family;
}

ComparisonProblem make_family_problem(const Family& family) {
  const FamilyOptions& o = family.options;
  ComparisonProblem made;
  Scene scene;
  State state;
  if (family.name == "pile") {
    SettledPile pile =
        settle_pile({.count = family.side * family.side, .mu = o.mu, .seed = o.seed});
    scene = std::move(pile.scene);
    state = std::move(pile.state);
    made.origin = fmt::format("{} disks {} after {} steps", scene.disks.size(),
                              pile.at_rest ? "at rest" : "still moving", pile.steps);
    // A tilted pile settles level; then gravity turns and the pile starts to flow.
    const double angle = o.tilt_degrees * std::acos(-1.0) / 180;
    if (angle != 0) scene.gravity = Eigen::Rotation2Dd(angle) * scene.gravity;
  } else {
    scene = make_family_scene(family.name, family.side, o);
    state = initial_state(scene);
    made.origin = fmt::format("family {}, {} disks, first step", family.name, scene.disks.size());
  }
  made.origin += fmt::format(", mu = {:g}, tilt {:g} degrees, mass ratio {:g}, e = {:g}, seed {}",
                             o.mu, o.tilt_degrees, o.mass_ratio, o.e_n, o.seed);
  made.problem = step_problem(scene, state, false);
  made.step = scene.step;
  made.smallest_radius = smallest_radius(scene);
  return made;
}

/// Contact problems along one run. The run is made once, when the first of them is asked for.
class SceneRun {
 public:
  SceneRun(Scene scene, std::vector<int> steps) : scene_(std::move(scene)), steps_(steps) {}

  ComparisonProblem at(int step) {
    if (problems_.empty()) run();
    return problems_.at(step);
  }

 private:
  void run() {
    SolverOptions options;
    options.tol = scene_.solver.tol;
    State state = initial_state(scene_);
    TimeStepper stepper(scene_, make_step_solver(*find_solver("auto"), options), false);
    for (int k = 1; k <= steps_.back(); ++k) {
      const StepReport report = stepper.advance(state);
      if (!std::binary_search(steps_.begin(), steps_.end(), k)) continue;
      ComparisonProblem& made = problems_[k];
      made.origin = fmt::format("scene {}, step {} at t = {:g} s of a run with auto to {:.0e}",
                                fs::path(scene_.source).filename().string(), k, report.time,
                                scene_.solver.tol);
      made.problem = stepper.problem();
      made.step = scene_.step;
      made.smallest_radius = smallest_radius(scene_);
    }
  }

  Scene scene_;
  std::vector<int> steps_;
  std::map<int, ComparisonProblem> problems_;
};

ProblemSource file_source(const fs::path& path) {
  return {path.stem().string(), path.string(), [path] {
            ComparisonProblem made;
            made.problem = read_problem(path).problem;
            made.origin = fmt::format("file {}", path.filename().string());
            return made;
          }};
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
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) sources.push_back(file_source(file));
}

void add_scene(const std::string& target, const TargetOptions& options,
               std::vector<ProblemSource>& sources) {
  const fs::path path = find_scene(target);
  Scene scene = read_scene(path);
  const int last = std::min(scene.num_steps, options.scene_steps);
  std::set<int> steps;
  for (int i = 1; i <= options.scene_problems; ++i) {
    steps.insert(std::max(
        1, static_cast<int>(std::lround(static_cast<double>(last) * i / options.scene_problems))));
  }
  const auto run =
      std::make_shared<SceneRun>(std::move(scene), std::vector<int>(steps.begin(), steps.end()));
  for (int step : steps) {
    sources.push_back({fmt::format("{}@{}", path.stem().string(), step), target,
                       [run, step] { return run->at(step); }});
  }
}

void add_target(const std::string& target, const TargetOptions& options,
                std::vector<ProblemSource>& sources) {
  if (fs::is_directory(target)) return add_folder(target, sources);
  if (fs::is_regular_file(target)) {
    if (fs::path(target).extension() == ".toml") return add_scene(target, options, sources);
    sources.push_back(file_source(target));
    return;
  }
  const std::vector<std::string> names = families();
  if (const std::size_t colon = target.find(':'); colon != std::string::npos) {
    const std::string family = target.substr(0, colon);
    if (std::find(names.begin(), names.end(), family) == names.end()) {
      throw std::invalid_argument(target + ": no such file; " +
                                  unknown_name_message("family", family, names));
    }
    sources.push_back(
        {target, target, [f = parse_family(target)] { return make_family_problem(f); }});
    return;
  }
  if (target == "benchmark" || target == "benchmark-quick") {
    for (const auto& t : target == "benchmark" ? kBenchmark : kQuickBenchmark) {
      add_target(t, options, sources);
    }
    return;
  }
  if (std::find(names.begin(), names.end(), target) != names.end()) {
    for (const fs::path& scene : shipped_scenes()) {
      if (scene.stem() == target) return add_scene(target, options, sources);
    }
    throw std::invalid_argument(
        fmt::format("target {}: a family needs a size, as in {}:20", target, target));
  }
  add_scene(target, options, sources);
}

}  // namespace

std::vector<ProblemSource> expand_targets(const std::vector<std::string>& targets,
                                          const TargetOptions& options) {
  std::vector<ProblemSource> sources;
  for (const std::string& target : targets) add_target(target, options, sources);
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
