#include "core/run_files/run_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "core/files/hdf5_file.h"
#include "core/run_files/frame_entries.h"
#include "core/scene/triangle_mesh.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

/// An enumerator read from a file.
template <class Enum>
Enum checked_enum(const Hdf5File& file, const std::string& name, int value, int last) {
  if (value < 0 || value > last) {
    throw FileError(file.path(), name, fmt::format("{} is not one of 0 to {}", value, last));
  }
  return static_cast<Enum>(value);
}

/// Row k of a dataset with D columns.
template <int D>
Vec<D> row_of(const std::vector<double>& values, std::size_t k) {
  return Eigen::Map<const Vec<D>>(values.data() + D * k);
}

/// Reads the constant data of the disks of a scene.
template <int D>
std::vector<Body<D>> read_fixed_disks(const Hdf5File& fixed) {
  const std::string at = bodies_group(fixed);
  const std::vector<double> radius = fixed.read_doubles(at + "radius");
  const std::size_t n = radius.size();
  const auto mass = fixed.read_doubles(at + "mass", n);
  const auto inertia = fixed.read_doubles(at + "inertia", n);
  const auto material = fixed.read_ints(at + "material", n);
  // Only scenes with rough walls have this entry.
  const auto wall =
      fixed.exists(at + "wall") ? fixed.read_ints(at + "wall", n) : std::vector<int>(n, -1);
  std::vector<Body<D>> disks(n);
  for (std::size_t k = 0; k < n; ++k) {
    disks[k].radius = radius[k];
    disks[k].mass = mass[k];
    disks[k].inertia = inertia[k];
    disks[k].material = material[k];
    disks[k].wall = wall[k];
  }
  return disks;
}

/// `fixed`: run.h5. `frame`: the frame's file, which describes all disks if some come or go.
template <int D>
std::vector<Body<D>> read_disks(const Hdf5File& fixed, const Hdf5File& frame,
                                Population<D>& population) {
  std::vector<Body<D>> disks;
  if (!read_population(frame, disks, population)) disks = read_fixed_disks<D>(fixed);
  const std::size_t n = disks.size();
  const std::string at = bodies_group(frame);
  const auto x = frame.read_doubles(at + "x", D * n);
  const auto turned =
      D == 2 ? frame.read_doubles(at + "angle", n) : frame.read_doubles(at + "orientation", 4 * n);
  const auto v = frame.read_doubles(at + "v", 3 * n);
  const auto spin = frame.read_doubles(at + "spin", to_size(kSpins<D>) * n);
  for (std::size_t k = 0; k < n; ++k) {
    Body<D>& d = disks[k];
    d.x = row_of<D>(x, k);
    d.v = row_of<3>(v, k).template head<D>();
    if constexpr (D == 2) {
      d.angle = turned[k];
      d.spin = spin[k];
    } else {
      d.orientation = Eigen::Quaterniond(turned[4 * k], turned[4 * k + 1], turned[4 * k + 2],
                                         turned[4 * k + 3]);
      d.spin = row_of<3>(spin, k);
    }
  }
  return disks;
}

/// Reads the triangles of all meshes.
void read_triangles(const Hdf5File& fixed, std::vector<Wall<3>>& walls) {
  const std::string numbers = "/walls/triangles";
  const bool any = std::any_of(walls.begin(), walls.end(),
                               [](const Wall<3>& w) { return w.shape == Wall<3>::Shape::kMesh; });
  if (!any) return;
  const auto counts = fixed.read_ints(numbers, walls.size());
  const int sum = std::accumulate(counts.begin(), counts.end(), 0);
  if (sum < 0) throw FileError(fixed.path(), numbers, "has negative entries");
  const auto corners = fixed.read_doubles("/walls/triangle", 9 * to_size(sum));
  const double* at = corners.data();
  for (std::size_t w = 0; w < walls.size(); ++w) {
    if (walls[w].shape != Wall<3>::Shape::kMesh) continue;
    if (counts[w] < 1 || counts[w] > (corners.data() + corners.size() - at) / 9) {
      throw FileError(fixed.path(), numbers, fmt::format("has {} for wall {}", counts[w], w));
    }
    std::vector<Wall<3>::Mesh::Triangle> triangles(to_size(counts[w]));
    for (auto& triangle : triangles) {
      for (Vec3& corner : triangle) {
        corner = Eigen::Map<const Vec3>(at);
        at += 3;
      }
    }
    walls[w].mesh = std::make_shared<const Wall<3>::Mesh>(std::move(triangles));
  }
}

template <int D>
std::vector<Wall<D>> read_walls(const Hdf5File& fixed, const Hdf5File& frame) {
  const std::vector<std::string> names = fixed.read_strings("/walls/name");
  const std::size_t count = names.size();
  const auto shape = fixed.read_ints("/walls/shape", count);
  const auto motion = fixed.read_ints("/walls/motion", count);
  const auto wall_material = fixed.read_ints("/walls/material", count);
  const auto normal = fixed.read_doubles("/walls/normal", D * count);
  const auto direction = fixed.read_doubles("/walls/direction", D * count);
  const auto wall_mass = fixed.read_doubles("/walls/mass", count);
  const auto a = frame.read_doubles("/walls/a", D * count);
  const auto b = frame.read_doubles("/walls/b", D * count);
  const auto wall_v = frame.read_doubles("/walls/v", D * count);
  // Written if a scene has circles, belts, walls moved across a force, or walls that start or go.
  const auto optional = [&](const Hdf5File& file, const char* name, std::size_t size) {
    return file.exists(name) ? file.read_doubles(name, size) : std::vector<double>(size, 0.0);
  };
  const auto radius = optional(fixed, "/walls/radius", count);
  const auto radius_b = optional(fixed, "/walls/radius_b", count);
  const auto across = optional(fixed, "/walls/across", D * count);
  const bool changes = frame.exists("/walls/present");
  // Frames of earlier versions do not have them.
  const Hdf5File& drives = frame.exists("/walls/force") ? frame : fixed;
  const auto force = drives.read_doubles("/walls/force", count);
  const auto spin = optional(drives, "/walls/spin", count);
  const auto belt = optional(drives, "/walls/belt", D * count);
  const auto present =
      changes ? frame.read_ints("/walls/present", count) : std::vector<int>(count, 1);
  const auto motion_now = changes ? frame.read_ints("/walls/motion", count) : motion;
  std::vector<Wall<D>> walls(count);
  for (std::size_t k = 0; k < count; ++k) {
    const auto at = [&](const std::vector<double>& y) { return row_of<D>(y, k); };
    walls[k] = {
        .name = names[k],
        .shape =
            checked_enum<typename Wall<D>::Shape>(fixed, "/walls/shape", shape[k], D == 2 ? 3 : 5),
        .motion = checked_enum<typename Wall<D>::Motion>(fixed, "/walls/motion", motion_now[k], 2),
        .a = at(a),
        .b = at(b),
        .normal = at(normal),
        .v = at(wall_v),
        .direction = at(direction),
        .force = force[k],
        .mass = wall_mass[k],
        .material = wall_material[k],
        .radius = radius[k],
        .radius_b = radius_b[k],
        .spin = spin[k],
        .across = at(across),
        .belt = at(belt),
        .present = present[k] != 0};
  }
  if constexpr (D == 3) read_triangles(fixed, walls);
  return walls;
}

/// The cell of a periodic scene, else none.
PeriodicCell read_state_cell(const Hdf5File& fixed, const Hdf5File& frame) {
  PeriodicCell cell;
  if (!fixed.exists("/cell/periodic")) return cell;
  const auto periodic = fixed.read_ints("/cell/periodic", 2);
  cell.in_x = periodic[0] != 0;
  cell.in_y = periodic[1] != 0;
  const auto motion = fixed.read_ints("/cell/motion", 3);
  const auto stress = fixed.read_doubles("/cell/stress", 3);
  const auto mass = fixed.read_doubles("/cell/mass", 3);
  const auto lengths = frame.read_doubles("/cell/lengths", 3);
  const auto speeds = frame.read_doubles("/cell/speeds", 3);
  for (int k = 0; k < 3; ++k) {
    const std::size_t at = to_size(k);
    cell.side(k) = {.motion = checked_enum<CellSide::Motion>(fixed, "/cell/motion", motion[at], 2),
                    .length = lengths[at],
                    .speed = speeds[at],
                    .stress = stress[at],
                    .mass = mass[at]};
  }
  return cell;
}

/// Throws FileError if a contact joins bodies that the run does not have.
template <int D>
std::vector<ContactOutcome<D>> read_contacts(const Hdf5File& file, std::size_t disks,
                                             std::size_t walls) {
  const std::vector<int> i = file.read_ints("/contacts/i");
  const std::size_t c = i.size();
  const auto j = file.read_ints("/contacts/j", c);
  const auto status = file.read_ints("/contacts/status", c);
  const auto contact_n = file.read_doubles("/contacts/n", D * c);
  const auto gap = file.read_doubles("/contacts/gap", c);
  const auto s_n = file.read_doubles("/contacts/s_n", c);
  const auto s_t = file.read_doubles("/contacts/s_t", to_size(kSpins<D>) * c);
  const auto u_n = file.read_doubles("/contacts/u_n", c);
  const auto u_t = file.read_doubles("/contacts/u_t", to_size(kSpins<D>) * c);
  const auto tangents = [&](const char* name) {
    const std::size_t size = to_size(kSpins<D>) * c;
    return file.exists(name) ? file.read_doubles(name, size) : std::vector<double>(size, 0.0);
  };
  // Only the spring-dashpot model writes springs.
  const auto spring = tangents("/contacts/spring");
  // Only scenes with cohesion write bonds; elsewhere every contact may become one.
  const auto bonded = file.exists("/contacts/bonded") ? file.read_ints("/contacts/bonded", c)
                                                      : std::vector<int>(c, 1);
  // Only scenes with rolling friction write moments.
  const auto moment = tangents("/contacts/moment");
  // Only periodic scenes write images.
  const bool images = file.exists("/contacts/image_x");
  const auto image_x = images ? file.read_ints("/contacts/image_x", c) : std::vector<int>(c);
  const auto image_y = images ? file.read_ints("/contacts/image_y", c) : std::vector<int>(c);
  const auto tangential = [](const std::vector<double>& values, std::size_t k) -> Tangent<D> {
    if constexpr (D == 2) {
      return values[k];
    } else {
      return row_of<3>(values, k);
    }
  };
  std::vector<ContactOutcome<D>> contacts(c);
  for (std::size_t k = 0; k < c; ++k) {
    if (i[k] < 0 || i[k] >= static_cast<int>(disks) || j[k] < 0 ||
        j[k] >= static_cast<int>(disks + walls)) {
      throw FileError(file.path(), "/contacts",
                      fmt::format("contact {} joins the bodies {} and {}", k, i[k], j[k]));
    }
    contacts[k] = {.contact = {.i = i[k],
                               .j = j[k],
                               .n = row_of<D>(contact_n, k),
                               .gap = gap[k],
                               .image_x = image_x[k],
                               .image_y = image_y[k]},
                   .s_n = s_n[k],
                   .s_t = tangential(s_t, k),
                   .u_n = u_n[k],
                   .u_t = tangential(u_t, k),
                   .status = checked_enum<ContactStatus>(file, "/contacts/status", status[k], 2),
                   .bonded = bonded[k] != 0,
                   .spring = tangential(spring, k),
                   .moment = tangential(moment, k)};
  }
  return contacts;
}

/// run.h5 of a run, open, and of a known version.
Hdf5File open_run(const fs::path& folder) {
  Hdf5File fixed(folder / "run.h5", Hdf5File::Mode::kRead);
  if (!fixed.exists("/format") || fixed.read_string("/format") != kRunFormat) {
    throw FileError(fixed.path(), "", "not the output of a run");
  }
  if (const int version = fixed.read_int("/format_version");
      version < 1 || version > kRunFormatVersion) {
    throw FileError(
        fixed.path(), "/format_version",
        fmt::format("{} is not known, this program reads 1 to {}", version, kRunFormatVersion));
  }
  return fixed;
}

int dimensions_of(const Hdf5File& fixed) {
  return fixed.exists("/dimensions") ? fixed.read_int("/dimensions") : 2;
}

}  // namespace

template <int D>
State<D> read_state(const fs::path& run, int step) {
  const fs::path folder = run_folder(run);
  const Hdf5File fixed = open_run(folder);
  if (const int in = dimensions_of(fixed); in != D) {
    throw FileError(fixed.path(), "/dimensions",
                    fmt::format("a run in {} dimensions, expected one in {}", in, D));
  }
  const std::vector<int> steps = steps_in_folder(folder);
  if (steps.empty()) throw FileError(folder, "frames", "no frame has been written");
  if (step < 0) step = steps.back();
  if (!std::binary_search(steps.begin(), steps.end(), step)) {
    throw FileError(folder, "frames",
                    fmt::format("there is no frame of step {}; the first is of step {}, the last "
                                "of step {}",
                                step, steps.front(), steps.back()));
  }
  const Hdf5File file(frame_path(folder, step), Hdf5File::Mode::kRead);
  State<D> state;
  state.step = file.read_int("/step");
  state.time = file.read_double("/time");
  state.wall_work = file.read_double("/wall_work");
  state.friction_loss = file.read_double("/friction_loss");
  state.shock_loss = file.read_double("/shock_loss");
  if (file.exists("/halvings")) state.halvings = file.read_int("/halvings");
  if (file.exists("/cohesion_loss")) state.cohesion_loss = file.read_double("/cohesion_loss");
  state.bodies = read_disks<D>(fixed, file, state.population);
  read_clusters(file, state);
  state.walls = read_walls<D>(fixed, file);
  state.cell = read_state_cell(fixed, file);
  state.contacts = read_contacts<D>(file, state.bodies.size(), state.walls.size());
  return state;
}

AnyState read_any_state(const fs::path& run, int step) {
  const bool disks = dimensions_of(open_run(run_folder(run))) == 2;
  if (disks) return read_state<2>(run, step);
  return read_state<3>(run, step);
}

template State<2> read_state<2>(const fs::path&, int);
template State<3> read_state<3>(const fs::path&, int);

}  // namespace bipot
