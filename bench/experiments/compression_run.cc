#include "bench/experiments/compression_run.h"

#include "bench/measure/statistics.h"
#include "core/motion/force_balance.h"

namespace bipot {
namespace {

/// The box between the four walls at mid-step, walls in the order left, right, bottom, top.
Box<2> box_of(const State<2>& state, double step) {
  const auto at = [&](std::size_t wall, int axis) {
    return state.walls[wall].a[axis] - 0.5 * step * state.walls[wall].v[axis];
  };
  return {Vec2(at(0, 0), at(2, 1)), Vec2(at(1, 0), at(3, 1))};
}

std::vector<double> window_pressures(const State<2>& state, double step, const Box<2>& box,
                                     std::span<const double> moments) {
  std::vector<double> pressures;
  const Vec2 size = box.size() / kWindows;
  for (int i = 0; i < kWindows; ++i) {
    for (int j = 0; j < kWindows; ++j) {
      const Vec2 lower = box.lower + Vec2(i * size[0], j * size[1]);
      pressures.push_back(window_stress(state, step, {lower, lower + size}, moments).pressure());
    }
  }
  return pressures;
}

/// One step of a compression, kept until its phase is known.
struct Sample {
  double kinetic = 0;
  Mat2 stress, walls, fabric_of_step;
  double wall_pressure = 0, applied_pressure = 0;
  double asymmetry = 0;
  double coordination = 0;
  std::vector<double> windows;
  State<2> contacts_only;
};

Sample measure(const Scene<2>& scene, const State<2>& before, const State<2>& after) {
  const double h = scene.step;
  Sample sample;
  const Box<2> box = box_of(after, h);
  const Vec2 size = box.size();
  const double area = size.prod();
  const std::vector<double> moments = spin_changes(before, after);
  sample.stress = sample_stress(after, h, area, moments).total();
  sample.asymmetry = asymmetry(sample.stress);
  sample.fabric_of_step = fabric_tensor(after);
  sample.coordination = coordination(after);
  sample.walls.setZero();
  const int num_disks = static_cast<int>(after.bodies.size());
  for (const ContactOutcome<2>& o : after.contacts) {
    if (o.contact.j < num_disks) continue;
    const Disk& d = after.bodies[static_cast<std::size_t>(o.contact.i)];
    const Vec2& n = o.contact.n;
    const Vec2 force = (o.s_n * n + o.s_t * Vec2(-n[1], n[0])) / h;
    const Vec2 point = d.x - 0.5 * h * d.v - (d.radius + o.contact.gap) * n;
    // Compression positive: minus the force on the disks, points from the box's centre.
    sample.walls -= force * (point - box.centre()).transpose() / area;
  }
  const std::vector<Vec2> pushes = wall_reactions(after, h);
  for (std::size_t k = 0; k < 4; ++k) {
    const double length = k < 2 ? size[1] : size[0];
    const Wall<2>& wall = scene.walls[k];
    sample.wall_pressure -= 0.25 * pushes[k].dot(wall.direction) / length;
    sample.applied_pressure += 0.25 * wall.force / length;
  }
  sample.windows = window_pressures(after, h, box, moments);
  sample.contacts_only.contacts = after.contacts;
  return sample;
}

Compression::Phase summarise(std::span<const Sample> samples) {
  Compression::Phase phase{.steps = static_cast<int>(samples.size())};
  if (samples.empty()) return phase;
  const double n = static_cast<double>(samples.size());
  std::vector<double> windows(kWindows * kWindows, 0.0);
  for (const Sample& s : samples) {
    phase.stress += s.stress / n;
    phase.walls += s.walls / n;
    phase.wall_pressure += s.wall_pressure / n;
    phase.applied_pressure += s.applied_pressure / n;
    phase.anisotropy += anisotropy(s.stress) / n;
    phase.fabric_anisotropy += anisotropy(s.fabric_of_step) / n;
    phase.asymmetry = std::max(phase.asymmetry, s.asymmetry);
    const Compression::WindowStatistics w = window_statistics(s.windows);
    phase.variation += w.variation / n;
    phase.horizontal += w.horizontal * w.horizontal / n;
    for (std::size_t k = 0; k < windows.size(); ++k) windows[k] += s.windows[k] / n;
    phase.contacts.add(s.contacts_only);
  }
  phase.horizontal = std::sqrt(phase.horizontal);
  constexpr std::size_t kBlocks = 8;
  std::vector<double> variations, sides;
  for (std::size_t b = 0; b < kBlocks && samples.size() >= kBlocks; ++b) {
    const std::size_t from = b * samples.size() / kBlocks, to = (b + 1) * samples.size() / kBlocks;
    double variation = 0, side = 0;
    for (const Sample& s : samples.subspan(from, to - from)) {
      const Compression::WindowStatistics w = window_statistics(s.windows);
      variation += w.variation / static_cast<double>(to - from);
      side += w.horizontal / static_cast<double>(to - from);
    }
    variations.push_back(variation);
    sides.push_back(side);
  }
  phase.variation_bar = mean_value(variations).confidence;
  phase.horizontal_bar = mean_value(sides).confidence;
  phase.mean_windows = window_statistics(windows);
  for (std::size_t lag = 0; lag <= kLags && lag + 1 < samples.size(); ++lag) {
    double sum = 0;
    int pairs = 0;
    for (std::size_t k = 0; k + lag < samples.size(); ++k) {
      const double correlation = force_correlation(samples[k].contacts_only.contacts,
                                                   samples[k + lag].contacts_only.contacts);
      if (std::isnan(correlation)) continue;
      sum += correlation;
      ++pairs;
    }
    phase.correlation.push_back(sum / pairs);
  }
  return phase;
}

}  // namespace

Compression::WindowStatistics window_statistics(const std::vector<double>& pressures) {
  Compression::WindowStatistics result;
  double sum = 0, squares = 0, right = 0;
  for (int i = 0; i < kWindows; ++i) {
    for (int j = 0; j < kWindows; ++j) {
      const double p = pressures[to_size(i * kWindows + j)];
      sum += p;
      squares += p * p;
      right += i < kWindows / 2 ? -p : p;
    }
  }
  const double n = static_cast<double>(pressures.size()), mean = sum / n;
  result.variation = std::sqrt(std::max(0.0, squares / n - mean * mean)) / mean;
  result.horizontal = right / sum;
  return result;
}

Compression run_compression(const Scene<2>& scene, const std::function<bool()>& interrupted) {
  Compression c{.scene = scene, .state = initial_state(scene)};
  std::vector<Sample> samples;
  int jammed_converged = 0;
  const int jammed_from = scene.num_steps - scene.num_steps / 3;  // steps after it are `jammed`
  double logarithms = 0;
  c.run = run_packing(scene, c.state, interrupted,
                      [&](const State<2>& before, const State<2>& after, const StepReport<2>& r) {
                        Sample s = measure(scene, before, after);
                        s.kinetic = r.energy.kinetic;
                        const std::vector<Vec2> pushes = wall_reactions(after, scene.step);
                        for (std::size_t k = 0; k < 4; ++k) {
                          const Wall<2>&a = before.walls[k], &b = after.walls[k];
                          const double inertia = b.mass * (b.v - a.v).dot(b.direction) / scene.step;
                          const double force = -pushes[k].dot(b.direction);
                          c.wall_balance = std::max(
                              c.wall_balance, std::abs(force - (b.force - inertia)) / b.force);
                        }
                        c.time.push_back(r.time);
                        c.pressure.push_back(0.5 * s.stress.trace());
                        c.wall_pressure.push_back(s.wall_pressure);
                        c.applied_pressure.push_back(s.applied_pressure);
                        if (r.step > jammed_from) {
                          jammed_converged += r.converged ? 1 : 0;
                          logarithms += std::log(r.error.guarded());
                        }
                        samples.push_back(std::move(s));
                        c.previous = before;
                        return true;
                      });
  double largest = 0;
  for (const Sample& s : samples) largest = std::max(largest, s.kinetic);
  std::size_t first = 0, last = 0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    // Without contacts there is nothing to compare yet.
    if (!(samples[k].kinetic > 0.1 * largest) || samples[k].stress.trace() == 0) continue;
    if (last == 0) first = k;
    last = k + 1;
  }
  const std::span<const Sample> all(samples);
  c.flow = summarise(all.subspan(first, last - first));
  const auto jammed = all.subspan(static_cast<std::size_t>(jammed_from));
  c.jammed = summarise(jammed);
  c.jammed_run.steps = c.jammed.steps;
  c.jammed_run.converged = jammed_converged;
  c.jammed_run.mean_error = std::exp(logarithms / c.jammed.steps);
  c.solid_fraction = covered_fraction(c.state, box_of(c.state, scene.step).size().prod());
  for (const Sample& s : jammed) {
    c.coordination += s.coordination / static_cast<double>(jammed.size());
  }
  return c;
}

}  // namespace bipot
