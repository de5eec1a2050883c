#include "core/motion/state.h"

#include <fmt/format.h>

#include <cmath>

namespace bipot {

State initial_state(const Scene& scene) {
  State state;
  state.disks = scene.disks;
  state.walls = scene.walls;
  return state;
}

double time_after_step(const State& state, double h) {
  const bool multiple = std::abs(state.time - state.step * h) <= 1e-6 * h;
  return multiple ? (state.step + 1) * h : state.time + h;
}

double kinetic_energy(const State& state) {
  double sum = 0;
  for (const Disk& d : state.disks) {
    sum += 0.5 * d.mass * d.v.squaredNorm() + 0.5 * d.inertia * d.spin * d.spin;
  }
  for (const Wall& w : state.walls) {
    if (w.motion == Wall::Motion::kDriven) sum += 0.5 * w.mass * w.v.squaredNorm();
  }
  return sum;
}

double potential_energy(const State& state, const Vec2& gravity) {
  double sum = 0;
  for (const Disk& d : state.disks) sum -= d.mass * gravity.dot(d.x);
  return sum;
}

Vec2 momentum(const State& state) {
  Vec2 sum = Vec2::Zero();
  for (const Disk& d : state.disks) sum += d.mass * d.v;
  for (const Wall& w : state.walls) {
    if (w.motion == Wall::Motion::kDriven) sum += w.mass * w.v;
  }
  return sum;
}

std::string restart_mismatch(const Scene& scene, const State& state) {
  if (state.disks.size() != scene.disks.size() || state.walls.size() != scene.walls.size()) {
    return fmt::format("it has {} disks and {} walls, the scene has {} and {}", state.disks.size(),
                       state.walls.size(), scene.disks.size(), scene.walls.size());
  }
  for (std::size_t i = 0; i < scene.disks.size(); ++i) {
    const Disk &a = state.disks[i], &b = scene.disks[i];
    const auto differs = [&](const char* field, double x, double y) {
      return fmt::format("disk {}: {} is {}, in the scene {}", i, field, x, y);
    };
    if (a.radius != b.radius) return differs("radius", a.radius, b.radius);
    if (a.mass != b.mass) return differs("mass", a.mass, b.mass);
    if (a.inertia != b.inertia) return differs("inertia", a.inertia, b.inertia);
    if (a.material != b.material) return differs("material", a.material, b.material);
  }
  for (std::size_t i = 0; i < scene.walls.size(); ++i) {
    const Wall &a = state.walls[i], &b = scene.walls[i];
    const char* field = a.shape != b.shape                                           ? "shape"
                        : a.motion != b.motion                                       ? "motion"
                        : a.material != b.material                                   ? "material"
                        : a.mass != b.mass                                           ? "mass"
                        : a.force != b.force                                         ? "force"
                        : a.direction != b.direction                                 ? "direction"
                        : a.shape == Wall::Shape::kHalfPlane && a.normal != b.normal ? "normal"
                                                                                     : nullptr;
    if (field != nullptr) {
      return fmt::format("wall {}: {} is not that of wall '{}' of the scene", i, field, b.name);
    }
  }
  return {};
}

}  // namespace bipot
