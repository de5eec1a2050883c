#include <fmt/format.h>

#include <string>
#include <vector>

#include "core/run_files/frame_entries.h"
#include "core/run_files/run_layout.h"

namespace bipot {
namespace {

struct ClusterNumber {
  const char *name, *unit;
  double Cluster::*member;
};
constexpr ClusterNumber kClusterNumbers[] = {{"angle", "rad", &Cluster::angle},
                                             {"spin", "rad/s", &Cluster::spin},
                                             {"mass", "kg", &Cluster::mass},
                                             {"inertia", "kg m2", &Cluster::inertia},
                                             {"area", "m2", &Cluster::area}};
struct ClusterVector {
  const char *name, *unit;
  Vec2 Cluster::*member;
};
constexpr ClusterVector kClusterVectors[] = {{"x", "m", &Cluster::x}, {"v", "m/s", &Cluster::v}};

std::vector<double> cluster_column(const Hdf5File& file, const std::string& name,
                                   std::size_t size) {
  std::vector<double> values = file.read_doubles(name);
  if (values.size() == size) return values;
  throw FileError(file.path(), name,
                  fmt::format("has {} elements, expected {}", values.size(), size));
}

}  // namespace

void write_clusters(Hdf5File& frame, const State<2>& state) {
  for (const auto& [name, unit, member] : kClusterNumbers) {
    std::vector<double> column;
    for (const Cluster& c : state.clusters.bodies) column.push_back(c.*member);
    const std::string dataset = std::string("/clusters/") + name;
    frame.write(dataset, column);
    frame.write_attribute(dataset, "unit", unit);
  }
  for (const auto& [name, unit, member] : kClusterVectors) {
    std::vector<double> rows;
    for (const Cluster& c : state.clusters.bodies) {
      rows.insert(rows.end(), {(c.*member)[0], (c.*member)[1]});
    }
    const std::string dataset = std::string("/clusters/") + name;
    frame.write_rows(dataset, rows, 2);
    frame.write_attribute(dataset, "unit", unit);
  }
  std::vector<int> cluster;
  std::vector<double> arms;
  for (const Disk& d : state.bodies) cluster.push_back(d.cluster);
  for (const Vec2& arm : state.clusters.arms) arms.insert(arms.end(), {arm[0], arm[1]});
  frame.write("/bodies/cluster", cluster);
  frame.write_rows("/bodies/arm", arms, 2);
  frame.write_attribute("/bodies/arm", "unit", "m");
}

void read_clusters(const Hdf5File& frame, State<2>& state) {
  const std::string bodies_at = bodies_group(frame);
  if (!frame.exists(bodies_at + "cluster")) return;
  const std::vector<int> cluster = frame.read_ints(bodies_at + "cluster");
  const std::size_t disks = state.bodies.size();
  const std::size_t count = frame.size("/clusters/mass");
  if (cluster.size() != disks) {
    throw FileError(frame.path(), bodies_at + "cluster",
                    fmt::format("has {} elements, expected {}", cluster.size(), disks));
  }
  state.clusters.bodies.assign(count, {});
  for (const auto& [name, unit, member] : kClusterNumbers) {
    const auto column = cluster_column(frame, std::string("/clusters/") + name, count);
    for (std::size_t k = 0; k < count; ++k) state.clusters.bodies[k].*member = column[k];
  }
  for (const auto& [name, unit, member] : kClusterVectors) {
    const auto rows = cluster_column(frame, std::string("/clusters/") + name, 2 * count);
    for (std::size_t k = 0; k < count; ++k) {
      state.clusters.bodies[k].*member = Vec2(rows[2 * k], rows[2 * k + 1]);
    }
  }
  const auto arms = cluster_column(frame, bodies_at + "arm", 2 * disks);
  for (std::size_t i = 0; i < disks; ++i) {
    if (cluster[i] < -1 || cluster[i] >= static_cast<int>(count)) {
      throw FileError(frame.path(), bodies_at + "cluster",
                      fmt::format("disk {} is in cluster {} of {}", i, cluster[i], count));
    }
    state.bodies[i].cluster = cluster[i];
    state.clusters.arms.emplace_back(arms[2 * i], arms[2 * i + 1]);
  }
}

}  // namespace bipot
