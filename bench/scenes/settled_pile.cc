#include "bench/scenes/settled_pile.h"

#include <cmath>

#include "core/scene/scene_family.h"
#include "solvers/registry.h"
#include "solvers/step_solver.h"

namespace bipot {

SettledPile settle_pile(const PileOptions& options) {
  SettledPile pile;
  const int side = static_cast<int>(std::ceil(std::sqrt(options.count)));
  pile.scene = make_family_scene("random", side, {.mu = options.mu, .seed = options.seed});
  pile.scene.disks.resize(options.count);
  pile.state = initial_state(pile.scene);
  SolverOptions solver;
  solver.tol = options.tol;
  solver.max_iterations = 1000;
  TimeStepper stepper(pile.scene, make_step_solver(require_solver("apgd"), solver), false);
  double initial = 0;
  while (pile.steps < options.max_steps && !pile.at_rest) {
    const StepReport report = stepper.advance(pile.state);
    if (++pile.steps == 1) initial = report.energy.kinetic + report.energy.potential;
    pile.at_rest = pile.steps > 10 && report.energy.kinetic < options.rest * initial;
  }
  pile.scene.disks = pile.state.disks;
  return pile;
}

}  // namespace bipot
