#include "core/problem_files/problem_geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/files/hdf5_file.h"

namespace bipot {
namespace {

constexpr const char* kGroup = "/bipot/geometry";

std::string name(const char* entry) { return fmt::format("{}/{}", kGroup, entry); }

template <class Items, class Value>
void write_geometry_vectors(Hdf5File& file, const char* entry, const Items& items,
                            const Value& value) {
  std::vector<double> numbers;
  for (const auto& item : items) {
    const Vec2 x = value(item);
    numbers.insert(numbers.end(), {x[0], x[1]});
  }
  file.write_rows(name(entry), numbers, 2);
}

template <class Items, class Value>
void write_geometry_ints(Hdf5File& file, const char* entry, const Items& items,
                         const Value& value) {
  std::vector<int> numbers;
  for (const auto& item : items) numbers.push_back(value(item));
  file.write(name(entry), std::span<const int>(numbers));
}

/// The numbers of an entry; throws unless there are `count` of them, all finite.
std::vector<double> read_numbers(const Hdf5File& file, const char* entry, std::size_t count) {
  std::vector<double> numbers = file.read_doubles(name(entry), count);
  for (const double x : numbers) {
    if (!std::isfinite(x)) throw FileError(file.path(), name(entry), "not finite");
  }
  return numbers;
}

std::vector<int> read_indices(const Hdf5File& file, const char* entry, std::size_t count,
                              std::size_t below) {
  std::vector<int> numbers = file.read_ints(name(entry), count);
  for (const int x : numbers) {
    if (x < 0 || to_size(x) >= below) {
      throw FileError(file.path(), name(entry), fmt::format("{} is out of range", x));
    }
  }
  return numbers;
}

Vec2 vector_at(const std::vector<double>& numbers, std::size_t k) {
  return Vec2(numbers[2 * k], numbers[2 * k + 1]);
}

}  // namespace

void write_geometry(const std::filesystem::path& path, const Scene<2>& scene,
                    const State<2>& state) {
  Hdf5File file(path, Hdf5File::Mode::kAppend);
  if (file.exists(kGroup)) file.remove(kGroup);
  std::vector<double> radii;
  for (const Disk& d : state.bodies) radii.push_back(d.radius);
  write_geometry_vectors(file, "disks/x", state.bodies, [](const Disk& d) { return d.x; });
  file.write(name("disks/radius"), std::span<const double>(radii));
  write_geometry_ints(file, "walls/shape", state.walls,
                      [](const Wall<2>& w) { return static_cast<int>(w.shape); });
  write_geometry_vectors(file, "walls/a", state.walls, [](const Wall<2>& w) { return w.a; });
  write_geometry_vectors(file, "walls/b", state.walls, [](const Wall<2>& w) { return w.b; });
  write_geometry_vectors(file, "walls/normal", state.walls,
                         [](const Wall<2>& w) { return w.normal; });
  const auto circle_or_gone = [](const Wall<2>& w) { return w.is_circle() || !w.present; };
  if (std::any_of(state.walls.begin(), state.walls.end(), circle_or_gone)) {
    std::vector<double> wall_radii;
    for (const Wall<2>& w : state.walls) wall_radii.push_back(w.radius);
    file.write(name("walls/radius"), std::span<const double>(wall_radii));
    write_geometry_ints(file, "walls/present", state.walls,
                        [](const Wall<2>& w) { return w.present ? 1 : 0; });
  }
  write_geometry_ints(file, "contacts/i", state.contacts,
                      [](const ContactOutcome<2>& o) { return o.contact.i; });
  write_geometry_ints(file, "contacts/j", state.contacts,
                      [](const ContactOutcome<2>& o) { return o.contact.j; });
  write_geometry_vectors(file, "contacts/n", state.contacts,
                         [](const ContactOutcome<2>& o) { return o.contact.n; });
  file.write(name("friction"), scene.has_friction() ? 1 : 0);
  file.write(name("step"), scene.step);
  file.write(name("number"), state.step);
  file.write(name("time"), state.time);
  file.close();
}

std::optional<ProblemGeometry> read_geometry(const std::filesystem::path& path, int contacts) {
  if (!Hdf5File::is_hdf5(path)) return std::nullopt;
  const Hdf5File file(path, Hdf5File::Mode::kRead);
  if (!file.exists(kGroup)) return std::nullopt;
  ProblemGeometry made;
  const std::size_t disks = file.size(name("disks/radius"));
  const std::vector<double> x = read_numbers(file, "disks/x", 2 * disks);
  const std::vector<double> radii = read_numbers(file, "disks/radius", disks);
  made.state.bodies.resize(disks);
  for (std::size_t k = 0; k < disks; ++k) {
    made.state.bodies[k].x = vector_at(x, k);
    made.state.bodies[k].radius = radii[k];
    if (!(radii[k] > 0)) throw FileError(path, name("disks/radius"), "not positive");
  }
  const std::size_t walls = file.size(name("walls/shape"));
  const std::vector<int> shapes = read_indices(file, "walls/shape", walls, 4);
  const std::vector<double> a = read_numbers(file, "walls/a", 2 * walls);
  const std::vector<double> b = read_numbers(file, "walls/b", 2 * walls);
  const std::vector<double> normal = read_numbers(file, "walls/normal", 2 * walls);
  const bool circles = file.exists(name("walls/radius"));
  const std::vector<double> wall_radii =
      circles ? read_numbers(file, "walls/radius", walls) : std::vector<double>(walls, 0.0);
  const std::vector<int> present =
      circles ? read_indices(file, "walls/present", walls, 2) : std::vector<int>(walls, 1);
  for (std::size_t k = 0; k < walls; ++k) {
    Wall<2> wall{.shape = static_cast<Wall<2>::Shape>(shapes[k]),
                 .a = vector_at(a, k),
                 .b = vector_at(b, k),
                 .normal = vector_at(normal, k),
                 .radius = wall_radii[k],
                 .present = present[k] != 0};
    made.state.walls.push_back(wall);
  }
  const std::size_t count = to_size(contacts);
  const std::vector<int> i = read_indices(file, "contacts/i", count, disks);
  const std::vector<int> j = read_indices(file, "contacts/j", count, disks + walls);
  const std::vector<double> n = read_numbers(file, "contacts/n", 2 * count);
  made.state.contacts.resize(count);
  for (std::size_t k = 0; k < count; ++k) {
    made.state.contacts[k].contact = {i[k], j[k], vector_at(n, k), 0};
  }
  made.state.step = file.read_int(name("number"));
  made.state.time = file.read_double(name("time"));
  made.scene.step = file.read_double(name("step"));
  if (!(made.scene.step > 0)) throw FileError(path, name("step"), "not positive");
  made.scene.walls = made.state.walls;
  made.scene.materials = {"default"};
  made.scene.laws = {{.mu = file.read_int(name("friction")) != 0 ? 1.0 : 0.0}};
  return made;
}

}  // namespace bipot
