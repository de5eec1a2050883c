#include "core/motion/step_outcome.h"

#include <cmath>

#include "core/problem/coulomb_cone.h"

namespace bipot {
namespace {

/// Normal and tangential values of one contact; the tangential ones are 0 without friction.
struct ContactValues {
  double s[2] = {0, 0};        // physical impulse
  double u_after[2] = {0, 0};  // relative velocity after the step
  double mean[2] = {0, 0};     // mean of the relative velocities before and after the step
};

/// u: Moreau's mean velocities in the problem's variables. Physical u⁺ = (1 + e) u - e u⁻ (36).
ContactValues contact_values(const ContactProblem& p, const AssembledStep& assembled,
                             const ContactLaw& law, int contact, const Vector& s, const Vector& u) {
  ContactValues values;
  for (int k = 0; k < p.dim; ++k) {
    const Eigen::Index row = contact * p.dim + k;
    const double e = k == 0 ? law.e_n : law.e_t;
    const double r = p.row_scale.size() == 0 ? 1.0 : p.row_scale[row];
    const double before = assembled.u_before[row];
    values.s[k] = s[row] / r;
    values.u_after[k] = (1 + e) * u[row] / r - e * before;
    values.mean[k] = 0.5 * (values.u_after[k] + before);
  }
  return values;
}

/// What a wall's impulse on a disk means for the world outside.
void add_wall_impulse(const Wall& wall, const Vec2& impulse, StepOutcome& outcome) {
  if (wall.motion == Wall::Motion::kDriven) {
    // What acts across the direction is taken by the wall's guide.
    outcome.external += impulse - impulse.dot(wall.direction) * wall.direction;
  } else {
    outcome.external += impulse;
    outcome.wall_work += impulse.dot(wall.v);
  }
}

}  // namespace

ContactStatus contact_status(double s_n, double s_t, double mu) {
  if (s_n <= 0) return ContactStatus::kTakeOff;
  return std::abs(s_t) < kConeEdge * mu * s_n ? ContactStatus::kStick : ContactStatus::kSlip;
}

StepOutcome step_outcome(const Scene& scene, const Midpoint& mid, const AssembledStep& assembled,
                         const Vector& s, const Vector& v, std::span<const Wall> walls_after) {
  const double h = scene.step;
  const ContactProblem& p = assembled.problem;
  const std::size_t num_disks = mid.disks.size();
  StepOutcome outcome;
  outcome.contacts.resize(mid.contacts.size());
  Vector u = p.num_rows() > 0 ? Vector(p.H.transpose() * (v - p.v_free)) : Vector();
  u += p.u_free;
  for (std::size_t c = 0; c < mid.contacts.size(); ++c) {
    const Contact& contact = mid.contacts[c];
    const std::size_t i = to_size(contact.i), j = to_size(contact.j);
    const Wall* wall = j < num_disks ? nullptr : &mid.walls[j - num_disks];
    const ContactLaw& law =
        scene.law(mid.disks[i].material, wall == nullptr ? mid.disks[j].material : wall->material);
    const ContactValues values = contact_values(p, assembled, law, static_cast<int>(c), s, u);
    outcome.contacts[c] = {.contact = contact,
                           .s_n = values.s[0],
                           .s_t = values.s[1],
                           .u_n = values.u_after[0],
                           .u_t = values.u_after[1],
                           .status = contact_status(values.s[0], values.s[1], law.mu)};
    if (values.s[0] > 0) ++outcome.active;
    outcome.shock_loss -= values.s[0] * values.mean[0];
    outcome.friction_loss -= values.s[1] * values.mean[1];
    if (wall == nullptr) continue;
    const Vec2 tangent(-contact.n[1], contact.n[0]);
    add_wall_impulse(*wall, values.s[0] * contact.n + values.s[1] * tangent, outcome);
  }
  for (const Disk& d : mid.disks) outcome.external += h * d.mass * scene.gravity;
  for (std::size_t w = 0; w < mid.walls.size(); ++w) {
    const Wall& wall = mid.walls[w];
    if (wall.motion != Wall::Motion::kDriven) continue;
    const Vec2 push = h * wall.force * wall.direction;
    outcome.external += push;
    outcome.wall_work += push.dot(0.5 * (wall.v + walls_after[w].v));
  }
  return outcome;
}

}  // namespace bipot
