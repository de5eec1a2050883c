#include "bench/measure/moving_problems.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>

#include "bench/problems/moving_scene.h"
#include "bench/report/build_info.h"
#include "core/base/file_error.h"
#include "core/files/atomic_file.h"
#include "core/problem_files/fclib_file.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

bool in_space(const std::string& family) {
  const std::vector<std::string> names = moving_sphere_names();
  return std::ranges::find(names, family) != names.end();
}

std::string key_of(const MovingRunRequest& request) {
  const FamilyOptions& o = request.options;
  return fmt::format("{}_{}_mu={:g}_tilt={:g}_e={:g}_seed={}", request.family, request.side, o.mu,
                     o.tilt_degrees, o.e_n, o.seed);
}

/// Description stored in the files; that of another version differs.
std::string recipe_of(const MovingRunRequest& request, int step) {
  const BuildInfo build = build_info();
  const FamilyOptions& o = request.options;
  return fmt::format(
      "family {}, side {}, mu = {:g}, tilt {:g} degrees, e = {:g}, seed {}: step {} of a run by apgd "
      "to {:g}, at most {} iterations a step; program {} {}",
      request.family, request.side, o.mu, o.tilt_degrees, o.e_n, o.seed, step, kMovingTolerance,
      kMovingIterations, build.version, build.commit);
}

fs::path path_of(const MovingRunRequest& request, int step) {
  return problem_cache_folder() / fmt::format("{}_step{}.hdf5", key_of(request), step);
}

/// Empty where the file is missing, damaged, or of another recipe.
std::optional<TestProblem> read_step(const MovingRunRequest& request, int step,
                                     const fs::path& path) {
  if (!fs::exists(path)) return std::nullopt;
  ProblemFile file;
  try {
    file = read_fclib(path);
  } catch (const FileError&) {
    return std::nullopt;  // cut off, or of another kind: made again
  }
  const std::string recipe = recipe_of(request, step);
  if (file.info.description != recipe) return std::nullopt;
  TestProblem made{.origin = recipe, .problem = std::move(file.problem)};
  if (!file.guesses.empty()) made.start = std::move(file.guesses.front());
  return made;
}

/// Keeps a step, and returns it as it is read again. (Another build may write this file meanwhile.)
std::optional<TestProblem> write_step(const MovingRunRequest& request, int step,
                                      const ContactProblem& problem, const Vector& start) {
  const fs::path path = path_of(request, step);
  std::error_code failed;
  fs::create_directories(path.parent_path(), failed);
  if (failed) throw FileError(path.parent_path(), "", failed.message());
  AtomicFile file(path);
  write_fclib(file.draft(), problem,
              {.title = fmt::format("{}, step {}", key_of(request), step),
               .description = recipe_of(request, step)},
              start.size() > 0 ? std::vector<Vector>{start} : std::vector<Vector>{});
  std::optional<TestProblem> written = read_step(request, step, file.draft());
  if (!written) throw FileError(path, "", "cannot be read again");
  file.commit();
  return written;
}

}  // namespace

fs::path problem_cache_folder() {
  const auto folder = [](const char* variable) -> fs::path {
    const char* value = std::getenv(variable);
    return value == nullptr ? fs::path() : fs::path(value);
  };
  if (const fs::path own = folder("BIPOT_CACHE"); !own.empty()) return own;
  if (const fs::path cache = folder("XDG_CACHE_HOME"); !cache.empty()) return cache / "bipot";
  if (const fs::path home = folder("HOME"); !home.empty()) return home / ".cache" / "bipot";
  const fs::path shared = fs::temp_directory_path() / fmt::format("bipot-{}", ::getuid());
  struct stat info {};
  // Another user could have put a folder there, with problems in it.
  if (::lstat(shared.c_str(), &info) == 0 &&
      (!S_ISDIR(info.st_mode) || info.st_uid != ::getuid())) {
    throw FileError(shared, "", "belongs to somebody else: set BIPOT_CACHE");
  }
  return shared;
}

std::vector<int> moving_steps(const std::string& family, int side, int count) {
  const int last = in_space(family) ? make_moving_spheres(family, side, {}).num_steps
                                    : make_moving_scene(family, side, {}).num_steps;
  std::vector<int> steps;
  for (int i = 1; i <= count; ++i) {
    const auto step = static_cast<int>(std::lround(last * (i - 0.35) / count));
    if (step >= 1 && (steps.empty() || step > steps.back())) steps.push_back(step);
  }
  return steps;
}

namespace {

template <int D>
std::vector<TestProblem> problems_of(const Scene<D>& scene, const MovingRunRequest& request) {
  // Uncommitted changes have no version of their own: files of such builds are not used.
  const bool trusted = !build_info().commit.ends_with("-dirty");
  std::map<int, std::optional<TestProblem>> problems;
  bool complete = trusted;
  for (const int step : request.steps) {
    if (complete) problems[step] = read_step(request, step, path_of(request, step));
    complete = complete && problems[step].has_value();
  }
  if (!complete) {
    problems.clear();
    run_moving_scene<D>(
        scene, request.steps,
        [&](const SceneStep<D>& step) {
          const int number = step.report.step;
          problems[number] = write_step(request, number, step.problem, step.start);
        },
        request.cancelled);
  }
  std::vector<TestProblem> made;
  for (const int step : request.steps) {
    std::optional<TestProblem> problem = std::move(problems[step]);
    if (!problem) {  // no contacts: FCLIB has no such problem
      problem.emplace();
      problem->origin = recipe_of(request, step);
      problem->problem.dim = scene.has_friction() ? D : 1;
    }
    problem->step = scene.step;
    problem->smallest_radius = smallest_radius(scene);
    made.push_back(std::move(*problem));
  }
  return made;
}

}  // namespace

std::vector<TestProblem> moving_problems(const MovingRunRequest& request) {
  const auto scene_of = [&](auto make) {
    return make(request.family, request.side, request.options);
  };
  if (in_space(request.family)) return problems_of(scene_of(&make_moving_spheres), request);
  return problems_of(scene_of(&make_moving_scene), request);
}

std::vector<std::string> moving_families() {
  std::vector<std::string> names = moving_family_names();
  for (const std::string& name : moving_sphere_names()) names.push_back(name);
  return names;
}

double bodies_in(const std::string& family, int side) {
  return std::pow(static_cast<double>(side), in_space(family) ? 3 : 2);
}

}  // namespace bipot
