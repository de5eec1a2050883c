#include "core/scene/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace bipot {
namespace {

std::string check_positive(const char* what, std::size_t index, const char* field, double value) {
  if (std::isfinite(value) && value > 0) return {};
  return fmt::format("{} {}: {} = {} is not a positive finite number", what, index, field, value);
}

std::string check_finite(const char* what, std::size_t index, const char* field, const Vec2& x) {
  if (x.allFinite()) return {};
  return fmt::format("{} {}: {} = ({}, {}) is not finite", what, index, field, x[0], x[1]);
}

std::string check_disk(const Disk& d, std::size_t i, int materials) {
  if (auto e = check_finite("disk", i, "position", d.x); !e.empty()) return e;
  if (auto e = check_finite("disk", i, "velocity", d.v); !e.empty()) return e;
  if (auto e = check_finite("disk", i, "angle, spin", Vec2(d.angle, d.spin)); !e.empty()) return e;
  if (auto e = check_positive("disk", i, "radius", d.radius); !e.empty()) return e;
  if (auto e = check_positive("disk", i, "mass", d.mass); !e.empty()) return e;
  if (auto e = check_positive("disk", i, "inertia", d.inertia); !e.empty()) return e;
  if (d.material < 0 || d.material >= materials) {
    return fmt::format("disk {}: material index {} is not in [0, {})", i, d.material, materials);
  }
  return {};
}

std::string check_unit(const char* field, std::size_t i, const Vec2& x) {
  if (std::abs(x.norm() - 1) < 1e-12) return {};
  return fmt::format("wall {}: {} = ({}, {}) is not a unit vector", i, field, x[0], x[1]);
}

std::string check_wall(const Wall& w, std::size_t i, int materials) {
  if (auto e = check_finite("wall", i, "point", w.a); !e.empty()) return e;
  if (auto e = check_finite("wall", i, "velocity", w.v); !e.empty()) return e;
  if (w.shape == Wall::Shape::kSegment) {
    if (auto e = check_finite("wall", i, "end point", w.b); !e.empty()) return e;
    if (w.a == w.b) return fmt::format("wall {}: the segment's two ends coincide", i);
  } else if (auto e = check_unit("normal", i, w.normal); !e.empty()) {
    return e;
  }
  if (w.motion == Wall::Motion::kDriven) {
    if (auto e = check_positive("wall", i, "mass", w.mass); !e.empty()) return e;
    if (auto e = check_unit("direction", i, w.direction); !e.empty()) return e;
    if (!std::isfinite(w.force)) {
      return fmt::format("wall {}: force = {} is not finite", i, w.force);
    }
  }
  if (w.material < 0 || w.material >= materials) {
    return fmt::format("wall {}: material index {} is not in [0, {})", i, w.material, materials);
  }
  return {};
}

}  // namespace

bool Scene::has_friction() const {
  for (const ContactLaw& law : laws) {
    if (law.mu > 0) return true;
  }
  return false;
}

double smallest_radius(const Scene& scene) {
  double smallest = kInfinity;
  for (const Disk& d : scene.disks) smallest = std::min(smallest, d.radius);
  return smallest;
}

std::string validate(const Scene& scene) {
  const int materials = static_cast<int>(scene.materials.size());
  if (!scene.gravity.allFinite()) return "gravity is not finite";
  if (!(scene.step > 0) || !std::isfinite(scene.step)) {
    return fmt::format("time step = {} s is not a positive finite number", scene.step);
  }
  if (scene.num_steps < 0) return fmt::format("number of steps = {} is negative", scene.num_steps);
  if (!(scene.contact_distance >= 0) || !std::isfinite(scene.contact_distance)) {
    return fmt::format("contact distance = {} m is not >= 0", scene.contact_distance);
  }
  if (scene.laws.size() != scene.materials.size() * scene.materials.size()) {
    return fmt::format("{} contact laws for {} materials", scene.laws.size(), materials);
  }
  for (std::size_t k = 0; k < scene.laws.size(); ++k) {
    const ContactLaw& law = scene.laws[k];
    const auto unit = [](double e) { return e >= 0 && e <= 1; };
    if (!(law.mu >= 0) || !std::isfinite(law.mu) || !unit(law.e_n) || !unit(law.e_t)) {
      return fmt::format("materials {} and {}: mu = {} (>= 0), e_n = {}, e_t = {} (both in [0, 1])",
                         scene.materials[k / scene.materials.size()],
                         scene.materials[k % scene.materials.size()], law.mu, law.e_n, law.e_t);
    }
  }
  for (std::size_t i = 0; i < scene.disks.size(); ++i) {
    if (auto e = check_disk(scene.disks[i], i, materials); !e.empty()) return e;
  }
  for (std::size_t i = 0; i < scene.walls.size(); ++i) {
    if (auto e = check_wall(scene.walls[i], i, materials); !e.empty()) return e;
  }
  const SpringDashpotChoice& dem = scene.dem;
  const auto at_least_zero = [](double x) { return x >= 0 && std::isfinite(x); };
  if (!at_least_zero(dem.stiffness) || !at_least_zero(dem.substep) || !(dem.overlap > 0) ||
      !(dem.overlap < 0.1) || !at_least_zero(dem.tangential_ratio) || !(dem.safety > 0) ||
      !(dem.safety <= 1)) {
    return fmt::format(
        "dem: stiffness = {} N/m (>= 0), overlap = {} (in (0, 0.1)), tangential_ratio = {} "
        "(>= 0), substep = {} s (>= 0), safety = {} (in (0, 1])",
        dem.stiffness, dem.overlap, dem.tangential_ratio, dem.substep, dem.safety);
  }
  for (int i : scene.output.track) {
    if (i < 0 || i >= static_cast<int>(scene.disks.size())) {
      return fmt::format("output.track: there is no disk {}", i);
    }
  }
  return {};
}

}  // namespace bipot
