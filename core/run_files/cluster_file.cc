#include <fmt/format.h>

#include <functional>
#include <string>
#include <vector>

#include "core/files/hdf5_columns.h"
#include "core/run_files/frame_entries.h"
#include "core/run_files/run_layout.h"

namespace bipot {
namespace {

/// Calls column(name, unit, member) for each dataset of the clusters.
template <int D, class Column>
void for_cluster_columns(const Column& column) {
  using Item = Cluster<D>;
  if constexpr (D == 2) {
    column("angle", "rad", &Item::angle);
  } else {
    column("orientation", "1", &Item::orientation);
  }
  column("spin", "rad/s", &Item::spin);
  column("mass", "kg", &Item::mass);
  column("inertia", "kg m2", &Item::inertia);
  if constexpr (D == 3) column("axes", "1", &Item::axes);
  column(D == 2 ? "area" : "volume", D == 2 ? "m2" : "m3", &Item::size);
  column("x", "m", &Item::x);
  column("v", "m/s", &Item::v);
}

}  // namespace

template <int D>
void write_clusters(Hdf5File& frame, const State<D>& state) {
  for_cluster_columns<D>([&](const char* name, const char* unit, auto member) {
    write_column(frame, std::string("/clusters/") + name, unit, state.clusters.bodies, member);
  });
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
  for_cluster_columns<D>([&](const char* name, const char*, auto member) {
    read_column(frame, std::string("/clusters/") + name, state.clusters.bodies, member);
  });
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
