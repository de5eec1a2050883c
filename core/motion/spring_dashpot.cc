#include "core/motion/spring_dashpot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/stopwatch.h"
#include "core/base/types.h"
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

bool before(int i, int j, int other_i, int other_j) {
  return i < other_i || (i == other_i && j < other_j);
}

}  // namespace

SpringDashpotStepper::SpringDashpotStepper(const Scene<2>& scene, std::function<bool()> cut_short,
                                           double most_created)
    : scene_(scene),
      setup_(spring_dashpot_setup(scene)),
      cut_short_(std::move(cut_short)),
      most_created_(most_created) {
  skin_ = scene.bodies.empty() ? 0 : kSkin * smallest_radius(scene);
}

void SpringDashpotStepper::load(const State<2>& state) {
  bodies_.resize(state.bodies.size());
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const Disk& d = state.bodies[k];
    bodies_[k] = {.x = d.x[0],
                  .y = d.x[1],
                  .angle = d.angle,
                  .vx = d.v[0],
                  .vy = d.v[1],
                  .spin = d.spin,
                  .inv_mass = 1 / d.mass,
                  .inv_inertia = 1 / d.inertia,
                  .radius = d.radius};
  }
  const double middle = state.time + 0.5 * scene_.step;
  walls_ = walls_at(scene_.walls, state.walls, middle);
  gravity_ = gravity_at(scene_, middle);
  walls_before_ = walls_;
  wall_push_.assign(walls_.size(), 0.0);
  // Takes the springs of the state; find_pairs() uses them.
  pairs_.clear();
  for (const ContactOutcome<2>& c : state.contacts) {
    if (c.spring == 0) continue;
    pairs_.push_back(make_pair(c.contact.i, c.contact.j));
    pairs_.back().spring = c.spring;
  }
  find_pairs(state);
  work_n_ = work_t_ = wall_work_ = 0;
  external_ = Vec2::Zero();
  worst_overlap_ = penetration_ = 0;
  worst_i_ = worst_j_ = -1;
}

SpringDashpotStepper::Pair SpringDashpotStepper::make_pair(int i, int j) const {
  const Body& a = bodies_[static_cast<std::size_t>(i)];
  const int n = static_cast<int>(bodies_.size());
  int material = 0;
  double normal = a.inv_mass, rim = a.inv_mass + a.radius * a.radius * a.inv_inertia;
  if (j < n) {
    const Body& b = bodies_[static_cast<std::size_t>(j)];
    normal += b.inv_mass;
    rim += b.inv_mass + b.radius * b.radius * b.inv_inertia;
    material = scene_.bodies[static_cast<std::size_t>(j)].material;
  } else {
    const Wall<2>& w = walls_[static_cast<std::size_t>(j - n)];
    // A driven wall yields along its direction only. Its mass enters in full, which damps the other
    // direction slightly more.
    if (w.motion == Wall<2>::Motion::kDriven) {
      normal += 1 / w.mass;
      rim += 1 / w.mass;
    }
    material = w.material;
  }
  const auto count = scene_.materials.size();
  const std::size_t law =
      static_cast<std::size_t>(scene_.bodies[static_cast<std::size_t>(i)].material) * count +
      static_cast<std::size_t>(material);
  const double zeta = setup_.damping[law];
  return {.i = i,
          .j = j,
          .mu = scene_.laws[law].mu,
          .c_n = 2 * zeta * std::sqrt(setup_.stiffness / normal),
          .c_t = 2 * zeta * std::sqrt(setup_.tangential_stiffness / rim)};
}

/// Makes a new neighbour list; pairs in use keep their springs.
void SpringDashpotStepper::find_pairs(const State<2>& state) {
  // Detection needs centres and radii alone.
  std::vector<Disk> disks = state.bodies;
  for (std::size_t k = 0; k < disks.size(); ++k) disks[k].x = Vec2(bodies_[k].x, bodies_[k].y);
  const std::vector<Contact<2>> near = detect_contacts(disks, walls_, skin_);
  fresh_.clear();
  auto old = pairs_.begin();
  const auto keep_old = [&] {
    if (old->touched || old->spring != 0) fresh_.push_back(*old);
    ++old;
  };
  for (const Contact<2>& c : near) {
    while (old != pairs_.end() && before(old->i, old->j, c.i, c.j)) keep_old();
    if (old != pairs_.end() && old->i == c.i && old->j == c.j) {
      fresh_.push_back(*old++);
    } else {
      fresh_.push_back(make_pair(c.i, c.j));
    }
  }
  while (old != pairs_.end()) keep_old();
  pairs_.swap(fresh_);
  path_ = 0;
}

SpringDashpotStepper::Geometry SpringDashpotStepper::geometry(const Pair& pair) const {
  const Body& a = bodies_[static_cast<std::size_t>(pair.i)];
  const auto j = static_cast<std::size_t>(pair.j);
  double dx = 0, dy = 0, reach = a.radius;
  if (j < bodies_.size()) {
    const Body& b = bodies_[j];
    dx = a.x - b.x;
    dy = a.y - b.y;
    reach += b.radius;
  } else {
    const Wall<2>& w = walls_[j - bodies_.size()];
    if (w.shape == Wall<2>::Shape::kHalfPlane) {
      const double height = w.normal[0] * (a.x - w.a[0]) + w.normal[1] * (a.y - w.a[1]);
      return {w.normal, height - reach};
    }
    if (w.is_circle()) {
      const bool hollow = w.shape == Wall<2>::Shape::kHollowCircle;
      const Vec2 d = hollow ? Vec2(w.a - Vec2(a.x, a.y)) : Vec2(Vec2(a.x, a.y) - w.a);
      const double length = d.norm();
      return {d / length, (hollow ? w.radius - length : length - w.radius) - reach};
    }
    const Vec2 along = w.b - w.a, from = Vec2(a.x, a.y) - w.a;
    const double t = std::clamp(from.dot(along) / along.squaredNorm(), 0.0, 1.0);
    dx = from[0] - t * along[0];
    dy = from[1] - t * along[1];
  }
  const double distance2 = dx * dx + dy * dy;
  const double distance = std::sqrt(distance2);
  return {Vec2(dx / distance, dy / distance), distance - reach};
}

Vec2 SpringDashpotStepper::relative_velocity(const Pair& pair, const Vec2& n) const {
  const Body& a = bodies_[static_cast<std::size_t>(pair.i)];
  const auto j = static_cast<std::size_t>(pair.j);
  double vx = a.vx, vy = a.vy, rim = a.radius * a.spin;
  if (j < bodies_.size()) {
    const Body& b = bodies_[j];
    vx -= b.vx;
    vy -= b.vy;
    rim += b.radius * b.spin;
  } else {
    const Wall<2>& w = walls_[j - bodies_.size()];
    const Vec2 v = surface_velocity(w, w.v, n);
    vx -= v[0];
    vy -= v[1];
  }
  return {n[0] * vx + n[1] * vy, n[0] * vy - n[1] * vx - rim};
}

void SpringDashpotStepper::drift(double dt) {
  for (Body& b : bodies_) {
    b.x += dt * b.vx;
    b.y += dt * b.vy;
    b.angle += dt * b.spin;
  }
  for (Wall<2>& w : walls_) {
    w.a += dt * w.v;
    w.b += dt * w.v;
  }
}

/// Forces at the midpoint. Work is the trapezoidal sum of force times velocity. Therefore the force
/// of each pair in the previous substep is still needed, and so are pairs that have just separated.
void SpringDashpotStepper::apply_contacts(double dt) {
  const double k_n = setup_.stiffness, k_t = setup_.tangential_stiffness;
  const std::size_t num_disks = bodies_.size();
  for (Pair& p : pairs_) {
    Body& a = bodies_[static_cast<std::size_t>(p.i)];
    const auto j = static_cast<std::size_t>(p.j);
    if (j < num_disks && p.f_n == 0 && p.spring == 0) {
      // Most pairs of the list do not touch.
      const Body& b = bodies_[j];
      const double dx = a.x - b.x, dy = a.y - b.y, reach = a.radius + b.radius;
      if (dx * dx + dy * dy >= reach * reach) continue;
    }
    const Geometry at = geometry(p);
    const double overlap = -at.gap;
    const bool apart = !(overlap > 0);
    if (apart && p.f_n == 0 && p.spring == 0) continue;
    const Vec2 u = relative_velocity(p, at.n);
    double f_n = 0, f_t = 0;
    if (apart) {
      p.spring = 0;
    } else {
      f_n = std::max(0.0, k_n * overlap - p.c_n * u[0]);
      if (p.mu > 0) {
        p.spring += dt * u[1];
        const double limit = p.mu * f_n;
        if (k_t * std::abs(p.spring) > limit) {
          // Slip: the spring keeps the elongation that friction can hold; the dashpot has no
          // effect.
          f_t = std::copysign(limit, -p.spring);
          p.spring = -f_t / k_t;
        } else {
          f_t = std::clamp(-k_t * p.spring - p.c_t * u[1], -limit, limit);
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
    work_n_ += 0.5 * dt * (p.f_n + f_n) * u[0];
    work_t_ += 0.5 * dt * (p.f_t + f_t) * u[1];
    p.f_n = f_n;
    p.f_t = f_t;
    if (apart) continue;
    const double fx = f_n * at.n[0] - f_t * at.n[1], fy = f_n * at.n[1] + f_t * at.n[0];
    a.fx += fx;
    a.fy += fy;
    a.torque -= a.radius * f_t;
    if (j < num_disks) {
      Body& b = bodies_[j];
      b.fx -= fx;
      b.fy -= fy;
      b.torque -= b.radius * f_t;
      continue;
    }
    const Wall<2>& w = walls_[j - num_disks];
    if (w.motion == Wall<2>::Motion::kDriven) {
      // Forces across the direction act on the guide of the wall.
      const double along = fx * w.direction[0] + fy * w.direction[1];
      wall_push_[j - num_disks] -= along;
      external_ += dt * (Vec2(fx, fy) - along * w.direction);
    } else {
      external_ += dt * Vec2(fx, fy);
    }
    const Vec2 v = prescribed_velocity(w, at.n);
    wall_work_ += dt * (fx * v[0] + fy * v[1]);
  }
}

void SpringDashpotStepper::kick(double dt) {
  const double gx = gravity_[0], gy = gravity_[1];
  for (Body& b : bodies_) {
    b.vx += dt * (b.fx * b.inv_mass + gx);
    b.vy += dt * (b.fy * b.inv_mass + gy);
    b.spin += dt * b.torque * b.inv_inertia;
    b.fx = b.fy = b.torque = 0;
  }
  for (std::size_t k = 0; k < walls_.size(); ++k) {
    Wall<2>& w = walls_[k];
    if (w.motion != Wall<2>::Motion::kDriven) continue;
    const Vec2 v = w.v + dt * (w.force + wall_push_[k]) / w.mass * w.direction;
    wall_work_ += dt * w.force * w.direction.dot(0.5 * (w.v + v));
    w.v = v;
    wall_push_[k] = 0;
  }
}

/// The last half of the trapezoidal sums.
void SpringDashpotStepper::close_work(double dt) {
  for (Pair& p : pairs_) {
    if (p.f_n == 0) continue;
    const Vec2 u = relative_velocity(p, geometry(p).n);
    work_n_ += 0.5 * dt * p.f_n * u[0];
    work_t_ += 0.5 * dt * p.f_t * u[1];
  }
}

SpringDashpotStepper::Elastic SpringDashpotStepper::elastic_energy() const {
  Elastic energy;
  for (const Pair& p : pairs_) {
    const double overlap = -geometry(p).gap;
    if (overlap > 0) energy.normal += 0.5 * setup_.stiffness * overlap * overlap;
    energy.tangential += 0.5 * setup_.tangential_stiffness * p.spring * p.spring;
  }
  return energy;
}

/// Upper bound of the approach of two bodies in a substep.
double SpringDashpotStepper::path_per_substep(double dt) const {
  double disk2 = 0, wall2 = 0;
  for (const Body& b : bodies_) disk2 = std::max(disk2, b.vx * b.vx + b.vy * b.vy);
  for (const Wall<2>& w : walls_) wall2 = std::max(wall2, w.v.squaredNorm());
  return dt * (std::sqrt(disk2) + std::sqrt(std::max(disk2, wall2)));
}

/// Bodies and walls as they are now.
void SpringDashpotStepper::place(State<2>& state) const {
  state.walls = walls_;
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const Body& b = bodies_[k];
    Disk& d = state.bodies[k];
    d.x = Vec2(b.x, b.y);
    d.angle = b.angle;
    d.v = Vec2(b.vx, b.vy);
    d.spin = b.spin;
  }
}

/// "disk 3 and wall 'lid'", the deepest of the step.
std::string SpringDashpotStepper::overlap_pair() const {
  const std::size_t j = to_size(worst_j_);
  return j < bodies_.size() ? fmt::format("disk {} and disk {}", worst_i_, worst_j_)
                            : fmt::format("disk {} and wall '{}'", worst_i_,
                                          scene_.walls[j - bodies_.size()].name);
}

/// Of the substep that ends now; `before` has the places where it began.
void SpringDashpotStepper::check_passages(const State<2>& state, State<2> before,
                                          StepReport<2>& report) const {
  State<2> after = before;
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
void SpringDashpotStepper::integrate(const State<2>& state, StepReport<2>& report) {
  const double dt = setup_.substep;
  using Kind = StepFailure::Kind;
  const double least = smallest_radius(scene_);
  for (int k = 0; k < setup_.substeps; ++k) {
    const double path = path_per_substep(dt);
    std::optional<State<2>> before;  // of a substep in which something may be passed
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
State<2> SpringDashpotStepper::state_after(const State<2>& state) const {
  State<2> next;
  next.step = state.step + 1;
  next.time = time_after_step(state, scene_.step);
  next.bodies = state.bodies;
  place(next);
  for (const Pair& p : pairs_) {
    const Geometry at = geometry(p);
    if (!p.touched && at.gap >= 0) continue;
    const Vec2 u = relative_velocity(p, at.n);
    next.contacts.push_back({.contact = {.i = p.i, .j = p.j, .n = at.n, .gap = at.gap},
                             .s_n = p.s_n,
                             .s_t = p.s_t,
                             .u_n = u[0],
                             .u_t = u[1],
                             .status = contact_status(p.s_n, p.s_t, p.mu),
                             .spring = p.spring});
  }
  return next;
}

/// Accumulated work of the state after the step, and the balances of energy and momentum.
void SpringDashpotStepper::close_ledger(const State<2>& state, const Elastic& elastic_before,
                                        State<2>& next, StepReport<2>& report) {
  const Elastic elastic_after = elastic_energy();
  const double friction_loss = -work_t_ - (elastic_after.tangential - elastic_before.tangential);
  const double shock_loss = -work_n_ - (elastic_after.normal - elastic_before.normal);
  const OutsideChanges<2> changes =
      outside_changes(scene_, state, walls_before_, gravity_, next, next.time);
  wall_work_ += changes.work;
  external_ += changes.impulse;
  next.wall_work = state.wall_work + wall_work_;
  next.friction_loss = state.friction_loss + friction_loss;
  next.shock_loss = state.shock_loss + shock_loss;
  const StateSums<2> now = state_sums(next, gravity_at(scene_, next.time)),
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
  for (const Disk& d : next.bodies) mass += d.mass;
  external_ += scene_.step * mass * gravity_;
  for (const Wall<2>& w : next.walls) {
    if (w.motion == Wall<2>::Motion::kDriven) external_ += scene_.step * w.force * w.direction;
  }
  report.momentum = now.momentum;
  report.momentum_imbalance = report.momentum - then.momentum - external_;
}

StepReport<2> SpringDashpotStepper::advance(State<2>& state) {
  StepReport<2> report;
  const Stopwatch watch;
  load(state);
  report.detection_seconds = watch.seconds();
  const Elastic elastic_before = elastic_energy();
  integrate(state, report);
  State<2> next = state_after(state);
  close_ledger(state, elastic_before, next, report);
  for (const ContactOutcome<2>& c : next.contacts) report.active += c.s_n > 0 ? 1 : 0;
  report.step = next.step;
  report.time = next.time;
  report.contacts = static_cast<int>(next.contacts.size());
  report.iterations = setup_.substeps;
  report.penetration = penetration_;
  report.overlap = worst_overlap_;
  if (report.overlap > kDeepOverlap) report.overlap_pair = overlap_pair();
  report.travel = step_travel(state, next, scene_.step).radii;
  report.wall_pushes = wall_pushes(next.contacts, next.bodies.size());
  report.solve_seconds = watch.seconds() - report.detection_seconds;
  state = std::move(next);
  return report;
}

}  // namespace bipot
