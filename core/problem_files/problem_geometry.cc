#include "core/problem_files/problem_geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/files/atomic_file.h"
#include "core/files/hdf5_columns.h"

namespace bipot {
namespace {

constexpr const char* kGroup = "/bipot/geometry";

std::string name(const char* entry) { return fmt::format("{}/{}", kGroup, entry); }

using PlaneContact = ContactOutcome<2>;

}  // namespace

void write_geometry(const std::filesystem::path& path, const Scene<2>& scene,
                    const State<2>& state) {
  AtomicFile target(path);
  target.copy_earlier();
  Hdf5File file(target.draft(), Hdf5File::Mode::kAppend);
  if (file.exists(kGroup)) file.remove(kGroup);
  write_column(file, name("disks/x"), "", state.bodies, &Disk::x);
  write_column(file, name("disks/radius"), "", state.bodies, &Disk::radius);
  write_column(file, name("walls/shape"), "", state.walls, &Wall<2>::shape);
  write_column(file, name("walls/a"), "", state.walls, &Wall<2>::a);
  write_column(file, name("walls/b"), "", state.walls, &Wall<2>::b);
  write_column(file, name("walls/normal"), "", state.walls, &Wall<2>::normal);
  const auto circle_or_gone = [](const Wall<2>& w) { return w.is_circle() || !w.present; };
  if (std::any_of(state.walls.begin(), state.walls.end(), circle_or_gone)) {
    write_column(file, name("walls/radius"), "", state.walls, &Wall<2>::radius);
    write_column(file, name("walls/present"), "", state.walls, &Wall<2>::present);
  }
  const auto& contacts = state.contacts;
  write_column(file, name("contacts/i"), "", contacts,
               [](const PlaneContact& o) { return o.contact.i; });
  write_column(file, name("contacts/j"), "", contacts,
               [](const PlaneContact& o) { return o.contact.j; });
  write_column(file, name("contacts/n"), "", contacts,
               [](const PlaneContact& o) { return o.contact.n; });
  file.write(name("friction"), scene.has_friction() ? 1 : 0);
  file.write(name("step"), scene.step);
  file.write(name("number"), state.step);
  file.write(name("time"), state.time);
  file.close();
  target.commit();
}

std::optional<ProblemGeometry> read_geometry(const std::filesystem::path& path, int contacts) {
  if (!Hdf5File::is_hdf5(path)) return std::nullopt;
  const Hdf5File file(path, Hdf5File::Mode::kRead);
  if (!file.exists(kGroup)) return std::nullopt;
  ProblemGeometry made;
  const auto require = [&](bool sound, const char* entry, const char* defect) {
    if (!sound) throw FileError(path, name(entry), defect);
  };
  std::vector<Disk>& disks = made.state.bodies;
  disks.resize(file.size(name("disks/radius")));
  read_column(file, name("disks/x"), disks, &Disk::x);
  read_column(file, name("disks/radius"), disks, &Disk::radius);
  for (const Disk& d : disks) {
    require(d.x.allFinite(), "disks/x", "not finite");
    require(d.radius > 0 && std::isfinite(d.radius), "disks/radius", "not positive and finite");
  }
  std::vector<Wall<2>>& walls = made.state.walls;
  walls.resize(file.size(name("walls/shape")));
  read_column(file, name("walls/shape"), walls, &Wall<2>::shape, 3);
  read_column(file, name("walls/a"), walls, &Wall<2>::a);
  read_column(file, name("walls/b"), walls, &Wall<2>::b);
  read_column(file, name("walls/normal"), walls, &Wall<2>::normal);
  read_optional_column(file, name("walls/radius"), walls, &Wall<2>::radius);
  read_optional_column(file, name("walls/present"), walls, &Wall<2>::present);
  for (const Wall<2>& w : walls) {
    require(w.a.allFinite(), "walls/a", "not finite");
    require(w.b.allFinite(), "walls/b", "not finite");
    require(w.normal.allFinite(), "walls/normal", "not finite");
    require(std::isfinite(w.radius), "walls/radius", "not finite");
    require(!w.is_circle() || w.radius > 0, "walls/radius", "missing or not positive");
  }
  std::vector<PlaneContact>& outcomes = made.state.contacts;
  outcomes.resize(to_size(contacts));
  read_column(file, name("contacts/i"), outcomes,
              [](PlaneContact& o) -> int& { return o.contact.i; });
  read_column(file, name("contacts/j"), outcomes,
              [](PlaneContact& o) -> int& { return o.contact.j; });
  read_column(file, name("contacts/n"), outcomes,
              [](PlaneContact& o) -> Vec2& { return o.contact.n; });
  for (const PlaneContact& o : outcomes) {
    const int i = o.contact.i, j = o.contact.j;
    require(i >= 0 && to_size(i) < disks.size(), "contacts/i", "out of range");
    require(j >= 0 && to_size(j) < disks.size() + walls.size(), "contacts/j", "out of range");
    require(o.contact.n.allFinite(), "contacts/n", "not finite");
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
