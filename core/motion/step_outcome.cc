#include "core/motion/step_outcome.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/motion/contact_axes.h"
#include "core/motion/joint_rows.h"
#include "core/problem/coulomb_cone.h"
#include "core/problem/equality_rows.h"
#include "core/scene/wall_motion.h"

namespace bipot {
namespace {

/// Normal and tangential values of one contact; the tangential ones are 0 without friction.
template <int D>
struct ContactValues {
  using Rows = std::array<double, to_size(3 * (D - 1))>;  // with those of rolling
  Rows s{};                                               // physical impulse and cohesion
  Rows u_after{};                                         // relative velocity after the step
  Rows mean{};  // mean of the relative velocities before and after the step
};

/// u: Moreau's mean velocities in the problem's variables. Physical u⁺ = (1 + e) u - e u⁻ (36).
template <int D>
ContactValues<D> contact_values(const ContactProblem& p, const AssembledStep& assembled,
                                const ContactLaw& law, int contact, const Vector& s,
                                const Vector& u) {
  ContactValues<D> values;
  for (std::size_t k = 0; k < to_size(p.dim); ++k) {
    const Eigen::Index row = contact * p.dim + static_cast<Eigen::Index>(k);
    const double e = k == 0 ? law.e_n : law.e_t;
    const double r = p.row_scale.size() == 0 ? 1.0 : p.row_scale[row];
    const double before = assembled.u_before[row];
    values.s[k] = s[row] / r;
    values.u_after[k] = (1 + e) * u[row] / r - e * before;
    values.mean[k] = 0.5 * (values.u_after[k] + before);
  }
  return values;
}

/// The tangential part of the values of a contact.
template <int D>
Tangent<D> tangential(const typename ContactValues<D>::Rows& values,
                      const std::array<Vec<D>, to_size(D)>& frame) {
  if constexpr (D == 2) {
    return values[1];
  } else {
    return values[1] * frame[1] + values[2] * frame[2];
  }
}

/// The moment of the values of a contact: its rows of rolling.
template <int D>
Spin<D> moment_of(const typename ContactValues<D>::Rows& values,
                  const std::array<Vec<D>, to_size(D)>& frame) {
  if constexpr (D == 2) {
    return values[2];
  } else {
    return values[3] * frame[1] + values[4] * frame[2] + values[5] * frame[0];
  }
}
double turning_work(const Wall<2>& wall, double moment) {
  return wall.is_circle() ? moment * wall.spin : 0.0;
}
double turning_work(const Wall<3>& wall, const Vec3& moment) {
  return wall.is_circle() ? wall.spin * wall.normal.dot(moment) : 0.0;
}

/// Adds the effect of a wall's impulse on a disk to the external sums.
template <int D>
void add_wall_impulse(const Wall<D>& wall, const Vec<D>& n, const Vec<D>& impulse,
                      StepOutcome<D>& outcome) {
  if (wall.motion == Wall<D>::Motion::kDriven) {
    // Impulses across the direction act on the guide of the wall.
    outcome.external += impulse - impulse.dot(wall.direction) * wall.direction;
  } else {
    outcome.external += impulse;
  }
  outcome.wall_work += impulse.dot(prescribed_velocity(wall, n));
}

/// Velocity of an image due to the sides of the cell that no force moves.
template <int D>
Vec2 prescribed_shift_velocity(const PeriodicCell& cell, const Contact<D>& contact) {
  PeriodicCell prescribed = cell;
  for (int k = 0; k < 3; ++k) {
    CellSide& side = prescribed.side(k);
    if (side.motion == CellSide::Motion::kDriven) side.speed = 0;
  }
  return prescribed.shift_velocity(contact.image_x, contact.image_y);
}

/// What contacts did alone, without gravity and driving forces.
template <int D>
StepOutcome<D> contact_outcomes(const Scene<D>& scene, const Midpoint<D>& mid,
                                std::span<const std::type_identity_t<Body<D>>> disks,
                                const ContactProblem& p, const AssembledStep& assembled,
                                const Vector& s, const Vector& v) {
  StepOutcome<D> outcome;
  outcome.contacts.resize(mid.contacts.size());
  const ContactProblem& given = without_equality_rows(p);  // in which v is
  Vector u = p.num_rows() > 0 ? Vector(given.H.transpose() * (v - given.v_free)) : Vector();
  u += given.u_free;
  if (assembled.shift.size() > 0) u -= assembled.shift;
  for (std::size_t c = 0; c < mid.contacts.size(); ++c) {
    const Contact<D>& contact = mid.contacts[c];
    const bool with_disk = to_size(contact.j) < disks.size();
    const int w = wall_of(disks, contact.j);
    const Wall<D>* wall = w < 0 ? nullptr : &mid.walls[to_size(w)];
    const ContactLaw& law = pair_law(scene, disks, mid.walls, contact.i, contact.j);
    const ContactValues<D> values = contact_values<D>(p, assembled, law, static_cast<int>(c), s, u);
    const Wall<D>* const touched = with_disk ? nullptr : &scene.walls[to_size(w)];
    const Tangent<D> s_t = tangential<D>(values.s, contact_axes<D>(contact.n, touched));
    const double friction = magnitude(tangential<D>(values.s, contact_frame<D>(contact.n)));
    const Eigen::Index row = static_cast<Eigen::Index>(c) * p.dim;
    const bool cohesive = assembled.pull.size() > 0;
    const double pull =
        cohesive ? assembled.pull[row] / (p.row_scale.size() == 0 ? 1.0 : p.row_scale[row]) : 0.0;
    const double s_n = values.s[0] - pull;
    outcome.contacts[c] = {.contact = contact,
                           .s_n = s_n,
                           .s_t = s_t,
                           .u_n = values.u_after[0],
                           .u_t = tangential<D>(values.u_after, dual_axes<D>(contact.n, touched)),
                           .status = contact_status(values.s[0], friction, law.mu),
                           .bonded = !cohesive || pull > 0,
                           .moment = moment_of<D>(values.s, contact_frame<D>(contact.n))};
    if (values.s[0] > 0) ++outcome.active;
    outcome.shock_loss -= values.s[0] * values.mean[0];
    outcome.cohesion_loss += pull * values.mean[0];
    for (std::size_t k = 1; k < to_size(std::max(p.dim, D)); ++k) {
      outcome.friction_loss -= values.s[k] * values.mean[k];
    }
    if (contact.with_image() && mid.cell.deforms()) {
      const Vec<D> impulse = s_n * contact.n + tangent_vector(contact.n, s_t);
      outcome.wall_work +=
          impulse.dot(in_dimensions<D>(prescribed_shift_velocity<D>(mid.cell, contact)));
    }
    if (wall == nullptr) continue;
    add_wall_impulse<D>(*wall, contact.n, s_n * contact.n + tangent_vector(contact.n, s_t),
                        outcome);
    if (p.rolls()) outcome.wall_work += turning_work(*wall, outcome.contacts[c].moment);
  }
  return outcome;
}

/// The forces that drive these walls, as they are in the step and after it, over its length.
template <int D>
void add_driving_forces(double step, std::span<const std::type_identity_t<Wall<D>>> walls,
                        std::span<const std::type_identity_t<Wall<D>>> walls_after,
                        StepOutcome<D>& outcome) {
  for (std::size_t w = 0; w < walls.size(); ++w) {
    const Wall<D>& wall = walls[w];
    if (wall.motion != Wall<D>::Motion::kDriven) continue;
    const Vec<D> push = step * wall.force * wall.direction;
    outcome.external += push;
    outcome.wall_work += push.dot(0.5 * (wall.v + walls_after[w].v));
  }
}

}  // namespace

ContactStatus contact_status(double s_n, double s_t, double mu) {
  if (s_n <= 0) return ContactStatus::kTakeOff;
  return std::abs(s_t) < kConeEdge * mu * s_n ? ContactStatus::kStick : ContactStatus::kSlip;
}

template <int D>
StepOutcome<D> step_outcome(const Scene<D>& scene, const Midpoint<D>& mid,
                            std::span<const std::type_identity_t<Body<D>>> disks,
                            const ContactProblem& p, const AssembledStep& assembled,
                            const Vector& s, const Vector& v, const State<D>& after,
                            bool count_walls) {
  const double h = scene.step;
  StepOutcome<D> outcome = contact_outcomes<D>(scene, mid, disks, p, assembled, s, v);
  for (const Body<D>& d : after.bodies) outcome.external += h * d.mass * mid.gravity;
  for (const Cluster<D>& c : mid.clusters.bodies) outcome.external += h * c.mass * mid.gravity;
  if (assembled.v_before.size() > 0) add_joint_outcome<D>(assembled, s, v, outcome);
  if (count_walls) add_driving_forces<D>(h, mid.walls, after.walls, outcome);
  for (int k = 0; k < 3; ++k) {
    const double force = stress_force(mid.cell, k);
    if (force != 0) {
      outcome.wall_work += h * force * 0.5 * (mid.cell.side(k).speed + after.cell.side(k).speed);
    }
  }
  return outcome;
}

template StepOutcome<2> step_outcome<2>(const Scene<2>&, const Midpoint<2>&, std::span<const Disk>,
                                        const ContactProblem&, const AssembledStep&, const Vector&,
                                        const Vector&, const State<2>&, bool);
template StepOutcome<3> step_outcome<3>(const Scene<3>&, const Midpoint<3>&,
                                        std::span<const Sphere>, const ContactProblem&,
                                        const AssembledStep&, const Vector&, const Vector&,
                                        const State<3>&, bool);

}  // namespace bipot
