#include "bench/tradeoff/trade_outcome.h"

#include <utility>

#include "core/motion/sample_area.h"
#include "core/motion/sample_volume.h"
#include "core/motion/stress_tensor.h"
#include "core/observables/measured_bodies.h"

namespace bipot {
namespace {

constexpr double kWindow = 0.1;    // of the duration
constexpr double kCarries = 1e-3;  // of the mean force: less does not carry

/// Lowest and highest point of the bodies along a direction.
template <int D>
std::pair<double, double> span_along(const std::vector<Body<D>>& disks, const Vec<D>& up) {
  double low = kInfinity, high = -low;
  for (const Body<D>& d : disks) {
    low = std::min(low, up.dot(d.x) - d.radius);
    high = std::max(high, up.dot(d.x) + d.radius);
  }
  return {low, high};
}

}  // namespace

double TradeQuantity::scale(double reference) const {
  const double s = std::max(std::abs(reference), least_scale);
  return s > 0 ? s : 1;
}

template <int D>
OutcomeRecorder<D>::OutcomeRecorder(const Scene<D>& scene) : scene_(scene) {
  g_ = scene.gravity.norm();
  if (g_ > 0) up_ = -scene.gravity / g_;
  end_ = scene.num_steps * scene.step;
  weight_ = weight_of(initial_state(scene));
  if (scene.bodies.size() == 1 && scene.walls.size() == 1 && !scene.has_gates() && g_ > 0 &&
      scene.walls[0].shape == Wall<D>::Shape::kHalfPlane &&
      scene.walls[0].motion == Wall<D>::Motion::kFixed &&
      scene.walls[0].normal.dot(up_) > 1 - 1e-12) {
    const Body<D>& d = scene.bodies[0];
    const Wall<D>& w = scene.walls[0];
    const double gap = w.normal.dot(d.x - w.a) - d.radius;
    const ContactLaw& law = scene.law(d.material, w.material);
    floor_ = up_.dot(w.a);
    if (gap > 1e-3 * d.radius && d.v.norm() == 0 && magnitude(d.spin) == 0 && law.e_n > 0) {
      plan_ball(gap);
    } else if (std::abs(gap) <= 1e-6 * d.radius && std::abs(d.v.dot(up_)) <= 1e-12 * d.v.norm() &&
               d.v.norm() > 0 && magnitude(d.spin) == 0 && law.mu > 0) {
      plan_slider();
    }
  }
  if (quantities_.empty()) plan_sample();
}

template <int D>
double OutcomeRecorder<D>::weight_of(const State<D>& state) const {
  double weight = 0;
  for (const MeasuredBody<D>& body : measured_bodies(state).list) weight += body.mass * g_;
  return weight;
}

template <int D>
void OutcomeRecorder<D>::plan_ball(double gap) {
  const double e = scene_.law(scene_.bodies[0].material, scene_.walls[0].material).e_n;
  const double fall = std::sqrt(2 * gap / g_);
  double impact = fall;
  for (int p = 1; p <= 2; ++p) {
    const double flight = 2 * std::pow(e, p) * fall;
    impact += flight;
    if (impact > end_) break;
    kind_ = Kind::kBall;
    const std::string number = std::to_string(p);
    const auto k = to_size(p);
    measure({.name = "height " + number,
             .unit = "m",
             .meaning = "height of bounce " + number,
             .exact = gap * std::pow(e, 2 * p)},
            [this, k] { return k < tops_.size() ? tops_[k] : kNaN; });
    measure({.name = "flight " + number,
             .unit = "s",
             .meaning = "time between the impacts of bounce " + number,
             .exact = flight},
            [this, k] { return k < impacts_.size() ? impacts_[k] - impacts_[k - 1] : kNaN; });
  }
}

template <int D>
void OutcomeRecorder<D>::plan_slider() {
  // m v' = -mu m g, I w' = -mu m g a until v = -a w.
  const Body<D>& d = scene_.bodies[0];
  const double mu = scene_.law(d.material, scene_.walls[0].material).mu;
  const double turn = 1 + d.mass * d.radius * d.radius / d.inertia;
  const double t1 = d.v.norm() / (mu * g_ * turn);
  if (t1 > end_) return;
  kind_ = Kind::kSlider;
  slowing_ = mu * g_ * turn;
  measure({.name = "v1",
           .unit = "m/s",
           .meaning = "speed at the end, rolling",
           .exact = d.v.norm() * (1 - 1 / turn)},
          [this] { return last_.bodies[0].v.norm(); });
  measure({.name = "t1", .unit = "s", .meaning = "time from which it rolls", .exact = t1},
          [this] { return rolls_from_; });
}

template <int D>
void OutcomeRecorder<D>::plan_sample() {
  double mean_radius = 0;
  for (const Body<D>& d : scene_.bodies) mean_radius += d.radius;
  if (scene_.bodies.empty()) {
    mean_radius = smallest_radius(scene_);
  } else {
    mean_radius /= static_cast<double>(scene_.bodies.size());
  }
  // Of the last tenth.
  const auto mean = [this](const double& sum) {
    return [this, &sum] { return sum / window_steps_; };
  };
  if (g_ > 0) {
    measure({.name = "height", .unit = "m", .meaning = "of the sample at the end, bottom to top"},
            [this] {
              const auto [low, high] = span_along(last_.bodies, up_);
              return last_.bodies.empty() ? kNaN : high - low;
            });
    measure({.name = "centre of mass",
             .unit = "m",
             .meaning = "its height above the lowest point at the end"},
            [this] {
              const double low = span_along(last_.bodies, up_).first;
              double moment = 0;
              for (const auto& body : measured_bodies(last_).list) {
                moment += body.mass * g_ * (up_.dot(body.x) - low);
              }
              return moment / weight_of(last_);
            });
  }
  measure({.name = "pressure", .unit = "Pa", .meaning = "mean pressure of the sample, last tenth"},
          [this] {
            if (last_.bodies.empty()) return kNaN;
            return pressure_ / window_steps_ / sample_measure(last_, scene_.step);
          });
  bool has_driven = false;
  for (const Wall<D>& w : scene_.walls) {
    has_floor_ |= g_ > 0 && w.shape == Wall<D>::Shape::kHalfPlane && w.normal.dot(up_) > 0.5;
    has_driven |= w.motion == Wall<D>::Motion::kDriven;
  }
  if (has_floor_) {
    measure({.name = "floor load",
             .meaning = "vertical force on the floor over the weight, last tenth"},
            mean(floor_load_));
  }
  const double energy = weight_ * mean_radius;
  measure({.name = "energy lost",
           .unit = "J",
           .meaning = "in contacts by the end",
           .least_scale = energy},
          [this] { return lost_; });
  if (scene_.has_friction()) {
    measure({.name = "to friction",
             .unit = "J",
             .meaning = "of it, by tangential forces",
             .least_scale = energy},
            [this] { return friction_loss_; });
  }
  measure({.name = "contacts",
           .meaning = "contacts that carry more than 1e-3 of the mean force, last tenth",
           .least_scale = 1},
          mean(contacts_));
  if (g_ > 0) {
    measure({.name = "speed",
             .meaning = "root mean square over √(g r), r the mean radius, last tenth",
             .least_scale = 1},
            [this, unit = std::sqrt(g_ * mean_radius)] {
              return std::sqrt(speed2_ / window_steps_) / unit;
            });
  }
  if (has_driven) {
    measure({.name = "wall travel", .unit = "m", .meaning = "of the driven walls by the end, mean"},
            [this] {
              double travel = 0;
              int driven = 0;
              for (std::size_t k = 0; k < last_.walls.size(); ++k) {
                if (last_.walls[k].motion != Wall<D>::Motion::kDriven) continue;
                travel += (last_.walls[k].a - scene_.walls[k].a).norm();
                ++driven;
              }
              return travel / driven;
            });
  }
  if constexpr (D == 2) find_columns();
  if (!scene_.outlets.empty()) {
    measure(
        {.name = "outflow", .unit = "kg", .meaning = "mass that left through outlets by the end"},
        [this] {
          double mass = 0;
          for (const GateFlow<D>& flow : last_.population.outlets) mass += flow.mass;
          return mass;
        });
  }
  if (!load_above_.empty()) {
    measure({.name = "column force",
             .meaning = "worst contact of a column against the weight above it, over the heaviest "
                        "column; mean over the last tenth",
             .exact = 0,
             .least_scale = 1},
            mean(column_error_));
  }
}

/// Without friction, straight columns of disks on a floor load each contact with the weight above
/// it, whatever the walls do.
template <int D>
void OutcomeRecorder<D>::find_columns() {
  if (scene_.has_friction() || !has_floor_ || scene_.bodies.size() < 2) return;
  if (scene_.has_gates()) return;
  if (!scene_.clusters.empty()) return;
  Vec<D> side = Vec<D>::Zero();
  side[0] = up_[1];
  side[1] = -up_[0];
  const double floor = span_along(scene_.bodies, up_).first;
  const double smallest = smallest_radius(scene_), close = 1e-3 * smallest;
  std::map<long, std::vector<int>> columns;
  for (int i = 0; i < static_cast<int>(scene_.bodies.size()); ++i) {
    if (scene_.bodies[i].v.norm() > 0) return;
    columns[std::lround(side.dot(scene_.bodies[i].x) / (10 * close))].push_back(i);
  }
  std::vector<double> above(scene_.bodies.size(), 0.0);
  for (auto& [x, column] : columns) {
    std::ranges::sort(column, std::greater<>(), [&](int k) { return up_.dot(scene_.bodies[k].x); });
    double load = 0;
    for (std::size_t k = 0; k < column.size(); ++k) {
      const Body<D>& d = scene_.bodies[column[k]];
      load += d.mass * g_;
      above[column[k]] = load;
      const bool last = k + 1 == column.size();
      const double below =
          last ? floor
               : up_.dot(scene_.bodies[column[k + 1]].x) + scene_.bodies[column[k + 1]].radius;
      if (std::abs(up_.dot(d.x) - d.radius - below) > close) return;
      if (!last && std::abs(side.dot(d.x - scene_.bodies[column[k + 1]].x)) > 1e-9 * smallest) {
        return;
      }
    }
    base_load_ = std::max(base_load_, load);
  }
  load_above_ = std::move(above);
}

template <int D>
void OutcomeRecorder<D>::step(const State<D>& state, const StepReport<D>& report) {
  if (kind_ == Kind::kBall) {
    // A flight between two steps with contact: its top and its end follow from any of its states.
    if (report.active > 0) {
      flies_ = false;
      return;
    }
    const Body<D>& ball = state.bodies[0];
    const double speed = up_.dot(ball.v);
    const double top = up_.dot(ball.x) - ball.radius - floor_ + speed * speed / (2 * g_);
    if (!flies_) {
      impacts_.emplace_back();
      tops_.emplace_back();
    }
    flies_ = true;
    impacts_.back() = report.time + (speed + std::sqrt(2 * g_ * std::max(top, 0.0))) / g_;
    tops_.back() = top;
    return;
  }
  if (kind_ == Kind::kSlider) {
    // It rolls when friction has taken the rest of the velocity of its contact.
    if (!state.contacts.empty() && state.contacts[0].status == ContactStatus::kSlip) {
      rolls_from_ = report.time + magnitude(state.contacts[0].u_t) / slowing_;
    }
    end_with(state);
    return;
  }
  friction_loss_ = report.energy.friction_loss;
  lost_ = report.energy.friction_loss + report.energy.shock_loss;
  end_with(state);
  const int before = std::exchange(step_, state.step);
  const double window = (1 - kWindow) * scene_.num_steps;
  if (state.step + (state.step - before) <= window) return;  // nor does the next one count
  const std::size_t n = state.bodies.size();
  double load = 0, worst = 0, impulses = 0, speed2 = 0;
  std::size_t bodies = state.clusters.bodies.size();
  for (const Cluster<D>& c : state.clusters.bodies) speed2 += c.v.squaredNorm();
  for (const Body<D>& d : state.bodies) {
    if (d.cluster >= 0) continue;
    speed2 += d.v.squaredNorm();
    ++bodies;
  }
  if (bodies > 0) speed2 /= static_cast<double>(bodies);
  MeanStress<D> stress;  // over one square metre; values() knows the area
  if (n > 0) stress = sample_stress(state, scene_.step, 1, contact_moments(state));
  const double kinetic = stress.kinetic.trace() / D;
  // Velocities are those at the end of a step. Between both ends they are taken as straight, and of
  // the step in which the last tenth begins a part counts.
  const double speed2_before = std::exchange(last_speed2_, speed2);
  const double kinetic_before = std::exchange(last_kinetic_, kinetic);
  if (state.step <= window) return;
  const double part = std::min((state.step - window) / (state.step - before), 1.0);
  const double of_start = before > 0 ? 0.5 * part : 0;
  window_steps_ += part;
  speed2_ += part * (of_start * speed2_before + (1 - of_start) * speed2);
  pressure_ += part * (stress.pressure() + of_start * (kinetic_before - kinetic));
  std::vector<double> below(load_above_.size(), 0.0);
  for (const ContactOutcome<D>& c : state.contacts) {
    const auto j = static_cast<std::size_t>(c.contact.j);
    const double force = c.s_n / scene_.step;
    impulses += c.s_n;
    const double rise = c.contact.n.dot(up_);
    if (j >= n && rise > 0.5) {
      load += force * rise + tangent_vector(c.contact.n, c.s_t).dot(up_) / scene_.step;
    }
    if (!below.empty() && std::abs(rise) > 0.5) {
      below[rise > 0 ? static_cast<std::size_t>(c.contact.i) : j] += force;
    }
  }
  if (report.active > 0) {
    const double least = kCarries * impulses / report.active;
    for (const ContactOutcome<D>& c : state.contacts) contacts_ += c.s_n > least ? part : 0;
  }
  const double weight = scene_.has_gates() ? weight_of(state) : weight_;
  floor_load_ += weight > 0 ? part * load / weight : 0;
  for (std::size_t k = 0; k < below.size(); ++k) {
    worst = std::max(worst, std::abs(below[k] - load_above_[k]) / base_load_);
  }
  column_error_ += part * worst;
}

template <int D>
void OutcomeRecorder<D>::end_with(const State<D>& state) {
  if (state.step < scene_.num_steps) return;
  last_ = state;
  ended_ = true;
}

template <int D>
void OutcomeRecorder<D>::measure(TradeQuantity quantity, std::function<double()> value) {
  quantities_.push_back(std::move(quantity));
  values_.push_back(std::move(value));
}

template <int D>
std::vector<double> OutcomeRecorder<D>::values() const {
  const bool ended = kind_ == Kind::kBall || ended_;
  std::vector<double> values;
  for (const auto& value : values_) values.push_back(ended ? value() : kNaN);
  return values;
}

template class OutcomeRecorder<2>;
template class OutcomeRecorder<3>;

}  // namespace bipot
