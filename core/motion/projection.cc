#include "core/motion/projection.h"

#include <algorithm>
#include <vector>

#include "core/motion/assembly.h"
#include "core/problem/delassus.h"
#include "core/scene/contact_detection.h"

namespace bipot {
namespace {

// A pair that leaves its overlap within this number of steps is not pushed.
constexpr double kLeaving = 10;

/// The scene's materials without friction and restitution: one row for each contact, no rotations.
template <int D>
Scene<D> frictionless(const Scene<D>& scene) {
  Scene<D> flat;
  flat.materials = scene.materials;
  flat.laws.assign(scene.laws.size(), ContactLaw{});
  flat.walls = scene.walls;
  flat.step = scene.step;
  return flat;
}

template <int D>
void displace(const AssembledStep& assembled, const Vector& way, State<D>& state,
              double& wall_work) {
  for (std::size_t i = 0; i < state.bodies.size(); ++i) {
    const int k = assembled.dofs.disk[i];
    if (k >= 0) state.bodies[i].x += way.segment<D>(k);
  }
  for (std::size_t w = 0; w < state.walls.size(); ++w) {
    const int k = assembled.dofs.wall[w];
    if (k < 0) continue;
    Wall<D>& wall = state.walls[w];
    wall.a += way[k] * wall.direction;
    wall.b += way[k] * wall.direction;
    wall_work += way[k] * wall.force;
  }
}

}  // namespace

template <int D>
Projection project_overlaps(const Scene<D>& scene, const StepSolver& solver, int threads,
                            State<D>& state, double reach) {
  Projection result;
  const std::vector<Contact<D>> contacts = detect_contacts<D>(
      state.bodies, state.walls, std::max(scene.contact_distance, reach), threads);
  const bool overlap = std::any_of(contacts.begin(), contacts.end(), [&](const Contact<D>& c) {
    return c.gap < -scene.contact_distance;
  });
  if (!overlap) return result;

  const Scene<D> flat = frictionless(scene);
  const std::vector<Vec<D>> still(state.bodies.size(), Vec<D>::Zero());
  const std::vector<double> still_walls(state.walls.size(), 0.0);
  // With the state's velocities: u_before then tells which pairs move apart.
  AssembledStep assembled =
      assemble_step<D>({flat, state.bodies, state.walls, contacts, still, still_walls}, threads);
  ContactProblem& p = assembled.problem;
  p.v_free.setZero();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Eigen::Index row = static_cast<Eigen::Index>(c);
    const double gap = reach > 0 ? std::max(contacts[c].gap, -reach) : contacts[c].gap;
    const bool leaves = kLeaving * scene.step * assembled.u_before[row] > -gap;
    p.u_free[row] = leaves ? std::max(gap, 0.0) : gap;
  }
  const StepSolution solution = solver(p, Vector());
  result.iterations = solution.iterations;
  result.solved = solution.converged && solution.s.size() == p.num_rows();
  if (!result.solved) {
    result.message = "overlaps were not taken out: " + solution.message;
    return result;
  }
  displace(assembled, body_velocities(p, solution.s), state, result.wall_work);
  return result;
}

template Projection project_overlaps(const Scene<2>&, const StepSolver&, int, State<2>&, double);
template Projection project_overlaps(const Scene<3>&, const StepSolver&, int, State<3>&, double);

}  // namespace bipot
