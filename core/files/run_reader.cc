#include "core/files/run_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "core/files/hdf5_file.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

/// Numbers of a dataset whose size must be right.
std::vector<double> read_sized(const Hdf5File& file, const std::string& name, std::size_t size) {
  std::vector<double> values = file.read_doubles(name);
  if (values.size() != size) {
    throw FileError(file.path(), name,
                    fmt::format("has {} elements, expected {}", values.size(), size));
  }
  return values;
}

std::vector<int> read_sized_ints(const Hdf5File& file, const std::string& name, std::size_t size) {
  std::vector<int> values = file.read_ints(name);
  if (values.size() != size) {
    throw FileError(file.path(), name,
                    fmt::format("has {} elements, expected {}", values.size(), size));
  }
  return values;
}

/// An enumerator read from a file.
template <class Enum>
Enum checked_enum(const Hdf5File& file, const std::string& name, int value, int last) {
  if (value < 0 || value > last) {
    throw FileError(file.path(), name, fmt::format("{} is not one of 0 to {}", value, last));
  }
  return static_cast<Enum>(value);
}

/// `fixed`: run.h5; `frame`: the frame's file.
std::vector<Disk> read_disks(const Hdf5File& fixed, const Hdf5File& frame) {
  const std::vector<double> radius = fixed.read_doubles("/disks/radius");
  const std::size_t n = radius.size();
  const auto mass = read_sized(fixed, "/disks/mass", n);
  const auto inertia = read_sized(fixed, "/disks/inertia", n);
  const auto material = read_sized_ints(fixed, "/disks/material", n);
  const auto x = read_sized(frame, "/disks/x", 2 * n);
  const auto angle = read_sized(frame, "/disks/angle", n);
  const auto v = read_sized(frame, "/disks/v", 3 * n);
  const auto spin = read_sized(frame, "/disks/spin", n);
  // Only rough walls write which disks are theirs.
  const auto wall = fixed.exists("/disks/wall") ? read_sized_ints(fixed, "/disks/wall", n)
                                                : std::vector<int>(n, -1);
  std::vector<Disk> disks(n);
  for (std::size_t k = 0; k < n; ++k) {
    disks[k] = {.x = Vec2(x[2 * k], x[2 * k + 1]),
                .angle = angle[k],
                .v = Vec2(v[3 * k], v[3 * k + 1]),
                .spin = spin[k],
                .radius = radius[k],
                .mass = mass[k],
                .inertia = inertia[k],
                .material = material[k],
                .wall = wall[k]};
  }
  return disks;
}

std::vector<Wall> read_walls(const Hdf5File& fixed, const Hdf5File& frame) {
  const std::vector<std::string> names = fixed.read_strings("/walls/name");
  const std::size_t count = names.size();
  const auto shape = read_sized_ints(fixed, "/walls/shape", count);
  const auto motion = read_sized_ints(fixed, "/walls/motion", count);
  const auto wall_material = read_sized_ints(fixed, "/walls/material", count);
  const auto normal = read_sized(fixed, "/walls/normal", 2 * count);
  const auto direction = read_sized(fixed, "/walls/direction", 2 * count);
  const auto force = read_sized(fixed, "/walls/force", count);
  const auto wall_mass = read_sized(fixed, "/walls/mass", count);
  const auto a = read_sized(frame, "/walls/a", 2 * count);
  const auto b = read_sized(frame, "/walls/b", 2 * count);
  const auto wall_v = read_sized(frame, "/walls/v", 2 * count);
  // Written where a scene has circles, walls moved across a force, walls that start or go.
  const auto optional = [&](const Hdf5File& file, const char* name, std::size_t size) {
    return file.exists(name) ? read_sized(file, name, size) : std::vector<double>(size, 0.0);
  };
  const auto radius = optional(fixed, "/walls/radius", count);
  const auto spin = optional(fixed, "/walls/spin", count);
  const auto across = optional(fixed, "/walls/across", 2 * count);
  const bool changes = frame.exists("/walls/present");
  const auto present =
      changes ? read_sized_ints(frame, "/walls/present", count) : std::vector<int>(count, 1);
  const auto motion_now = changes ? read_sized_ints(frame, "/walls/motion", count) : motion;
  std::vector<Wall> walls(count);
  for (std::size_t k = 0; k < count; ++k) {
    const auto pair = [&](const std::vector<double>& y) { return Vec2(y[2 * k], y[2 * k + 1]); };
    walls[k] = {.name = names[k],
                .shape = checked_enum<Wall::Shape>(fixed, "/walls/shape", shape[k], 3),
                .motion = checked_enum<Wall::Motion>(fixed, "/walls/motion", motion_now[k], 2),
                .a = pair(a),
                .b = pair(b),
                .normal = pair(normal),
                .v = pair(wall_v),
                .direction = pair(direction),
                .force = force[k],
                .mass = wall_mass[k],
                .material = wall_material[k],
                .radius = radius[k],
                .spin = spin[k],
                .across = pair(across),
                .present = present[k] != 0};
  }
  return walls;
}

/// The cell of a periodic scene; none where there is none.
Cell read_state_cell(const Hdf5File& fixed, const Hdf5File& frame) {
  Cell cell;
  if (!fixed.exists("/cell/periodic")) return cell;
  const auto periodic = read_sized_ints(fixed, "/cell/periodic", 2);
  cell.in_x = periodic[0] != 0;
  cell.in_y = periodic[1] != 0;
  const auto motion = read_sized_ints(fixed, "/cell/motion", 3);
  const auto stress = read_sized(fixed, "/cell/stress", 3);
  const auto mass = read_sized(fixed, "/cell/mass", 3);
  const auto lengths = read_sized(frame, "/cell/lengths", 3);
  const auto speeds = read_sized(frame, "/cell/speeds", 3);
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

/// Throws FileError where a contact joins bodies that the run does not have.
std::vector<ContactOutcome> read_contacts(const Hdf5File& file, std::size_t disks,
                                          std::size_t walls) {
  const std::vector<int> i = file.read_ints("/contacts/i");
  const std::size_t c = i.size();
  const auto j = read_sized_ints(file, "/contacts/j", c);
  const auto status = read_sized_ints(file, "/contacts/status", c);
  const auto contact_n = read_sized(file, "/contacts/n", 2 * c);
  const auto gap = read_sized(file, "/contacts/gap", c);
  const auto s_n = read_sized(file, "/contacts/s_n", c);
  const auto s_t = read_sized(file, "/contacts/s_t", c);
  const auto u_n = read_sized(file, "/contacts/u_n", c);
  const auto u_t = read_sized(file, "/contacts/u_t", c);
  // Only the spring-dashpot model writes springs.
  const auto spring = file.exists("/contacts/spring") ? read_sized(file, "/contacts/spring", c)
                                                      : std::vector<double>(c, 0.0);
  // Only periodic scenes write images.
  const bool images = file.exists("/contacts/image_x");
  const auto image_x = images ? read_sized_ints(file, "/contacts/image_x", c) : std::vector<int>(c);
  const auto image_y = images ? read_sized_ints(file, "/contacts/image_y", c) : std::vector<int>(c);
  std::vector<ContactOutcome> contacts(c);
  for (std::size_t k = 0; k < c; ++k) {
    if (i[k] < 0 || i[k] >= static_cast<int>(disks) || j[k] < 0 ||
        j[k] >= static_cast<int>(disks + walls)) {
      throw FileError(file.path(), "/contacts",
                      fmt::format("contact {} joins the bodies {} and {}", k, i[k], j[k]));
    }
    contacts[k] = {.contact = {.i = i[k],
                               .j = j[k],
                               .n = Vec2(contact_n[2 * k], contact_n[2 * k + 1]),
                               .gap = gap[k],
                               .image_x = image_x[k],
                               .image_y = image_y[k]},
                   .s_n = s_n[k],
                   .s_t = s_t[k],
                   .u_n = u_n[k],
                   .u_t = u_t[k],
                   .status = checked_enum<ContactStatus>(file, "/contacts/status", status[k], 2),
                   .spring = spring[k]};
  }
  return contacts;
}

}  // namespace

std::string read_scene_text(const fs::path& run) {
  return Hdf5File(run_folder(run) / "run.h5", Hdf5File::Mode::kRead).read_string("/scene");
}

State read_state(const fs::path& run, int step) {
  const fs::path folder = run_folder(run);
  const Hdf5File fixed(folder / "run.h5", Hdf5File::Mode::kRead);
  if (!fixed.exists("/format") || fixed.read_string("/format") != kRunFormat) {
    throw FileError(fixed.path(), "", "not the output of a run");
  }
  if (const int version = fixed.read_int("/format_version"); version != kRunFormatVersion) {
    throw FileError(fixed.path(), "/format_version",
                    fmt::format("{} is not known, this program writes and reads {}", version,
                                kRunFormatVersion));
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
  State state;
  state.step = file.read_int("/step");
  state.time = file.read_double("/time");
  state.wall_work = file.read_double("/wall_work");
  state.friction_loss = file.read_double("/friction_loss");
  state.shock_loss = file.read_double("/shock_loss");
  state.disks = read_disks(fixed, file);
  state.walls = read_walls(fixed, file);
  state.cell = read_state_cell(fixed, file);
  state.contacts = read_contacts(file, state.disks.size(), state.walls.size());
  return state;
}

}  // namespace bipot
