#include <gtest/gtest.h>

#include <cmath>

#include "core/observables/observables.h"
#include "core/run_files/observable_output.h"
#include "core/run_files/run_reader.h"
#include "core/scene/scene_family.h"
#include "core/scene_files/scene_file.h"
#include "solvers/simulation/run_folder.h"
#include "tests/support/source_folder.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

/// 16 disks that fall into a box; measured every third step from step 15 on, in a window.
Scene<2> measured_scene() {
  Scene<2> scene = make_family_scene("random", 4);
  scene.num_steps = 120;
  scene.solver.name = "apgd";
  scene.solver.tol = 1e-6;
  scene.output.every = 25;
  scene.output.picture = false;
  ObservableChoice<2> choice;
  choice.every = 3;
  choice.starts = 0.6;  // the middle of the run
  choice.window = {Vec2(0.2, 0), Vec2(4, 2.5)};
  choice.profile = ProfileChoice{.axis = 1, .bins = 4, .low = 0, .high = 4};
  choice.crossings = {{"middle", Vec2(4, 1), Vec2(0, 1)}};
  choice.force_bins = 5;
  scene.observables = choice;
  return scene;
}

/// The run in one folder, stopped after each of `stops` steps and continued from its files.
template <int D>
void run_in_parts(const Scene<D>& scene, const std::filesystem::path& folder,
                  const std::vector<int>& stops) {
  RunFolderOptions options{.folder = folder};
  int done = 0;
  for (const int stop : stops) {
    State<D> state = done == 0 ? initial_state(scene) : read_state<D>(folder);
    ASSERT_EQ(state.step, done);
    options.resume = done > 0;
    run_scene(scene, state, {.steps = stop - done, .folder = options});
    done = stop;
  }
}

constexpr const char* kFiles[] = {"observables.csv",  "observables_mean.csv", "profile.csv",
                                  "profile_mean.csv", "forces.csv",           "forces_mean.csv"};

// Stops before the window of the means (at 40), in it on a step that is measured (75), in it on one
// that is not (100): the means, and every row that they are made of, are the same to the last
// digit.
TEST(ObservableMeans, AreTheSameWhetherARunWasRestartedOrNot) {
  const TemporaryFolder folder;
  const Scene<2> scene = measured_scene();
  run_in_parts(scene, folder.path() / "whole", {120});
  run_in_parts(scene, folder.path() / "parts", {40, 75, 100, 120});
  for (const char* file : kFiles) {
    const std::string whole = file_text(folder.path() / "whole" / file);
    EXPECT_EQ(whole, file_text(folder.path() / "parts" / file)) << file;
    EXPECT_GT(std::count(whole.begin(), whole.end(), '\n'), 1) << file;
  }
}

TEST(ObservableMeans, InSpaceAreTheSameWhetherARunWasRestartedOrNot) {
  const TemporaryFolder folder;
  auto scene = std::get<Scene<3>>(parse_any_scene(R"(
[contact]
mu = 0.4
[cell]
width = 0.5
[[spheres]]
arrangement = "random"
count = 30
radii = [0.05, 0.07]
width = 0.5
depth = 0.4
density = 1000
[[walls]]
point = [0, 0, 0]
normal = [0, 0, 1]
[[walls]]
point = [0, 0, 0]
normal = [0, 1, 0]
[[walls]]
point = [0, 0.4, 0]
normal = [0, -1, 0]
[time]
step = 2e-3
steps = 60
[solver]
tol = 1e-4
[output]
every = 25
picture = false
[observables]
every = 3
starts = 0.06
window = [0.1, 0, 0, 0.45, 0.3, 0.5]
profile = "z"
profile_range = [0, 0.6]
profile_bins = 5
force_bins = 6
[[observables.faces]]
name = "level"
point = [0, 0, 0.3]
normal = [0, 0, -1]
[[observables.faces]]
name = "hole"
point = [0.25, 0.2, 0.3]
normal = [0.1, 0.2, -1]
radius = 0.1
)",
                                                  "test.toml"));
  run_in_parts(scene, folder.path() / "whole", {60});
  run_in_parts(scene, folder.path() / "parts", {20, 39, 50, 60});
  for (const char* file : kFiles) {
    const std::string whole = file_text(folder.path() / "whole" / file);
    EXPECT_EQ(whole, file_text(folder.path() / "parts" / file)) << file;
    EXPECT_GT(std::count(whole.begin(), whole.end(), '\n'), 1) << file;
  }
  const NumberTable rows = read_number_table(folder / "whole/observables.csv");
  // They fall through the level, and some of them through the hole.
  double level = 0, hole = 0;
  for (const auto& row : rows.rows) {
    level += row[rows.column("flux_level")];
    hole += row[rows.column("flux_hole")];
  }
  EXPECT_GT(hole, 0);
  EXPECT_GT(level, hole);
}

// A run that was stopped short and goes on has means of its own meanwhile: those of what it has
// measured.
TEST(ObservableMeans, AreThoseOfTheWindowAlone) {
  const TemporaryFolder folder;
  Scene<2> scene = measured_scene();
  double sum = 0, all = 0;
  int measured = 0, total = 0;
  RunFolderOptions options{.folder = folder.path() / "run"};
  State<2> state = initial_state(scene);
  SceneRunOptions<2> run;
  run.on_step = [&](const SceneStep<2>& step) {
    if (step.state.step % 3 != 0) return true;
    const double coordination = observe(scene, step.state, *scene.observables).coordination_without;
    if (std::isfinite(coordination)) {
      all += coordination;
      ++total;
      if (step.state.time >= 0.6 - 1e-9) {
        sum += coordination;
        ++measured;
      }
    }
    return true;
  };
  run.folder = options;
  run_scene(scene, state, run);
  ASSERT_GT(measured, 10);
  const std::string means = file_text(options.folder / "observables_mean.csv");
  const std::size_t at = means.find("coordination_without_rattlers");
  ASSERT_NE(at, std::string::npos) << means;
  const double written = std::stod(means.substr(means.find(',', at) + 1));
  EXPECT_NEAR(written, sum / measured, 1e-8) << means;  // nine digits
  // The fall before the window would have changed it.
  EXPECT_GT(std::abs(written - all / total), 0.03);
}

}  // namespace
}  // namespace bipot
