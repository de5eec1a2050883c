#include "core/run_files/run_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "core/files/hdf5_columns.h"
#include "core/run_files/frame_entries.h"
#include "core/scene/triangle_mesh.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

bool finite_turn(const Disk& d) { return std::isfinite(d.angle) && std::isfinite(d.spin); }
bool finite_turn(const Sphere& s) {
  return s.orientation.coeffs().allFinite() && s.spin.allFinite();
}

/// `fixed`: run.h5. `frame`: the frame's file, which describes all disks if some come or go.
template <int D>
std::vector<Body<D>> read_disks(const Hdf5File& fixed, const Hdf5File& frame,
                                Population<D>& population) {
  std::vector<Body<D>> disks;
  if (!read_population(frame, disks, population)) read_body_constants(fixed, disks);
  const std::string at = bodies_group(frame);
  read_column(frame, at + "x", disks, &Body<D>::x);
  if constexpr (D == 2) {
    read_column(frame, at + "angle", disks, &Disk::angle);
  } else {
    read_column(frame, at + "orientation", disks, &Sphere::orientation);
  }
  std::vector<Vec3> v(disks.size());
  read_column(frame, at + "v", v, std::identity());
  for (std::size_t k = 0; k < disks.size(); ++k) disks[k].v = v[k].head<D>();
  read_column(frame, at + "spin", disks, &Body<D>::spin);
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
  using Wall = Wall<D>;
  std::vector<Wall> walls;
  for (std::string& name : fixed.read_strings("/walls/name")) {
    walls.push_back({.name = std::move(name)});
  }
  read_column(fixed, "/walls/shape", walls, &Wall::shape, D == 2 ? 3 : 5);
  // Walls that start or go: frames then have their motion of that moment.
  const Hdf5File& motion = frame.exists("/walls/present") ? frame : fixed;
  read_column(motion, "/walls/motion", walls, &Wall::motion, 2);
  read_column(fixed, "/walls/material", walls, &Wall::material);
  read_column(fixed, "/walls/normal", walls, &Wall::normal);
  read_column(fixed, "/walls/direction", walls, &Wall::direction);
  read_column(fixed, "/walls/mass", walls, &Wall::mass);
  read_column(frame, "/walls/a", walls, &Wall::a);
  read_column(frame, "/walls/b", walls, &Wall::b);
  read_column(frame, "/walls/v", walls, &Wall::v);
  // Written if a scene has circles, belts, walls moved across a force, or walls that start or go.
  read_optional_column(fixed, "/walls/radius", walls, &Wall::radius);
  read_optional_column(fixed, "/walls/radius_b", walls, &Wall::radius_b);
  read_optional_column(fixed, "/walls/across", walls, &Wall::across);
  // Frames of earlier versions do not have them.
  const Hdf5File& drives = frame.exists("/walls/force") ? frame : fixed;
  read_column(drives, "/walls/force", walls, &Wall::force);
  read_optional_column(drives, "/walls/spin", walls, &Wall::spin);
  read_optional_column(drives, "/walls/belt", walls, &Wall::belt);
  read_optional_column(frame, "/walls/present", walls, &Wall::present);
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
  std::vector<CellSide> sides(3);
  read_column(fixed, "/cell/motion", sides, &CellSide::motion, 2);
  read_column(fixed, "/cell/stress", sides, &CellSide::stress);
  read_column(fixed, "/cell/mass", sides, &CellSide::mass);
  read_column(frame, "/cell/lengths", sides, &CellSide::length);
  read_column(frame, "/cell/speeds", sides, &CellSide::speed);
  for (int k = 0; k < 3; ++k) cell.side(k) = sides[to_size(k)];
  return cell;
}

/// Throws FileError if a contact joins bodies that the run does not have.
template <int D>
std::vector<ContactOutcome<D>> read_contacts(const Hdf5File& file, std::size_t disks,
                                             std::size_t walls) {
  using Outcome = ContactOutcome<D>;
  std::vector<Outcome> contacts(file.size("/contacts/i"));
  read_column(file, "/contacts/i", contacts, [](Outcome& c) -> int& { return c.contact.i; });
  read_column(file, "/contacts/j", contacts, [](Outcome& c) -> int& { return c.contact.j; });
  read_column(file, "/contacts/status", contacts, &Outcome::status, 2);
  read_column(file, "/contacts/n", contacts, [](Outcome& c) -> Vec<D>& { return c.contact.n; });
  read_column(file, "/contacts/gap", contacts, [](Outcome& c) -> double& { return c.contact.gap; });
  read_column(file, "/contacts/s_n", contacts, &Outcome::s_n);
  read_column(file, "/contacts/s_t", contacts, &Outcome::s_t);
  read_column(file, "/contacts/u_n", contacts, &Outcome::u_n);
  read_column(file, "/contacts/u_t", contacts, &Outcome::u_t);
  // Only the spring-dashpot model writes springs.
  read_optional_column(file, "/contacts/spring", contacts, &Outcome::spring);
  // Only scenes with cohesion write bonds; elsewhere every contact may become one.
  read_optional_column(file, "/contacts/bonded", contacts, &Outcome::bonded);
  // Only scenes with rolling friction write moments.
  read_optional_column(file, "/contacts/moment", contacts, &Outcome::moment);
  // Only periodic scenes write images.
  read_optional_column(file, "/contacts/image_x", contacts,
                       [](Outcome& c) -> int& { return c.contact.image_x; });
  read_optional_column(file, "/contacts/image_y", contacts,
                       [](Outcome& c) -> int& { return c.contact.image_y; });
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const int i = contacts[k].contact.i, j = contacts[k].contact.j;
    if (i < 0 || i >= static_cast<int>(disks) || j < 0 || j >= static_cast<int>(disks + walls)) {
      throw FileError(file.path(), "/contacts",
                      fmt::format("contact {} joins the bodies {} and {}", k, i, j));
    }
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
  if (state.step < 0 || !std::isfinite(state.time)) {
    throw FileError(file.path(), "/time", fmt::format("step {}, {} s", state.step, state.time));
  }
  state.wall_work = file.read_double("/wall_work");
  state.friction_loss = file.read_double("/friction_loss");
  state.shock_loss = file.read_double("/shock_loss");
  if (file.exists("/halvings")) state.halvings = file.read_int("/halvings");
  if (file.exists("/cohesion_loss")) state.cohesion_loss = file.read_double("/cohesion_loss");
  state.bodies = read_disks<D>(fixed, file, state.population);
  for (std::size_t i = 0; i < state.bodies.size(); ++i) {
    const Body<D>& body = state.bodies[i];
    if (body.x.allFinite() && body.v.allFinite() && finite_turn(body)) continue;
    throw FileError(file.path(), "/bodies",
                    fmt::format("{} {}: place or motion is not finite", kBodyName<D>, i));
  }
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
