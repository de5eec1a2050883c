#include "bench/experiments/scene_parts.h"

namespace bipot {

template <int D>
Scene<D> empty_scene(const ContactLaw& law, double step, double tol,
                     const ValidationContext& context) {
  Scene<D> scene;
  scene.title = "validate";
  scene.source = "generated";
  scene.materials = {"default"};
  scene.laws = {law};
  scene.step = step;
  scene.contact_distance = 1e-6;
  scene.solver = context.choice(tol);
  return scene;
}

template <int D>
Body<D> round_body(const Vec<D>& x, double radius, double mass) {
  Body<D> body;
  body.x = x;
  body.radius = radius;
  body.mass = mass;
  body.inertia = (D == 2 ? 0.5 : 0.4) * mass * radius * radius;
  return body;
}

template <int D>
Wall<D> flat_floor() {
  Wall<D> floor;
  floor.name = "floor";
  return floor;
}

Wall<2> plane_wall(const std::string& name, const Vec2& point, const Vec2& normal) {
  Wall<2> wall;
  wall.name = name;
  wall.a = point;
  wall.normal = normal;
  return wall;
}

template <int D>
ScenePartRun<D> run_from(const Scene<D>& scene, State<D> start, const ValidationContext& context,
                         const std::function<bool(const SceneStep<D>&)>& on_step) {
  ScenePartRun<D> part;
  part.state = std::move(start);
  SceneRunOptions<D> options;
  options.cancelled = context.stopped;
  options.on_step = on_step;
  const SceneRun<D> run = run_scene<D>(scene, part.state, options);
  if (run.end == SceneRun<D>::End::kFailed) throw *run.failure;
  part.stopped = run.end == SceneRun<D>::End::kCancelled;
  part.steps = run.totals.steps;
  part.unsolved = run.totals.steps - run.totals.converged;
  return part;
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

template Scene<2> empty_scene<2>(const ContactLaw&, double, double, const ValidationContext&);
template Scene<3> empty_scene<3>(const ContactLaw&, double, double, const ValidationContext&);
template Body<2> round_body<2>(const Vec2&, double, double);
template Body<3> round_body<3>(const Vec3&, double, double);
template Wall<2> flat_floor<2>();
template Wall<3> flat_floor<3>();
template ScenePartRun<2> run_from(const Scene<2>&, State<2>, const ValidationContext&,
                                  const std::function<bool(const SceneStep<2>&)>&);
template ScenePartRun<3> run_from(const Scene<3>&, State<3>, const ValidationContext&,
                                  const std::function<bool(const SceneStep<3>&)>&);

}  // namespace bipot
