#pragma once

#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace bipot {

/// From the centre of mass of the cluster to the disk, at the present rotation. [m]
Vec2 turned_arm(const Cluster& cluster, const Vec2& arm);

/// Velocity of a point of the cluster at an arm from the centre of mass. [m/s]
inline Vec2 cluster_velocity(const Cluster& cluster, const Vec2& arm) {
  return cluster.v + cluster.spin * Vec2(-arm[1], arm[0]);
}

/// Moves the cluster with its present velocities for a time h.
inline void drift(Cluster& cluster, double h) {
  cluster.x += h * cluster.v;
  cluster.angle += h * cluster.spin;
}

/// Sets position, angle, velocity and spin of the disks that belong to clusters. Nothing in 3D.
template <int D>
void place_members(const Clusters& clusters, std::vector<Body<D>>& disks);

/// Joins the last `count` disks of a scene to a cluster at rest, with the mass (or density) and
/// inertia given. Position, radius and material of the disks must be set. Without inertia, that of
/// their union as a homogeneous body counts. A single disk remains a disk. Throws
/// std::invalid_argument for two disks with one centre.
struct ClusterMass {
  double mass = 0;     ///< > 0, or 0: by density                                     [kg]
  double density = 0;  ///< of the union, where no mass is given               [kg/m³]
  double inertia = 0;  ///< about the centre of mass; 0: homogeneous               [kg m²]
};
void join_disks(Scene<2>& scene, std::size_t count, const ClusterMass& given);

/// Empty if no cluster is so long that it may touch an image of itself, else an error message.
template <int D>
std::string check_cluster_lengths(const std::vector<Body<D>>& disks, const PeriodicCell& cell,
                                  double eta);

/// Empty for sound clusters, else one sentence that names the entry and its value.
template <int D>
std::string check_clusters(const Scene<D>& scene);

}  // namespace bipot
