#include "core/motion/time_stepping.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/motion/assembly.h"
#include "core/problem/delassus.h"
#include "core/scene/contact_detection.h"

namespace bipot {
namespace {

class Stopwatch {
 public:
  /// Seconds since construction or the last lap.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return seconds;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// The impulses of the step before, carried to the contacts of the same pairs; physical -> solver.
Vector warm_start(const std::vector<ContactOutcome>& before, std::span<const Contact> contacts,
                  const ContactProblem& p) {
  Vector s0 = Vector::Zero(p.num_rows());
  auto old = before.begin();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const auto less = [&](const ContactOutcome& o) {
      return o.contact.i < contacts[c].i ||
             (o.contact.i == contacts[c].i && o.contact.j < contacts[c].j);
    };
    while (old != before.end() && less(*old)) ++old;
    if (old == before.end()) break;
    if (old->contact.i != contacts[c].i || old->contact.j != contacts[c].j) continue;
    const int row = static_cast<int>(c) * p.dim;
    const bool scaled = p.row_scale.size() != 0;
    s0[row] = old->s_n * (scaled ? p.row_scale[row] : 1.0);
    if (p.dim == 2) s0[row + 1] = old->s_t * (scaled ? p.row_scale[row + 1] : 1.0);
  }
  return s0;
}

/// A step up to its contact problem: everything at the mid-point of the step (38).
struct Midpoint {
  std::vector<Disk> disks;  // positions at the mid-point, velocities before the step
  std::vector<Wall> walls;
  std::vector<Contact> contacts;
  std::vector<Vec2> disk_v_free;
  std::vector<double> wall_v_free;  // driven walls: speed along their direction
  AssembledStep assembled;
  double detection_seconds = 0, assembly_seconds = 0;
};

Midpoint make_midpoint(const Scene& scene, const State& state, bool explicit_delassus) {
  const double h = scene.step;
  Midpoint mid;
  Stopwatch watch;
  mid.disks = state.disks;
  mid.walls = state.walls;
  for (Disk& d : mid.disks) {
    d.x += 0.5 * h * d.v;
    d.angle += 0.5 * h * d.spin;
  }
  for (Wall& w : mid.walls) {
    w.a += 0.5 * h * w.v;
    w.b += 0.5 * h * w.v;
  }
  mid.contacts = detect_contacts(mid.disks, mid.walls, scene.contact_distance);
  mid.detection_seconds = watch.lap();

  mid.disk_v_free.resize(mid.disks.size());
  for (std::size_t i = 0; i < mid.disks.size(); ++i) {
    mid.disk_v_free[i] = mid.disks[i].v + h * scene.gravity;
  }
  mid.wall_v_free.assign(mid.walls.size(), 0.0);
  for (std::size_t w = 0; w < mid.walls.size(); ++w) {
    const Wall& wall = mid.walls[w];
    if (wall.motion != Wall::Motion::kDriven) continue;
    mid.wall_v_free[w] = wall.v.dot(wall.direction) + h * wall.force / wall.mass;
  }
  mid.assembled = assemble_step(scene, mid.disks, mid.walls, mid.contacts, mid.disk_v_free,
                                mid.wall_v_free, explicit_delassus);
  mid.assembly_seconds = watch.lap();
  return mid;
}

}  // namespace

double kinetic_energy(const State& state) {
  double sum = 0;
  for (const Disk& d : state.disks) {
    sum += 0.5 * d.mass * d.v.squaredNorm() + 0.5 * d.inertia * d.spin * d.spin;
  }
  for (const Wall& w : state.walls) {
    if (w.motion == Wall::Motion::kDriven) sum += 0.5 * w.mass * w.v.squaredNorm();
  }
  return sum;
}

double potential_energy(const State& state, const Vec2& gravity) {
  double sum = 0;
  for (const Disk& d : state.disks) sum -= d.mass * gravity.dot(d.x);
  return sum;
}

Vec2 momentum(const State& state) {
  Vec2 sum = Vec2::Zero();
  for (const Disk& d : state.disks) sum += d.mass * d.v;
  for (const Wall& w : state.walls) {
    if (w.motion == Wall::Motion::kDriven) sum += w.mass * w.v;
  }
  return sum;
}

ContactStatus contact_status(double s_n, double s_t, double mu) {
  constexpr double kEdge = 1 - 1e-9;  // relative distance from the cone's edge that counts as slip
  if (s_n <= 0) return ContactStatus::kTakeOff;
  return std::abs(s_t) < kEdge * mu * s_n ? ContactStatus::kStick : ContactStatus::kSlip;
}

State initial_state(const Scene& scene) {
  State state;
  state.disks = scene.disks;
  state.walls = scene.walls;
  return state;
}

TimeStepper::TimeStepper(const Scene& scene, StepSolver solver, bool explicit_delassus)
    : scene_(scene), solver_(std::move(solver)), explicit_delassus_(explicit_delassus) {}

std::string restart_mismatch(const Scene& scene, const State& state) {
  if (state.disks.size() != scene.disks.size() || state.walls.size() != scene.walls.size()) {
    return fmt::format("it has {} disks and {} walls, the scene has {} and {}", state.disks.size(),
                       state.walls.size(), scene.disks.size(), scene.walls.size());
  }
  for (std::size_t i = 0; i < scene.disks.size(); ++i) {
    const Disk &a = state.disks[i], &b = scene.disks[i];
    const auto differs = [&](const char* field, double x, double y) {
      return fmt::format("disk {}: {} is {}, in the scene {}", i, field, x, y);
    };
    if (a.radius != b.radius) return differs("radius", a.radius, b.radius);
    if (a.mass != b.mass) return differs("mass", a.mass, b.mass);
    if (a.inertia != b.inertia) return differs("inertia", a.inertia, b.inertia);
    if (a.material != b.material) return differs("material", a.material, b.material);
  }
  for (std::size_t i = 0; i < scene.walls.size(); ++i) {
    const Wall &a = state.walls[i], &b = scene.walls[i];
    const char* field = a.shape != b.shape                                           ? "shape"
                        : a.motion != b.motion                                       ? "motion"
                        : a.material != b.material                                   ? "material"
                        : a.mass != b.mass                                           ? "mass"
                        : a.force != b.force                                         ? "force"
                        : a.direction != b.direction                                 ? "direction"
                        : a.shape == Wall::Shape::kHalfPlane && a.normal != b.normal ? "normal"
                                                                                     : nullptr;
    if (field != nullptr) {
      return fmt::format("wall {}: {} is not that of wall '{}' of the scene", i, field, b.name);
    }
  }
  return {};
}

ContactProblem step_problem(const Scene& scene, const State& state, bool explicit_delassus) {
  return make_midpoint(scene, state, explicit_delassus).assembled.problem;
}

StepReport TimeStepper::advance(State& state) {
  const double h = scene_.step;
  const Vec2& g = scene_.gravity;
  StepReport report;

  // 1.-3. Mid-point configuration, candidates there, free velocities and the contact problem.
  Midpoint mid = make_midpoint(scene_, state, explicit_delassus_);
  const std::vector<Disk>& disks = mid.disks;
  const std::vector<Wall>& walls = mid.walls;
  const std::vector<Contact>& contacts = mid.contacts;
  const AssembledStep& assembled = mid.assembled;
  const DofMap& dofs = assembled.dofs;
  for (const Contact& c : contacts) report.penetration = std::max(report.penetration, -c.gap);
  report.detection_seconds = mid.detection_seconds;
  report.assembly_seconds = mid.assembly_seconds;
  problem_ = std::move(mid.assembled.problem);
  const ContactProblem& p = problem_;

  // 4. Impulses.
  Stopwatch watch;
  const Vector s0 = scene_.solver.warm_start ? warm_start(state.contacts, contacts, p) : Vector();
  StepSolution solution = solver_(p, s0);
  report.solve_seconds = watch.lap();
  const int step_number = state.step + 1;
  const auto failure = [&](StepFailure::Kind kind, const std::string& why) {
    return StepFailure(kind,
                       fmt::format("step {} at t = {:.9g} s: {}", step_number, state.time, why));
  };
  if (solution.refused) throw failure(StepFailure::Kind::kInvalidInput, solution.message);
  if (solution.cut_short) throw failure(StepFailure::Kind::kCutShort, solution.message);
  if (solution.failed || solution.s.size() != p.num_rows() || !solution.s.allFinite()) {
    throw failure(StepFailure::Kind::kNumerical, solution.message.empty()
                                                     ? "the solver returned no finite impulse"
                                                     : solution.message);
  }
  const Vector v = p.num_dofs() > 0 ? body_velocities(p, solution.s) : Vector();

  // 5. Velocities after the step, then positions (43).
  State next;
  next.step = step_number;
  // Multiples of h have no drift; after a restart with another step size there are none.
  const bool multiple = std::abs(state.time - state.step * h) <= 1e-6 * h;
  next.time = multiple ? step_number * h : state.time + h;
  next.disks = disks;
  next.walls = walls;
  for (std::size_t i = 0; i < disks.size(); ++i) {
    Disk& d = next.disks[i];
    const int k = dofs.disk[i];
    d.v = k < 0 ? mid.disk_v_free[i] : Vec2(v.segment<2>(k));
    if (k >= 0 && dofs.per_disk == 3) d.spin = v[k + 2];
    d.x += 0.5 * h * d.v;
    d.angle += 0.5 * h * d.spin;
  }
  for (std::size_t w = 0; w < walls.size(); ++w) {
    Wall& wall = next.walls[w];
    if (wall.motion == Wall::Motion::kDriven) {
      const double speed = dofs.wall[w] < 0 ? mid.wall_v_free[w] : v[dofs.wall[w]];
      wall.v = speed * wall.direction;
    }
    wall.a += 0.5 * h * wall.v;
    wall.b += 0.5 * h * wall.v;
  }

  // Contact outcomes, work and momentum through the contacts.
  const int dim = p.dim;
  const int num_disks = static_cast<int>(disks.size());
  double wall_work = 0, friction_loss = 0, shock_loss = 0;
  Vec2 external = Vec2::Zero();
  next.contacts.resize(contacts.size());
  const Vector relative_after = [&] {
    // Physical u⁺ = (1 + e) u - e u⁻, from Moreau's mean (36).
    Vector u = p.num_rows() > 0 ? Vector(p.H.transpose() * (v - p.v_free)) : Vector();
    return Vector(u + p.u_free);
  }();
  for (int c = 0; c < static_cast<int>(contacts.size()); ++c) {
    ContactOutcome& out = next.contacts[c];
    const Contact& contact = contacts[c];
    out.contact = contact;
    const Disk& a = disks[contact.i];
    const bool with_disk = contact.j < num_disks;
    const Wall* wall = with_disk ? nullptr : &walls[contact.j - num_disks];
    const ContactLaw& law =
        scene_.law(a.material, with_disk ? disks[contact.j].material : wall->material);
    double mean[2] = {0, 0}, s[2] = {0, 0}, u_after[2] = {0, 0};
    for (int row = 0; row < dim; ++row) {
      const double e = row == 0 ? law.e_n : law.e_t;
      const double r = p.row_scale.size() == 0 ? 1.0 : p.row_scale[c * dim + row];
      const double before = assembled.u_before[c * dim + row];
      s[row] = solution.s[c * dim + row] / r;
      u_after[row] = (1 + e) * relative_after[c * dim + row] / r - e * before;
      mean[row] = 0.5 * (u_after[row] + before);
    }
    out.s_n = s[0];
    out.s_t = s[1];
    out.u_n = u_after[0];
    out.u_t = u_after[1];
    out.status = contact_status(out.s_n, out.s_t, law.mu);
    if (out.s_n > 0) ++report.active;
    shock_loss -= s[0] * mean[0];
    friction_loss -= s[1] * mean[1];
    if (wall != nullptr) {
      const Vec2 impulse = s[0] * contact.n + s[1] * Vec2(-contact.n[1], contact.n[0]);
      if (wall->motion == Wall::Motion::kDriven) {
        // What acts across the direction is taken by the wall's guide.
        external += impulse - impulse.dot(wall->direction) * wall->direction;
      } else {
        external += impulse;
        wall_work += impulse.dot(wall->v);
      }
    }
  }
  for (const Disk& d : disks) external += h * d.mass * g;
  for (std::size_t w = 0; w < walls.size(); ++w) {
    if (walls[w].motion != Wall::Motion::kDriven) continue;
    const Vec2 push = h * walls[w].force * walls[w].direction;
    external += push;
    wall_work += push.dot(0.5 * (walls[w].v + next.walls[w].v));
  }

  next.wall_work = state.wall_work + wall_work;
  next.friction_loss = state.friction_loss + friction_loss;
  next.shock_loss = state.shock_loss + shock_loss;
  report.energy = {.kinetic = kinetic_energy(next),
                   .potential = potential_energy(next, g),
                   .wall_work = next.wall_work,
                   .friction_loss = next.friction_loss,
                   .shock_loss = next.shock_loss};
  report.energy.imbalance = report.energy.kinetic + report.energy.potential -
                            kinetic_energy(state) - potential_energy(state, g) - wall_work +
                            friction_loss + shock_loss;
  if (!std::isfinite(report.energy.kinetic + report.energy.potential)) {
    throw failure(StepFailure::Kind::kNumerical, "the energy is not finite");
  }
  report.momentum = momentum(next);
  report.momentum_imbalance = report.momentum - momentum(state) - external;
  report.step = next.step;
  report.time = next.time;
  report.contacts = static_cast<int>(contacts.size());
  report.converged = solution.converged;
  report.message = solution.message;
  report.iterations = solution.iterations;
  report.error = solution.error;
  state = std::move(next);
  return report;
}

}  // namespace bipot
