#include "core/motion/state.h"

#include <fmt/format.h>

#include "core/motion/population.h"
#include "core/scene/cluster_motion.h"
#include "core/scene/triangle_mesh.h"
#include "core/scene/wall_motion.h"

namespace bipot {
namespace {

bool same_mesh(const Wall<2>&, const Wall<2>&) { return true; }
bool same_mesh(const Wall<3>& a, const Wall<3>& b) {
  return !a.mesh || !b.mesh || a.mesh->triangles == b.mesh->triangles;
}

}  // namespace

template <int D>
State<D> initial_state(const Scene<D>& scene) {
  State<D> state;
  state.bodies = scene.bodies;
  state.walls = walls_at(scene.walls, scene.walls, 0.5 * scene.step);
  state.clusters = scene.clusters;
  state.cell = scene.cell;
  state.population = initial_population(scene);
  return state;
}

template <int D>
StateSums<D> state_sums(const State<D>& state, const std::type_identity_t<Vec<D>>& gravity,
                        bool count_walls) {
  StateSums<D> sums;
  for (const Body<D>& d : state.bodies) {
    sums.kinetic += 0.5 * d.mass * d.v.squaredNorm() + turning_energy(d);
    sums.potential -= d.mass * gravity.dot(d.x);
    sums.momentum += d.mass * d.v;
  }
  for (const Cluster<D>& c : state.clusters.bodies) {
    sums.kinetic += 0.5 * c.mass * c.v.squaredNorm() + turning_energy(c);
    sums.potential -= c.mass * gravity.dot(c.x);
    sums.momentum += c.mass * c.v;
  }
  if (!count_walls) return sums;
  for (const Wall<D>& w : state.walls) {
    sums.kinetic += wall_kinetic_energy(w);
    sums.momentum += wall_momentum(w);
  }
  if (state.cell.periodic()) sums.kinetic += cell_kinetic_energy(state.cell);
  return sums;
}

template <int D>
Spin<D> angular_momentum(const State<D>& state) {
  Spin<D> sum = no_turn<D>();
  for (const Body<D>& d : state.bodies) {
    sum += arm_times(d.x, Vec<D>(d.mass * d.v)) + d.inertia * d.spin;
  }
  for (const Cluster<D>& c : state.clusters.bodies) {
    sum += arm_times(c.x, Vec<D>(c.mass * c.v)) + own_momentum(c);
  }
  return sum;
}

template <int D>
std::string count_mismatch(const Scene<D>& scene, const State<D>& state) {
  const Population<D>& there = state.population;
  if (there.outlets.size() != scene.outlets.size() || there.inlets.size() != scene.inlets.size()) {
    return fmt::format("it has {} outlets and {} inlets, the scene has {} and {}",
                       there.outlets.size(), there.inlets.size(), scene.outlets.size(),
                       scene.inlets.size());
  }
  if ((!scene.has_gates() && state.bodies.size() != scene.bodies.size()) ||
      state.walls.size() != scene.walls.size()) {
    return fmt::format("it has {} {}s and {} walls, the scene has {} and {}", state.bodies.size(),
                       kBodyName<D>, state.walls.size(), scene.bodies.size(), scene.walls.size());
  }
  const std::size_t joined = state.clusters.bodies.size(), planned = scene.clusters.bodies.size();
  if (!scene.has_gates() && joined != planned) {
    return fmt::format("it has {} clusters, the scene has {}", joined, planned);
  }
  if (scene.has_gates() && there.numbers.size() != state.bodies.size()) {
    return fmt::format("it has numbers for {} of {} {}s", there.numbers.size(), state.bodies.size(),
                       kBodyName<D>);
  }
  const auto beyond = [](int index, std::size_t count) {
    return index >= 0 && to_size(index) >= count;
  };
  for (std::size_t k = 0; k < state.bodies.size(); ++k) {
    const Body<D>& body = state.bodies[k];
    if (body.material < 0 || beyond(body.material, scene.materials.size()) ||
        beyond(body.cluster, joined) || beyond(body.wall, scene.walls.size())) {
      return fmt::format("{} {} has material {}, cluster {} and wall {}", kBodyName<D>, k,
                         body.material, body.cluster, body.wall);
    }
  }
  return {};
}

template <int D>
std::string restart_mismatch(const Scene<D>& scene, const State<D>& state) {
  if (std::string counts = count_mismatch(scene, state); !counts.empty()) return counts;
  const Population<D>& there = state.population;
  for (std::size_t k = 0; k < state.bodies.size(); ++k) {
    const std::size_t i = scene.has_gates() ? to_size(there.numbers[k]) : k;
    if (i >= scene.bodies.size()) break;  // came in
    const Body<D>&a = state.bodies[k], &b = scene.bodies[i];
    const auto differs = [&](const char* field, double x, double y) {
      return fmt::format("{} {}: {} is {}, in the scene {}", kBodyName<D>, i, field, x, y);
    };
    if (a.radius != b.radius) return differs("radius", a.radius, b.radius);
    if (a.mass != b.mass) return differs("mass", a.mass, b.mass);
    if (a.inertia != b.inertia) return differs("inertia", a.inertia, b.inertia);
    if (a.material != b.material) return differs("material", a.material, b.material);
    if (a.wall != b.wall) return differs("wall", a.wall, b.wall);
    if ((a.cluster < 0) != (b.cluster < 0)) return differs("cluster", a.cluster, b.cluster);
  }
  const std::vector<Cluster<D>>&joined = state.clusters.bodies, &planned = scene.clusters.bodies;
  for (std::size_t c = 0; c < joined.size() && !scene.has_gates(); ++c) {
    if (joined[c].mass != planned[c].mass || joined[c].inertia != planned[c].inertia) {
      return fmt::format("cluster {}: mass or inertia is not that of the scene", c);
    }
  }
  for (std::size_t i = 0; i < scene.walls.size(); ++i) {
    const Wall<D>&a = state.walls[i], &b = scene.walls[i];
    const bool same_way = a.motion == b.motion && !has_schedule(b);
    const bool moved =
        same_way && b.motion == Wall<D>::Motion::kFixed && (a.a != b.a || a.b != b.b);
    const bool drawn = same_way && b.motion == Wall<D>::Motion::kMoving && a.v != b.v;
    const char* field = a.shape != b.shape                               ? "shape"
                        : a.motion != b.motion && !has_schedule(b)       ? "motion"
                        : a.radius != b.radius                           ? "radius"
                        : a.radius_b != b.radius_b                       ? "radius"
                        : !same_mesh(a, b)                               ? "triangles"
                        : moved                                          ? "place"
                        : drawn || a.across != b.across                  ? "velocity"
                        : a.material != b.material                       ? "material"
                        : a.mass != b.mass                               ? "mass"
                        : a.force != b.force && b.time_factor.constant() ? "force"
                        : a.direction != b.direction                     ? "direction"
                        : a.shape == Wall<D>::Shape::kHalfPlane && a.normal != b.normal ? "normal"
                                                                                        : nullptr;
    if (field != nullptr) {
      return fmt::format("wall {}: {} is not that of wall '{}' of the scene", i, field, b.name);
    }
  }
  for (int k = 0; k < 3; ++k) {
    const CellSide &a = state.cell.side(k), &b = scene.cell.side(k);
    if (a.motion != b.motion || a.stress != b.stress || a.mass != b.mass) {
      return "the cell is not that of the scene";
    }
  }
  if (state.cell.in_x != scene.cell.in_x || state.cell.in_y != scene.cell.in_y) {
    return "the cell is not periodic as that of the scene";
  }
  return {};
}

template State<2> initial_state(const Scene<2>&);
template StateSums<2> state_sums<2>(const State<2>&, const Vec2&, bool);
template double angular_momentum(const State<2>&);
template std::string count_mismatch(const Scene<2>&, const State<2>&);
template std::string restart_mismatch(const Scene<2>&, const State<2>&);
template State<3> initial_state(const Scene<3>&);
template StateSums<3> state_sums<3>(const State<3>&, const Vec3&, bool);
template Vec3 angular_momentum(const State<3>&);
template std::string count_mismatch(const Scene<3>&, const State<3>&);
template std::string restart_mismatch(const Scene<3>&, const State<3>&);

}  // namespace bipot
