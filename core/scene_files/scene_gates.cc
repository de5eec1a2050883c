#include "core/scene_files/scene_groups.h"
#include "core/scene_files/scene_tables.h"

namespace bipot {
namespace {

/// `lower` and `upper` of a box along the axes.
template <int D>
void read_box(const SceneTable& table, bool turned, Vec<D>& lower, Vec<D>& upper) {
  const auto low = table.maybe_vec<D>("lower"), high = table.maybe_vec<D>("upper");
  if (!low || !high) table.fail("lower", "give lower and upper, two corners of a box [m]");
  if (!(low->array() < high->array()).all()) {
    table.fail("upper", "must be above lower in each direction");
  }
  if (turned) table.fail("lower", "a box along the axes does not turn with 'rotate_degrees'");
  lower = *low;
  upper = *high;
}

/// Names become columns of gates.csv.
template <int D>
std::string gate_name(const SceneTable& table, const std::string& fallback, const Scene<D>& scene) {
  const std::string name = table.column_name(fallback);
  bool taken = false;
  for (const Outlet<D>& other : scene.outlets) taken |= other.name == name;
  for (const Inlet<D>& other : scene.inlets) taken |= other.name == name;
  if (taken) table.fail("name", "names of outlets and inlets must differ");
  return name;
}

template <int D>
Outlet<D> read_outlet(const SceneTable& table, bool turned, const Scene<D>& scene) {
  Outlet<D> outlet;
  outlet.name = gate_name(table, fmt::format("outlet{}", scene.outlets.size()), scene);
  const auto point = table.maybe_vec<D>("point"), normal = table.maybe_vec<D>("normal");
  outlet.box = table.has("lower") || table.has("upper");
  if (outlet.box == (point || normal)) {
    table.fail("point", D == 2
                            ? "give point and normal (a half-plane), or lower and upper (a box)"
                            : "give point and normal (a half-space), or lower and upper (a box)");
  }
  if (outlet.box) {
    read_box<D>(table, turned, outlet.lower, outlet.upper);
    return outlet;
  }
  if (!point || !normal) table.fail("normal", "give both point and normal");
  outlet.point = *point;
  outlet.normal = table.direction<D>("normal");
  return outlet;
}

template <int D>
Inlet<D> read_inlet(const SceneTable& table, bool turned, const Scene<D>& scene) {
  Inlet<D> inlet;
  inlet.name = gate_name(table, fmt::format("inlet{}", scene.inlets.size()), scene);
  read_box<D>(table, turned, inlet.lower, inlet.upper);
  inlet.rate = table.positive("rate");
  for (const RadiusClass& drawn : read_radius_classes(table)) {
    inlet.radii.push_back(drawn.radius);
    inlet.shares.push_back(drawn.fraction);
  }
  const GroupMass group = read_group_mass(table);
  inlet.mass = group.mass.value_or(0);
  inlet.density = group.density.value_or(0);
  inlet.inertia = group.inertia.value_or(0);
  inlet.v = table.vec_or_zero<D>("velocity");
  inlet.spin = table.spin<D>();
  inlet.material = material_index(scene, table, "material");
  inlet.seed = table.integer("seed", inlet.seed);
  if (inlet.seed < 0) table.fail("seed", "expected a non-negative integer");
  if (table.has("count")) inlet.count = table.natural("count");
  table.read_period(inlet.starts, inlet.stops);
  if (auto e = check_inlet(inlet, static_cast<int>(scene.materials.size())); !e.empty()) {
    table.fail("radii", e);
  }
  return inlet;
}

}  // namespace

template <int D>
void read_gates(const SceneTable& root, bool turned, Scene<D>& scene) {
  for (const SceneTable& table : root.tables("outlets")) {
    scene.outlets.push_back(read_outlet(table, turned, scene));
  }
  for (const SceneTable& table : root.tables("inlets")) {
    scene.inlets.push_back(read_inlet(table, turned, scene));
  }
}

template void read_gates(const SceneTable&, bool, Scene<2>&);
template void read_gates(const SceneTable&, bool, Scene<3>&);

}  // namespace bipot
