#include "bench/validate/scene_parts.h"

namespace bipot {

template <int D>
SceneIn<D> empty_scene(const ContactLaw& law, double step, double tol,
                       const ValidationContext& context) {
  SceneIn<D> scene;
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
BodyIn<D> round_body(const VecIn<D>& x, double radius, double mass) {
  BodyIn<D> body;
  body.x = x;
  body.radius = radius;
  body.mass = mass;
  body.inertia = (D == 2 ? 0.5 : 0.4) * mass * radius * radius;
  return body;
}

template <int D>
WallIn<D> flat_floor() {
  WallIn<D> floor;
  floor.name = "floor";
  return floor;
}

Wall plane_wall(const std::string& name, const Vec2& point, const Vec2& normal) {
  Wall wall;
  wall.name = name;
  wall.a = point;
  wall.normal = normal;
  return wall;
}

template <int D>
ScenePartRun<D> run_from(const SceneIn<D>& scene, StateIn<D> start,
                         const ValidationContext& context,
                         const std::function<bool(const SceneStepIn<D>&)>& on_step) {
  ScenePartRun<D> part;
  part.state = std::move(start);
  SceneRunOptionsIn<D> options;
  options.cancelled = context.stopped;
  options.on_step = on_step;
  const SceneRunIn<D> run = run_scene<D>(scene, part.state, options);
  if (run.end == SceneRunIn<D>::End::kFailed) throw *run.failure;
  part.stopped = run.end == SceneRunIn<D>::End::kCancelled;
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

template SceneIn<2> empty_scene<2>(const ContactLaw&, double, double, const ValidationContext&);
template SceneIn<3> empty_scene<3>(const ContactLaw&, double, double, const ValidationContext&);
template BodyIn<2> round_body<2>(const Vec2&, double, double);
template BodyIn<3> round_body<3>(const Vec3&, double, double);
template WallIn<2> flat_floor<2>();
template WallIn<3> flat_floor<3>();
template ScenePartRun<2> run_from(const SceneIn<2>&, StateIn<2>, const ValidationContext&,
                                  const std::function<bool(const SceneStepIn<2>&)>&);
template ScenePartRun<3> run_from(const SceneIn<3>&, StateIn<3>, const ValidationContext&,
                                  const std::function<bool(const SceneStepIn<3>&)>&);

}  // namespace bipot
