#include "core/scene/cluster_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "core/scene/disk_union.h"
#include "core/scene/sphere_union.h"

namespace bipot {

namespace {

/// Newton's method for the mean angular momentum of the mid-point rule; in the principal axes.
Vec3 mean_momentum(const Vec3& start, const Vec3& inertia, double h) {
  Vec3 mean = start;
  for (int k = 0; k < 20; ++k) {
    const Vec3 spin = mean.cwiseQuotient(inertia);
    const Vec3 residual = mean - start - 0.5 * h * mean.cross(spin);
    const Mat<3> slope =
        Mat<3>::Identity() -
        0.5 * h * (cross_matrix(mean) * inertia.cwiseInverse().asDiagonal() - cross_matrix(spin));
    const Vec3 change = slope.inverse() * residual;
    mean -= change;
    if (!(change.norm() > 1e-16 * mean.norm())) break;
  }
  return mean;
}

/// Sets position, rotation and motion of one member.
template <int D>
void place(const Cluster<D>& cluster, const Vec<D>& at, Body<D>& body) {
  const Vec<D> arm = turned_arm(cluster, at);
  body.x = cluster.x + arm;
  body.v = cluster.v + swept(cluster.spin, arm);
  body.spin = cluster.spin;
  if constexpr (D == 2) {
    body.angle = cluster.angle;
  } else {
    body.orientation = cluster.orientation;
  }
}

template <int D>
void require_different_centres(std::span<const Body<D>> bodies) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (bodies[i].x != bodies[j].x) continue;
      throw std::invalid_argument(
          fmt::format("two {}s of a cluster have the same centre", kBodyName<D>));
    }
  }
}

bool positive(double x) { return std::isfinite(x) && x > 0; }
bool positive(const Vec3& x) { return x.allFinite() && x.minCoeff() > 0; }
bool finite_turn(const Cluster<2>& c) { return std::isfinite(c.angle + c.spin); }
bool finite_turn(const Cluster<3>& c) {
  return c.orientation.coeffs().allFinite() && c.spin.allFinite();
}
std::string inertia_text(double x) { return fmt::format("{}", x); }
std::string inertia_text(const Vec3& x) { return fmt::format("({}, {}, {})", x[0], x[1], x[2]); }

}  // namespace

Vec2 turned_arm(const Cluster<2>& cluster, const Vec2& arm) {
  if (cluster.angle == 0) return arm;
  return Eigen::Rotation2D<double>(cluster.angle) * arm;
}

double turning_energy(const Cluster<3>& cluster) {
  const Vec3 spin = own_spin(cluster);
  return 0.5 * spin.dot(cluster.inertia.cwiseProduct(spin));
}

Vec3 own_momentum(const Cluster<3>& cluster) {
  return cluster.orientation *
         (cluster.axes * Vec3(cluster.inertia.cwiseProduct(own_spin(cluster))));
}

void drift(Cluster<3>& cluster, double h) {
  cluster.x += h * cluster.v;
  if (cluster.spin == Vec3::Zero()) return;
  Eigen::Quaterniond own = cluster.orientation * cluster.axes;
  const Vec3& inertia = cluster.inertia;
  Vec3 momentum = inertia.cwiseProduct(own.conjugate() * cluster.spin);
  constexpr double kLargestTurn = 0.25;
  const double turn = std::abs(h) * momentum.norm() / inertia.minCoeff();
  const double parts = std::max(1.0, std::ceil(turn / kLargestTurn));
  const double step = h / parts;
  for (double part = 0; part < parts; ++part) {
    const Vec3 mean = mean_momentum(momentum, inertia, step);
    const Vec3 half = 0.5 * step * mean.cwiseQuotient(inertia);
    momentum = 2 * mean - momentum;
    own = (own * Eigen::Quaterniond(1, half[0], half[1], half[2])).normalized();
  }
  cluster.orientation = (own * cluster.axes.conjugate()).normalized();
  cluster.spin = cluster.orientation * (cluster.axes * Vec3(momentum.cwiseQuotient(inertia)));
}

template <int D>
void place_members(const Clusters<D>& clusters, std::vector<Body<D>>& bodies) {
  if (clusters.empty()) return;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const int c = bodies[i].cluster;
    if (c >= 0) place(clusters.bodies[to_size(c)], clusters.arms[i], bodies[i]);
  }
}

void join_disks(Scene<2>& scene, std::size_t count, const Clusters<2>::Mass& given) {
  const std::span<Disk> disks = std::span(scene.bodies).last(count);
  require_different_centres<2>(disks);
  std::vector<Circle> circles;
  for (const Disk& disk : disks) circles.push_back({disk.x, disk.radius});
  const UnionMoments moments = union_moments(circles);
  Cluster<2> body{.x = moments.centre,
                  .mass = given.mass > 0 ? given.mass : given.density * moments.area,
                  .size = moments.area};
  body.inertia = given.inertia > 0 ? given.inertia : body.mass * moments.polar / moments.area;
  if (count == 1) {
    Disk& disk = scene.bodies.back();
    const double a = disk.radius;  // the same bits as for [[disks]]
    disk.mass = given.mass > 0 ? given.mass : given.density * std::numbers::pi * a * a;
    disk.inertia = given.inertia > 0 ? given.inertia : 0.5 * disk.mass * a * a;
    if (!scene.clusters.empty()) scene.clusters.arms.resize(scene.bodies.size(), Vec2::Zero());
    return;
  }
  scene.clusters.arms.resize(scene.bodies.size() - count, Vec2::Zero());
  for (Disk& disk : disks) {
    disk.mass = disk.inertia = 0;
    disk.cluster = static_cast<int>(scene.clusters.bodies.size());
    scene.clusters.arms.emplace_back(disk.x - body.x);
  }
  scene.clusters.bodies.push_back(body);
}

Cluster<3> joined(std::span<const Sphere> spheres, const Clusters<3>::Mass& given) {
  require_different_centres<3>(spheres);
  Cluster<3> body = union_of_spheres(spheres);
  const double density = given.mass > 0 ? given.mass / body.size : given.density;
  body.mass = given.mass > 0 ? given.mass : density * body.size;
  body.inertia *= density;
  if (given.inertia != Vec3::Zero()) {
    body.inertia = given.inertia;
    body.axes = Eigen::Quaterniond::Identity();
  }
  return body;
}

void add_cluster(Scene<3>& scene, Cluster<3> cluster, std::span<const Sphere> spheres,
                 const Vec3& x, const Eigen::Quaterniond& turn) {
  const Vec3 centre = cluster.x;
  cluster.x = x;
  cluster.axes = (turn * cluster.axes).normalized();
  scene.clusters.arms.resize(scene.bodies.size(), Vec3::Zero());
  for (Sphere sphere : spheres) {
    const Vec3 arm = turn * (sphere.x - centre);
    sphere.cluster = static_cast<int>(scene.clusters.bodies.size());
    sphere.mass = sphere.inertia = 0;
    place(cluster, arm, sphere);
    scene.bodies.push_back(sphere);
    scene.clusters.arms.push_back(arm);
  }
  scene.clusters.bodies.push_back(cluster);
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
  const Clusters<D>& clusters = scene.clusters;
  const int count = static_cast<int>(clusters.bodies.size());
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body<D>& d = scene.bodies[i];
    if (d.cluster < 0) continue;
    if (d.cluster >= count) {
      return fmt::format("{} {}: there is no cluster {}", kBodyName<D>, i, d.cluster);
    }
    if (d.wall >= 0)
      return fmt::format("{} {} is in a cluster and glued to a wall", kBodyName<D>, i);
  }
  if (count == 0) return {};
  if (clusters.arms.size() != scene.bodies.size()) {
    return fmt::format("{} arms of clusters for {} {}s", clusters.arms.size(), scene.bodies.size(),
                       kBodyName<D>);
  }
  for (int k = 0; k < count; ++k) {
    const Cluster<D>& c = clusters.bodies[to_size(k)];
    if (!positive(c.mass) || !positive(c.inertia) || !positive(c.size)) {
      return fmt::format("cluster {}: mass = {} kg, inertia = {} kg m², {} = {} {} (all > 0)", k,
                         c.mass, inertia_text(c.inertia), D == 2 ? "area" : "volume", c.size,
                         D == 2 ? "m²" : "m³");
    }
    if (!c.x.allFinite() || !c.v.allFinite() || !finite_turn(c)) {
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
  if (D == 3 && scene.accuracy > 0) return "clusters of spheres do not go with accuracy";
  if (scene.project_overlaps) return "clusters do not go with overlaps = \"project\"";
  if (scene.predict_gaps) return "clusters do not go with overlaps = \"predict\"";
  return {};
}

template void place_members(const Clusters<2>&, std::vector<Disk>&);
template void place_members(const Clusters<3>&, std::vector<Sphere>&);
template std::string check_cluster_lengths<2>(const std::vector<Disk>&, const PeriodicCell&,
                                              double);
template std::string check_cluster_lengths<3>(const std::vector<Sphere>&, const PeriodicCell&,
                                              double);
template std::string check_clusters(const Scene<2>&);
template std::string check_clusters(const Scene<3>&);

}  // namespace bipot
