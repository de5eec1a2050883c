#include "core/scene/scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "core/scene/cluster_motion.h"
#include "core/scene/joints.h"

namespace bipot {
namespace {

std::string check_positive(const char* what, std::size_t index, const char* field, double value) {
  if (std::isfinite(value) && value > 0) return {};
  return fmt::format("{} {}: {} = {} is not a positive finite number", what, index, field, value);
}

/// As "(1, 2)".
template <class Vec>
std::string in_brackets(const Vec& x) {
  return fmt::format("({})", fmt::join(x.data(), x.data() + x.size(), ", "));
}

template <class Vec>
std::string check_finite(const char* what, std::size_t index, const char* field, const Vec& x) {
  if (x.allFinite()) return {};
  return fmt::format("{} {}: {} = {} is not finite", what, index, field, in_brackets(x));
}

std::string check_turn(const Disk& d, std::size_t i) {
  return check_finite("disk", i, "angle, spin", Vec2(d.angle, d.spin));
}

std::string check_turn(const Sphere& s, std::size_t i) {
  if (auto e = check_finite("sphere", i, "orientation", s.orientation.coeffs()); !e.empty())
    return e;
  return check_finite("sphere", i, "spin", s.spin);
}

template <int D>
std::string check_body(const Body<D>& d, std::size_t i, int materials) {
  const char* what = kBodyName<D>;
  if (auto e = check_finite(what, i, "position", d.x); !e.empty()) return e;
  if (auto e = check_finite(what, i, "velocity", d.v); !e.empty()) return e;
  if (auto e = check_turn(d, i); !e.empty()) return e;
  if (auto e = check_positive(what, i, "radius", d.radius); !e.empty()) return e;
  if (d.wall < 0 && d.cluster < 0) {
    if (auto e = check_positive(what, i, "mass", d.mass); !e.empty()) return e;
    if (auto e = check_positive(what, i, "inertia", d.inertia); !e.empty()) return e;
  } else if (d.mass != 0 || d.inertia != 0) {
    return fmt::format("{} {} is {}, and has a mass of {} kg", what, i,
                       d.wall >= 0 ? "glued to a wall" : "part of a cluster", d.mass);
  }
  if (d.material < 0 || d.material >= materials) {
    return fmt::format("{} {}: material index {} is not in [0, {})", what, i, d.material,
                       materials);
  }
  return {};
}

template <class Vec>
std::string check_unit(const char* field, std::size_t i, const Vec& x) {
  if (std::abs(x.norm() - 1) < 1e-12) return {};
  return fmt::format("wall {}: {} = {} is not a unit vector", i, field, in_brackets(x));
}

template <int D>
std::string check_wall(const Wall<D>& w, std::size_t i, int materials) {
  if (auto e = check_finite("wall", i, "point", w.a); !e.empty()) return e;
  if (auto e = check_finite("wall", i, "velocity", w.v); !e.empty()) return e;
  if (w.shape == Wall<D>::Shape::kSegment) {
    if (auto e = check_finite("wall", i, "end point", w.b); !e.empty()) return e;
    if (w.a == w.b) return fmt::format("wall {}: the segment's two ends coincide", i);
  } else if (w.is_circle()) {
    if (auto e = check_positive("wall", i, "radius", w.radius); !e.empty()) return e;
    if (!std::isfinite(w.spin)) return fmt::format("wall {}: spin = {} is not finite", i, w.spin);
    if constexpr (D == 3) {
      if (auto e = check_unit("axis", i, w.normal); !e.empty()) return e;
    }
  } else if (w.shape == Wall<D>::Shape::kCone) {
    const auto radius = [](double x) { return x >= 0 && std::isfinite(x); };
    if (!w.b.allFinite() || w.a == w.b || !radius(w.radius) || !radius(w.radius_b) ||
        w.radius + w.radius_b == 0) {
      return fmt::format("wall {}: a cone needs two different ends and radii >= 0, not {} and {} m",
                         i, w.radius, w.radius_b);
    }
  } else if (w.shape == Wall<D>::Shape::kMesh && w.mesh == nullptr) {
    return fmt::format("wall {}: it has no triangles", i);
  } else if (auto e = check_unit("normal", i, w.normal); !e.empty()) {
    return e;
  }
  if (auto e = check_finite("wall", i, "surface velocity", w.belt); !e.empty()) return e;
  if (w.has_grain()) {
    if (auto e = check_unit("grain", i, w.grain); !e.empty()) return e;
    if (auto e = check_positive("wall", i, "grain_ratio", w.grain_ratio); !e.empty()) return e;
  }
  if (w.motion == Wall<D>::Motion::kDriven) {
    if (auto e = check_positive("wall", i, "mass", w.mass); !e.empty()) return e;
    if (auto e = check_unit("direction", i, w.direction); !e.empty()) return e;
    if (!std::isfinite(w.force)) {
      return fmt::format("wall {}: force = {} is not finite", i, w.force);
    }
    if (!(std::abs(w.across.dot(w.direction)) <= 1e-12 * w.across.norm())) {
      return fmt::format("wall {}: it is moved by {} m/s, not across its direction", i,
                         in_brackets(w.across));
    }
  }
  if (!(w.starts >= 0) || !(w.stops >= w.starts) || !(w.removed >= 0)) {
    return fmt::format("wall {}: starts = {} s (>= 0), stops = {} s (>= starts), removed = {} s", i,
                       w.starts, w.stops, w.removed);
  }
  if (auto e = check_time_factor(w.time_factor); !e.empty())
    return fmt::format("wall {}: {}", i, e);
  if (w.material < 0 || w.material >= materials) {
    return fmt::format("wall {}: material index {} is not in [0, {})", i, w.material, materials);
  }
  return {};
}

/// Glued disks need a wall that neither turns nor leaves.
template <int D>
std::string check_glued(const Scene<D>& scene, std::size_t i) {
  const int w = scene.bodies[i].wall;
  if (w < 0) return {};
  if (w >= static_cast<int>(scene.walls.size())) {
    return fmt::format("{} {}: there is no wall {}", kBodyName<D>, i, w);
  }
  const Wall<D>& wall = scene.walls[to_size(w)];
  if (wall.spin == 0 && wall.belt.isZero(0) && wall.removed == kInfinity) return {};
  return fmt::format("wall {}: '{}' turns, is a belt or is removed, and {} {} is glued to it", w,
                     wall.name, kBodyName<D>, i);
}

/// Checks the entries of a scene that a periodic cell excludes.
template <int D>
std::string check_periodic(const Scene<D>& scene) {
  const PeriodicCell& cell = scene.cell;
  if (!cell.periodic()) return {};
  if (auto e = check_cell(cell); !e.empty()) return e;
  if (D == 3 && cell.deforms()) return "cell: in 3D it cannot deform";
  double largest = 0;
  for (const Body<D>& d : scene.bodies) largest = std::max(largest, d.radius);
  if (!(shortest_period(cell) > 4 * largest + 2 * scene.detection_distance())) {
    return fmt::format(
        "the cell repeats itself after {} m: it must be longer than two of the largest diameters, "
        "{} m",
        shortest_period(cell), 4 * largest);
  }
  if (D == 2 && cell.in_y && !scene.gravity.isZero(0)) {
    return "gravity has no place in a cell that is periodic in x and y: gravity = [0, 0]";
  }
  for (std::size_t w = 0; w < scene.walls.size(); ++w) {
    const Wall<D>& wall = scene.walls[w];
    const bool plane = wall.shape == Wall<D>::Shape::kHalfPlane;
    if (wall.is_surface()) {
      return fmt::format("wall {}: a periodic scene has no place for triangles and cones", w);
    }
    const bool across = wall.normal[0] != 0 || (cell.in_y && wall.normal[1] != 0);
    if (plane && across) {
      return fmt::format(
          "wall {}: {}", w,
          D == 2 ? "a half-plane in a periodic scene lies along x, and there is no place for it "
                   "where the cell is periodic in y as well"
                 : "a plane in a periodic scene lies along the directions that repeat themselves");
    }
    if (D == 3 && wall.is_circle() && !(wall.normal.cwiseAbs().maxCoeff() > 1 - 1e-12)) {
      return fmt::format("wall {}: a cylinder in a periodic scene lies along an axis", w);
    }
    for (int axis = 0; axis < (cell.in_y ? 2 : 1); ++axis) {
      const bool along = D == 3 && wall.is_circle() && std::abs(wall.normal[axis]) > 0.5;
      const double reach = plane || along    ? 0
                           : wall.radius > 0 ? 2 * wall.radius
                                             : std::abs(wall.b[axis] - wall.a[axis]) * (1 - 1e-12);
      const double length = cell.side(axis).length;
      if (reach <= length) continue;
      return fmt::format("wall {}: it is {} m {}, the cell {} m", w, reach,
                         axis == 0 ? "wide"
                         : D == 2  ? "high"
                                   : "deep",
                         length);
    }
    if (!plane && cell.deforms()) {
      return fmt::format("wall {}: a cell that deforms has no place for segments and circles", w);
    }
  }
  return {};
}

/// Checks the accuracy, and the entries that it excludes.
template <int D>
std::string check_accuracy(const Scene<D>& scene) {
  const double x = scene.accuracy;
  if (x == 0) return {};
  if (!(x >= 1e-6) || !(x <= 0.3)) {
    return fmt::format("accuracy = {:g} of a radius is not in [1e-6, 0.3], nor 0: none", x);
  }
  const auto refused = [](const char* with, const char* why) {
    return fmt::format("accuracy does not go with {}: {}", with, why);
  };
  if (scene.model == Model::kSpringDashpot) {
    return refused("the model \"dem\"", "its substeps follow from its stiffness");
  }
  if (scene.travel > 0) return refused("travel", "both cut the steps");
  if (scene.predict_gaps) {
    return refused("overlaps = \"predict\"", "bodies that have not met yet push each other");
  }
  if (scene.project_overlaps) {
    return refused("overlaps = \"project\"", "it takes out the overlaps that measure the accuracy");
  }
  for (const Wall<D>& wall : scene.walls) {
    if (wall.is_surface()) return refused("triangles and cones", "they may be touched twice");
  }
  const double most = 1e-2 * x * smallest_radius(scene);
  if (scene.contact_distance > most) {
    return fmt::format(
        "accuracy = {:g} needs a contact distance of at most {:.3g} m, a hundredth of the accuracy "
        "in smallest radii; it is {:.3g} m",
        x, most, scene.contact_distance);
  }
  return {};
}

/// Checks the entries that another law of impact than Newton's excludes.
template <int D>
std::string check_impact(const Scene<D>& scene) {
  if (scene.impact == ContactLaw::Impact::kNewton) return {};
  const bool poisson = scene.impact == ContactLaw::Impact::kPoisson;
  const auto refused = [&](const char* with, const char* why) {
    return fmt::format("impact = \"{}\" does not go with {}: {}", poisson ? "poisson" : "fremond",
                       with, why);
  };
  if (scene.model == Model::kSpringDashpot) {
    return refused("the model \"dem\"", "its dashpots make the restitution");
  }
  if (scene.accuracy > 0) return refused("accuracy", "its contacts turn by Newton's law");
  if (scene.predict_gaps) return refused("overlaps = \"predict\"", "that needs e_n = 0");
  if (scene.has_cohesion()) return refused("cohesion", "a pull is no impact");
  if (scene.has_rolling()) return refused("rolling friction", "no moment comes back");
  if (!scene.joints.empty()) return refused("pins and ropes", "they have no such law");
  for (const ContactLaw& law : scene.laws) {
    if (law.e_t == 0) continue;
    return refused("e_t", poisson ? "only normal impulses are returned"
                                  : "friction opposes the mean of the velocities before and after");
  }
  return {};
}

/// Checks cohesion, and the entries that it excludes.
template <int D>
std::string check_cohesion(const Scene<D>& scene) {
  for (const ContactLaw& law : scene.laws) {
    if (!(law.cohesion >= 0) || !std::isfinite(law.cohesion)) {
      return fmt::format("cohesion = {} N is not >= 0", law.cohesion);
    }
  }
  if (!(scene.cohesion_range >= 0) || !std::isfinite(scene.cohesion_range)) {
    return fmt::format("cohesion_range = {} m is not >= 0", scene.cohesion_range);
  }
  if (!scene.has_cohesion()) {
    if (scene.cohesion_range == 0 && scene.heal) return {};
    return "cohesion_range and heal = false need cohesion > 0";
  }
  if (scene.model == Model::kSpringDashpot) return "cohesion does not go with the model \"dem\"";
  const bool surface = std::any_of(scene.walls.begin(), scene.walls.end(),
                                   [](const Wall<D>& wall) { return wall.is_surface(); });
  if (!scene.heal && surface) {
    return "heal = false does not go with walls of triangles and cones: they may be touched twice";
  }
  if (scene.cohesion_range < 2 * scene.accuracy * smallest_radius(scene)) {
    return fmt::format(
        "cohesion with accuracy = {:g} needs a cohesion_range of at least {:.3g} m, two accuracies "
        "in smallest radii: contacts may drift by that much",
        scene.accuracy, 2 * scene.accuracy * smallest_radius(scene));
  }
  if (scene.cohesion_range == 0) return {};
  for (const ContactLaw& law : scene.laws) {
    if (law.e_n == 0) continue;
    return fmt::format(
        "cohesion_range goes with e_n = 0 alone: a pair in its range stops before it touches, and "
        "e_n = {} would act on its remaining speed",
        law.e_n);
  }
  return {};
}

/// Checks forces on bodies and drag, and the entries that they exclude.
template <int D>
std::string check_outside_forces(const Scene<D>& scene) {
  const Drag<D>& drag = scene.drag;
  if (!(drag.coefficient >= 0) || !std::isfinite(drag.coefficient) || !drag.velocity.allFinite()) {
    return fmt::format("drag: coefficient = {} N s/m² (>= 0), velocity = {}", drag.coefficient,
                       in_brackets(drag.velocity));
  }
  if (scene.forces.empty() && drag.coefficient == 0) return {};
  if (scene.model == Model::kSpringDashpot)
    return "forces and drag do not go with the model \"dem\"";
  if (!scene.clusters.empty()) return "forces and drag do not go with clusters";
  if (!scene.forces.empty() && scene.has_gates()) {
    return "forces on bodies do not go with outlets and inlets, which renumber them";
  }
  const int bodies = static_cast<int>(scene.bodies.size());
  for (std::size_t k = 0; k < scene.forces.size(); ++k) {
    const BodyForce<D>& f = scene.forces[k];
    if (f.first < 0 || f.last < f.first || f.last >= bodies) {
      return fmt::format("forces[{}]: there are no bodies {} to {}", k, f.first, f.last);
    }
    if (auto e = check_finite("force", k, "force", f.force); !e.empty()) return e;
    if (auto e = check_time_factor(f.time_factor); !e.empty())
      return fmt::format("forces[{}]: {}", k, e);
    for (int i = f.first; i <= f.last; ++i) {
      if (scene.bodies[to_size(i)].wall >= 0) {
        return fmt::format("forces[{}]: {} {} is glued to a wall", k, kBodyName<D>, i);
      }
    }
  }
  return {};
}

/// Checks outlets and inlets, and the entries that they exclude.
template <int D>
std::string check_gates(const Scene<D>& scene) {
  if (!scene.has_gates()) return {};
  if (scene.model == Model::kSpringDashpot) {
    return "outlets and inlets do not go with the model \"dem\"";
  }
  if (!scene.inlets.empty() && scene.cell.periodic()) {
    return "inlets have no place in a periodic cell";
  }
  for (const Outlet<D>& outlet : scene.outlets) {
    if (auto e = check_outlet(outlet); !e.empty()) return e;
    const PeriodicCell& cell = scene.cell;
    const auto is_far = [&](int axis, double period) {
      return std::max(outlet.lower[axis], -outlet.upper[axis]) > (kMostCells - 1) * period;
    };
    if (outlet.box && ((cell.in_x && is_far(0, cell.width.length)) ||
                       (cell.in_y && is_far(1, cell.height.length)))) {
      return fmt::format("outlet '{}': its box lies more than {} cells away", outlet.name,
                         kMostCells);
    }
  }
  for (std::size_t k = 0; k < scene.inlets.size(); ++k) {
    const Inlet<D>& inlet = scene.inlets[k];
    if (auto e = check_inlet(inlet, static_cast<int>(scene.materials.size())); !e.empty()) return e;
    if (inlet.rate * scene.step > 1e5) {  // probably a typing error; it would exhaust the memory
      return fmt::format("inlets[{}]: {:.3g} bodies a step, at most 1e5 are possible", k,
                         inlet.rate * scene.step);
    }
  }
  return {};
}

std::string check_springs(const SpringDashpotChoice& dem) {
  struct Limited {
    const char *name, *unit, *range;
    double value;
    bool holds;
  };
  const auto from_zero = [](double x) { return x >= 0 && std::isfinite(x); };
  const Limited all[] = {
      {"stiffness", " N/m", ">= 0", dem.stiffness, from_zero(dem.stiffness)},
      {"overlap", "", "in (0, 0.1)", dem.overlap, dem.overlap > 0 && dem.overlap < 0.1},
      {"tangential_ratio", "", ">= 0", dem.tangential_ratio, from_zero(dem.tangential_ratio)},
      {"substep", " s", ">= 0", dem.substep, from_zero(dem.substep)},
      {"safety", "", "in (0, 1]", dem.safety, dem.safety > 0 && dem.safety <= 1}};
  for (const Limited& x : all) {
    if (x.holds) continue;
    return fmt::format("dem: {} = {}{}, expected a number {}", x.name, x.value, x.unit, x.range);
  }
  return {};
}

}  // namespace

void drift(Sphere& sphere, double h) {
  sphere.x += h * sphere.v;
  const double speed = sphere.spin.norm();
  if (speed == 0) return;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(speed * h, sphere.spin / speed));
  sphere.orientation = (turn * sphere.orientation).normalized();
}

template <int D>
bool Scene<D>::has_friction() const {
  const auto rubs = [](const ContactLaw& law) { return law.mu > 0; };
  return std::any_of(laws.begin(), laws.end(), rubs) || has_rolling();
}

template <int D>
bool Scene<D>::has_rolling() const {
  return std::any_of(laws.begin(), laws.end(),
                     [](const ContactLaw& law) { return law.mu_r > 0 || law.mu_spin > 0; });
}

template <int D>
bool Scene<D>::has_cohesion() const {
  return std::any_of(laws.begin(), laws.end(),
                     [](const ContactLaw& law) { return law.cohesion > 0; });
}

template <int D>
Vec<D> gravity_at(const Scene<D>& scene, double time) {
  const Tilt& tilt = scene.tilt;
  if (tilt.rate == 0) return scene.gravity;
  const double turned = std::clamp(time, tilt.starts, tilt.stops) - tilt.starts;
  const Vec2 plane =
      Eigen::Rotation2D<double>(tilt.rate * turned) * Vec2(scene.gravity[0], scene.gravity[D - 1]);
  Vec<D> gravity = scene.gravity;
  gravity[0] = plane[0];
  gravity[D - 1] = plane[1];
  return gravity;
}

template <int D>
double smallest_radius(const Scene<D>& scene) {
  double smallest = kInfinity;
  for (const Body<D>& d : scene.bodies) smallest = std::min(smallest, d.radius);
  for (const Inlet<D>& inlet : scene.inlets) {
    for (const double radius : inlet.radii) smallest = std::min(smallest, radius);
  }
  return smallest;
}

template <int D>
std::string validate(const Scene<D>& scene) {
  const int materials = static_cast<int>(scene.materials.size());
  if (!scene.gravity.allFinite()) return "gravity is not finite";
  if (!std::isfinite(scene.tilt.rate) || !(scene.tilt.starts >= 0) ||
      !(scene.tilt.stops >= scene.tilt.starts)) {
    return fmt::format("tilt: rate = {} rad/s, starts = {} s (>= 0), stops = {} s (>= starts)",
                       scene.tilt.rate, scene.tilt.starts, scene.tilt.stops);
  }
  if (!(scene.step > 0) || !std::isfinite(scene.step)) {
    return fmt::format("time step = {} s is not a positive finite number", scene.step);
  }
  if (!(scene.travel >= 0) || !std::isfinite(scene.travel)) {
    return fmt::format("travel = {} of the smallest radius is not >= 0", scene.travel);
  }
  if (scene.travel > 0 && scene.model == Model::kSpringDashpot) {
    return "travel has no meaning with the model \"dem\", whose substeps are shorter";
  }
  if (auto e = check_accuracy(scene); !e.empty()) return e;
  if (scene.num_steps < 0) return fmt::format("number of steps = {} is negative", scene.num_steps);
  if (!(scene.contact_distance >= 0) || !std::isfinite(scene.contact_distance)) {
    return fmt::format("contact distance = {} m is not >= 0", scene.contact_distance);
  }
  if (scene.project_overlaps && (scene.cell.periodic() || scene.model == Model::kSpringDashpot)) {
    return "overlaps = \"project\" has no meaning in a periodic cell, nor with the model \"dem\"";
  }
  if (scene.start == StartChoice::kPushApart && scene.cell.periodic()) {
    return "[start] overlaps = \"push apart\" has no meaning in a periodic cell";
  }
  if (scene.predict_gaps) {
    if (scene.cell.periodic() || scene.model == Model::kSpringDashpot) {
      return "overlaps = \"predict\" has no meaning in a periodic cell, nor with the model \"dem\"";
    }
    for (const ContactLaw& law : scene.laws) {
      if (law.e_n == 0) continue;
      return fmt::format(
          "overlaps = \"predict\" goes with e_n = 0 alone: bodies are slowed down before they "
          "touch, and e_n = {} would act on their remaining speed",
          law.e_n);
    }
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
    if (!(law.mu_r >= 0) || !std::isfinite(law.mu_r) || !(law.mu_spin >= 0) ||
        !std::isfinite(law.mu_spin)) {
      return fmt::format("mu_r = {} m and mu_spin = {} m, expected >= 0", law.mu_r, law.mu_spin);
    }
    if (D == 2 && law.mu_spin > 0) return "mu_spin is for spheres: disks do not turn about normals";
  }
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (auto e = check_body(scene.bodies[i], i, materials); !e.empty()) return e;
    if (auto e = check_glued(scene, i); !e.empty()) return e;
  }
  for (std::size_t i = 0; i < scene.walls.size(); ++i) {
    if (auto e = check_wall(scene.walls[i], i, materials); !e.empty()) return e;
  }
  if (scene.model == Model::kSpringDashpot &&
      std::any_of(scene.walls.begin(), scene.walls.end(),
                  [](const Wall<D>& wall) { return wall.has_grain(); })) {
    return "a grain of walls does not go with the model \"dem\"";
  }
  if (scene.has_rolling() && scene.model == Model::kSpringDashpot) {
    return "rolling friction does not go with the model \"dem\"";
  }
  for (const auto check : {check_periodic<D>, check_gates<D>, check_cohesion<D>, check_impact<D>,
                           check_outside_forces<D>, check_clusters<D>, check_joints<D>}) {
    if (auto e = check(scene); !e.empty()) return e;
  }
  if (auto e = check_springs(scene.dem); !e.empty()) return e;
  if (scene.model == Model::kSpringDashpot && scene.dem.tangential_ratio == 0 &&
      scene.has_friction()) {
    return "dem: tangential_ratio = 0 would take out the friction: give mu = 0 for that";
  }
  for (int i : scene.output.track) {
    if (i < 0 || i >= static_cast<int>(scene.bodies.size())) {
      return fmt::format("output.track: there is no {} {}", kBodyName<D>, i);
    }
  }
  return {};
}

template struct Scene<2>;
template struct Scene<3>;
template Vec2 gravity_at(const Scene<2>&, double);
template Vec3 gravity_at(const Scene<3>&, double);
template double smallest_radius(const Scene<2>&);
template double smallest_radius(const Scene<3>&);
template std::string validate(const Scene<2>&);
template std::string validate(const Scene<3>&);

}  // namespace bipot
