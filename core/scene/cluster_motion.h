#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/scene/contact_frame.h"
#include "core/scene/scene.h"

namespace bipot {

/// From the centre of mass of the cluster to the body, at the present rotation. [m]
Vec2 turned_arm(const Cluster<2>& cluster, const Vec2& arm);
inline Vec3 turned_arm(const Cluster<3>& cluster, const Vec3& arm) {
  return cluster.orientation * arm;
}

/// A vector along the present principal axes. In 2D nothing changes.
inline double in_own_axes(const Cluster<2>& /*cluster*/, double x) { return x; }
inline Vec3 in_own_axes(const Cluster<3>& cluster, const Vec3& x) {
  return (cluster.orientation * cluster.axes).conjugate() * x;
}

/// The spin in the degrees of freedom of a problem: along the principal axes. [rad/s]
template <int D>
Spin<D> own_spin(const Cluster<D>& cluster) {
  return in_own_axes(cluster, cluster.spin);
}
inline void set_own_spin(Cluster<2>& cluster, const Vector& v, int row) { cluster.spin = v[row]; }
inline void set_own_spin(Cluster<3>& cluster, const Vector& v, int row) {
  cluster.spin = cluster.orientation * (cluster.axes * Vec3(v.segment<3>(row)));
}

/// Kinetic energy of the rotation [J], and angular momentum about the centre of mass [kg m²/s].
inline double turning_energy(const Disk& d) { return 0.5 * d.inertia * d.spin * d.spin; }
inline double turning_energy(const Sphere& s) { return 0.5 * s.inertia * s.spin.squaredNorm(); }
inline double turning_energy(const Cluster<2>& c) { return 0.5 * c.inertia * c.spin * c.spin; }
inline double own_momentum(const Cluster<2>& c) { return c.inertia * c.spin; }
double turning_energy(const Cluster<3>& cluster);
Vec3 own_momentum(const Cluster<3>& cluster);

/// Moves the cluster with its present velocities for a time h.
inline void drift(Cluster<2>& cluster, double h) {
  cluster.x += h * cluster.v;
  cluster.angle += h * cluster.spin;
}

/// The same in 3D, where a cluster turns without torque. In its principal axes Euler's equations L' =
/// L x I⁻¹L are solved by the implicit mid-point rule: with M the mean of both L,
///
///     L⁺ = L + h M x I⁻¹M,     R⁺ = R cay(h I⁻¹M),
///
/// cay: the turn by 2 atan(h|I⁻¹M|/2) about I⁻¹M. Energy and momentum R L are kept to rounding; the
/// order is 2 (Austin, Krishnaprasad, Wang, J. Comput. Phys. 107, 1993). The spin changes: it is not
/// constant in space. Turns by more than a quarter of a radian are cut into parts.
void drift(Cluster<3>& cluster, double h);

/// Sets place, rotation, velocity and spin of the bodies that belong to clusters.
template <int D>
void place_members(const Clusters<D>& clusters, std::vector<Body<D>>& bodies);

/// Joins the last `count` disks of a scene to a cluster at rest, with the mass (or density) and
/// inertia given. Position, radius and material of the disks must be set. Without inertia, that of
/// their union as a homogeneous body counts. A single disk remains a disk. Throws
/// std::invalid_argument for two disks with one centre.
void join_disks(Scene<2>& scene, std::size_t count, const Clusters<2>::Mass& given);

/// The spheres as one body at rest, to be added by add_cluster(). An inertia given has its moments
/// about the axes of space. Throws std::invalid_argument for two spheres with one centre.
Cluster<3> joined(std::span<const Sphere> spheres, const Clusters<3>::Mass& given);
/// Adds this cluster, turned about its centre of mass, which comes to x, and its spheres with its
/// motion. `spheres`: those of which it was joined, with radius and material.
void add_cluster(Scene<3>& scene, Cluster<3> cluster, std::span<const Sphere> spheres,
                 const Vec3& x, const Eigen::Quaterniond& turn);

/// Empty if no cluster is so long that it may touch an image of itself, else an error message.
template <int D>
std::string check_cluster_lengths(const std::vector<Body<D>>& disks, const PeriodicCell& cell,
                                  double eta);

/// Empty for sound clusters, else one sentence that names the entry and its value.
template <int D>
std::string check_clusters(const Scene<D>& scene);

}  // namespace bipot
