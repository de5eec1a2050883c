#include "core/scene_files/scene_tables.h"

namespace bipot {
namespace {

int at_least_one(const SceneTable& table, std::string_view key, int fallback) {
  const int value = table.integer(key, fallback);
  if (value < 1) table.fail(key, fmt::format("expected a positive integer, got {}", value));
  return value;
}

template <int D>
void read_window(const SceneTable& table, ObservableChoice<D>& choice) {
  const std::vector<double> window = table.numbers("window");
  if (!table.has("window")) return;
  bool sound = window.size() == 2 * D;
  for (std::size_t k = 0; sound && k < D; ++k) sound = window[k] < window[D + k];
  if (!sound) {
    table.fail("window", D == 2 ? "expected [left, bottom, right, top] [m]"
                                : "expected [x, y, z, x, y, z] of two opposite corners, the lower "
                                  "ones first [m]");
  }
  choice.window = {Vec<D>(window.data()), Vec<D>(window.data() + D)};
}

template <int D>
void read_profile(const SceneTable& table, ObservableChoice<D>& choice) {
  if (!table.has("profile")) {
    for (const char* key : {"profile_bins", "profile_range"}) {
      if (table.has(key)) table.fail(key, "belongs to a profile");
    }
    return;
  }
  ProfileChoice profile;
  const std::vector<std::string> axes =
      D == 2 ? std::vector<std::string>{"x", "y"} : std::vector<std::string>{"x", "y", "z"};
  profile.axis = table.one_of("profile", "y", axes)[0] - 'x';
  profile.bins = at_least_one(table, "profile_bins", profile.bins);
  const std::vector<double> range = table.numbers("profile_range");
  if (range.size() != 2 || !(range[0] < range[1])) {
    table.fail("profile_range", "expected two numbers, the lower one first [m]");
  }
  profile.low = range[0];
  profile.high = range[1];
  choice.profile = profile;
}

/// Name of a line or face, which becomes a column.
template <int D>
std::string read_name(const SceneTable& table, const char* kind,
                      const ObservableChoice<D>& choice) {
  const std::string name = table.column_name(fmt::format("{}{}", kind, choice.crossings.size()));
  for (const FluxSurface<D>& other : choice.crossings) {
    if (other.name == name) table.fail("name", "names must differ");
  }
  return name;
}

void read_crossings(const SceneTable& table, const PeriodicCell&, ObservableChoice<2>& choice) {
  if (table.has("faces")) table.fail("faces", "belongs to scenes in 3D: in 2D, lines");
  for (const SceneTable& line : table.tables("lines")) {
    const std::string name = read_name(line, "line", choice);
    const auto from = line.maybe_vec<2>("from"), to = line.maybe_vec<2>("to");
    if (!from || !to || *from == *to) line.fail("from", "give from and to, two different points");
    choice.crossings.push_back({name, *from, *to});
  }
}

bool along_axis(const Vec3& direction) { return (direction.array() != 0).count() == 1; }

/// The first side of a rectangle: given, or along the first axis in its plane.
Vec3 first_side(const SceneTable& face, const Vec3& normal) {
  if (const auto along = face.maybe_vec<3>("along")) {
    const Vec3 across = *along - along->dot(normal) * normal;
    if (!(across.norm() > 1e-9 * along->norm())) {
      face.fail("along", "expected a direction that does not lie along the normal");
    }
    return across.normalized();
  }
  if (!along_axis(normal)) {
    face.fail("along", "is missing: the normal is no axis, so that the sides may lie anyhow");
  }
  return normal[0] != 0 ? Vec3::UnitY() : Vec3::UnitX();
}

FluxFace read_face(const SceneTable& face) {
  using Shape = FluxFace::Shape;
  FluxFace read;
  read.point = face.vec<3>("point");
  const auto normal = face.maybe_vec<3>("normal");
  if (!normal || normal->isZero(0)) face.fail("normal", "expected a direction that is not zero");
  read.normal = along_axis(*normal) ? Vec3(normal->cwiseSign()) : Vec3(normal->normalized());
  if (face.has("radius") && face.has("size")) {
    face.fail("size", "a face has a radius (a disk), or a size (a rectangle)");
  }
  if (face.has("along") && !face.has("size")) {
    face.fail("along", "belongs to a rectangle, which has a size");
  }
  if (face.has("radius")) {
    read.shape = Shape::kDisk;
    read.radius = face.positive("radius");
  } else if (const auto size = face.maybe_vec<2>("size")) {
    if (!(size->minCoeff() > 0)) face.fail("size", "expected two positive numbers [m]");
    read.shape = Shape::kRectangle;
    read.size = *size;
  }
  // Disks and planes are isotropic: any frame will do.
  read.along = read.shape == Shape::kRectangle || along_axis(read.normal)
                   ? first_side(face, read.normal)
                   : contact_frame<3>(read.normal)[1];
  return read;
}

/// Extent of a face from its middle along an axis.
double reach(const FluxFace& face, int axis) {
  if (face.shape == FluxFace::Shape::kDisk) {
    return face.radius * std::sqrt(std::max(0.0, 1 - face.normal[axis] * face.normal[axis]));
  }
  const Vec3 across = face.normal.cross(face.along);
  return 0.5 * (face.size[0] * std::abs(face.along[axis]) + face.size[1] * std::abs(across[axis]));
}

/// Images are counted if they reach into the cell: measured regions must lie in it.
void require_in_cell(const SceneTable& table, const char* key, const PeriodicCell& cell, int axis,
                     double low, double high) {
  if (axis == 0 ? !cell.in_x : axis == 1 ? !cell.in_y : true) return;
  const double length = cell.side(axis).length;
  if (low < -1e-12 * length || high > (1 + 1e-12) * length) {
    table.fail(key, fmt::format("reaches from {} = {:.12g} to {:.12g} m, out of the periodic cell "
                                "(0 to {:.12g} m)",
                                "xyz"[axis], low, high, length));
  }
}

void read_crossings(const SceneTable& table, const PeriodicCell& cell,
                    ObservableChoice<3>& choice) {
  if (table.has("lines")) table.fail("lines", "belongs to scenes in 2D: in 3D, faces");
  for (const SceneTable& face : table.tables("faces")) {
    const std::string name = read_name(face, "face", choice);
    FluxFace read = read_face(face);
    read.name = name;
    if (read.shape == FluxFace::Shape::kPlane && cell.periodic() && !along_axis(read.normal)) {
      face.fail("normal", "a face without ends in a periodic cell has a normal along an axis");
    }
    for (int axis = 0; axis < 2; ++axis) {
      const double half = read.shape == FluxFace::Shape::kPlane ? 0 : reach(read, axis);
      if (half == 0 && read.normal[axis] == 0) continue;  // without ends
      require_in_cell(face, "point", cell, axis, read.point[axis] - half, read.point[axis] + half);
    }
    choice.crossings.push_back(read);
  }
}

}  // namespace

template <int D>
std::optional<ObservableChoice<D>> read_observables(const SceneTable& root,
                                                    const PeriodicCell& cell) {
  const auto found = root.table("observables");
  if (!found) return std::nullopt;
  const SceneTable& table = *found;
  ObservableChoice<D> choice;
  choice.every = at_least_one(table, "every", choice.every);
  choice.starts = table.number("starts", choice.starts);
  read_window<D>(table, choice);
  read_profile<D>(table, choice);
  choice.force_bins = at_least_one(table, "force_bins", choice.force_bins);
  constexpr int kMostBins = 1000000;
  if (choice.force_bins > kMostBins) table.fail("force_bins", "expected at most a million");
  if (table.has("force_limit")) choice.force_limit = table.positive("force_limit");
  for (int axis = 0; D == 3 && axis < 2; ++axis) {
    if (choice.window) {
      require_in_cell(table, "window", cell, axis, choice.window->lower[axis],
                      choice.window->upper[axis]);
    }
    if (choice.profile && choice.profile->axis == axis) {
      require_in_cell(table, "profile_range", cell, axis, choice.profile->low,
                      choice.profile->high);
    }
  }
  read_crossings(table, cell, choice);
  return choice;
}

template std::optional<ObservableChoice<2>> read_observables(const SceneTable&,
                                                             const PeriodicCell&);
template std::optional<ObservableChoice<3>> read_observables(const SceneTable&,
                                                             const PeriodicCell&);

}  // namespace bipot
