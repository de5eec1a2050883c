#include "core/observables/observables.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "core/motion/periodic_state.h"
#include "core/motion/sample_volume.h"

namespace bipot {
namespace {

/// Area of the unit disk with X > x.
double cap(double x) {
  x = std::clamp(x, -1.0, 1.0);
  return std::acos(x) - x * std::sqrt(1 - x * x);
}

/// Area of the unit disk with X < x and Y < y.
double corner(double x, double y) {
  x = std::clamp(x, -1.0, 1.0);
  y = std::clamp(y, -1.0, 1.0);
  if (x * x + y * y >= 1) {  // the corner lies outside of the disk
    if (x < 0 && y < 0) return 0;
    if (x >= 0 && y >= 0) return std::numbers::pi - cap(x) - cap(y);
    return x < 0 ? cap(-x) : cap(-y);
  }
  // Between the chord at Y = y and the lower half, from the chord's left end on.
  const double end = std::sqrt(1 - y * y);
  const auto primitive = [](double t) { return 0.5 * (t * std::sqrt(1 - t * t) + std::asin(t)); };
  const double between = y * (x + end) + primitive(x) - primitive(-end);
  return y >= 0 ? cap(end) + between : between;
}

bool inside(const Vec2& x, const Vec2& low, const Vec2& high) {
  return (x.array() >= low.array()).all() && (x.array() < high.array()).all();
}

bool in_window(const ObservableChoice& choice, const Vec2& x) {
  return !choice.window || inside(x, choice.window->first, choice.window->second);
}

/// In space there are no windows.
bool in_window(const ObservableChoice& /*choice*/, const Vec3& /*x*/) { return true; }

/// The states's disks where they can be compared with places.
template <int D>
StateIn<D> in_place(const StateIn<D>& state) {
  return state.cell.periodic() ? wrapped_state(state) : state;
}

/// Least squares fit v = v0 + L x.
template <int D>
MatIn<D> fitted_gradient(const std::vector<const BodyIn<D>*>& disks) {
  const MatIn<D> undefined = MatIn<D>::Constant(kNaN);
  if (disks.size() < D + 1) return undefined;
  VecIn<D> x_mean = VecIn<D>::Zero(), v_mean = VecIn<D>::Zero();
  const double count = static_cast<double>(disks.size());
  for (const BodyIn<D>* d : disks) {
    x_mean += d->x / count;
    v_mean += d->v / count;
  }
  MatIn<D> xx = MatIn<D>::Zero(), vx = MatIn<D>::Zero();
  for (const BodyIn<D>* d : disks) {
    const VecIn<D> x = d->x - x_mean;
    xx += x * x.transpose();
    vx += (d->v - v_mean) * x.transpose();
  }
  double scale = xx.trace() * xx.trace();
  if (D == 3) scale *= xx.trace();
  if (!(std::abs(xx.determinant()) > 1e-12 * scale)) return undefined;
  return vx * xx.inverse();
}

double volume_of(const Sphere& s) {
  return 4 * std::numbers::pi / 3 * s.radius * s.radius * s.radius;
}

/// What the spheres take up.
double disks_area(const StateIn<3>& placed, const ObservableChoice& /*choice*/) {
  double sum = 0;
  for (const Sphere& s : placed.disks) {
    if (s.wall < 0) sum += volume_of(s);
  }
  return sum;
}

/// Mean diameter and density of the spheres; in the plane neither is asked for.
void observe_grains(const State& /*placed*/, Observables& /*seen*/) {}
void observe_grains(const StateIn<3>& placed, ObservablesIn<3>& seen) {
  double mass = 0;
  for (const Sphere& s : placed.disks) {
    if (s.wall >= 0) continue;
    seen.mean_diameter += 2 * s.radius / seen.disks;
    mass += s.mass;
  }
  seen.density = mass / disks_area(placed, {});
}

double disks_area(const State& placed, const ObservableChoice& choice) {
  double sum = 0;
  for (const Disk& d : placed.disks) {
    if (d.wall >= 0) continue;
    if (!choice.window) {
      sum += std::numbers::pi * d.radius * d.radius;
      continue;
    }
    for (const Vec2& shift : image_shifts(placed.cell)) {
      sum += area_in_rectangle(d.x + shift, d.radius, choice.window->first, choice.window->second);
    }
  }
  return sum;
}

/// Contacts: coordination, sliding, fabric.
template <int D>
void observe_contacts(const StateIn<D>& placed, const ObservableChoice& choice,
                      const std::vector<bool>& rattles, ObservablesIn<D>& seen) {
  std::vector<bool> counted(placed.disks.size());
  for (std::size_t i = 0; i < placed.disks.size(); ++i) {
    counted[i] = placed.disks[i].wall < 0 && in_window(choice, placed.disks[i].x);
    if (!counted[i]) continue;
    ++seen.disks;
    seen.rattlers += rattles[i] ? 1 : 0;
    seen.mean_mass += placed.disks[i].mass;
  }
  seen.mean_mass /= seen.disks;
  int ends = 0, held_ends = 0;
  for (const ContactOutcomeIn<D>& o : placed.contacts) {
    if (!(o.s_n > 0)) continue;
    const std::size_t i = to_size(o.contact.i), j = to_size(o.contact.j);
    const bool with_disk = j < placed.disks.size();
    const bool loose = rattles[i] || (with_disk && rattles[j]);
    const int here = (counted[i] ? 1 : 0) + (with_disk && counted[j] ? 1 : 0);
    ends += here;
    if (!loose) held_ends += here;
    if constexpr (D == 2) {
      const Disk& d = placed.disks[i];
      Vec2 point = d.x - d.radius * o.contact.n;
      if (placed.cell.periodic()) point = wrapped(placed.cell, point);
      if (!in_window(choice, point)) continue;
    }
    ++seen.contacts;
    seen.sliding += o.status == ContactStatus::kSlip ? 1 : 0;
    seen.fabric += o.contact.n * o.contact.n.transpose();
  }
  const int held = seen.disks - seen.rattlers;
  seen.coordination = seen.disks > 0 ? static_cast<double>(ends) / seen.disks : kNaN;
  seen.coordination_without = held > 0 ? static_cast<double>(held_ends) / held : kNaN;
  if (seen.contacts > 0) {
    seen.fabric /= seen.contacts;
  } else {
    seen.fabric.setConstant(kNaN);
  }
}

}  // namespace

double area_in_rectangle(const Vec2& x, double radius, const Vec2& low, const Vec2& high) {
  const Vec2 a = (low - x) / radius, b = (high - x) / radius;
  const double unit =
      corner(b[0], b[1]) - corner(a[0], b[1]) - corner(b[0], a[1]) + corner(a[0], a[1]);
  return radius * radius * std::max(0.0, unit);
}

template <int D>
double ObservablesIn<D>::sliding_share() const {
  return contacts > 0 ? static_cast<double>(sliding) / contacts : kNaN;
}

template <int D>
double ObservablesIn<D>::shear_rate() const {
  const MatIn<D> rate = 0.5 * (velocity_gradient + velocity_gradient.transpose());
  const MatIn<D> deviator = rate - rate.trace() / D * MatIn<D>::Identity();
  return std::sqrt(2 * deviator.squaredNorm());
}

template <int D>
double ObservablesIn<D>::inertial_number() const {
  if (D == 2) return shear_rate() * std::sqrt(mean_mass / stress.pressure());
  return shear_rate() * mean_diameter * std::sqrt(density / stress.pressure());
}

template <int D>
double ObservablesIn<D>::friction() const {
  return stress_ratio<D>(stress.total());
}

template <int D>
double stress_ratio(const MatIn<D>& stress) {
  if constexpr (D == 2) {
    return anisotropy(stress);
  } else {
    const double pressure = stress.trace() / 3;
    if (pressure == 0) return kNaN;
    const MatIn<3> deviator = 0.5 * (stress + stress.transpose()) - pressure * MatIn<3>::Identity();
    return std::sqrt(0.5 * deviator.squaredNorm()) / std::abs(pressure);
  }
}

template <int D>
std::vector<bool> find_rattlers(const SceneIn<D>& scene, const StateIn<D>& state) {
  const bool gravity = !scene.gravity.isZero(0);
  const int needed = scene.has_friction() ? 2 : gravity ? D : D + 1;
  const std::size_t disks = state.disks.size();
  std::vector<int> held(disks, 0);
  std::vector<std::vector<std::size_t>> neighbours(disks);
  for (const ContactOutcomeIn<D>& o : state.contacts) {
    if (!(o.s_n > 0)) continue;
    const std::size_t i = to_size(o.contact.i), j = to_size(o.contact.j);
    ++held[i];
    if (j >= disks) continue;
    ++held[j];
    neighbours[i].push_back(j);
    neighbours[j].push_back(i);
  }
  std::vector<bool> rattles(disks, false);
  std::vector<std::size_t> loose;
  const auto let_go = [&](std::size_t i) {
    if (rattles[i] || held[i] >= needed || state.disks[i].wall >= 0) return;
    rattles[i] = true;
    loose.push_back(i);
  };
  for (std::size_t i = 0; i < disks; ++i) let_go(i);
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
ObservablesIn<D> observe(const SceneIn<D>& scene, const StateIn<D>& state,
                         const ObservableChoice& choice) {
  ObservablesIn<D> seen;
  const StateIn<D> placed = in_place(state);
  observe_contacts<D>(placed, choice, find_rattlers(scene, state), seen);
  observe_grains(placed, seen);
  const std::vector<SpinIn<D>> moments = contact_moments(state);
  double area = 0;
  if (D == 2 && choice.window) {
    if constexpr (D == 2) {
      const Box window{.lower = choice.window->first, .upper = choice.window->second};
      area = window.size().prod();
      if (!(window.size().minCoeff() > 0)) throw std::invalid_argument("the window has no area");
      seen.stress = window_stress(placed, scene.step, window, moments);
    }
  } else {
    area = sample_area(state, scene.step);
    seen.stress = sample_stress<D>(state, scene.step, area, moments);
  }
  seen.solid_fraction = disks_area(placed, choice) / area;
  std::vector<const BodyIn<D>*> measured;
  for (std::size_t i = 0; i < state.disks.size(); ++i) {
    if (placed.disks[i].wall >= 0) continue;
    if (in_window(choice, placed.disks[i].x)) measured.push_back(&placed.disks[i]);
  }
  seen.velocity_gradient = fitted_gradient<D>(measured);
  return seen;
}

Profile observe_profile(const State& state, double step, const ObservableChoice& choice) {
  const ProfileChoice& chosen = choice.profile.value();
  const State placed = in_place(state);
  const std::size_t axis = to_size(chosen.axis), across = 1 - axis;
  const double width = (chosen.high - chosen.low) / chosen.bins;
  // As wide as the window, the cell, what half-planes leave, or the disks.
  Vec2 low = Vec2::Constant(kInfinity), high = Vec2::Constant(-kInfinity);
  for (const Disk& d : placed.disks) {
    low = low.cwiseMin(d.x - Vec2::Constant(d.radius));
    high = high.cwiseMax(d.x + Vec2::Constant(d.radius));
  }
  for (const Wall& w : placed.walls) {
    if (w.shape != Wall::Shape::kHalfPlane || !w.present ||
        std::abs(w.normal[static_cast<Eigen::Index>(across)]) < 1 - 1e-12)
      continue;
    const auto k = static_cast<Eigen::Index>(across);
    const double at = w.a[k] - 0.5 * step * w.v[k];
    if (w.normal[k] > 0) low[k] = at;
    if (w.normal[k] < 0) high[k] = at;
  }
  const bool periodic = placed.cell.periodic() && (across == 0 || placed.cell.in_y);
  if (periodic) {
    const auto k = static_cast<Eigen::Index>(across);
    low[k] = 0;
    high[k] = across == 0 ? placed.cell.width.length : placed.cell.height.length;
  }
  if (choice.window) {
    low = choice.window->first;
    high = choice.window->second;
  }
  Profile profile;
  const std::size_t bins = to_size(chosen.bins);
  std::vector<double> area(bins, 0.0), square(bins, 0.0);
  profile.vx.assign(bins, 0.0);
  profile.vy.assign(bins, 0.0);
  profile.spin.assign(bins, 0.0);
  const auto a = static_cast<Eigen::Index>(axis);
  for (const Disk& d : placed.disks) {
    if (d.wall >= 0) continue;
    for (const Vec2& shift : image_shifts(placed.cell)) {
      const Vec2 x = d.x + shift;
      const int first =
          std::max(0, static_cast<int>(std::floor((x[a] - d.radius - chosen.low) / width)));
      const int last = std::min(
          chosen.bins - 1, static_cast<int>(std::floor((x[a] + d.radius - chosen.low) / width)));
      for (int bin = first; bin <= last; ++bin) {
        Vec2 from = low, to = high;
        from[a] = chosen.low + bin * width;
        to[a] = from[a] + width;
        const double part = area_in_rectangle(x, d.radius, from, to);
        const std::size_t b = to_size(bin);
        area[b] += part;
        profile.vx[b] += part * d.v[0];
        profile.vy[b] += part * d.v[1];
        profile.spin[b] += part * d.spin;
        square[b] += part * d.v.squaredNorm();
      }
    }
  }
  const auto k = static_cast<Eigen::Index>(across);
  const double bin_area = width * (high[k] - low[k]);
  for (std::size_t b = 0; b < bins; ++b) {
    profile.position.push_back(chosen.low + (static_cast<double>(b) + 0.5) * width);
    profile.solid_fraction.push_back(area[b] / bin_area);
    const bool empty = !(area[b] > 0);
    for (std::vector<double>* mean : {&profile.vx, &profile.vy, &profile.spin}) {
      (*mean)[b] = empty ? kNaN : (*mean)[b] / area[b];
    }
    profile.temperature.push_back(
        empty ? kNaN
              : std::max(0.0, 0.5 * (square[b] / area[b] - profile.vx[b] * profile.vx[b] -
                                     profile.vy[b] * profile.vy[b])));
  }
  return profile;
}

double line_flux(const State& state, const FluxLine& line) {
  const State placed = in_place(state);
  const Vec2 along = (line.b - line.a).normalized();
  const Vec2 left(-along[1], along[0]);
  const double length = (line.b - line.a).norm();
  double flux = 0;
  for (const Disk& d : placed.disks) {
    for (const Vec2& shift : image_shifts(placed.cell)) {
      const Vec2 x = d.x + shift - line.a;
      const double off = x.dot(left);
      if (std::abs(off) >= d.radius) continue;
      const double half = std::sqrt(d.radius * d.radius - off * off), at = x.dot(along);
      const double chord = std::min(at + half, length) - std::max(at - half, 0.0);
      if (!(chord > 0)) continue;
      flux += d.mass / (std::numbers::pi * d.radius * d.radius) * chord * d.v.dot(left);
    }
  }
  return flux;
}

template <int D>
ForceDistribution observe_forces(const StateIn<D>& state, double step,
                                 const ObservableChoice& choice) {
  ForceDistribution forces;
  forces.counts.assign(to_size(choice.force_bins), 0);
  const StateIn<D> placed = in_place(state);
  std::vector<double> loaded;
  for (const ContactOutcomeIn<D>& o : placed.contacts) {
    if (!(o.s_n > 0)) continue;
    if constexpr (D == 2) {
      const Disk& d = placed.disks[to_size(o.contact.i)];
      Vec2 point = d.x - d.radius * o.contact.n;
      if (placed.cell.periodic()) point = wrapped(placed.cell, point);
      if (!in_window(choice, point)) continue;
    }
    loaded.push_back(o.s_n / step);
    forces.mean += loaded.back();
  }
  if (loaded.empty()) return forces;
  forces.mean /= static_cast<double>(loaded.size());
  for (const double f : loaded) {
    const double bin = f / forces.mean / choice.force_limit * choice.force_bins;
    ++forces.counts[to_size(std::min(choice.force_bins - 1, static_cast<int>(bin)))];
  }
  return forces;
}

template struct ObservablesIn<2>;
template struct ObservablesIn<3>;
template double stress_ratio<2>(const Mat2&);
template double stress_ratio<3>(const MatIn<3>&);
template Observables observe(const Scene&, const State&, const ObservableChoice&);
template ObservablesIn<3> observe(const SceneIn<3>&, const StateIn<3>&, const ObservableChoice&);
template std::vector<bool> find_rattlers(const Scene&, const State&);
template std::vector<bool> find_rattlers(const SceneIn<3>&, const StateIn<3>&);
template ForceDistribution observe_forces(const State&, double, const ObservableChoice&);
template ForceDistribution observe_forces(const StateIn<3>&, double, const ObservableChoice&);

}  // namespace bipot
