#include "bench/experiments/experiment_scene.h"

#include "core/scene/generators.h"

namespace bipot {

template <int D>
Scene<D> experiment_scene(const ContactLaw& law, double step, const Experiment::Trial& trial) {
  Scene<D> scene = one_law<D>(law);
  scene.title = "validate";
  scene.source = "generated";
  scene.step = step;
  scene.contact_distance = 1e-6;
  scene.solver = trial.choice();
  return scene;
}

double fill_box(Scene<2>& scene, int count, double width, double spacing, std::uint64_t seed) {
  scene.gravity = Vec2(0, -kGravity);
  scene.bodies =
      random_filling(count, {{0.4, 1}, {0.5, 1}, {0.6, 1}}, width, spacing, seed, Vec2::Zero());
  double top = 0;
  for (Disk& d : scene.bodies) {
    give_mass(d, d.radius * d.radius);
    top = std::max(top, d.x[1]);
  }
  scene.walls = {flat_floor<2>(), half_space<2>(Vec2(0, 0), Vec2(1, 0), "left"),
                 half_space<2>(Vec2(width, 0), Vec2(-1, 0), "right")};
  return top;
}

template <int D>
State<D> run_from(const Scene<D>& scene, State<D> start, Experiment::Trial& trial,
                  const std::function<bool(const SceneStep<D>&)>& on_step) {
  SceneRunOptions<D> options{.cancelled = trial.context.stopped, .on_step = on_step};
  const SceneRun<D> run = run_scene<D>(scene, start, options);
  if (run.end == SceneRun<D>::End::kFailed) throw *run.failure;
  trial.go_on();
  trial.steps += run.totals.steps;
  trial.unsolved += run.totals.steps - run.totals.converged;
  return start;
}

Observation find_threshold(double low, double high, const std::function<bool(double)>& holds) {
  if (holds(low)) return {low, 0, "at the least value that was tried already"};
  if (!holds(high)) return {high, 0, "not even at the largest value that was tried"};
  const double width = 1e-4 * (high - low);
  while (high - low > width) {
    const double middle = 0.5 * (low + high);
    (holds(middle) ? high : low) = middle;
  }
  return {0.5 * (low + high)};
}

template Scene<2> experiment_scene<2>(const ContactLaw&, double, const Experiment::Trial&);
template Scene<3> experiment_scene<3>(const ContactLaw&, double, const Experiment::Trial&);
template State<2> run_from(const Scene<2>&, State<2>, Experiment::Trial&,
                           const std::function<bool(const SceneStep<2>&)>&);
template State<3> run_from(const Scene<3>&, State<3>, Experiment::Trial&,
                           const std::function<bool(const SceneStep<3>&)>&);

}  // namespace bipot
