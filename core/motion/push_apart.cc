#include "core/motion/push_apart.h"

#include <algorithm>

#include "core/motion/projection.h"
#include "core/scene/start_check.h"

namespace bipot {
namespace {

constexpr int kMostRounds = 200;

/// The deepest overlap of two bodies or of a body and a wall; 0: none.                     [m]
template <int D>
double deepest(const Scene<D>& scene, int threads) {
  double depth = 0;
  for (const StartOverlap<D>& overlap : start_overlaps(scene, threads)) {
    if (to_size(overlap.contact.j) >= scene.bodies.size() + scene.walls.size()) continue;
    depth = std::max(depth, -overlap.contact.gap);
  }
  return depth;
}

}  // namespace

template <int D>
PushApart push_apart(Scene<D>& scene, const StepSolver& solver, int threads) {
  PushApart done;
  const std::vector<Body<D>> before = scene.bodies;
  double largest = 0;
  for (const Body<D>& body : before) largest = std::max(largest, body.radius);
  State<D> state = initial_state(scene);
  for (Body<D>& body : state.bodies) body.v.setZero();
  Scene<D> still = scene;
  for (auto* walls : {&state.walls, &still.walls}) {
    for (Wall<D>& wall : *walls) {  // bodies give way, driven walls do not
      wall.v.setZero();
      if (wall.motion == Wall<D>::Motion::kDriven) wall.motion = Wall<D>::Motion::kFixed;
    }
  }
  still.contact_distance = 0;
  for (; done.rounds < kMostRounds; ++done.rounds) {
    const double depth = deepest(scene, threads);
    if (depth == 0) break;
    const Projection round =
        project_overlaps(still, solver, threads, state, std::min(depth, largest));
    if (!round.solved) {
      done.message = round.message;
      break;
    }
    for (std::size_t i = 0; i < before.size(); ++i) scene.bodies[i].x = state.bodies[i].x;
  }
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double way = (scene.bodies[i].x - before[i].x).norm();
    done.way = std::max(done.way, way);
    done.radii = std::max(done.radii, way / before[i].radius);
  }
  return done;
}

template PushApart push_apart(Scene<2>&, const StepSolver&, int);
template PushApart push_apart(Scene<3>&, const StepSolver&, int);

}  // namespace bipot
