#include "core/motion/joint_rows.h"

#include <array>
#include <utility>

#include "core/base/triplets.h"
#include "core/problem/equality_rows.h"
#include "core/scene/cluster_motion.h"
#include "core/scene/joints.h"

namespace bipot {
namespace {

Vec2 turned_by(double angle, const Vec2& arm) { return Eigen::Rotation2D<double>(angle) * arm; }
Vec3 turned_by(const Vec3& angle, const Vec3& arm) {
  const double size = angle.norm();
  return size == 0 ? arm : Vec3(Eigen::AngleAxisd(size, angle / size) * arm);
}

/// The arm after a step of h, turned by the motion of its own body without torque.
Vec2 drifted(const Cluster<2>& cluster, double h, const Vec2& arm) {
  return turned_by(h * cluster.spin, arm);
}
Vec3 drifted(Cluster<3> cluster, double h, const Vec3& arm) {
  const Vec3 own = cluster.orientation.conjugate() * arm;
  drift(cluster, h);
  return cluster.orientation * own;
}

/// One end of a joint at mid-step, with the velocities before the step.
template <int D>
struct End {
  int dof = -1;                   // of its body; -1: the ground
  Vec<D> point = Vec<D>::Zero();  // [m]
  Vec<D> arm = Vec<D>::Zero();    // from the centre of mass [m]
  Vec<D> v = Vec<D>::Zero();      // of the point [m/s]
  Vec<D> bend = Vec<D>::Zero();   // its way in a step by turning, but for h v [m]
  const Cluster<D>* cluster = nullptr;

  End(int body, const Vec<D>& at, std::span<const std::type_identity_t<Body<D>>> bodies,
      const ClusterInput<D>& clusters, const DofMap& dofs, double h)
      : point(at) {
    if (body < 0) return;
    const Body<D>& b = bodies[to_size(body)];
    dof = dofs.disk[to_size(body)];
    Vec<D> centre = b.x;
    Vec<D> of_centre = b.v;
    if (b.cluster >= 0) {
      cluster = &clusters.bodies[to_size(b.cluster)];
      centre = cluster->x;
      of_centre = cluster->v;
    }
    arm = point - centre;
    v = of_centre + swept(b.spin, arm);
    const Vec<D> after = cluster ? drifted(*cluster, h, arm) : turned_by(h * b.spin, arm);
    bend = after - arm - h * swept(b.spin, arm);
  }

  /// Entries of the velocity of the point along the axis: a line of G or a column of H.
  template <class Add>
  void entries(const Vec<D>& axis, double sign, const Add& add) const {
    if (dof < 0) return;
    for (int k = 0; k < D; ++k) add(dof + k, sign * axis[k]);
    if constexpr (D == 2) {
      add(dof + D, sign * arm_times(arm, axis));
    } else {
      Vec3 turn = arm_times(arm, axis);
      if (cluster != nullptr) turn = in_own_axes(*cluster, turn);
      for (int k = 0; k < 3; ++k) add(dof + D + k, sign * turn[k]);
    }
  }
};

template <int D>
std::pair<End<D>, End<D>> ends_of(const Scene<D>& scene, const typename Scene<D>::Joint& joint,
                                  std::span<const std::type_identity_t<Body<D>>> bodies,
                                  const ClusterInput<D>& clusters, const DofMap& dofs) {
  const auto [from, to] = joint_points<D>(joint, bodies);
  return {End<D>(joint.i, from, bodies, clusters, dofs, scene.step),
          End<D>(joint.j, to, bodies, clusters, dofs, scene.step)};
}

void append(Vector& x, const std::vector<double>& values) {
  const auto more = static_cast<Eigen::Index>(values.size());
  x.conservativeResize(x.size() + more);
  x.tail(more) = Eigen::Map<const Vector>(values.data(), more);
}

}  // namespace

template <int D>
void add_ropes(const Scene<D>& scene, std::span<const std::type_identity_t<Body<D>>> bodies,
               const ClusterInput<D>& clusters, AssembledStep& step) {
  ContactProblem& p = step.problem;
  const double h = scene.step;
  Triplets entries;
  std::vector<double> free;
  for (const typename Scene<D>::Joint& joint : scene.joints) {
    if (!joint.is_rope()) continue;
    const auto [from, to] = ends_of<D>(scene, joint, bodies, clusters, step.dofs);
    const Vec<D> apart = from.point - to.point, w = from.v - to.v;
    const double distance = apart.norm();
    if (distance < 0.5 * joint.length) continue;  // slack, and without a direction at 0
    const Vec<D> n = -apart / distance;
    // After the midpoint the ends part as they met before it: w reflected at the rope's sphere.
    const Vec<D> parting = w - 2 * n.dot(w) * n;
    const Vec<D> then = apart + h * parting + from.bend - to.bend;
    const double shift = (joint.length - then.norm()) / h - n.dot(parting);
    const auto frame = contact_frame<D>(n);
    for (int row = 0; row < p.dim; ++row) {
      const int column = p.num_rows() + static_cast<int>(free.size());
      double u = row > 0 ? 0.0 : shift;
      const auto add = [&](int dof, double value) {
        entries.emplace_back(dof, column, value);
        u += value * p.v_free[dof];
      };
      if (row < D) {  // no rolling in a rope
        from.entries(frame[to_size(row)], 1, add);
        to.entries(frame[to_size(row)], -1, add);
      }
      free.push_back(u);
    }
  }
  if (free.empty()) return;
  const std::size_t ropes = free.size() / to_size(p.dim);
  enlarge(p.H, p.H.rows(), p.H.cols() + static_cast<Eigen::Index>(free.size()), entries);
  append(p.u_free, free);
  append(p.mu, std::vector<double>(ropes, 0.0));
  if (p.dim > D) append(p.mu_r, std::vector<double>(ropes, 0.0));
  if (p.dim == 6) append(p.mu_spin, std::vector<double>(ropes, 0.0));
  if (p.row_scale.size() > 0) append(p.row_scale, std::vector<double>(free.size(), 1.0));
  if (step.shift.size() > 0) append(step.shift, std::vector<double>(free.size(), 0.0));
}

template <int D>
void add_pins(const Scene<D>& scene, std::span<const std::type_identity_t<Body<D>>> bodies,
              const ClusterInput<D>& clusters, AssembledStep& step) {
  ContactProblem& p = step.problem;
  const double h = scene.step;
  step.v_before = p.v_free;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const int dof = step.dofs.disk[i];
    if (dof < 0) continue;
    const Body<D>& b = bodies[i];
    Vec<D> v = b.v;
    if (b.cluster >= 0) v = clusters.bodies[to_size(b.cluster)].v;
    step.v_before.template segment<D>(dof) = v;  // spins have no other cause of change
  }
  Triplets entries;
  std::vector<double> values;
  for (const typename Scene<D>::Joint& joint : scene.joints) {
    if (joint.is_rope()) continue;
    const auto [from, to] = ends_of<D>(scene, joint, bodies, clusters, step.dofs);
    const Vec<D> b = -(from.point - to.point + from.bend - to.bend) / h;
    for (int k = 0; k < D; ++k) {
      const int row = static_cast<int>(values.size());
      const auto add = [&](int dof, double value) { entries.emplace_back(row, dof, value); };
      from.entries(Vec<D>::Unit(k), 1, add);
      to.entries(Vec<D>::Unit(k), -1, add);
      values.push_back(b[k]);
    }
  }
  if (values.empty()) return;
  SparseRows G =
      from_triplets<SparseRows>(static_cast<Eigen::Index>(values.size()), p.H.rows(), entries);
  Vector b;
  append(b, values);
  p = with_equality_rows(std::move(p), std::move(G), std::move(b), true);
}

template <int D>
void add_joint_outcome(const AssembledStep& step, const Vector& s, const Vector& v,
                       StepOutcome<D>& outcome) {
  const ContactProblem& p = without_equality_rows(step.problem);
  const Eigen::Index contacts = step.u_before.size();  // rows without those of ropes
  const Vector impulse = p.A * (v - p.v_free) - p.H.leftCols(contacts) * s.head(contacts);
  outcome.joint_loss = -0.5 * impulse.dot(v + step.v_before);
  outcome.shock_loss += outcome.joint_loss;
  const Vector gain = p.v_free - step.v_before;
  outcome.from_rest = 0.5 * gain.dot(p.A * gain);
  std::vector<bool> added(to_size(impulse.size()), false);  // disks of a cluster share theirs
  for (const int dof : step.dofs.disk) {
    if (dof < 0 || added[to_size(dof)]) continue;
    added[to_size(dof)] = true;
    outcome.external += impulse.segment<D>(dof);
  }
}

template void add_ropes(const Scene<2>&, std::span<const Disk>, const ClusterInput<2>&,
                        AssembledStep&);
template void add_ropes(const Scene<3>&, std::span<const Sphere>, const ClusterInput<3>&,
                        AssembledStep&);
template void add_pins(const Scene<2>&, std::span<const Disk>, const ClusterInput<2>&,
                       AssembledStep&);
template void add_pins(const Scene<3>&, std::span<const Sphere>, const ClusterInput<3>&,
                       AssembledStep&);
template void add_joint_outcome(const AssembledStep&, const Vector&, const Vector&,
                                StepOutcome<2>&);
template void add_joint_outcome(const AssembledStep&, const Vector&, const Vector&,
                                StepOutcome<3>&);

}  // namespace bipot
