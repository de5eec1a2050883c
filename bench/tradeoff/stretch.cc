#include "bench/tradeoff/stretch.h"

#include "core/motion/population.h"
#include "core/observables/measured_bodies.h"
#include "core/observables/observables.h"
#include "core/scene/contact_detection.h"

namespace bipot {
namespace {

template <int D>
Vec3 in_space(const Vec<D>& v) {
  Vec3 wide = Vec3::Zero();
  wide.template head<D>() = v;
  return wide;
}

/// Overlap of each overlapping pair over the smaller radius, by the numbers of the bodies; walls:
/// -1 - wall.
using Overlaps = std::map<std::pair<int, int>, double>;
template <int D>
int number_of(const State<D>& state, int body) {
  const int bodies = static_cast<int>(state.bodies.size());
  return body < bodies ? body_number(state, body) : bodies - 1 - body;
}
template <int D>
Overlaps overlaps_of(const State<D>& state) {
  Overlaps overlaps;
  for (const Contact<D>& c : detect_contacts<D>(state.bodies, state.walls, 0)) {
    if (c.gap >= 0) continue;
    const std::size_t j = to_size(c.j);
    double radius = state.bodies[to_size(c.i)].radius;
    if (j < state.bodies.size()) radius = std::min(radius, state.bodies[j].radius);
    overlaps[{number_of(state, c.i), number_of(state, c.j)}] = -c.gap / radius;
  }
  return overlaps;
}

/// Momentum of each body, by the number of its first disk or sphere, and its mass.
template <int D>
std::map<int, std::pair<Vec<D>, double>> momenta(const State<D>& state) {
  std::map<int, std::pair<Vec<D>, double>> all;
  for (const MeasuredBody<D>& body : measured_bodies(state).list) {
    all[body_number(state, static_cast<int>(body.parts.front()))] = {body.mass * body.v, body.mass};
  }
  return all;
}

/// Adds the impulses on the walls, those of their glued disks included, over h.
template <int D>
void add_loads(const State<D>& state, double weight, std::vector<Vec3>& load) {
  for (const ContactOutcome<D>& o : state.contacts) {
    const int wall = wall_of(state.bodies, o.contact.j);
    if (wall < 0) continue;
    const Vec<D> impulse = o.s_n * o.contact.n + tangent_vector(o.contact.n, o.s_t);
    load[to_size(wall)] -= weight * in_space<D>(impulse);
  }
}

template <int D>
double loaded_contacts(const State<D>& state) {
  const int bodies = static_cast<int>(state.bodies.size());
  double ends = 0;
  for (const ContactOutcome<D>& o : state.contacts) {
    if (o.s_n > 0) ends += o.contact.j < bodies ? 2 : 1;
  }
  return bodies > 0 ? ends / bodies : 0;
}

}  // namespace

template <int D>
int stretch_steps(const Scene<D>& scene, double asked) {
  const double seconds = asked > 0 ? asked : scene.num_steps * scene.step / 50;
  return 4 * std::max(4, static_cast<int>(std::lround(seconds / scene.step / 4)));
}

template <int D>
StretchSample run_stretch(const Scene<D>& whole, State<D> state, int steps,
                          const RunSetting& setting, const RunLimits& limits) {
  Scene<D> scene = whole;
  scene.num_steps = steps;
  const int planned = steps_of(steps, setting);
  const double h = scene.step * setting.step_factor;
  StretchSample sample;
  sample.load.assign(state.walls.size(), Vec3::Zero());
  const double before = state.friction_loss + state.shock_loss;
  const Overlaps overlaps = overlaps_of(state);
  auto moving = momenta(state);
  for (const auto& [number, body] : moving) sample.force[number] = Vec3::Zero();
  std::vector<Wall<D>> walls = state.walls;
  double weights = 0;
  Mat<D> stress = Mat<D>::Zero();
  int k = 0;
  RunObserver<D> observer;
  observer.on_step = [&](const SceneStep<D>& step) {
    const State<D>& now = step.state;
    const double weight = 1 - std::abs((2.0 * k + 1) / planned - 1);
    weights += weight * h;
    const Vec<D> gravity = gravity_at(scene, now.time - 0.5 * h);
    auto after = momenta(now);
    std::erase_if(sample.force,
                  [&](const auto& f) { return f.first >= 0 && !after.contains(f.first); });
    for (auto& [number, force] : sample.force) {
      if (number < 0) continue;
      const auto& [p, mass] = after.at(number);
      force += weight * in_space<D>(p - moving.at(number).first - h * mass * gravity);
    }
    for (std::size_t w = 0; w < now.walls.size(); ++w) {
      const Wall<D>& wall = now.walls[w];
      if (wall.motion != Wall<D>::Motion::kDriven) continue;
      sample.force.try_emplace(-1 - static_cast<int>(w), Vec3::Zero()).first->second +=
          weight * in_space<D>(wall.mass * (wall.v - walls[w].v) - h * wall.force * wall.direction);
    }
    add_loads(now, weight, sample.load);
    sample.coordination += weight * h * loaded_contacts(now);
    if (!now.bodies.empty()) {
      stress += weight * sample_stress(now, h, 1, contact_moments(now)).total();
    }
    for (const auto& [pair, overlap] : overlaps_of(now)) {
      const auto old = overlaps.find(pair);
      sample.penetration =
          std::max(sample.penetration, overlap - (old == overlaps.end() ? 0 : old->second));
    }
    moving = std::move(after);
    walls = now.walls;
    ++k;
    return true;
  };
  sample.run = run_setting(scene, state, setting, limits, observer);
  for (auto& [number, force] : sample.force) force /= weights;
  for (Vec3& load : sample.load) load /= weights;
  sample.coordination /= weights;
  sample.stress_ratio = stress_ratio<D>(stress);
  sample.dissipated = state.friction_loss + state.shock_loss - before;
  return sample;
}

template <int D>
double energy_floor(const Scene<D>& scene, const State<D>& state) {
  double weight = 0;
  for (const auto& body : measured_bodies(state).list) weight += body.mass * scene.gravity.norm();
  return 1e-3 * std::max(kinetic_energy(state), weight * smallest_radius(scene));
}

namespace {

/// The mean of the differences of each stretch over the scale of all, and twice its standard error.
struct MeanDifference {
  std::vector<Vec3> each;
  double scale = 0;  // sum over the stretches

  void write(double& error, double& bar) const {
    if (!(scale > 0)) return;
    Vec3 sum = Vec3::Zero();
    for (const Vec3& x : each) sum += x;
    const auto n = static_cast<double>(each.size());
    double squares = 0;
    for (const Vec3& x : each) squares += (x - sum / n).squaredNorm();
    error = sum.norm() / scale;
    bar = n > 1 ? 2 * std::sqrt(n / (n - 1) * squares) / scale : kInfinity;
  }
};

}  // namespace

MeasuredError stretch_errors(const std::vector<StretchSample>& samples,
                             const std::vector<StretchSample>& reference, double floor,
                             std::size_t first) {
  MeasuredError measured;
  Accuracy &error = measured.error, &bar = measured.bar;
  MeanDifference energy, contacts, ratio;
  std::vector<MeanDifference> loads(reference.front().load.size());
  std::vector<Vec3> total(loads.size(), Vec3::Zero());
  const auto add = [](MeanDifference& to, double a, double b) {
    to.each.emplace_back(a - b, 0, 0);
    to.scale += std::abs(b);
  };
  for (std::size_t w = 0; w < samples.size(); ++w) {
    const StretchSample &a = samples[w], &b = reference[w];
    double apart = 0, largest = 0;
    for (const auto& [number, force] : b.force) {
      largest = std::max(largest, force.norm());
      if (const auto other = a.force.find(number); other != a.force.end()) {
        apart = std::max(apart, (other->second - force).norm());
      }
    }
    if (largest > 0) error.force = std::fmax(error.force, apart / largest);
    error.penetration = std::fmax(error.penetration, a.penetration);
    if (w < first) continue;
    add(energy, a.dissipated, b.dissipated);
    add(contacts, a.coordination, b.coordination);
    if (std::isfinite(a.stress_ratio) && std::isfinite(b.stress_ratio)) {
      add(ratio, a.stress_ratio, b.stress_ratio);
    }
    for (std::size_t k = 0; k < loads.size(); ++k) {
      loads[k].each.push_back(a.load[k] - b.load[k]);
      total[k] += b.load[k];
    }
  }
  energy.scale = std::max(energy.scale, floor);
  energy.write(error.energy, bar.energy);
  contacts.write(error.coordination, bar.coordination);
  ratio.write(error.stress_ratio, bar.stress_ratio);
  double largest = 0;
  for (const Vec3& load : total) largest = std::max(largest, load.norm());
  for (MeanDifference& load : loads) {
    MeasuredError one;
    load.scale = largest;
    load.write(one.error.load, one.bar.load);
    if (!(one.bound().load <= measured.bound().load)) {
      error.load = one.error.load;
      bar.load = one.bar.load;
    }
  }
  return measured;
}

MeasuredError added_errors(const std::vector<StretchSample>& samples,
                           const std::vector<StretchSample>& reference, double floor,
                           std::size_t first) {
  MeasuredError measured = stretch_errors(samples, reference, floor, first);
  double& added = measured.error.penetration;
  added = 0;
  for (std::size_t w = 0; w < samples.size(); ++w) {
    added = std::max(added, samples[w].penetration - reference[w].penetration);
  }
  return measured;
}

template int stretch_steps(const Scene<2>&, double);
template int stretch_steps(const Scene<3>&, double);
template StretchSample run_stretch(const Scene<2>&, State<2>, int, const RunSetting&,
                                   const RunLimits&);
template StretchSample run_stretch(const Scene<3>&, State<3>, int, const RunSetting&,
                                   const RunLimits&);
template double energy_floor(const Scene<2>&, const State<2>&);
template double energy_floor(const Scene<3>&, const State<3>&);

}  // namespace bipot
