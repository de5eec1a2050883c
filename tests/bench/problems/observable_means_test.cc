#include "core/observables/observables.h"
#include "core/run_files/observable_output.h"
#include "core/run_files/run_reader.h"
#include "core/scene/scene_family.h"
#include "solvers/simulation/run_folder.h"
#include "tests/support/scene_text.h"
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
  ObservableChoice<2> choice{.every = 3};
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
void run_in_parts(const Scene<D>& scene, const fs::path& folder, const std::vector<int>& stops) {
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

/// A run in parts writes what it writes as a whole, into these subfolders.
template <int D>
void expect_same_means(const Scene<D>& scene, const TemporaryFolder& folder,
                       const std::vector<int>& stops) {
  run_in_parts(scene, folder / "whole", {stops.back()});
  run_in_parts(scene, folder / "parts", stops);
  for (const char* file : kFiles) {
    const std::string whole = file_text(folder / "whole" / file);
    EXPECT_EQ(whole, file_text(folder / "parts" / file)) << file;
    EXPECT_GT(std::count(whole.begin(), whole.end(), '\n'), 1) << file;
  }
}

// Stops before the window of the means (at 40), in it on a step that is measured (75), in it on one
// that is not (100): the means, and every row that they are made of, are the same to the last
// digit.
TEST(ObservableMeans, AreTheSameWhetherARunWasRestartedOrNot) {
  const TemporaryFolder folder;
  const Scene<2> scene = measured_scene();
  expect_same_means(scene, folder, {40, 75, 100, 120});
}

TEST(ObservableMeans, InSpaceAreTheSameWhetherARunWasRestartedOrNot) {
  const TemporaryFolder folder;
  auto scene = scene_of<3>(R"(
contact = {mu = 0.4}
cell = {width = 0.5}
spheres = [{arrangement = "random", count = 30, radii = [0.05, 0.07], width = 0.5, depth = 0.4, density = 1000}]
walls = [{point = [0, 0, 0], normal = [0, 0, 1]}, {point = [0, 0, 0], normal = [0, 1, 0]},
  {point = [0, 0.4, 0], normal = [0, -1, 0]}]
time = {step = 2e-3, steps = 60}
solver = {tol = 1e-4}
output = {every = 25, picture = false}
[observables]
every = 3
starts = 0.06
window = [0.1, 0, 0, 0.45, 0.3, 0.5]
profile = "z"
profile_range = [0, 0.6]
profile_bins = 5
force_bins = 6
faces = [{name = "level", point = [0, 0, 0.3], normal = [0, 0, -1]},
  {name = "hole", point = [0.25, 0.2, 0.3], normal = [0.1, 0.2, -1], radius = 0.1}]
)");
  expect_same_means(scene, folder, {20, 39, 50, 60});
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
