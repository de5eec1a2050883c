#include "core/motion/spring_dashpot_setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "core/base/disjoint_sets.h"
#include "core/scene/contact_detection.h"

namespace bipot {
namespace {

/// Extent of the bodies along a unit vector.
template <int D>
double extent(const Scene<D>& scene, const Vec<D>& axis) {
  double low = kInfinity, high = -kInfinity;
  for (const Body<D>& d : scene.bodies) {
    low = std::min(low, axis.dot(d.x) - d.radius);
    high = std::max(high, axis.dot(d.x) + d.radius);
  }
  return high - low;
}

/// Area, or volume in space, of a body; part of it in a dense arrangement.
template <int D>
double size_of(const Body<D>& d) {
  const double square = std::numbers::pi * d.radius * d.radius;
  return D == 2 ? square : 4.0 / 3 * square * d.radius;
}
template <int D>
constexpr double kDense = D == 2 ? 0.8 : 0.6;

/// The product over the directions across `axis` of f(extent).
template <int D, class F>
double over_base(const Scene<D>& scene, const Vec<D>& axis, F&& f) {
  const auto frame = contact_frame<D>(axis);
  double product = 1;
  for (std::size_t k = 1; k < to_size(D); ++k) product *= f(extent<D>(scene, frame[k]));
  return product;
}
template <int D>
double base(const Scene<D>& scene, const Vec<D>& axis) {
  return over_base(scene, axis, [](double across) { return across; });
}

struct Load {
  double force = 0;  // [N]
  double speed = 0;  // [m/s]
};

/// Largest fall of bodies under gravity until they lie densely.
template <int D>
double fall(const Scene<D>& scene, const Vec<D>& up, double base) {
  double all = 0, lowest = kInfinity;
  for (const Body<D>& d : scene.bodies) {
    all += size_of(d);
    lowest = std::min(lowest, up.dot(d.x) - d.radius);
  }
  double result = 0, least = kInfinity;
  for (const Body<D>& d : scene.bodies) {
    double height = up.dot(d.x) - d.radius - lowest;
    bool floor = false;
    for (const Wall<D>& w : scene.walls) {
      const double slope = w.normal.dot(up);
      if (w.shape != Wall<D>::Shape::kHalfPlane || slope < 1e-9) continue;
      const double above = std::max(0.0, (w.normal.dot(d.x - w.a) - d.radius) / slope);
      height = floor ? std::min(height, above) : above;
      floor = true;
    }
    least = std::min(least, height);
    result = std::max(result, height - (all - size_of(d)) / (kDense<D> * base));
  }
  return std::max(result, least);
}

/// Upper estimate of a disk's impact speed: a single disk among half-planes cannot hit one
/// sideways.
template <int D>
double impact_speed(const Scene<D>& scene, const Body<D>& disk) {
  if (scene.bodies.size() > 1) return disk.v.norm();
  double speed = 0;
  for (const Wall<D>& w : scene.walls) {
    if (w.shape != Wall<D>::Shape::kHalfPlane) return disk.v.norm();
    speed = std::max(speed, -w.normal.dot(disk.v));
  }
  return speed;
}

/// The largest factor of a driven or moving wall, whenever that is: parameters do not depend on the
/// duration.
template <int D>
double largest_factor(const Wall<D>& wall) {
  return wall.time_factor.largest(-kInfinity, kInfinity);
}

template <int D>
Load estimate_load(const Scene<D>& scene, double smallest) {
  Load load;
  double mass = 0, diameters = 0, all = 0, disk_speed = 0, wall_speed = 0;
  for (const Body<D>& d : scene.bodies) {
    mass += d.mass;
    diameters += 2 * d.radius;
    all += size_of(d);
    disk_speed = std::max(disk_speed, impact_speed(scene, d));
  }
  for (const Wall<D>& w : scene.walls) {
    const bool moves = w.motion == Wall<D>::Motion::kMoving;
    wall_speed = std::max(wall_speed, (moves ? largest_factor(w) : 1) * w.v.norm());
  }
  const double diameter = diameters / static_cast<double>(scene.bodies.size());
  const double column = std::pow(diameter, D - 1);
  const bool supported = supported_by_walls(scene, 1e-3 * smallest);
  double speed2 = (disk_speed + wall_speed) * (disk_speed + wall_speed);
  const double g = scene.gravity.norm();
  if (g > 0) {
    const Vec<D> up = -scene.gravity / g;
    const double ground = base(scene, up);
    load.force = mass * g / std::max(1.0, ground / column);
    if (!supported) speed2 += 2 * g * fall(scene, up, ground);
  }
  for (const Wall<D>& w : scene.walls) {
    if (w.motion != Wall<D>::Motion::kDriven || w.force == 0) continue;
    const double across = base(scene, w.direction), force = largest_factor(w) * std::abs(w.force);
    load.force = std::max(load.force, force / std::max(1.0, std::floor(across / column)));
    const double slack = std::max(0.0, extent(scene, w.direction) - all / (kDense<D> * across));
    if (!supported) {
      speed2 = std::max(speed2, 2 * force * slack / (w.mass + mass));
    }
  }
  load.speed = std::sqrt(speed2);
  return load;
}

/// Bound of the number of bodies of a radius that touch one. In space they cover caps, which fill
/// at most pi/√12 of a sphere (L. Fejes Tóth, 1943).
template <int D>
double most_around(double radius, double others) {
  const double sine = others / (radius + others);
  return D == 2 ? std::numbers::pi / std::asin(sine)
                : std::numbers::pi / std::sqrt(3.0) / (1 - std::sqrt(1 - sine * sine));
}

/// Σ over the contacts of one disk, per unit of stiffness and of damping coefficient.
struct CriticalStep {
  double kappa = 0, chi = 0;
  double step() const {
    return kappa > 0 ? (std::sqrt(chi * chi + 4 * kappa) - chi) / kappa : kInfinity;
  }
};

template <int D>
double critical_step(const Scene<D>& scene, double k_n, double k_t, double zeta) {
  const double smallest = smallest_radius(scene);
  double heaviest = 0, least_mobile = kInfinity;
  const auto mobility = [](const Body<D>& d) {
    return 1 / d.mass + d.radius * d.radius / d.inertia;
  };
  for (const Body<D>& d : scene.bodies) {
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
  for (const Body<D>& d : scene.bodies) {
    const int around = static_cast<int>(std::floor(most_around<D>(d.radius, smallest) + 1e-9));
    const int disks = std::min(around, others);
    const int at_walls = std::min(walls, around - disks);
    const CriticalStep pair = contact(1 / d.mass, mobility(d), 1 / heaviest, least_mobile);
    const CriticalStep wall = contact(1 / d.mass, mobility(d), 0, 0);
    step = std::min(step, CriticalStep{2 * disks * pair.kappa + at_walls * wall.kappa,
                                       2 * disks * pair.chi + at_walls * wall.chi}
                              .step());
  }
  for (const Wall<D>& w : scene.walls) {
    if (w.motion != Wall<D>::Motion::kDriven || scene.bodies.empty()) continue;
    const double along = std::min(static_cast<double>(scene.bodies.size()),
                                  over_base(scene, w.direction, [&](double across) {
                                    return std::floor(across / (2 * smallest)) + 1;
                                  }));
    CriticalStep c = contact(1 / w.mass, 0, 1 / heaviest, 0);
    // A driven wall moves along one direction only, which includes normal and tangential parts.
    c.kappa = std::max(k_n, k_t) / w.mass;
    c.chi = std::max(c.chi, 2 * zeta * std::sqrt(k_t / least_mobile) / w.mass);
    step = std::min(step, CriticalStep{2 * along * c.kappa, 2 * along * c.chi}.step());
  }
  return step;
}

/// Half of the shortest period of two bodies in contact.
template <int D>
double shortest_half_period(const Scene<D>& scene, double k_n, double k_t) {
  double normal = 0, rim = 0;
  for (const Body<D>& d : scene.bodies) {
    normal = std::max(normal, 1 / d.mass);
    rim = std::max(rim, 1 / d.mass + d.radius * d.radius / d.inertia);
  }
  double other_normal = scene.bodies.size() > 1 ? normal : 0;
  double other_rim = scene.bodies.size() > 1 ? rim : 0;
  for (const Wall<D>& w : scene.walls) {
    if (w.motion != Wall<D>::Motion::kDriven) continue;
    other_normal = std::max(other_normal, 1 / w.mass);
    other_rim = std::max(other_rim, 1 / w.mass);
  }
  const double omega2 = std::max(k_n * (normal + other_normal), k_t * (rim + other_rim));
  return omega2 > 0 ? std::numbers::pi / std::sqrt(omega2) : kInfinity;
}

}  // namespace

template <int D>
bool supported_by_walls(const Scene<D>& scene, double touching) {
  const int n = static_cast<int>(scene.bodies.size());
  DisjointSets held(n + 1);  // the last: all walls together
  for (const Contact<D>& c : detect_contacts<D>(scene.bodies, scene.walls, touching)) {
    held.unite(c.i, std::min(c.j, n));
  }
  for (int i = 0; i < n; ++i) {
    if (held.find(i) != held.find(n)) return false;
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

template <int D>
std::string no_springs(const Scene<D>& scene) {
  if (scene.cell.periodic()) return "dem: periodic scenes are for rigid contacts only";
  for (const Body<D>& d : scene.bodies) {
    if (d.wall >= 0) return "dem: rough walls are for rigid contacts only";
  }
  for (const Wall<D>& w : scene.walls) {
    if (w.is_surface()) {
      return fmt::format(
          "dem: wall '{}' has several contacts with a sphere, so this is for rigid contacts only",
          w.name);
    }
    if (w.removed == kInfinity) continue;
    return fmt::format(
        "dem: wall '{}' is removed at {:g} s; the energy of springs at it would not be accounted "
        "for, so this is for rigid contacts only",
        w.name, w.removed);
  }
  return {};
}

template <int D>
SpringDashpotSetup spring_dashpot_setup(const Scene<D>& scene) {
  if (std::string why = no_springs(scene); !why.empty()) throw std::invalid_argument(why);
  const SpringDashpotChoice& choice = scene.dem;
  SpringDashpotSetup setup;
  const double smallest = scene.bodies.empty() ? 0 : smallest_radius(scene);
  double heaviest = 0;
  for (const Body<D>& d : scene.bodies) heaviest = std::max(heaviest, d.mass);

  setup.stiffness = choice.stiffness;
  if (setup.stiffness == 0 && !scene.bodies.empty()) {
    const Load load = estimate_load(scene, smallest);
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

template bool supported_by_walls(const Scene<2>&, double);
template bool supported_by_walls(const Scene<3>&, double);
template std::string no_springs(const Scene<2>&);
template std::string no_springs(const Scene<3>&);
template SpringDashpotSetup spring_dashpot_setup(const Scene<2>&);
template SpringDashpotSetup spring_dashpot_setup(const Scene<3>&);

}  // namespace bipot
