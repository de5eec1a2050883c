#include "core/motion/spring_dashpot_setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "core/base/types.h"
#include "core/scene/contact_detection.h"

namespace bipot {
namespace {

/// Extent of the disks along a unit vector.
double extent(const Scene<2>& scene, const Vec2& axis) {
  double low = kInfinity, high = -kInfinity;
  for (const Disk& d : scene.bodies) {
    low = std::min(low, axis.dot(d.x) - d.radius);
    high = std::max(high, axis.dot(d.x) + d.radius);
  }
  return high - low;
}

struct Load {
  double force = 0;  // [N]
  double speed = 0;  // [m/s]
};

/// Largest fall of disks under gravity until they lie densely (0.8 of the area filled).
double fall(const Scene<2>& scene, const Vec2& up, double width) {
  double area = 0, lowest = kInfinity;
  for (const Disk& d : scene.bodies) {
    area += std::numbers::pi * d.radius * d.radius;
    lowest = std::min(lowest, up.dot(d.x) - d.radius);
  }
  double result = 0, least = kInfinity;
  for (const Disk& d : scene.bodies) {
    double height = up.dot(d.x) - d.radius - lowest;
    bool floor = false;
    for (const Wall<2>& w : scene.walls) {
      const double slope = w.normal.dot(up);
      if (w.shape != Wall<2>::Shape::kHalfPlane || slope < 1e-9) continue;
      const double above = std::max(0.0, (w.normal.dot(d.x - w.a) - d.radius) / slope);
      height = floor ? std::min(height, above) : above;
      floor = true;
    }
    least = std::min(least, height);
    const double others = area - std::numbers::pi * d.radius * d.radius;
    result = std::max(result, height - others / (0.8 * width));
  }
  return std::max(result, least);
}

/// Upper estimate of a disk's impact speed: a single disk among half-planes cannot hit one
/// sideways.
double impact_speed(const Scene<2>& scene, const Disk& disk) {
  if (scene.bodies.size() > 1) return disk.v.norm();
  double speed = 0;
  for (const Wall<2>& w : scene.walls) {
    if (w.shape != Wall<2>::Shape::kHalfPlane) return disk.v.norm();
    speed = std::max(speed, -w.normal.dot(disk.v));
  }
  return speed;
}

Load estimate_load(const Scene<2>& scene, double smallest) {
  Load load;
  double mass = 0, diameters = 0, area = 0, disk_speed = 0, wall_speed = 0;
  for (const Disk& d : scene.bodies) {
    mass += d.mass;
    diameters += 2 * d.radius;
    area += std::numbers::pi * d.radius * d.radius;
    disk_speed = std::max(disk_speed, impact_speed(scene, d));
  }
  for (const Wall<2>& w : scene.walls) wall_speed = std::max(wall_speed, w.v.norm());
  const double diameter = diameters / static_cast<double>(scene.bodies.size());
  const bool supported = supported_by_walls(scene, 1e-3 * smallest);
  double speed2 = (disk_speed + wall_speed) * (disk_speed + wall_speed);
  const double g = scene.gravity.norm();
  if (g > 0) {
    const Vec2 up = -scene.gravity / g;
    const double width = extent(scene, Vec2(-up[1], up[0]));
    load.force = mass * g / std::max(1.0, width / diameter);
    if (!supported) speed2 += 2 * g * fall(scene, up, width);
  }
  for (const Wall<2>& w : scene.walls) {
    if (w.motion != Wall<2>::Motion::kDriven || w.force == 0) continue;
    const double across = extent(scene, Vec2(-w.direction[1], w.direction[0]));
    load.force =
        std::max(load.force, std::abs(w.force) / std::max(1.0, std::floor(across / diameter)));
    const double slack = std::max(0.0, extent(scene, w.direction) - area / (0.8 * across));
    if (!supported) {
      speed2 = std::max(speed2, 2 * std::abs(w.force) * slack / (w.mass + mass));
    }
  }
  load.speed = std::sqrt(speed2);
  return load;
}

/// Σ over the contacts of one disk, per unit of stiffness and of damping coefficient.
struct CriticalStep {
  double kappa = 0, chi = 0;
  double step() const {
    return kappa > 0 ? (std::sqrt(chi * chi + 4 * kappa) - chi) / kappa : kInfinity;
  }
};

double critical_step(const Scene<2>& scene, double k_n, double k_t, double zeta) {
  double smallest = kInfinity, heaviest = 0, least_mobile = kInfinity;
  const auto mobility = [](const Disk& d) { return 1 / d.mass + d.radius * d.radius / d.inertia; };
  for (const Disk& d : scene.bodies) {
    smallest = std::min(smallest, d.radius);
    heaviest = std::max(heaviest, d.mass);
    least_mobile = std::min(least_mobile, mobility(d));
  }
  // Stiffness and dashpot of a contact, seen by a body of mobilities 1/m and `rim` at its rim.
  const auto contact = [&](double inv_m, double rim, double other_inv_m, double other_rim) {
    return CriticalStep{std::max(k_n * inv_m, k_t * rim),
                        2 * zeta *
                            std::max(std::sqrt(k_n / (inv_m + other_inv_m)) * inv_m,
                                     rim > 0 ? std::sqrt(k_t / (rim + other_rim)) * rim : 0.0)};
  };
  const int others = static_cast<int>(scene.bodies.size()) - 1;
  const int walls = static_cast<int>(scene.walls.size());
  double step = kInfinity;
  for (const Disk& d : scene.bodies) {
    const double half_angle = std::asin(smallest / (d.radius + smallest));
    const int around = static_cast<int>(std::floor(std::numbers::pi / half_angle + 1e-9));
    const int disks = std::min(around, others);
    const int at_walls = std::min(walls, around - disks);
    const CriticalStep pair = contact(1 / d.mass, mobility(d), 1 / heaviest, least_mobile);
    const CriticalStep wall = contact(1 / d.mass, mobility(d), 0, 0);
    step = std::min(step, CriticalStep{2 * disks * pair.kappa + at_walls * wall.kappa,
                                       2 * disks * pair.chi + at_walls * wall.chi}
                              .step());
  }
  for (const Wall<2>& w : scene.walls) {
    if (w.motion != Wall<2>::Motion::kDriven || scene.bodies.empty()) continue;
    const double across = extent(scene, Vec2(-w.direction[1], w.direction[0]));
    const double along =
        std::min(static_cast<double>(scene.bodies.size()), std::floor(across / (2 * smallest)) + 1);
    CriticalStep c = contact(1 / w.mass, 0, 1 / heaviest, 0);
    // A driven wall moves along one direction only, which includes normal and tangential parts.
    c.kappa = std::max(k_n, k_t) / w.mass;
    c.chi = std::max(c.chi, 2 * zeta * std::sqrt(k_t / least_mobile) / w.mass);
    step = std::min(step, CriticalStep{2 * along * c.kappa, 2 * along * c.chi}.step());
  }
  return step;
}

/// Half of the shortest period of two bodies in contact.
double shortest_half_period(const Scene<2>& scene, double k_n, double k_t) {
  double normal = 0, rim = 0;
  for (const Disk& d : scene.bodies) {
    normal = std::max(normal, 1 / d.mass);
    rim = std::max(rim, 1 / d.mass + d.radius * d.radius / d.inertia);
  }
  double other_normal = scene.bodies.size() > 1 ? normal : 0;
  double other_rim = scene.bodies.size() > 1 ? rim : 0;
  for (const Wall<2>& w : scene.walls) {
    if (w.motion != Wall<2>::Motion::kDriven) continue;
    other_normal = std::max(other_normal, 1 / w.mass);
    other_rim = std::max(other_rim, 1 / w.mass);
  }
  const double omega2 = std::max(k_n * (normal + other_normal), k_t * (rim + other_rim));
  return omega2 > 0 ? std::numbers::pi / std::sqrt(omega2) : kInfinity;
}

}  // namespace

bool supported_by_walls(const Scene<2>& scene, double touching) {
  const std::size_t n = scene.bodies.size();
  std::vector<std::size_t> parent(n + 1);  // the last: all walls together
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const Contact<2>& c : detect_contacts(scene.bodies, scene.walls, touching)) {
    parent[root(static_cast<std::size_t>(c.i))] = root(std::min(static_cast<std::size_t>(c.j), n));
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (root(i) != root(n)) return false;
  }
  return true;
}

double restitution_of_damping(double zeta) {
  const double one_minus = 1 - zeta * zeta;
  if (std::abs(one_minus) < 1e-8) return std::exp(-2 * zeta);  // the limit of both branches
  const double ratio = one_minus > 0 ? std::acos(zeta) / std::sqrt(one_minus)
                                     : std::acosh(zeta) / std::sqrt(-one_minus);
  return std::exp(-2 * zeta * ratio);
}

double damping_of_restitution(double e_n) {
  double low = 0, high = kMaxDamping;
  if (e_n >= 1) return 0;
  if (e_n <= restitution_of_damping(high)) return high;
  // Bisection to the last bit: the function is smooth and decreasing.
  for (double mid = 0.5 * (low + high); mid > low && mid < high; mid = 0.5 * (low + high)) {
    (restitution_of_damping(mid) > e_n ? low : high) = mid;
  }
  return low;
}

SpringDashpotSetup spring_dashpot_setup(const Scene<2>& scene) {
  if (scene.cell.periodic()) {
    throw std::invalid_argument("dem: periodic scenes are for rigid contacts only");
  }
  for (const Disk& d : scene.bodies) {
    if (d.wall >= 0) throw std::invalid_argument("dem: rough walls are for rigid contacts only");
  }
  for (const Wall<2>& w : scene.walls) {
    if (w.removed == kInfinity) continue;
    throw std::invalid_argument(fmt::format(
        "dem: wall '{}' is removed at {:g} s; the energy of springs at it would not be accounted "
        "for, so this is for rigid contacts only",
        w.name, w.removed));
  }
  const SpringDashpotChoice& choice = scene.dem;
  SpringDashpotSetup setup;
  double smallest = kInfinity, heaviest = 0;
  for (const Disk& d : scene.bodies) {
    smallest = std::min(smallest, d.radius);
    heaviest = std::max(heaviest, d.mass);
  }
  if (scene.bodies.empty()) smallest = 0;

  setup.stiffness = choice.stiffness;
  if (setup.stiffness == 0 && !scene.bodies.empty()) {
    const Load load = estimate_load(scene, smallest);
    setup.load_force = load.force;
    setup.load_speed = load.speed;
    const double length = choice.overlap * smallest;
    const double impact = load.speed / (10 * length);
    setup.stiffness = std::max(load.force / length, heaviest * impact * impact);
    if (!(setup.stiffness > 0) || !std::isfinite(setup.stiffness)) {
      throw std::invalid_argument(
          "dem: no weight, no driven wall and no speed say how stiff the contacts must be; give a "
          "stiffness [N/m]");
    }
  }
  setup.tangential_stiffness = choice.tangential_ratio * setup.stiffness;

  double most_damped = 0, least_e_n = 1, most_e_t = 0;
  bool too_dissipative = false;
  for (const ContactLaw& law : scene.laws) {
    setup.damping.push_back(damping_of_restitution(law.e_n));
    most_damped = std::max(most_damped, setup.damping.back());
    least_e_n = std::min(least_e_n, law.e_n);
    most_e_t = std::max(most_e_t, law.mu > 0 ? law.e_t : 0.0);
    too_dissipative |= law.e_n < restitution_of_damping(kMaxDamping);
  }
  if (too_dissipative) {
    setup.departures.push_back(
        fmt::format("e_n = {:g} is represented as {:.3f}: more damping than {:g} of critical would "
                    "need ever smaller substeps",
                    least_e_n, restitution_of_damping(kMaxDamping), kMaxDamping));
  }
  if (most_e_t > 0) {
    setup.departures.push_back(
        fmt::format("e_t = {:g} is not represented: tangential contact is a spring of {:.3g} k_n, "
                    "damped like the normal one and limited by friction",
                    most_e_t, choice.tangential_ratio));
  }

  const bool friction = scene.has_friction();
  const double k_n = setup.stiffness, k_t = friction ? setup.tangential_stiffness : 0;
  setup.critical_step = critical_step(scene, k_n, k_t, most_damped);
  double substep = choice.substep;
  if (substep > setup.critical_step) {
    throw std::invalid_argument(
        fmt::format("dem: a substep of {:.6g} s is unstable: the critical one is {:.6g} s for a "
                    "stiffness of {:.6g} N/m; take a smaller substep or a smaller stiffness",
                    substep, setup.critical_step, setup.stiffness));
  }
  if (substep == 0) {
    const double resolution = 20 + 40 * most_damped;
    substep = std::min(choice.safety * setup.critical_step,
                       shortest_half_period(scene, k_n, k_t) / resolution);
  }
  const double count = std::ceil(scene.step / substep - 1e-9);
  if (!(count < std::numeric_limits<int>::max())) {
    throw std::invalid_argument(
        fmt::format("dem: a step of {:g} s in substeps of {:.3g} s is more than can be counted",
                    scene.step, substep));
  }
  setup.substeps = std::max(1, static_cast<int>(count));
  setup.substep = scene.step / setup.substeps;
  return setup;
}

}  // namespace bipot
