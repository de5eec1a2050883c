#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "core/files/hdf5_columns.h"
#include "core/run_files/frame_entries.h"
#include "core/run_files/run_layout.h"

namespace bipot {
namespace {

/// A dataset of the clusters: rows of `width` numbers, which `at` finds in one of them. Four are a
/// quaternion, which the file begins with w.
template <int D>
struct ClusterEntry {
  const char *name, *unit;
  int width;
  double* (*at)(Cluster<D>&);
};
constexpr ClusterEntry<2> kEntries2[] = {
    {"angle", "rad", 1, [](Cluster<2>& c) { return &c.angle; }},
    {"spin", "rad/s", 1, [](Cluster<2>& c) { return &c.spin; }},
    {"mass", "kg", 1, [](Cluster<2>& c) { return &c.mass; }},
    {"inertia", "kg m2", 1, [](Cluster<2>& c) { return &c.inertia; }},
    {"area", "m2", 1, [](Cluster<2>& c) { return &c.size; }},
    {"x", "m", 2, [](Cluster<2>& c) { return c.x.data(); }},
    {"v", "m/s", 2, [](Cluster<2>& c) { return c.v.data(); }}};
constexpr ClusterEntry<3> kEntries3[] = {
    {"orientation", "1", 4, [](Cluster<3>& c) { return c.orientation.coeffs().data(); }},
    {"spin", "rad/s", 3, [](Cluster<3>& c) { return c.spin.data(); }},
    {"mass", "kg", 1, [](Cluster<3>& c) { return &c.mass; }},
    {"inertia", "kg m2", 3, [](Cluster<3>& c) { return c.inertia.data(); }},
    {"axes", "1", 4, [](Cluster<3>& c) { return c.axes.coeffs().data(); }},
    {"volume", "m3", 1, [](Cluster<3>& c) { return &c.size; }},
    {"x", "m", 3, [](Cluster<3>& c) { return c.x.data(); }},
    {"v", "m/s", 3, [](Cluster<3>& c) { return c.v.data(); }}};

template <int D>
std::span<const ClusterEntry<D>> cluster_entries() {
  if constexpr (D == 2) {
    return kEntries2;
  } else {
    return kEntries3;
  }
}

}  // namespace

template <int D>
void write_clusters(Hdf5File& frame, const State<D>& state) {
  for (const auto& [name, unit, width, at] : cluster_entries<D>()) {
    std::vector<double> rows;
    for (Cluster<D> c : state.clusters.bodies) {
      if (width == 4) std::rotate(at(c), at(c) + 3, at(c) + 4);
      rows.insert(rows.end(), at(c), at(c) + width);
    }
    const std::string dataset = std::string("/clusters/") + name;
    if (width == 1) {
      frame.write(dataset, rows, unit);
    } else {
      frame.write_rows(dataset, rows, to_size(width), unit);
    }
  }
  write_column(frame, "/bodies/cluster", "", state.bodies, &Body<D>::cluster);
  std::vector<Vec<D>> arms = state.clusters.arms;  // none once all clusters have left
  arms.resize(state.bodies.size(), Vec<D>::Zero());
  write_column(frame, "/bodies/arm", "m", arms, std::identity());
}

template <int D>
void read_clusters(const Hdf5File& frame, State<D>& state) {
  const std::string bodies_at = bodies_group(frame);
  if (!frame.exists(bodies_at + "cluster")) return;
  read_column(frame, bodies_at + "cluster", state.bodies, &Body<D>::cluster);
  const std::size_t count = frame.size("/clusters/mass");
  state.clusters.bodies.assign(count, {});
  for (const auto& [name, unit, width, at] : cluster_entries<D>()) {
    const auto rows = frame.read_doubles(std::string("/clusters/") + name, to_size(width) * count);
    for (std::size_t k = 0; k < count; ++k) {
      double* const to = at(state.clusters.bodies[k]);
      std::copy_n(rows.data() + to_size(width) * k, width, to);
      if (width == 4) std::rotate(to, to + 1, to + 4);
    }
  }
  state.clusters.arms.resize(state.bodies.size());
  read_column(frame, bodies_at + "arm", state.clusters.arms, std::identity());
  for (std::size_t i = 0; i < state.bodies.size(); ++i) {
    const int cluster = state.bodies[i].cluster;
    if (cluster >= -1 && cluster < static_cast<int>(count)) continue;
    throw FileError(frame.path(), bodies_at + "cluster",
                    fmt::format("{} {} is in cluster {} of {}", kBodyName<D>, i, cluster, count));
  }
}

template void write_clusters(Hdf5File&, const State<2>&);
template void write_clusters(Hdf5File&, const State<3>&);
template void read_clusters(const Hdf5File&, State<2>&);
template void read_clusters(const Hdf5File&, State<3>&);

}  // namespace bipot
