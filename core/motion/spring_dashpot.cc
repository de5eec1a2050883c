#include "core/motion/spring_dashpot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/stopwatch.h"
#include "core/motion/outside_changes.h"
#include "core/motion/passage.h"
#include "core/motion/step_outcome.h"
#include "core/scene/contact_detection.h"
#include "core/scene/wall_motion.h"

namespace bipot {
namespace {

/// Reach of the neighbour list, relative to the smallest radius. Larger values make searches rarer
/// and lists longer.
constexpr double kSkin = 0.2;
constexpr double kMostOverlap = 0.1;  // over the smaller radius: beyond it a step fails
constexpr int kPollEvery = 64;        // substeps between looks at the clock

// Tangents and turns in the plane and in space.
bool is_zero(double x) { return x == 0; }
bool is_zero(const Vec3& x) { return x.isZero(0); }
double with_length(double x, double length) { return std::copysign(length, x); }
Vec3 with_length(const Vec3& x, double length) { return length / x.norm() * x; }
/// Tangential velocity; v: of the centres, rim: Σ radius spin.
double sliding(const Vec2& n, const Vec2& v, double rim) { return n[0] * v[1] - n[1] * v[0] - rim; }
Vec3 sliding(const Vec3& n, const Vec3& v, const Vec3& rim) {
  return v - n.dot(v) * n + n.cross(rim);
}
/// A spring follows the normal, which has turned, and keeps its length.
void lay_into_plane(double& /*spring*/, const Vec2& /*n*/) {}
void lay_into_plane(Vec3& spring, const Vec3& n) {
  const Vec3 laid = spring - n.dot(spring) * n;
  const double length = laid.norm();
  if (length > 0) spring = spring.norm() / length * laid;
}
void turn(double& angle, double by) { angle += by; }
void turn(Eigen::Quaterniond& orientation, const Vec3& by) {
  const Eigen::Quaterniond rate(0, by[0], by[1], by[2]);
  orientation.coeffs() += 0.5 * (rate * orientation).coeffs();
}
double turned(const Disk& d) { return d.angle; }
const Eigen::Quaterniond& turned(const Sphere& s) { return s.orientation; }
void place_turned(double angle, Disk& d) { d.angle = angle; }
void place_turned(const Eigen::Quaterniond& by, Sphere& s) { s.orientation = by.normalized(); }

}  // namespace

template <int D>
SpringDashpotStepper<D>::SpringDashpotStepper(const Scene<D>& scene,
                                              std::function<bool()> cut_short, double most_created)
    : scene_(scene),
      setup_(spring_dashpot_setup(scene)),
      cut_short_(std::move(cut_short)),
      most_created_(most_created) {
  skin_ = scene.bodies.empty() ? 0 : kSkin * smallest_radius(scene);
}

template <int D>
void SpringDashpotStepper<D>::load(const State<D>& state) {
  bodies_.resize(state.bodies.size());
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const Body<D>& d = state.bodies[k];
    bodies_[k] = {.x = d.x,
                  .v = d.v,
                  .spin = d.spin,
                  .turned = turned(d),
                  .inv_mass = 1 / d.mass,
                  .inv_inertia = 1 / d.inertia,
                  .radius = d.radius};
  }
  const double middle = state.time + 0.5 * scene_.step;
  walls_ = walls_at(scene_.walls, state.walls, middle, scene_.step);
  gravity_ = gravity_at(scene_, middle);
  walls_before_ = walls_;
  wall_push_.assign(walls_.size(), 0.0);
  // Takes the springs of the state; find_pairs() uses them.
  pairs_.clear();
  for (const ContactOutcome<D>& c : state.contacts) {
    if (is_zero(c.spring)) continue;
    pairs_.push_back(make_pair(c.contact.i, c.contact.j));
    pairs_.back().spring = c.spring;
  }
  find_pairs(state);
  work_n_ = work_t_ = wall_work_ = 0;
  external_.setZero();
  worst_overlap_ = penetration_ = 0;
  worst_i_ = worst_j_ = -1;
}

template <int D>
typename SpringDashpotStepper<D>::Pair SpringDashpotStepper<D>::make_pair(int i, int j) const {
  const Particle& a = bodies_[to_size(i)];
  const int n = static_cast<int>(bodies_.size());
  int material = 0;
  double normal = a.inv_mass, rim = a.inv_mass + a.radius * a.radius * a.inv_inertia;
  if (j < n) {
    const Particle& b = bodies_[to_size(j)];
    normal += b.inv_mass;
    rim += b.inv_mass + b.radius * b.radius * b.inv_inertia;
    material = scene_.bodies[to_size(j)].material;
  } else {
    const Wall<D>& w = walls_[to_size(j - n)];
    // A driven wall yields along its direction only. Its mass enters in full, which damps the other
    // direction slightly more.
    if (w.motion == Wall<D>::Motion::kDriven) {
      normal += 1 / w.mass;
      rim += 1 / w.mass;
    }
    material = w.material;
  }
  const std::size_t law =
      to_size(scene_.bodies[to_size(i)].material) * scene_.materials.size() + to_size(material);
  const double zeta = setup_.damping[law];
  return {.i = i,
          .j = j,
          .mu = scene_.laws[law].mu,
          .c_n = 2 * zeta * std::sqrt(setup_.stiffness / normal),
          .c_t = 2 * zeta * std::sqrt(setup_.tangential_stiffness / rim)};
}

/// Makes a new neighbour list; pairs in use keep their springs.
template <int D>
void SpringDashpotStepper<D>::find_pairs(const State<D>& state) {
  // Detection needs centres and radii alone.
  std::vector<Body<D>> bodies = state.bodies;
  for (std::size_t k = 0; k < bodies.size(); ++k) bodies[k].x = bodies_[k].x;
  const std::vector<Contact<D>> near = detect_contacts<D>(bodies, walls_, skin_);
  fresh_.clear();
  auto old = pairs_.begin();
  const auto keep_old = [&] {
    if (old->touched || !is_zero(old->spring)) fresh_.push_back(*old);
    ++old;
  };
  for (const Contact<D>& c : near) {
    while (old != pairs_.end() && std::pair(old->i, old->j) < c.pair()) keep_old();
    if (old != pairs_.end() && std::pair(old->i, old->j) == c.pair()) {
      fresh_.push_back(*old++);
    } else {
      fresh_.push_back(make_pair(c.i, c.j));
    }
  }
  while (old != pairs_.end()) keep_old();
  pairs_.swap(fresh_);
  path_ = 0;
}

template <int D>
typename SpringDashpotStepper<D>::Geometry SpringDashpotStepper<D>::geometry(
    const Pair& pair) const {
  const Particle& a = bodies_[to_size(pair.i)];
  const auto j = to_size(pair.j);
  Vec<D> way;
  double reach = a.radius;
  if (j < bodies_.size()) {
    way = a.x - bodies_[j].x;
    reach += bodies_[j].radius;
  } else {
    const Wall<D>& w = walls_[j - bodies_.size()];
    way = a.x - w.a;
    if (w.shape == Wall<D>::Shape::kHalfPlane) return {w.normal, w.normal.dot(way) - reach};
    if (w.is_circle()) {
      const bool hollow = w.shape == Wall<D>::Shape::kHollowCircle;
      if constexpr (D == 3) way -= way.dot(w.normal) * w.normal;
      if (hollow) way = -way;
      const double length = way.norm();
      return {way / length, (hollow ? w.radius - length : length - w.radius) - reach};
    }
    const Vec<D> along = w.b - w.a;
    way -= std::clamp(way.dot(along) / along.squaredNorm(), 0.0, 1.0) * along;
  }
  const double distance = way.norm();
  return {way / distance, distance - reach};
}

template <int D>
typename SpringDashpotStepper<D>::RelativeVelocity SpringDashpotStepper<D>::relative_velocity(
    const Pair& pair, const Vec<D>& n) const {
  const Particle& a = bodies_[to_size(pair.i)];
  const auto j = to_size(pair.j);
  Vec<D> v = a.v;
  Spin<D> rim = a.radius * a.spin;
  if (j < bodies_.size()) {
    const Particle& b = bodies_[j];
    v -= b.v;
    rim += b.radius * b.spin;
  } else {
    const Wall<D>& w = walls_[j - bodies_.size()];
    v -= surface_velocity(w, w.v, n);
  }
  return {n.dot(v), sliding(n, v, rim)};
}

template <int D>
void SpringDashpotStepper<D>::drift(double dt) {
  for (Particle& b : bodies_) {
    b.x += dt * b.v;
    turn(b.turned, dt * b.spin);
  }
  for (Wall<D>& w : walls_) {
    w.a += dt * w.v;
    w.b += dt * w.v;
  }
}

/// Forces at the midpoint. Work is the trapezoidal sum of force times velocity. Therefore the force
/// of each pair in the previous substep is still needed, and so are pairs that have just separated.
template <int D>
void SpringDashpotStepper<D>::apply_contacts(double dt) {
  const double k_n = setup_.stiffness, k_t = setup_.tangential_stiffness;
  const std::size_t num_disks = bodies_.size();
  for (Pair& p : pairs_) {
    Particle& a = bodies_[to_size(p.i)];
    const auto j = to_size(p.j);
    if (j < num_disks && p.f_n == 0 && is_zero(p.spring)) {
      // Most pairs of the list do not touch.
      const Particle& b = bodies_[j];
      const double reach = a.radius + b.radius;
      if ((a.x - b.x).squaredNorm() >= reach * reach) continue;
    }
    const Geometry at = geometry(p);
    const double overlap = -at.gap;
    const bool apart = !(overlap > 0);
    if (apart && p.f_n == 0 && is_zero(p.spring)) continue;
    const RelativeVelocity u = relative_velocity(p, at.n);
    double f_n = 0;
    Tangent<D> f_t = no_turn<D>();
    if (apart) {
      p.spring = no_turn<D>();
    } else {
      f_n = std::max(0.0, k_n * overlap - p.c_n * u.n);
      if (p.mu > 0) {
        lay_into_plane(p.spring, at.n);
        p.spring += dt * u.t;
        const double limit = p.mu * f_n;
        if (k_t * magnitude(p.spring) > limit) {
          // Slip: the spring keeps the elongation that friction can hold; the dashpot has no
          // effect.
          f_t = with_length(-p.spring, limit);
          p.spring = -f_t / k_t;
        } else {
          f_t = -k_t * p.spring - p.c_t * u.t;
          if (magnitude(f_t) > limit) f_t = with_length(f_t, limit);
        }
      }
      p.touched = true;
      p.s_n += dt * f_n;
      p.s_t += dt * f_t;
      if (overlap > penetration_) penetration_ = overlap;
      const double smaller = j < num_disks ? std::min(a.radius, bodies_[j].radius) : a.radius;
      if (!(overlap <= worst_overlap_ * smaller)) {
        worst_overlap_ = overlap / smaller;
        worst_i_ = p.i;
        worst_j_ = p.j;
      }
    }
    work_n_ += 0.5 * dt * (p.f_n + f_n) * u.n;
    work_t_ += 0.5 * dt * inner(p.f_t + f_t, u.t);
    p.f_n = f_n;
    p.f_t = f_t;
    if (apart) continue;
    const Vec<D> force = f_n * at.n + tangent_vector(at.n, f_t);
    const Spin<D> turning_force = turning(at.n, f_t);
    a.force += force;
    a.torque -= a.radius * turning_force;
    if (j < num_disks) {
      Particle& b = bodies_[j];
      b.force -= force;
      b.torque -= b.radius * turning_force;
      continue;
    }
    const Wall<D>& w = walls_[j - num_disks];
    if (w.motion == Wall<D>::Motion::kDriven) {
      // Forces across the direction act on the guide of the wall.
      const double along = force.dot(w.direction);
      wall_push_[j - num_disks] -= along;
      external_ += dt * (force - along * w.direction);
    } else {
      external_ += dt * force;
    }
    wall_work_ += dt * force.dot(prescribed_velocity(w, at.n));
  }
}

template <int D>
void SpringDashpotStepper<D>::kick(double dt) {
  for (Particle& b : bodies_) {
    b.v += dt * (b.inv_mass * b.force + gravity_);
    b.spin += dt * b.inv_inertia * b.torque;
    b.force.setZero();
    b.torque = no_turn<D>();
  }
  for (std::size_t k = 0; k < walls_.size(); ++k) {
    Wall<D>& w = walls_[k];
    if (w.motion != Wall<D>::Motion::kDriven) continue;
    const Vec<D> v = w.v + dt * (w.force + wall_push_[k]) / w.mass * w.direction;
    wall_work_ += dt * w.force * w.direction.dot(0.5 * (w.v + v));
    w.v = v;
    wall_push_[k] = 0;
  }
}

/// The last half of the trapezoidal sums.
template <int D>
void SpringDashpotStepper<D>::close_work(double dt) {
  for (Pair& p : pairs_) {
    if (p.f_n == 0) continue;
    const RelativeVelocity u = relative_velocity(p, geometry(p).n);
    work_n_ += 0.5 * dt * p.f_n * u.n;
    work_t_ += 0.5 * dt * inner(p.f_t, u.t);
  }
}

template <int D>
typename SpringDashpotStepper<D>::Elastic SpringDashpotStepper<D>::elastic_energy() const {
  Elastic energy;
  for (const Pair& p : pairs_) {
    const double overlap = -geometry(p).gap;
    if (overlap > 0) energy.normal += 0.5 * setup_.stiffness * overlap * overlap;
    energy.tangential += 0.5 * setup_.tangential_stiffness * inner(p.spring, p.spring);
  }
  return energy;
}

/// Upper bound of the approach of two bodies in a substep.
template <int D>
double SpringDashpotStepper<D>::path_per_substep(double dt) const {
  double disk2 = 0, wall2 = 0;
  for (const Particle& b : bodies_) disk2 = std::max(disk2, b.v.squaredNorm());
  for (const Wall<D>& w : walls_) wall2 = std::max(wall2, w.v.squaredNorm());
  return dt * (std::sqrt(disk2) + std::sqrt(std::max(disk2, wall2)));
}

/// Bodies and walls as they are now.
template <int D>
void SpringDashpotStepper<D>::place(State<D>& state) const {
  state.walls = walls_;
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const Particle& b = bodies_[k];
    Body<D>& d = state.bodies[k];
    d.x = b.x;
    d.v = b.v;
    d.spin = b.spin;
    place_turned(b.turned, d);
  }
}

/// "disk 3 and wall 'lid'", the deepest of the step.
template <int D>
std::string SpringDashpotStepper<D>::overlap_pair() const {
  const std::size_t j = to_size(worst_j_);
  return j < bodies_.size() ? fmt::format("{0} {1} and {0} {2}", kBodyName<D>, worst_i_, worst_j_)
                            : fmt::format("{} {} and wall '{}'", kBodyName<D>, worst_i_,
                                          scene_.walls[j - bodies_.size()].name);
}

/// Of the substep that ends now; `before` has the places where it began.
template <int D>
void SpringDashpotStepper<D>::check_passages(const State<D>& state, State<D> before,
                                             StepReport<D>& report) const {
  State<D> after = before;
  place(after);
  const std::vector<Passage> passages = find_passages(before, after, setup_.substep);
  if (passages.empty()) return;
  if (report.passages == 0) report.passage = passage_text(scene_, passages.front());
  report.passages += static_cast<int>(passages.size());
  if (refuse_passages_) {
    throw StepFailure(StepFailure::Kind::kPassage, state, report.passage);
  }
}

/// All substeps of a step.
template <int D>
void SpringDashpotStepper<D>::integrate(const State<D>& state, StepReport<D>& report) {
  const double dt = setup_.substep;
  using Kind = StepFailure::Kind;
  const double least = smallest_radius(scene_);
  for (int k = 0; k < setup_.substeps; ++k) {
    const double path = path_per_substep(dt);
    std::optional<State<D>> before;  // of a substep in which something may be passed
    if (path > least) place(before.emplace(state));
    drift(0.5 * dt);
    path_ += path;
    if (!(path_ <= skin_)) {
      const Stopwatch search;
      if (!std::isfinite(path_)) {
        throw StepFailure(Kind::kNumerical, state, "a velocity is not finite");
      }
      find_pairs(state);
      report.detection_seconds += search.seconds();
    }
    apply_contacts(dt);
    if (!(worst_overlap_ <= kMostOverlap)) {
      throw StepFailure(
          Kind::kNumerical, state,
          fmt::format(
              "{} overlap by {:.2g} of the radius (limit {:g}): a stiffness of {:.4g} N/m is "
              "too low for this load, raise it",
              overlap_pair(), worst_overlap_, kMostOverlap, setup_.stiffness));
    }
    kick(dt);
    drift(0.5 * dt);
    if (before) check_passages(state, *std::move(before), report);
    if (cut_short_ && (k + 1) % kPollEvery == 0 && cut_short_()) {
      throw StepFailure(Kind::kCutShort, state,
                        fmt::format("stopped after {} of {} substeps", k + 1, setup_.substeps));
    }
  }
  close_work(dt);
}

/// Bodies, walls and contacts after the last substep.
template <int D>
State<D> SpringDashpotStepper<D>::state_after(const State<D>& state) const {
  State<D> next;
  next.step = state.step + 1;
  next.time = time_after_step(state, scene_.step);
  next.bodies = state.bodies;
  place(next);
  for (const Pair& p : pairs_) {
    const Geometry at = geometry(p);
    if (!p.touched && at.gap >= 0) continue;
    const RelativeVelocity u = relative_velocity(p, at.n);
    next.contacts.push_back({.contact = {.i = p.i, .j = p.j, .n = at.n, .gap = at.gap},
                             .s_n = p.s_n,
                             .s_t = p.s_t,
                             .u_n = u.n,
                             .u_t = u.t,
                             .status = contact_status(p.s_n, magnitude(p.s_t), p.mu),
                             .spring = p.spring});
  }
  return next;
}

/// Accumulated work of the state after the step, and the balances of energy and momentum.
template <int D>
void SpringDashpotStepper<D>::close_ledger(const State<D>& state, const Elastic& elastic_before,
                                           State<D>& next, StepReport<D>& report) {
  const Elastic elastic_after = elastic_energy();
  const double friction_loss = -work_t_ - (elastic_after.tangential - elastic_before.tangential);
  const double shock_loss = -work_n_ - (elastic_after.normal - elastic_before.normal);
  const OutsideChanges<D> changes =
      outside_changes<D>(scene_, state, walls_before_, gravity_, {}, next);  // no forces on bodies
  wall_work_ += changes.work;
  external_ += changes.impulse;
  next.wall_work = state.wall_work + wall_work_;
  next.friction_loss = state.friction_loss + friction_loss;
  next.shock_loss = state.shock_loss + shock_loss;
  const StateSums<D> now = state_sums(next, gravity_at(scene_, next.time)),
                     then = state_sums(state, gravity_at(scene_, state.time));
  report.energy = {.kinetic = now.kinetic,
                   .potential = now.potential,
                   .wall_work = next.wall_work,
                   .friction_loss = next.friction_loss,
                   .shock_loss = next.shock_loss,
                   .elastic = elastic_after.sum()};
  const double kinetic_before = then.kinetic;
  const double fallen = then.potential - report.energy.potential;
  report.energy.imbalance = report.energy.kinetic - kinetic_before - fallen + elastic_after.sum() -
                            elastic_before.sum() - wall_work_ + friction_loss + shock_loss;
  if (!std::isfinite(report.energy.kinetic + report.energy.potential + report.energy.elastic)) {
    throw StepFailure(StepFailure::Kind::kNumerical, state, "the energy is not finite");
  }
  const double in_play =
      kinetic_before + elastic_before.sum() + std::abs(fallen) + std::abs(wall_work_);
  const double created = -(friction_loss + shock_loss);
  const double rounding = 1e-12 * std::abs(report.energy.potential);
  if (created > most_created_ * in_play + rounding) {
    throw StepFailure(
        StepFailure::Kind::kNumerical, state,
        fmt::format("the contacts made {:.2g} of the energy in play: substeps of {:.4g} s "
                    "are too long for a stiffness of {:.4g} N/m, shorten them",
                    created / in_play, setup_.substep, setup_.stiffness));
  }
  double mass = 0;
  for (const Body<D>& d : next.bodies) mass += d.mass;
  external_ += scene_.step * mass * gravity_;
  for (const Wall<D>& w : next.walls) {
    if (w.motion == Wall<D>::Motion::kDriven) external_ += scene_.step * w.force * w.direction;
  }
  report.momentum = now.momentum;
  report.momentum_imbalance = report.momentum - then.momentum - external_;
}

template <int D>
StepReport<D> SpringDashpotStepper<D>::advance(State<D>& state) {
  StepReport<D> report;
  const Stopwatch watch;
  load(state);
  report.detection_seconds = watch.seconds();
  const Elastic elastic_before = elastic_energy();
  integrate(state, report);
  State<D> next = state_after(state);
  close_ledger(state, elastic_before, next, report);
  for (const ContactOutcome<D>& c : next.contacts) report.active += c.s_n > 0 ? 1 : 0;
  report.step = next.step;
  report.time = next.time;
  report.contacts = static_cast<int>(next.contacts.size());
  report.iterations = setup_.substeps;
  report.penetration = penetration_;
  report.overlap = worst_overlap_;
  if (report.overlap > 0) report.overlap_pair = overlap_pair();
  report.travel = step_travel(state, next, scene_.step).radii;
  report.force_energy = force_energy<D>(gravity_, next.walls, next.cell, scene_.step, next.contacts,
                                        next.bodies.size());
  report.solve_seconds = watch.seconds() - report.detection_seconds;
  state = std::move(next);
  return report;
}

template class SpringDashpotStepper<2>;
template class SpringDashpotStepper<3>;

}  // namespace bipot
