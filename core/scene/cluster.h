#pragma once

#include <vector>

#include "core/base/types.h"

namespace bipot {

/// Disks that are joined rigidly: one body with three degrees of freedom at its centre of mass.
struct Cluster {
  Vec2 x = Vec2::Zero();  ///< centre of mass                         [m]
  double angle = 0;       ///< rotation since the start               [rad]
  Vec2 v = Vec2::Zero();  ///< velocity of the centre of mass         [m/s]
  double spin = 0;        ///< angular velocity, counter-clockwise    [rad/s]
  double mass = 0;        ///< > 0                                    [kg]
  double inertia = 0;     ///< > 0, about the centre of mass          [kg m²]
  double area = 0;        ///< > 0, of the union of its disks         [m²]
};

/// The clusters of a scene or a state. A disk of a cluster (Body::cluster) has no mass of its own.
/// Its position and velocity follow from its cluster (core/scene/cluster_motion.h).
struct Clusters {
  std::vector<Cluster> bodies;
  std::vector<Vec2>
      arms;  ///< of each disk of the scene: from the centre of mass of its cluster to its
             ///< own, before anything turned; empty without clusters [m]

  bool empty() const { return bodies.empty(); }
};

}  // namespace bipot
