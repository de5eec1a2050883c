#include "core/observables/observables.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "core/motion/periodic_state.h"
#include "core/motion/sample_area.h"
#include "core/motion/sample_volume.h"
#include "core/observables/cut_bodies.h"
#include "core/observables/measured_bodies.h"

namespace bipot {
namespace {

template <int D>
bool in_window(const ObservableChoice<D>& choice, const std::type_identity_t<Vec<D>>& x) {
  return !choice.window || choice.window->contains(x);
}

/// The point of contact, in the cell.
template <int D>
Vec<D> touching_point(const State<D>& placed, const Contact<D>& contact) {
  const Body<D>& d = placed.bodies[to_size(contact.i)];
  Vec<D> point = d.x - d.radius * contact.n;
  if (placed.cell.periodic()) {
    point.template head<2>() = wrapped(placed.cell, point.template head<2>());
  }
  return point;
}

/// Least squares fit v = v0 + L x.
template <int D>
Mat<D> fitted_gradient(const std::vector<const MeasuredBody<D>*>& disks) {
  const Mat<D> undefined = Mat<D>::Constant(kNaN);
  if (disks.size() < D + 1) return undefined;
  Vec<D> x_mean = Vec<D>::Zero(), v_mean = Vec<D>::Zero();
  const double count = static_cast<double>(disks.size());
  for (const MeasuredBody<D>* d : disks) {
    x_mean += d->x / count;
    v_mean += d->v / count;
  }
  Mat<D> xx = Mat<D>::Zero(), vx = Mat<D>::Zero();
  for (const MeasuredBody<D>* d : disks) {
    const Vec<D> x = d->x - x_mean;
    xx += x * x.transpose();
    vx += (d->v - v_mean) * x.transpose();
  }
  double scale = xx.trace() * xx.trace();
  if (D == 3) scale *= xx.trace();
  if (!(std::abs(xx.determinant()) > 1e-12 * scale)) return undefined;
  return vx * xx.inverse();
}

/// Mean diameter, of spheres of the same volumes, and density; 2D needs neither.
void observe_grains(const State<3>& placed, const ObservableChoice<3>& choice,
                    Observables<3>& seen) {
  double mass = 0, volume = 0;
  for (const MeasuredBody<3>& body : measured_bodies(placed).list) {
    if (!in_window<3>(choice, body.x)) continue;
    seen.mean_diameter += 2 * std::cbrt(0.75 * body.size / std::numbers::pi) / seen.bodies;
    mass += body.mass;
    volume += body.size;
  }
  seen.density = mass / volume;
}

/// Part of the window that the bodies cover.
template <int D>
double disks_area(const State<D>& placed, const MeasuredBodies<D>& bodies,
                  const ObservableChoice<D>& choice) {
  double sum = 0;
  if (!choice.window) {
    for (const MeasuredBody<D>& body : bodies.list) sum += body.size;
    return sum;
  }
  const std::vector<CellNumber> images =
      images_over(placed.cell, extent_of_bodies(placed), choice.window->flat());
  for (const MeasuredBody<D>& body : bodies.list) {
    for (const auto& [kx, ky] : images) {
      const Vec<D> shift = in_dimensions<D>(placed.cell.shift(kx, ky));
      sum += part_in_box<D>(placed, body, shift, *choice.window);
    }
  }
  return sum;
}

/// Contacts: coordination, sliding, fabric.
template <int D>
void observe_contacts(const State<D>& placed, const MeasuredBodies<D>& bodies,
                      const ObservableChoice<D>& choice, const std::vector<bool>& rattles,
                      Observables<D>& seen) {
  std::vector<bool> counted(placed.bodies.size());
  for (const MeasuredBody<D>& body : bodies.list) {
    if (!in_window<D>(choice, body.x)) continue;
    for (const std::size_t i : body.parts) counted[i] = true;
    ++seen.bodies;
    seen.rattlers += rattles[body.parts.front()] ? 1 : 0;
    seen.mean_mass += body.mass;
  }
  seen.mean_mass /= seen.bodies;
  int ends = 0, held_ends = 0;
  for (const ContactOutcome<D>& o : placed.contacts) {
    if (!o.loaded()) continue;
    const std::size_t i = to_size(o.contact.i), j = to_size(o.contact.j);
    const bool with_disk = j < placed.bodies.size();
    const bool loose = rattles[i] || (with_disk && rattles[j]);
    const int here = (counted[i] ? 1 : 0) + (with_disk && counted[j] ? 1 : 0);
    ends += here;
    if (!loose) held_ends += here;
    if (!in_window<D>(choice, touching_point(placed, o.contact))) continue;
    ++seen.contacts;
    seen.sliding += o.status == ContactStatus::kSlip ? 1 : 0;
    seen.fabric += o.contact.n * o.contact.n.transpose();
  }
  const int held = seen.bodies - seen.rattlers;
  seen.coordination = seen.bodies > 0 ? static_cast<double>(ends) / seen.bodies : kNaN;
  seen.coordination_without = held > 0 ? static_cast<double>(held_ends) / held : kNaN;
  if (seen.contacts > 0) {
    seen.fabric /= seen.contacts;
  } else {
    seen.fabric.setConstant(kNaN);
  }
}

/// Beside hollow cylinders, which cut the bins themselves: on the axes across them the section ends
/// a little beyond.
void cut_by_cylinders(const State<3>& placed, double step, Box<3>& section) {
  for (const Wall<3>& w : placed.walls) {
    if (w.shape != Wall<3>::Shape::kHollowCircle || !w.present) continue;
    for (int k = 0; k < 3; ++k) {
      if (std::abs(w.normal[k]) > 1e-12) continue;  // it goes on there
      const double at = w.a[k] - 0.5 * step * w.v[k], beyond = 1.01 * w.radius;
      section.lower[k] = std::max(section.lower[k], at - beyond);
      section.upper[k] = std::min(section.upper[k], at + beyond);
    }
  }
}
void cut_by_cylinders(const State<2>&, double, Box<2>&) {}

/// Ends of the bins of a profile across its axis: those of the window, the cell, the region that
/// half-planes and, in 3D, hollow cylinders leave, or the disks.
template <int D>
Box<D> profile_section(const State<D>& placed, double step, const ObservableChoice<D>& choice) {
  if (choice.window) return *choice.window;
  Box<D> bodies{Vec<D>::Constant(kInfinity), Vec<D>::Constant(-kInfinity)};
  for (const Body<D>& d : placed.bodies) bodies.include(d.x, d.radius);
  Box<D> section{Vec<D>::Constant(-kInfinity), Vec<D>::Constant(kInfinity)};
  cut_by_cylinders(placed, step, section);
  for (int k = 0; k < D; ++k) {
    if (!std::isfinite(section.lower[k])) section.lower[k] = bodies.lower[k];
    if (!std::isfinite(section.upper[k])) section.upper[k] = bodies.upper[k];
  }
  for (const Wall<D>& w : placed.walls) {
    if (w.shape != Wall<D>::Shape::kHalfPlane || !w.present) continue;
    for (int k = 0; k < D; ++k) {
      if (std::abs(w.normal[k]) < 1 - 1e-12) continue;
      const double at = w.a[k] - 0.5 * step * w.v[k];
      if (w.normal[k] > 0) section.lower[k] = at;
      if (w.normal[k] < 0) section.upper[k] = at;
    }
  }
  for (int k = 0; k < 2; ++k) {
    if (k == 0 ? !placed.cell.periodic() : !placed.cell.in_y) continue;
    section.lower[k] = 0;
    section.upper[k] = placed.cell.side(k).length;
  }
  return section;
}

/// Area or volume of a bin outside of hollow cylinders, which is cut off.
double cut_size(const State<3>& placed, double step, const Box<3>& bin) {
  ConvexBody body(bin.lower, bin.upper);
  for (const Wall<3>& w : placed.walls) {
    if (w.present && w.shape == Wall<3>::Shape::kHollowCircle) {
      clip_by_cylinder(body, w.a - 0.5 * step * w.v, w);
    }
  }
  return body.volume();
}

}  // namespace

template <int D>
double Observables<D>::shear_rate() const {
  const Mat<D> rate = 0.5 * (velocity_gradient + velocity_gradient.transpose());
  const Mat<D> deviator = rate - rate.trace() / D * Mat<D>::Identity();
  return std::sqrt(2 * deviator.squaredNorm());
}

template <int D>
double Observables<D>::inertial_number() const {
  if (D == 2) return shear_rate() * std::sqrt(mean_mass / stress.pressure());
  return shear_rate() * mean_diameter * std::sqrt(density / stress.pressure());
}

template <int D>
double stress_ratio(const Mat<D>& stress) {
  if constexpr (D == 2) {
    return anisotropy(stress);
  } else {
    const double pressure = stress.trace() / 3;
    if (pressure == 0) return kNaN;
    const Mat<3> deviator = 0.5 * (stress + stress.transpose()) - pressure * Mat<3>::Identity();
    return std::sqrt(0.5 * deviator.squaredNorm()) / std::abs(pressure);
  }
}

template <int D>
std::vector<bool> find_rattlers(const Scene<D>& scene, const State<D>& state) {
  const bool gravity = !scene.gravity.isZero(0);
  const int needed = scene.has_friction() ? 2 : gravity ? D : D + 1;
  const MeasuredBodies<D> bodies = measured_bodies(state);
  std::vector<int> held(bodies.list.size(), 0);
  std::vector<std::vector<std::size_t>> neighbours(bodies.list.size());
  for (const ContactOutcome<D>& o : state.contacts) {
    if (!o.loaded()) continue;
    const std::size_t j = to_size(o.contact.j);
    const int a = bodies.of_disk[to_size(o.contact.i)];
    const int b = j < state.bodies.size() ? bodies.of_disk[j] : -1;
    for (const auto& [one, other] : {std::pair(a, b), std::pair(b, a)}) {
      if (one < 0) continue;
      ++held[to_size(one)];
      if (other >= 0) neighbours[to_size(one)].push_back(to_size(other));
    }
  }
  std::vector<bool> rattles(state.bodies.size(), false);
  std::vector<std::size_t> loose;
  const auto let_go = [&](std::size_t body) {
    const std::vector<std::size_t>& parts = bodies.list[body].parts;
    if (rattles[parts.front()] || held[body] >= needed) return;
    for (const std::size_t i : parts) rattles[i] = true;
    loose.push_back(body);
  };
  for (std::size_t i = 0; i < bodies.list.size(); ++i) let_go(i);
  while (!loose.empty()) {
    const std::size_t i = loose.back();
    loose.pop_back();
    for (const std::size_t j : neighbours[i]) {
      --held[j];
      let_go(j);
    }
  }
  return rattles;
}

template <int D>
Observables<D> observe(const Scene<D>& scene, const State<D>& state,
                       const std::type_identity_t<ObservableChoice<D>>& choice) {
  Observables<D> seen;
  const State<D> placed = wrapped_state(state);
  const MeasuredBodies<D> bodies = measured_bodies(placed);
  observe_contacts<D>(placed, bodies, choice, find_rattlers(scene, state), seen);
  if constexpr (D == 3) observe_grains(placed, choice, seen);
  const std::vector<Spin<D>> moments = contact_moments(state);
  double area = 0;
  if (choice.window) {
    const Box<D>& window = *choice.window;
    area = window.size().prod();
    if (!(window.size().minCoeff() > 0)) {
      throw std::invalid_argument(D == 2 ? "the window has no area" : "the window has no volume");
    }
    seen.stress = window_stress<D>(placed, scene.step, window, moments);
  } else {
    area = sample_measure(state, scene.step);
    seen.stress = sample_stress<D>(state, scene.step, area, moments);
  }
  seen.solid_fraction = disks_area<D>(placed, bodies, choice) / area;
  std::vector<const MeasuredBody<D>*> measured;
  for (const MeasuredBody<D>& body : bodies.list) {
    if (in_window<D>(choice, body.x)) measured.push_back(&body);
  }
  seen.velocity_gradient = fitted_gradient<D>(measured);
  return seen;
}

template <int D>
Profile<D> observe_profile(const State<D>& state, double step,
                           const std::type_identity_t<ObservableChoice<D>>& choice) {
  const ProfileChoice& chosen = choice.profile.value();
  const State<D> placed = wrapped_state(state);
  const double width = (chosen.high - chosen.low) / chosen.bins;
  const Box<D> section = profile_section(placed, step, choice);
  const auto a = static_cast<Eigen::Index>(chosen.axis);
  const auto box_of = [&](int bin) {
    Box<D> box = section;
    box.lower[a] = chosen.low + bin * width;
    box.upper[a] = box.lower[a] + width;
    return box;
  };
  Profile<D> profile;
  const std::size_t bins = to_size(chosen.bins);
  std::vector<double> area(bins, 0.0), square(bins, 0.0);
  profile.velocity.assign(bins, Vec<D>::Zero());
  profile.spin.assign(bins, no_turn<D>());
  const auto bin_at = [&](double at) {
    const double bin = std::floor((at - chosen.low) / width);
    return static_cast<int>(std::clamp(bin, -1.0, static_cast<double>(chosen.bins)));
  };
  Box<D> whole = section;
  whole.lower[a] = chosen.low;
  whole.upper[a] = chosen.high;
  const std::vector<CellNumber> images =
      images_over(placed.cell, extent_of_bodies(placed), whole.flat());
  for (const MeasuredBody<D>& body : measured_bodies(placed).list) {
    double lowest = kInfinity, highest = -kInfinity;
    for (const std::size_t i : body.parts) {
      lowest = std::min(lowest, placed.bodies[i].x[a] - placed.bodies[i].radius);
      highest = std::max(highest, placed.bodies[i].x[a] + placed.bodies[i].radius);
    }
    for (const auto& [kx, ky] : images) {
      const Vec<D> shift = in_dimensions<D>(placed.cell.shift(kx, ky));
      const Vec<D> v = body.v + in_dimensions<D>(placed.cell.shift_velocity(kx, ky));
      const int first = std::max(0, bin_at(lowest + shift[a]));
      const int last = std::min(chosen.bins - 1, bin_at(highest + shift[a]));
      for (int bin = first; bin <= last; ++bin) {
        const double part = part_in_box<D>(placed, body, shift, box_of(bin));
        const std::size_t b = to_size(bin);
        area[b] += part;
        profile.velocity[b] += part * v;
        profile.spin[b] += part * body.spin;
        square[b] += part * v.squaredNorm();
      }
    }
  }
  const std::vector<Spin<D>> moments = contact_moments(state);
  for (std::size_t b = 0; b < bins; ++b) {
    const Box<D> box = box_of(static_cast<int>(b));
    Vec<D> extent = box.size();
    extent[a] = width;
    double size = extent.prod();
    if constexpr (D == 3) {
      if (!choice.window) size = cut_size(placed, step, box);
    }
    profile.position.push_back(chosen.low + (static_cast<double>(b) + 0.5) * width);
    profile.solid_fraction.push_back(area[b] / size);
    const double weight = area[b] > 0 ? area[b] : kNaN;
    profile.velocity[b] /= weight;
    profile.spin[b] /= weight;
    double spread = square[b] / weight;
    for (int k = 0; k < D; ++k) spread -= profile.velocity[b][k] * profile.velocity[b][k];
    profile.temperature.push_back(area[b] > 0 ? std::max(0.0, spread / D) : kNaN);
    profile.stress.push_back(window_stress<D>(placed, step, box, moments).total() *
                             (box.size().prod() / size));
  }
  return profile;
}

double mass_flux(const State<2>& state, const FluxLine& line) {
  const State<2> placed = wrapped_state(state);
  const Vec2 along = (line.b - line.a).normalized();
  const Vec2 left(-along[1], along[0]);
  const double length = (line.b - line.a).norm();
  double flux = 0;
  std::vector<std::pair<double, double>> chords;  // of the line in the body's disks
  Box<2> ends;
  ends.include(line.a);
  ends.include(line.b);
  const std::vector<CellNumber> images = images_over(placed.cell, extent_of_bodies(placed), ends);
  for (const MeasuredBody<2>& body : measured_bodies(placed).list) {
    for (const auto& [kx, ky] : images) {
      const Vec2 shift = placed.cell.shift(kx, ky);
      const double across = (body.v + placed.cell.shift_velocity(kx, ky)).dot(left);
      chords.clear();
      for (const std::size_t i : body.parts) {
        const Disk& d = placed.bodies[i];
        const Vec2 x = d.x + shift - line.a;
        const double off = x.dot(left);
        if (std::abs(off) >= d.radius) continue;
        const double half = std::sqrt(d.radius * d.radius - off * off), at = x.dot(along);
        const double last = std::min(at + half, length), first = std::max(at - half, 0.0);
        if (last - first > 0) chords.emplace_back(first, last);
      }
      if (chords.empty()) continue;
      const double density = body.mass / body.size;
      if (body.parts.size() == 1) {
        flux += density * (chords[0].second - chords[0].first) * across;
        continue;
      }
      // Overlaps count once. A point at s along the line crosses it with v + spin (s - s_centre).
      std::sort(chords.begin(), chords.end());
      const double centre = (body.x + shift - line.a).dot(along);
      double reached = -kInfinity;
      for (const auto& [begin, last] : chords) {
        const double first = std::max(begin, reached);
        reached = std::max(reached, last);
        if (!(last > first)) continue;
        flux += density * (last - first) * (across + body.spin * (0.5 * (first + last) - centre));
      }
    }
  }
  return flux;
}

double mass_flux(const State<3>& state, const FluxFace& face) {
  const State<3> placed = wrapped_state(state);
  const Vec3 across = face.normal.cross(face.along);
  Box<2> rectangle{-0.5 * face.size, 0.5 * face.size};
  if (face.shape == FluxFace::Shape::kPlane) {
    rectangle = {Vec2::Constant(-kInfinity), Vec2::Constant(kInfinity)};
    for (int axis = 0; axis < 2; ++axis) {  // of the cell
      if (axis == 0 ? !placed.cell.in_x : !placed.cell.in_y) continue;
      const double length = placed.cell.side(axis).length;
      for (const int side : {0, 1}) {
        const double sign = (side == 0 ? face.along : across)[axis];
        if (sign == 0) continue;  // the normal lies along this axis
        rectangle.lower[side] = sign > 0 ? -face.point[axis] : face.point[axis] - length;
        rectangle.upper[side] = rectangle.lower[side] + length;
      }
    }
  }
  double flux = 0;
  // A plane has the part of one cell.
  const double half = face.shape == FluxFace::Shape::kPlane  ? placed.cell.shift(1, 1).norm()
                      : face.shape == FluxFace::Shape::kDisk ? face.radius
                                                             : 0.5 * face.size.norm();
  Box<2> region;
  region.include(face.point.head<2>(), half);
  const std::vector<CellNumber> images = images_over(placed.cell, extent_of_bodies(placed), region);
  for (const Sphere& s : placed.bodies) {
    for (const auto& [kx, ky] : images) {
      const Vec3 x = s.x + in_dimensions<3>(placed.cell.shift(kx, ky)) - face.point;
      const Vec3 v = s.v + in_dimensions<3>(placed.cell.shift_velocity(kx, ky));
      const double off = x.dot(face.normal);
      if (std::abs(off) >= s.radius) continue;
      const double section = std::sqrt(s.radius * s.radius - off * off);  // a disk
      const Vec2 at(x.dot(face.along), x.dot(across));
      const double area = face.shape == FluxFace::Shape::kDisk
                              ? area_in_disk(at.norm(), section, face.radius)
                              : part_in_box(at, section, rectangle);
      flux +=
          s.mass / (4 * std::numbers::pi / 3 * std::pow(s.radius, 3)) * area * v.dot(face.normal);
    }
  }
  return flux;
}

template <int D>
ForceDistribution observe_forces(const State<D>& state, double step,
                                 const std::type_identity_t<ObservableChoice<D>>& choice) {
  ForceDistribution forces;
  forces.counts.assign(to_size(choice.force_bins), 0);
  const State<D> placed = wrapped_state(state);
  std::vector<double> loaded;
  for (const ContactOutcome<D>& o : placed.contacts) {
    if (!o.loaded()) continue;
    if (!in_window<D>(choice, touching_point(placed, o.contact))) continue;
    loaded.push_back(std::abs(o.s_n) / step);
    forces.mean += loaded.back();
  }
  if (loaded.empty()) return forces;
  forces.mean /= static_cast<double>(loaded.size());
  for (const double f : loaded) {
    const double bin = f / forces.mean / choice.force_limit * choice.force_bins;
    ++forces.counts[to_size(static_cast<int>(std::min(choice.force_bins - 1.0, bin)))];
  }
  return forces;
}

template struct Observables<2>;
template struct Observables<3>;
template double stress_ratio<2>(const Mat2&);
template double stress_ratio<3>(const Mat<3>&);
template Observables<2> observe(const Scene<2>&, const State<2>&, const ObservableChoice<2>&);
template Observables<3> observe(const Scene<3>&, const State<3>&, const ObservableChoice<3>&);
template std::vector<bool> find_rattlers(const Scene<2>&, const State<2>&);
template std::vector<bool> find_rattlers(const Scene<3>&, const State<3>&);
template Profile<2> observe_profile(const State<2>&, double, const ObservableChoice<2>&);
template Profile<3> observe_profile(const State<3>&, double, const ObservableChoice<3>&);
template ForceDistribution observe_forces(const State<2>&, double, const ObservableChoice<2>&);
template ForceDistribution observe_forces(const State<3>&, double, const ObservableChoice<3>&);

}  // namespace bipot
