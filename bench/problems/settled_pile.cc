#include "bench/problems/settled_pile.h"

#include <cmath>

#include "core/scene/scene_family.h"
#include "solvers/registry.h"
#include "solvers/simulation/scene_run.h"
#include "solvers/simulation/step_solver.h"

namespace bipot {

SettledPile settle_pile(const SettledPile::Options& options) {
  SettledPile pile;
  const int side = static_cast<int>(std::ceil(std::sqrt(options.count)));
  pile.scene = make_family_scene("random", side, {.mu = options.mu, .seed = options.seed});
  pile.scene.bodies.resize(options.count);
  pile.state = initial_state(pile.scene);
  SolverOptions solver{.tol = options.tol, .max_iterations = 1000, .cancelled = options.cancelled};
  double initial = 0;
  SceneRunOptions<2> to_rest;
  to_rest.steps = 3000;
  to_rest.solver = make_step_solver(require_solver("apgd"), solver);
  to_rest.on_step = [&](const SceneStep<2>& step) {
    const EnergyLedger& energy = step.report.energy;
    if (++pile.steps == 1) initial = energy.kinetic + energy.potential;
    pile.at_rest = pile.steps > 10 && energy.kinetic < options.rest * initial;
    return !pile.at_rest;
  };
  to_rest.cancelled = options.cancelled;
  const SceneRun<2> run = run_scene(pile.scene, pile.state, to_rest);
  if (options.cancelled()) throw Interrupted();
  if (run.failure) throw *run.failure;
  pile.scene.bodies = pile.state.bodies;
  return pile;
}

}  // namespace bipot
