#include "bench/experiments/packing.h"

#include <fmt/format.h>

#include "bench/measure/statistics.h"
#include "core/scene/scene_parts.h"
#include "solvers/simulation/scene_run.h"

namespace bipot {
namespace {

bool before(const ContactOutcome<2>& a, const ContactOutcome<2>& b) {
  return a.contact.i != b.contact.i ? a.contact.i < b.contact.i : a.contact.j < b.contact.j;
}

/// Visits the pairs of two sorted lists, once each; null if a list does not have the pair.
template <class Show>
void merge_pairs(std::span<const ContactOutcome<2>> a, std::span<const ContactOutcome<2>> b,
                 const Show& show) {
  auto p = a.begin();
  auto q = b.begin();
  while (p != a.end() || q != b.end()) {
    if (q == b.end() || (p != a.end() && before(*p, *q))) {
      show(&*p++, static_cast<const ContactOutcome<2>*>(nullptr));
    } else if (p == a.end() || before(*q, *p)) {
      show(static_cast<const ContactOutcome<2>*>(nullptr), &*q++);
    } else {
      show(&*p++, &*q++);
    }
  }
}

/// Area that a chord at a distance from the centre cuts off a circle.
double segment_area(double radius, double distance) {
  const double x = std::clamp(distance / radius, -1.0, 1.0);
  return radius * radius * (std::acos(x) - x * std::sqrt(1 - x * x));
}

}  // namespace

PackingRun run_packing(
    const Scene<2>& scene, State<2>& state, const std::function<bool()>& interrupted,
    const std::function<bool(const State<2>&, const State<2>&, const StepReport<2>&)>& on_step) {
  PackingRun run;
  State<2> previous;
  std::vector<ContactOutcome<2>> old, older;  // one and two steps before `state`
  double logarithms = 0;
  int positive = 0;
  SceneRunOptions<2> options;
  options.cancelled = interrupted;
  options.before_step = [&](State<2>& next) {
    previous = next;
    // e_t = 1 reverses tangential velocities at each step. At rest forces then repeat themselves
    // every second step: those of two steps before are the better start.
    if (force_correlation(next.contacts, older) > force_correlation(next.contacts, old)) {
      next.contacts = old;
      ++run.far_starts;
    }
  };
  options.on_step = [&](const SceneStep<2>& step) {
    const StepReport<2>& report = step.report;
    older = std::move(old);
    old = previous.contacts;
    const double error = report.error.guarded();
    if (error > 0) {
      logarithms += std::log(error);
      ++positive;
    }
    return !on_step || on_step(previous, step.state, report);
  };
  const SceneRun<2> taken = run_scene(scene, state, options);
  if (taken.failure) throw *taken.failure;
  if (taken.end == SceneRun<2>::End::kCancelled) throw std::runtime_error("interrupted");
  run.steps = taken.totals.steps;
  run.converged = taken.totals.converged;
  run.iterations = taken.totals.iterations;
  run.mean_error = positive > 0 ? std::exp(logarithms / positive) : 0;
  return run;
}

double displacement_energy(const State<2>& before, const State<2>& after) {
  double sum = 0;
  for (std::size_t k = 0; k < after.bodies.size(); ++k) {
    const Disk &a = before.bodies[k], &b = after.bodies[k];
    const double spin = 0.5 * (a.spin + b.spin);
    sum += 0.5 * b.mass * (0.5 * (a.v + b.v)).squaredNorm() + 0.5 * b.inertia * spin * spin;
  }
  for (std::size_t k = 0; k < after.walls.size(); ++k) {
    const Wall<2>&a = before.walls[k], &b = after.walls[k];
    if (b.motion != Wall<2>::Motion::kDriven) continue;
    sum += 0.5 * b.mass * (0.5 * (a.v + b.v)).squaredNorm();
  }
  return sum;
}

double coordination(const State<2>& state) {
  const int disks = static_cast<int>(state.bodies.size());
  int ends = 0;
  for (const ContactOutcome<2>& o : state.contacts) {
    if (o.s_n > 0) ends += o.contact.j < disks ? 2 : 1;
  }
  return disks > 0 ? static_cast<double>(ends) / disks : kNaN;
}

double covered_fraction(const State<2>& state, double area) {
  double sum = 0;
  for (const Disk& d : state.bodies) sum += extent(d);
  for (const ContactOutcome<2>& o : state.contacts) {
    if (!(o.contact.gap < 0)) continue;
    const double a = state.bodies[static_cast<std::size_t>(o.contact.i)].radius;
    const auto j = static_cast<std::size_t>(o.contact.j);
    if (j >= state.bodies.size()) {
      sum -= segment_area(a, a + o.contact.gap);
      continue;
    }
    const double b = state.bodies[j].radius, d = a + b + o.contact.gap;
    const double chord = 0.5 * (d + (a * a - b * b) / d);  // its distance from the first centre
    sum -= segment_area(a, chord) + segment_area(b, d - chord);
  }
  return sum / area;
}

double force_correlation(std::span<const ContactOutcome<2>> a,
                         std::span<const ContactOutcome<2>> b) {
  double n = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
  merge_pairs(a, b, [&](const ContactOutcome<2>* p, const ContactOutcome<2>* q) {
    const double s = p != nullptr ? p->s_n : 0, t = q != nullptr ? q->s_n : 0;
    if (!(s > 0) && !(t > 0)) return;
    n += 1;
    x += s;
    y += t;
    xx += s * s;
    yy += t * t;
    xy += s * t;
  });
  const double vary_x = n * xx - x * x, vary_y = n * yy - y * y;
  return vary_x > 0 && vary_y > 0 ? (n * xy - x * y) / std::sqrt(vary_x * vary_y) : kNaN;
}

std::vector<double> relative_forces(const State<2>& state, int layers) {
  double top = 0;
  for (const Disk& d : state.bodies) top = std::max(top, d.x[1]);
  std::vector<std::vector<double>> forces(to_size(layers));
  for (const ContactOutcome<2>& o : state.contacts) {
    if (!(o.s_n > 0)) continue;
    const Disk& d = state.bodies[to_size(o.contact.i)];
    const double y = d.x[1] - d.radius * o.contact.n[1];
    forces[to_size(std::clamp(static_cast<int>(layers * y / top), 0, layers - 1))].push_back(o.s_n);
  }
  std::vector<double> relative;
  for (const std::vector<double>& layer : forces) {
    double sum = 0;
    for (const double f : layer) sum += f;
    for (const double f : layer) relative.push_back(f * static_cast<double>(layer.size()) / sum);
  }
  return relative;
}

Chart::Series force_histogram(const std::string& name, int style, const std::vector<double>& forces,
                              double bin) {
  std::vector<int> counts;
  for (const double f : forces) {
    const auto k = static_cast<std::size_t>(f / bin);
    if (k >= counts.size()) counts.resize(k + 1);
    ++counts[k];
  }
  Chart::Series series{name, style, {}};
  for (std::size_t k = 0; k < counts.size(); ++k) {
    if (counts[k] == 0) continue;
    series.points.push_back({(static_cast<double>(k) + 0.5) * bin,
                             counts[k] / (bin * static_cast<double>(forces.size())), false,
                             fmt::format("{} forces", counts[k])});
  }
  return series;
}

void MeanContacts::add(const State<2>& state) {
  std::vector<ContactOutcome<2>> sums;
  sums.reserve(std::max(sums_.size(), state.contacts.size()));
  merge_pairs(sums_, state.contacts,
              [&](const ContactOutcome<2>* sum, const ContactOutcome<2>* now) {
                sums.push_back(now != nullptr ? *now : *sum);
                if (sum != nullptr && now != nullptr) {
                  sums.back().s_n += sum->s_n;
                  sums.back().s_t += sum->s_t;
                  sums.back().u_n += sum->u_n;
                  sums.back().u_t += sum->u_t;
                }
              });
  sums_ = std::move(sums);
  ++steps_;
}

State<2> MeanContacts::in(const State<2>& state) const {
  State<2> mean = state;
  mean.contacts = sums_;
  for (ContactOutcome<2>& o : mean.contacts) {
    for (double* x : {&o.s_n, &o.s_t, &o.u_n, &o.u_t}) *x /= steps_;
  }
  return mean;
}

Surface measure_surface(const State<2>& state, double left, double right, int bins) {
  const double width = (right - left) / bins;
  std::vector<double> x, top;
  for (int k = 0; k < bins; ++k) {
    const double first = left + k * width, last = first + width;
    double highest = -kInfinity;
    for (const Disk& d : state.bodies) {
      const double aside = std::max({first - d.x[0], d.x[0] - last, 0.0});  // of the bin
      if (aside >= d.radius) continue;
      highest = std::max(highest, d.x[1] + std::sqrt(d.radius * d.radius - aside * aside));
    }
    if (!std::isfinite(highest)) continue;  // bare floor
    x.push_back(0.5 * (first + last));
    top.push_back(highest);
  }
  Surface surface;
  const double middle = 0.5 * (left + right);
  std::vector<double> aside;
  for (double at : x) aside.push_back(std::abs(at - middle));
  for (double height : top) surface.height += height / static_cast<double>(top.size());
  for (double height : top) surface.roughness += std::pow(height - surface.height, 2);
  surface.roughness = std::sqrt(surface.roughness / static_cast<double>(top.size()));
  surface.slope = fitted_slope(x, top);
  surface.heap = -fitted_slope(aside, top);
  return surface;
}

}  // namespace bipot
