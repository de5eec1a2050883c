// Another project's program: reads a scene, takes 50 of its steps and prints how they ended.
#include <cstdio>

#include "core/scene_files/scene_file.h"
#include "solvers/simulation/scene_run.h"

int main(int, char** arguments) {
  const bipot::Scene<2> scene = bipot::read_scene(arguments[1]);
  bipot::State<2> state = bipot::initial_state(scene);
  const bipot::SceneRun<2> run = bipot::run_scene(scene, state, {.steps = 50});
  std::printf("%s: t = %g s, %d of %d steps, %d converged, %s\n", scene.title.c_str(), state.time,
              run.totals.steps, run.planned, run.totals.converged,
              run.failure ? run.failure->what() : "all taken");
  return run.totals.converged == 50 ? 0 : 1;
}
