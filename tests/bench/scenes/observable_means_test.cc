#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "bench/scenes/run_folder.h"
#include "core/files/observable_output.h"
#include "core/files/run_reader.h"
#include "core/observables/observables.h"
#include "core/scene/scene_family.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

/// 16 disks that fall into a box; measured every third step from step 15 on, in a window.
Scene measured_scene() {
  Scene scene = make_family_scene("random", 4);
  scene.num_steps = 120;
  scene.solver.name = "apgd";
  scene.solver.tol = 1e-6;
  scene.output.every = 25;
  scene.output.picture = false;
  ObservableChoice choice;
  choice.every = 3;
  choice.starts = 0.6;  // the middle of the run
  choice.window = {Vec2(0.2, 0), Vec2(4, 2.5)};
  choice.profile = ProfileChoice{.axis = 1, .bins = 4, .low = 0, .high = 4};
  choice.lines = {{"middle", Vec2(4, 1), Vec2(0, 1)}};
  choice.force_bins = 5;
  scene.observables = choice;
  return scene;
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  EXPECT_TRUE(in.good()) << path;
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// The run in one folder, stopped after each of `stops` steps and continued from its files.
void run_in_parts(const Scene& scene, const std::filesystem::path& folder,
                  const std::vector<int>& stops) {
  RunFolderOptions options;
  options.folder = folder;
  int done = 0;
  for (const int stop : stops) {
    State state = done == 0 ? initial_state(scene) : read_state(folder);
    ASSERT_EQ(state.step, done);
    options.resume = done > 0;
    run_scene_into(scene, state, {.steps = stop - done}, options);
    done = stop;
  }
}

constexpr const char* kFiles[] = {"observables.csv",  "observables_mean.csv", "profile.csv",
                                  "profile_mean.csv", "forces.csv",           "forces_mean.csv"};

// Stops before the window of the means (at 40), in it on a step that is measured (75), in it on one that is not (100):
// the means, and every row that they are made of, are the same to the last digit.
TEST(ObservableMeans, AreTheSameWhetherARunWasRestartedOrNot) {
  const TemporaryFolder folder;
  const Scene scene = measured_scene();
  run_in_parts(scene, folder.path() / "whole", {120});
  run_in_parts(scene, folder.path() / "parts", {40, 75, 100, 120});
  for (const char* file : kFiles) {
    const std::string whole = text_of(folder.path() / "whole" / file);
    EXPECT_EQ(whole, text_of(folder.path() / "parts" / file)) << file;
    EXPECT_GT(std::count(whole.begin(), whole.end(), '\n'), 1) << file;
  }
}

// A run that was stopped short and goes on has means of its own meanwhile: those of what it has measured.
TEST(ObservableMeans, AreThoseOfTheWindowAlone) {
  const TemporaryFolder folder;
  Scene scene = measured_scene();
  double sum = 0, all = 0;
  int measured = 0, total = 0;
  RunFolderOptions options;
  options.folder = folder.path() / "run";
  State state = initial_state(scene);
  SceneRunOptions run;
  run.on_step = [&](const SceneStep& step) {
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
  run_scene_into(scene, state, run, options);
  ASSERT_GT(measured, 10);
  const std::string means = text_of(options.folder / "observables_mean.csv");
  const std::size_t at = means.find("coordination_without_rattlers");
  ASSERT_NE(at, std::string::npos) << means;
  const double written = std::stod(means.substr(means.find(',', at) + 1));
  EXPECT_NEAR(written, sum / measured, 1e-9) << means;
  // The fall before the window would have changed it.
  EXPECT_GT(std::abs(written - all / total), 0.03);
}

}  // namespace
}  // namespace bipot
