#include "core/motion/assembly.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/base/large_pages.h"
#include "core/base/parallel.h"
#include "core/motion/contact_axes.h"
#include "core/motion/joint_rows.h"
#include "core/problem/delassus.h"
#include "core/scene/cluster_motion.h"
#include "core/scene/wall_motion.h"

namespace bipot {

namespace {

/// Sets the first dofs of the disks in contact (marked by 0); all disks of a cluster share one set.
template <int D>
void number_disks(std::span<const Body<D>> disks, std::size_t clusters, DofMap& dofs) {
  std::vector<int> of_cluster(clusters, -1);
  for (std::size_t i = 0; i < disks.size(); ++i) {
    if (dofs.disk[i] < 0) continue;
    const int cluster = disks[i].cluster;
    int& first = cluster < 0 ? dofs.disk[i] : of_cluster[to_size(cluster)];
    if (cluster < 0 || first < 0) {
      first = dofs.size;
      dofs.size += dofs.per_disk;
    }
    dofs.disk[i] = first;
  }
}

template <int D>
DofMap number_dofs(const StepInput<D>& in) {
  const std::size_t clusters = in.clusters.bodies.size();
  const bool turn = in.scene.has_friction() || clusters > 0 || !in.scene.joints.empty();
  DofMap dofs{.per_disk = turn ? D + kSpins<D> : D};
  dofs.disk.assign(in.bodies.size(), -1);
  dofs.wall.assign(in.walls.size(), -1);
  for (const Contact<D>& c : in.contacts) {
    dofs.disk[to_size(c.i)] = 0;
    const int w = wall_of(in.bodies, c.j);
    if (w < 0) {
      dofs.disk[to_size(c.j)] = 0;
    } else if (in.walls[to_size(w)].motion == Wall<D>::Motion::kDriven) {
      dofs.wall[to_size(w)] = 0;
    }
  }
  for (const typename Scene<D>::Joint& joint : in.scene.joints) {
    dofs.disk[to_size(joint.i)] = 0;
    if (joint.j >= 0) dofs.disk[to_size(joint.j)] = 0;
  }
  number_disks<D>(in.bodies, clusters, dofs);
  for (int& dof : dofs.wall) {
    if (dof == 0) dof = dofs.size++;
  }
  const PeriodicCell* const cell = in.cell.cell;
  if (cell == nullptr) return dofs;
  for (int k = 0; k < 3; ++k) {
    if (cell->side(k).motion != CellSide::Motion::kDriven) continue;
    const bool used = std::any_of(in.contacts.begin(), in.contacts.end(), [&](const auto& c) {
      return !side_share(*cell, k, c.image_x, c.image_y).isZero(0);
    });
    if (used) dofs.side[k] = dofs.size++;
  }
  return dofs;
}

/// Writes columns of H one after the other from a given place on, rows ascending.
class ColumnWriter {
 public:
  ColumnWriter(SparseMatrix& H, int column, int at) : H_(H), column_(column), at_(at) {}
  void add(int row, double value) {
    H_.innerIndexPtr()[at_] = row;
    H_.valuePtr()[at_++] = value;
  }
  void close() { H_.outerIndexPtr()[++column_] = at_; }

 private:
  SparseMatrix& H_;
  int column_, at_;
};

/// Number of degrees of freedom of the cell at which a contact has entries.
template <int D>
int sides_of(const Contact<D>& contact, const DofMap& dofs, const PeriodicCell* cell) {
  int count = 0;
  for (int k = 0; k < 3; ++k) {
    if (dofs.side[k] < 0) continue;
    if (!side_share(*cell, k, contact.image_x, contact.image_y).isZero(0)) ++count;
  }
  return count;
}

/// Adds the velocity of the image of j relative to j: before the step, and without contacts.
template <int D>
void add_image_velocity(const CellInput& input, const Contact<D>& contact, Vec<D>& before,
                        Vec<D>& free) {
  if (input.cell == nullptr || !contact.with_image()) return;
  PeriodicCell cell = *input.cell;
  before += in_dimensions<D>(cell.shift_velocity(contact.image_x, contact.image_y));
  for (int k = 0; k < 3; ++k) cell.side(k).speed = input.v_free[k];
  free += in_dimensions<D>(cell.shift_velocity(contact.image_x, contact.image_y));
}

/// The moment n x axis of a tangential force at the arm n. In the plane along e3: 1.
template <int D>
Spin<D> unit_moment(const Vec<D>& n, const Vec<D>& axis) {
  if constexpr (D == 2) {
    return 1;
  } else {
    return n.cross(axis);
  }
}

/// The entries of H at a spin, from `row` on.
void add_moment(ColumnWriter& columns, int row, double moment) { columns.add(row, moment); }
void add_moment(ColumnWriter& columns, int row, const Vec3& moment) {
  for (int k = 0; k < 3; ++k) columns.add(row + k, moment[k]);
}

/// Number of entries of H in the columns of a contact.
template <int D>
int entries_of(const StepInput<D>& in, const Contact<D>& contact, const DofMap& dofs, int d) {
  const std::span<const Body<D>> disks = in.bodies;
  const int turning = std::max(0, d - D);  // rows of rolling
  d -= turning;
  int of_disk = D + (d - 1) * (D + kSpins<D>)+turning * kSpins<D>;
  const int w = wall_of(disks, contact.j);
  const int of_cell = d * sides_of(contact, dofs, in.cell.cell);
  // In a cluster the normal force turns the body as well.
  const int of_normal = kSpins<D> * ((disks[to_size(contact.i)].cluster >= 0 ? 1 : 0) +
                                     (w < 0 && disks[to_size(contact.j)].cluster >= 0 ? 1 : 0));
  if (w < 0) return 2 * of_disk + of_cell + of_normal;
  of_disk += of_normal;
  return of_disk + of_cell + (dofs.wall[to_size(w)] >= 0 ? d : 0);
}

/// The moment (arm n + c) x axis on the cluster of a body, with c from the centre of mass to the
/// body, in the degrees of freedom of its spin. `side` -1: c with the other sign.
template <int D>
Spin<D> cluster_moment(const ClusterInput<D>& clusters, const Body<D>& body, double arm,
                       const Vec<D>& n, const Vec<D>& axis, double side) {
  const Cluster<D>& cluster = clusters.bodies[to_size(body.cluster)];
  const Vec<D> c = body.x - cluster.x;
  return in_own_axes(cluster, Spin<D>(arm * unit_moment<D>(n, axis) + side * arm_times(c, axis)));
}

/// 1 over the distance between the centres of a contact: its normal turns by the way across n over
/// this distance. Negative in a hollow circle, 0 on a plane.                               [1/m]
template <int D>
double bend_of(const Contact<D>& contact, const Body<D>& body, const Body<D>* other,
               const Wall<D>* wall) {
  double distance = contact.gap + body.radius;
  if (other != nullptr) {
    distance += other->radius;
  } else if (wall->is_circle()) {
    const bool hollow = wall->shape == Wall<D>::Shape::kHollowCircle;
    distance += hollow ? -wall->radius : wall->radius;
  } else {
    const bool half_plane = wall->shape == Wall<D>::Shape::kHalfPlane;
    const Vec<D> along = wall->b - wall->a;
    if (half_plane || std::abs(contact.n.dot(along)) < 1e-9 * along.norm()) return 0;
  }
  return distance == 0 ? 0 : 1 / distance;
}

/// Acceleration of a disk's centre by the turning of its cluster.
template <int D>
Vec<D> pull_of(const ClusterInput<D>& clusters, const Body<D>& disk) {
  if constexpr (D == 2) {
    if (disk.cluster >= 0) {
      const Cluster<D>& cluster = clusters.bodies[to_size(disk.cluster)];
      return -cluster.spin * cluster.spin * (disk.x - cluster.x);
    }
  }
  return Vec<D>::Zero();
}

/// Acceleration of the surface of the wall that a contact acts on, where it is prescribed.
template <int D>
Vec<D> wall_acceleration(const StepInput<D>& in, const Contact<D>& contact) {
  const int w = wall_of(in.bodies, contact.j);
  if (w < 0 || in.walls[to_size(w)].factor_rate == 0) return Vec<D>::Zero();
  const Wall<D>& whole = in.scene.walls[to_size(w)];
  const bool glued = to_size(contact.j) < in.bodies.size();
  return in.walls[to_size(w)].factor_rate *
         (glued ? whole.v : surface_velocity(whole, whole.v, contact.n));
}

/// Half of the change of a contact's velocity in a step in which only its normal and the clusters
/// turn, and walls change their prescribed velocity: δ of data/manual/explanation/accuracy.md,
/// along n and the tangents [m/s]. b: null at a wall.
template <int D>
Vec<D> half_turn(const StepInput<D>& in, const Contact<D>& contact,
                 const std::array<Vec<D>, to_size(D)>& frame, const Body<D>& a, const Body<D>* b,
                 const Wall<D>* wall) {
  const Vec<D>& n = frame[0];
  Vec<D> other = b != nullptr ? b->v : wall->v, unused = other, pull = pull_of<D>(in.clusters, a);
  add_image_velocity<D>(in.cell, contact, other, unused);
  Vec<D> w = a.v - other;
  Spin<D> arms = a.radius * a.spin;
  if (b != nullptr) {
    arms += b->radius * b->spin;
    pull -= pull_of<D>(in.clusters, *b);
  }
  w -= n.dot(w) * n;
  if constexpr (D == 3) {
    if (b == nullptr && wall->is_circle()) w -= w.dot(wall->normal) * wall->normal;
  }
  const std::size_t j = to_size(contact.j);
  const Body<D>* const disk = j < in.bodies.size() ? &in.bodies[j] : nullptr;
  const Vec<D> turn = bend_of<D>(contact, a, disk, wall) * w;  // of n in time
  Vec<D> change = Vec<D>::Zero();
  change[0] = w.dot(turn) + n.dot(pull);
  if constexpr (D == 3) {
    for (int k = 1; k < 3; ++k) change[k] = -frame[to_size(k)].dot(arms.cross(turn));
  }
  const Vec<D> wall_pull = wall_acceleration(in, contact);
  for (int k = 0; k < D; ++k) change[k] -= frame[to_size(k)].dot(wall_pull);
  return 0.5 * in.scene.step * change;
}

/// Angular velocity of a wall: circles alone turn.
double spin_of(const Wall<2>& wall) { return wall.is_circle() ? wall.spin : 0.0; }
Vec3 spin_of(const Wall<3>& wall) {
  return wall.is_circle() ? Vec3(wall.spin * wall.normal) : Vec3(Vec3::Zero());
}

/// The moment's axis in row D, D + 1 ... of a contact: e3 in the plane, then in space the tangents
/// and the normal.
double rolling_axis(const std::array<Vec2, 2>& /*frame*/, int /*k*/) { return 1; }
Vec3 rolling_axis(const std::array<Vec3, 3>& frame, int k) { return frame[to_size((k + 1) % 3)]; }

/// The rows of rolling: the spin of body i less that of j, or of the wall. `k`, `l`: first degrees
/// of freedom of the bodies, l < 0 at a wall.
template <int D>
void write_rolling(const ClusterInput<D>& clusters, const Body<D>& a, const Body<D>* b,
                   const Spin<D>& turning, const ContactLaw& law,
                   const std::array<Vec<D>, to_size(D)>& frame, int c, int k, int l,
                   ColumnWriter& columns, AssembledStep& step) {
  ContactProblem& p = step.problem;
  const double r_n = std::sqrt(1 + law.e_n), r_t = std::sqrt(1 + law.e_t);
  p.mu_r[c] = law.mu_r * r_t / r_n;
  if (D == 3) p.mu_spin[c] = law.mu_spin * r_t / r_n;
  for (int row = D; row < p.dim; ++row) {
    const Spin<D> axis = rolling_axis(frame, row - D);
    const double before = inner(axis, turning);
    step.u_before[c * p.dim + row] = before;
    p.u_free[c * p.dim + row] = (1 + law.e_t) * before / r_t;  // only contacts exert torques
    if (p.row_scale.size() > 0) p.row_scale[c * p.dim + row] = r_t;
    const auto along_own = [&](const Body<D>& body, const Spin<D>& x) {
      return body.cluster < 0 ? x : in_own_axes(clusters.bodies[to_size(body.cluster)], x);
    };
    add_moment(columns, k + D, along_own(a, Spin<D>(axis / r_t)));
    if (l >= 0) add_moment(columns, l + D, along_own(*b, Spin<D>(-axis / r_t)));
    columns.close();
  }
}

/// The columns and rows of contact c.
template <int D>
void write_contact(const StepInput<D>& in, const Contact<D>& contact, int c, ColumnWriter& columns,
                   AssembledStep& step) {
  const DofMap& dofs = step.dofs;
  ContactProblem& p = step.problem;
  const int d = p.dim;
  const std::size_t i = to_size(contact.i), j = to_size(contact.j);
  const int at_wall = wall_of(in.bodies, contact.j);
  const bool with_disk = at_wall < 0;
  const std::size_t w = with_disk ? 0 : to_size(at_wall);
  const Body<D>& a = in.bodies[i];
  const Body<D>* b = with_disk ? &in.bodies[j] : nullptr;
  const Wall<D>* wall = with_disk ? nullptr : &in.walls[w];
  const ContactLaw& law = pair_law(in.scene, in.bodies, in.walls, contact.i, contact.j);
  const double r_n = std::sqrt(1 + law.e_n), r_t = std::sqrt(1 + law.e_t);
  p.mu[c] = d > 1 ? law.mu * r_t / r_n : 0.0;

  Vec<D> other_before, other_free;
  if (with_disk) {
    other_before = b->v;
    other_free = in.body_v_free[j];
  } else {
    const bool driven = wall->motion == Wall<D>::Motion::kDriven;
    const Vec<D> free = driven ? driven_velocity(*wall, in.wall_v_free[w]) : wall->v;
    other_before = surface_velocity(*wall, wall->v, contact.n);
    other_free = surface_velocity(*wall, free, contact.n);
  }
  add_image_velocity<D>(in.cell, contact, other_before, other_free);
  const int k = dofs.disk[i];
  const int l = with_disk ? dofs.disk[j] : dofs.wall[w];
  const auto frame = contact_axes<D>(contact.n, wall == nullptr ? nullptr : &in.scene.walls[w]);
  const bool turns_a = a.cluster >= 0, turns_b = with_disk && b->cluster >= 0;
  Vec<D> turn = Vec<D>::Zero();
  if (in.scene.accuracy > 0) turn = half_turn<D>(in, contact, frame, a, b, wall);
  for (int row = 0; row < std::min(d, D); ++row) {
    const Vec<D>& axis = frame[to_size(row)];
    const double e = row == 0 ? law.e_n : law.e_t;
    const double r = row == 0 ? r_n : r_t;
    const double arm_a = row == 0 ? 0 : -a.radius;
    const double arm_b = row == 0 || !with_disk ? 0 : -b->radius;
    const Spin<D> moment = unit_moment<D>(contact.n, axis);
    const double spin_part =
        arm_a * inner(moment, a.spin) + (with_disk ? arm_b * inner(moment, b->spin) : 0.0);
    const double before = axis.dot(a.v - other_before) + spin_part;
    const double free = axis.dot(in.body_v_free[i] - other_free) + spin_part;
    step.u_before[c * d + row] = before;
    p.u_free[c * d + row] = (free + e * before) / r;
    if (p.row_scale.size() > 0) p.row_scale[c * d + row] = r;
    if (step.shift.size() > 0) {
      double& shift = step.shift[c * d + row];
      if (in.scene.accuracy > 0) shift = (1 - e) * turn[row] / r;
      const bool closes = in.scene.accuracy == 0 || !in.cohesion.empty();
      if (row == 0 && contact.gap > 0 && closes) shift += contact.gap / (in.scene.step * r);
      p.u_free[c * d + row] += shift;
    }

    for (int x = 0; x < D; ++x) columns.add(k + x, axis[x] / r);
    if (turns_a) {
      const Spin<D> whole = cluster_moment<D>(in.clusters, a, arm_a, contact.n, axis, 1);
      add_moment(columns, k + D, Spin<D>(whole / r));
    } else if (row > 0) {
      add_moment(columns, k + D, Spin<D>(arm_a / r * moment));
    }
    if (with_disk) {
      for (int x = 0; x < D; ++x) columns.add(l + x, -axis[x] / r);
      if (turns_b) {
        const Spin<D> whole = cluster_moment<D>(in.clusters, *b, arm_b, contact.n, axis, -1);
        add_moment(columns, l + D, Spin<D>(whole / r));
      } else if (row > 0) {
        add_moment(columns, l + D, Spin<D>(arm_b / r * moment));
      }
    } else if (l >= 0) {
      columns.add(l, -axis.dot(wall->direction) / r);
    }
    for (int side = 0; side < 3; ++side) {
      if (dofs.side[side] < 0) continue;
      const Vec2 share = side_share(*in.cell.cell, side, contact.image_x, contact.image_y);
      if (share.isZero(0)) continue;
      columns.add(dofs.side[side], -share.dot(axis.template head<2>()) / r);
    }
    columns.close();
  }
  // What a solve leaves of an approach gets smaller in every step. Once it is below the rounding of
  // the sliding velocity, no tolerance on it can be proved.
  double& approach = p.u_free[c * d];
  const double slip =
      std::min(d, D) < 2 ? 0 : p.u_free.segment(c * d + 1, std::min(d, D) - 1).norm();
  if (std::abs(approach) < std::numeric_limits<double>::epsilon() * slip) approach = 0;
  if (!p.rolls()) return;
  const Spin<D> turning = a.spin - (with_disk ? b->spin : spin_of(*wall));
  write_rolling<D>(in.clusters, a, b, turning, law, contact_frame<D>(contact.n), c, k,
                   with_disk ? l : -1, columns, step);
}

/// Cohesion as forces on the bodies: they change v_free and u_free.
void add_cohesion(double h, std::span<const double> forces, AssembledStep& step) {
  ContactProblem& p = step.problem;
  step.pull = Vector::Zero(p.num_rows());
  for (std::size_t c = 0; c < forces.size(); ++c) {
    const Eigen::Index row = static_cast<Eigen::Index>(c) * p.dim;
    const double r = p.row_scale.size() > 0 ? p.row_scale[row] : 1.0;
    step.pull[row] = r * h * forces[c];
  }
  if (p.num_rows() == 0) return;
  const Vector v = (p.H * step.pull).cwiseQuotient(p.A.diagonal());
  p.v_free -= v;
  p.u_free -= p.H.transpose() * v;
}

/// Sets masses and free velocities of the clusters in contact.
template <int D>
void fill_clusters(const StepInput<D>& in, const DofMap& dofs, Vector& mass, Vector& v_free) {
  if (in.clusters.bodies.empty()) return;
  for (std::size_t i = 0; i < in.bodies.size(); ++i) {
    const int k = dofs.disk[i];
    if (k < 0 || in.bodies[i].cluster < 0) continue;
    const std::size_t c = to_size(in.bodies[i].cluster);
    const Cluster<D>& cluster = in.clusters.bodies[c];
    mass.segment<D>(k).setConstant(cluster.mass);
    v_free.segment<D>(k) = in.clusters.v_free[c];
    mass.segment<kSpins<D>>(k + D) << cluster.inertia;
    v_free.segment<kSpins<D>>(k + D) << own_spin(cluster);
  }
}

}  // namespace

template <int D>
AssembledStep assemble_step(const StepInput<D>& input, int threads) {
  StepInput<D> in = input;
  if (in.cell.cell != nullptr && !in.cell.cell->deforms()) in.cell = {};  // its images stand still
  const Scene<D>& scene = in.scene;
  const bool friction = scene.has_friction();
  const int num_contacts = static_cast<int>(in.contacts.size());
  // Without contacts nothing rolls, and a problem has no coefficients that would say so.
  const int d = num_contacts > 0 ? scene.contact_rows() : (friction ? D : 1);

  AssembledStep step{.dofs = number_dofs(in)};
  const DofMap& dofs = step.dofs;
  ContactProblem& p = step.problem;
  p.dim = d;

  Vector mass(dofs.size);
  p.v_free.resize(dofs.size);
  run_pieces(threads, static_cast<int>(in.bodies.size()), [&](int begin, int end) {
    for (std::size_t i = to_size(begin); i < to_size(end); ++i) {
      const int k = dofs.disk[i];
      const Body<D>& body = in.bodies[i];
      if (k < 0 || body.cluster >= 0) continue;
      mass.template segment<D>(k).setConstant(body.mass);
      p.v_free.template segment<D>(k) = in.body_v_free[i];
      if (dofs.per_disk > D) {
        mass.template segment<kSpins<D>>(k + D).setConstant(body.inertia);
        p.v_free.template segment<kSpins<D>>(k + D) << body.spin;  // only contacts exert torques
      }
    }
  });
  fill_clusters(in, dofs, mass, p.v_free);
  for (std::size_t w = 0; w < in.walls.size(); ++w) {
    if (dofs.wall[w] < 0) continue;
    mass[dofs.wall[w]] = in.walls[w].mass;
    p.v_free[dofs.wall[w]] = in.wall_v_free[w];
  }
  for (int k = 0; k < 3; ++k) {
    if (dofs.side[k] < 0) continue;
    mass[dofs.side[k]] = in.cell.cell->side(k).mass;
    p.v_free[dofs.side[k]] = in.cell.v_free[k];
  }
  p.A = mass.asDiagonal();

  bool any_restitution = false;
  for (const ContactLaw& law : scene.laws) any_restitution |= law.e_n != 0 || law.e_t != 0;
  p.mu = large_vector(num_contacts);
  if (d > D) p.mu_r.resize(num_contacts);
  if (d == 6) p.mu_spin.resize(num_contacts);
  p.u_free = large_vector(d * num_contacts);
  step.u_before = large_vector(d * num_contacts);
  if (scene.predict_gaps || scene.accuracy > 0 || !in.cohesion.empty()) {
    step.shift = Vector::Zero(d * num_contacts);
  }
  if (any_restitution) p.row_scale = large_vector(d * num_contacts);

  // First entry of each contact's columns, which several threads write.
  std::vector<int> start(to_size(num_contacts) + 1, 0);
  run_pieces(threads, num_contacts, [&](int begin, int end) {
    for (std::size_t c = to_size(begin); c < to_size(end); ++c) {
      start[c + 1] = entries_of(in, in.contacts[c], dofs, d);
    }
  });
  std::partial_sum(start.begin(), start.end(), start.begin());
  p.H.resize(dofs.size, d * num_contacts);
  p.H.resizeNonZeros(start.back());
  p.H.outerIndexPtr()[0] = 0;
  run_pieces(threads, num_contacts, [&](int begin, int end) {
    ColumnWriter columns(p.H, d * begin, start[to_size(begin)]);
    for (int c = begin; c < end; ++c) write_contact(in, in.contacts[to_size(c)], c, columns, step);
  });
  if (!scene.joints.empty()) add_ropes<D>(scene, in.bodies, in.clusters, step);
  if (!in.cohesion.empty()) add_cohesion(scene.step, in.cohesion, step);
  if (!scene.joints.empty()) add_pins<D>(scene, in.bodies, in.clusters, step);
  return step;
}

template AssembledStep assemble_step(const StepInput<2>&, int);
template AssembledStep assemble_step(const StepInput<3>&, int);

}  // namespace bipot
