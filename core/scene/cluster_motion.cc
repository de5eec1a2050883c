#include "core/scene/cluster_motion.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "core/scene/disk_union.h"

namespace bipot {

Vec2 turned_arm(const Cluster& cluster, const Vec2& arm) {
  if (cluster.angle == 0) return arm;
  return Eigen::Rotation2D<double>(cluster.angle) * arm;
}

template <int D>
void place_members(const Clusters& clusters, std::vector<Body<D>>& disks) {
  if constexpr (D == 2) {
    if (clusters.empty()) return;
    for (std::size_t i = 0; i < disks.size(); ++i) {
      Disk& d = disks[i];
      if (d.cluster < 0) continue;
      const Cluster& cluster = clusters.bodies[to_size(d.cluster)];
      const Vec2 arm = turned_arm(cluster, clusters.arms[i]);
      d.x = cluster.x + arm;
      d.v = cluster_velocity(cluster, arm);
      d.angle = cluster.angle;
      d.spin = cluster.spin;
    }
  }
}

void join_disks(Scene<2>& scene, std::size_t count, const ClusterMass& given) {
  const std::size_t first = scene.bodies.size() - count;
  std::vector<Circle> circles;
  for (std::size_t i = first; i < scene.bodies.size(); ++i) {
    for (const Circle& other : circles) {
      if (other.centre == scene.bodies[i].x) {
        throw std::invalid_argument("two disks of a cluster have the same centre");
      }
    }
    circles.push_back({scene.bodies[i].x, scene.bodies[i].radius});
  }
  const UnionMoments moments = union_moments(circles);
  Cluster body{.x = moments.centre,
               .mass = given.mass > 0 ? given.mass : given.density * moments.area,
               .area = moments.area};
  body.inertia = given.inertia > 0 ? given.inertia : body.mass * moments.polar / moments.area;
  if (count == 1) {
    Disk& disk = scene.bodies.back();
    const double a = disk.radius;  // the same bits as for [[disks]]
    disk.mass = given.mass > 0 ? given.mass : given.density * std::numbers::pi * a * a;
    disk.inertia = given.inertia > 0 ? given.inertia : 0.5 * disk.mass * a * a;
    if (!scene.clusters.empty()) scene.clusters.arms.resize(scene.bodies.size(), Vec2::Zero());
    return;
  }
  scene.clusters.arms.resize(scene.bodies.size(), Vec2::Zero());
  for (std::size_t i = first; i < scene.bodies.size(); ++i) {
    scene.bodies[i].mass = scene.bodies[i].inertia = 0;
    scene.bodies[i].cluster = static_cast<int>(scene.clusters.bodies.size());
    scene.clusters.arms[i] = scene.bodies[i].x - body.x;
  }
  scene.clusters.bodies.push_back(body);
}

template <int D>
std::string check_cluster_lengths(const std::vector<Body<D>>& disks, const PeriodicCell& cell,
                                  double eta) {
  const double period = shortest_period(cell);
  std::vector<std::vector<std::size_t>> members;
  for (std::size_t i = 0; i < disks.size(); ++i) {
    if (disks[i].cluster < 0) continue;
    const std::size_t c = to_size(disks[i].cluster);
    if (c >= members.size()) members.resize(c + 1);
    for (const std::size_t j : members[c]) {
      const double length = (disks[i].x - disks[j].x).norm() + disks[i].radius + disks[j].radius;
      if (period > length + eta) continue;
      return fmt::format(
          "the cell repeats itself after {:.6g} m: it must be longer than the clusters, of which "
          "number {} is {:.6g} m long, so that none touches itself",
          period, c, length);
    }
    members[c].push_back(i);
  }
  return {};
}

template <int D>
std::string check_clusters(const Scene<D>& scene) {
  const Clusters& clusters = scene.clusters;
  const int count = static_cast<int>(clusters.bodies.size());
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body<D>& d = scene.bodies[i];
    if (d.cluster < 0) continue;
    if (D == 3) return fmt::format("sphere {}: there are clusters of disks alone", i);
    if (d.cluster >= count) return fmt::format("disk {}: there is no cluster {}", i, d.cluster);
    if (d.wall >= 0) return fmt::format("disk {} is in a cluster and glued to a wall", i);
  }
  if (count == 0) return {};
  if (clusters.arms.size() != scene.bodies.size()) {
    return fmt::format("{} arms of clusters for {} disks", clusters.arms.size(),
                       scene.bodies.size());
  }
  for (int k = 0; k < count; ++k) {
    const Cluster& c = clusters.bodies[to_size(k)];
    const auto positive = [](double x) { return std::isfinite(x) && x > 0; };
    if (!positive(c.mass) || !positive(c.inertia) || !positive(c.area)) {
      return fmt::format("cluster {}: mass = {} kg, inertia = {} kg m², area = {} m² (all > 0)", k,
                         c.mass, c.inertia, c.area);
    }
    if (!c.x.allFinite() || !c.v.allFinite() || !std::isfinite(c.angle + c.spin)) {
      return fmt::format("cluster {}: its place or motion is not finite", k);
    }
  }
  if (scene.cell.periodic()) {
    if (auto e = check_cluster_lengths<D>(scene.bodies, scene.cell, scene.detection_distance());
        !e.empty()) {
      return e;
    }
  }
  if (scene.model == Model::kSpringDashpot) return "clusters do not go with the model \"dem\"";
  if (scene.start == StartChoice::kPushApart) {
    return "clusters do not go with [start] overlaps = \"push apart\"";
  }
  if (scene.project_overlaps) return "clusters do not go with overlaps = \"project\"";
  if (scene.predict_gaps) return "clusters do not go with overlaps = \"predict\"";
  return {};
}

template void place_members(const Clusters&, std::vector<Disk>&);
template void place_members(const Clusters&, std::vector<Sphere>&);
template std::string check_cluster_lengths<2>(const std::vector<Disk>&, const PeriodicCell&,
                                              double);
template std::string check_cluster_lengths<3>(const std::vector<Sphere>&, const PeriodicCell&,
                                              double);
template std::string check_clusters(const Scene<2>&);
template std::string check_clusters(const Scene<3>&);

}  // namespace bipot
