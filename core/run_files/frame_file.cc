#include "core/run_files/frame_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/files/atomic_file.h"
#include "core/motion/force_balance.h"
#include "core/motion/periodic_state.h"
#include "core/motion/sample_area.h"
#include "core/motion/sample_volume.h"
#include "core/run_files/frame_entries.h"
#include "core/run_files/hdf5_columns.h"
#include "core/run_files/observable_output.h"
#include "core/run_files/xdmf_index.h"
#include "core/scene/scene_box.h"
#include "core/scene/wall_motion.h"
#include "core/scene/wall_pieces.h"

namespace bipot {
namespace {

/// Orientation of the bodies: angles in 2D, unit quaternions (w, x, y, z) in 3D.
void write_orientations(Hdf5File& file, const std::vector<Disk>& disks) {
  write_doubles(file, "/bodies/angle", "rad", disks, [](const Disk& d) { return d.angle; });
}
void write_orientations(Hdf5File& file, const std::vector<Sphere>& spheres) {
  write_vectors(file, "/bodies/orientation", "1", spheres, [](const Sphere& s) {
    const auto& q = s.orientation;
    return Eigen::Vector4d(q.w(), q.x(), q.y(), q.z());
  });
}

/// ParaView's symmetric tensors: xx, xy, xz, yy, yz, zz.
template <int D>
std::array<double, 6> six_components(const Mat<D>& s) {
  const double xy = 0.5 * (s(0, 1) + s(1, 0));
  if constexpr (D == 2) {
    return {s(0, 0), xy, 0.0, s(1, 1), 0.0, 0.0};
  } else {
    return {s(0, 0), xy, 0.5 * (s(0, 2) + s(2, 0)), s(1, 1), 0.5 * (s(1, 2) + s(2, 1)), s(2, 2)};
  }
}

/// Stress of each disk and of the sample. Changes of spin are those of the contact moments
/// (stress_tensor.h).
template <int D>
void write_stresses(Hdf5File& file, const State<D>& state, double step,
                    const MeanStress<D>& sample) {
  const std::vector<Spin<D>> moments = contact_moments(state);
  const std::vector<MeanStress<D>> disks = disk_stresses<D>(state, step, moments);
  Hdf5Column tensors(6 * disks.size());
  for (const MeanStress<D>& stress : disks) {
    for (const double x : six_components<D>(stress.total())) tensors.add(x);
  }
  file.write_rows("/bodies/stress", tensors.values(), 6);
  file.write_attribute("/bodies/stress", "unit", "Pa");
  write_doubles(file, "/bodies/pressure", "Pa", disks,
                [](const MeanStress<D>& s) { return s.pressure(); });
  const char* size = D == 2 ? "/sample/area" : "/sample/volume";
  file.write(size, sample.area);
  file.write_attribute(size, "unit", D == 2 ? "m2" : "m3");
  if (!(sample.area > 0)) return;
  for (const auto& [name, part] : {std::pair{"/sample/contact_stress", &sample.contact},
                                   {"/sample/kinetic_stress", &sample.kinetic},
                                   {"/sample/spin_stress", &sample.spin}}) {
    const Eigen::Matrix<double, D, D, Eigen::RowMajor> rows = *part;
    file.write_rows(name, std::vector<double>(rows.data(), rows.data() + D * D), D);
    file.write_attribute(name, "unit", "Pa");
  }
}

/// Writes walls as they are drawn: lines, and the rims of circles; in 3D pieces with four corners.
void write_wall_shapes(Hdf5File& file, const std::vector<Wall<2>>& walls, const Box<2>& view) {
  Hdf5Column lines(4 * walls.size());
  for (const auto& [first, last] : wall_lines(walls, view)) {
    lines.add(first);
    lines.add(last);
  }
  file.write_rows("/walls/segment", lines.values(), 2);
  write_point_numbers(file, "/walls/points", 2 * walls.size());
}
void write_wall_shapes(Hdf5File& file, const std::vector<Wall<3>>& walls, const Box<3>& view) {
  Hdf5Column corners(12 * walls.size());
  for (const WallPiece& piece : wall_pieces(walls, view)) {
    for (const Vec3& corner : piece.corners) corners.add(corner);
  }
  file.write_rows("/walls/piece", corners.values(), 3);
  write_point_numbers(file, "/walls/points", corners.values().size() / 3);
}

/// Circles as polygons, closed: kRimPoints points each.
void write_rims(Hdf5File& file, const std::vector<Wall<2>>& walls) {
  Hdf5Column rim(0);
  for (const Wall<2>& w : walls) {
    if (!w.is_circle()) continue;
    for (int k = 0; k < kRimPoints; ++k) {
      const double angle = 2 * std::numbers::pi * k / (kRimPoints - 1);
      const double radius = w.present ? w.radius : 0;
      rim.add(Vec2(w.a + radius * Vec2(std::cos(angle), std::sin(angle))));
    }
  }
  if (rim.values().empty()) return;
  file.write_rows("/walls/rim", rim.values(), 2);
  file.write_attribute("/walls/rim", "unit", "m");
  write_point_numbers(file, "/walls/rim_points", rim.values().size() / 2);
}

/// Velocities with three components, as ParaView's vectors have them.
template <int D>
void write_velocities(Hdf5File& file, const std::vector<Body<D>>& bodies) {
  Hdf5Column velocity(3 * bodies.size());
  for (const Body<D>& b : bodies) {
    velocity.add(b.v);
    if constexpr (D == 2) velocity.add(0.0);
  }
  file.write_rows("/bodies/v", velocity.values(), 3);
  file.write_attribute("/bodies/v", "unit", "m/s");
}

}  // namespace

template <int D>
void write_wall_drives(Hdf5File& file, const std::vector<Wall<D>>& walls,
                       const std::vector<Wall<D>>& scene) {
  const auto any = [&](const auto& is) { return std::any_of(scene.begin(), scene.end(), is); };
  write_doubles(file, "/walls/force", "N", walls, [](const Wall<D>& w) { return w.force; });
  if (any([](const Wall<D>& w) { return w.is_circle() || w.is_surface(); })) {
    write_doubles(file, "/walls/spin", "rad/s", walls, [](const Wall<D>& w) { return w.spin; });
  }
  if (any([](const Wall<D>& w) { return !w.belt.isZero(0); })) {
    write_vectors(file, "/walls/belt", "m/s", walls, [](const Wall<D>& w) { return w.belt; });
  }
}

template <int D>
MeanStress<D> stress_of_sample(const State<D>& state, double step) {
  return sample_stress<D>(state, step, sample_measure(state, step), contact_moments(state));
}

template <int D>
void write_frame_file(const std::filesystem::path& path, const Scene<D>& scene,
                      const State<D>& state, const MeanStress<D>& stress) {
  AtomicFile target(path);
  Hdf5File file(target.draft(), Hdf5File::Mode::kCreate);
  file.write("/step", state.step);
  file.write("/time", state.time);
  file.write_attribute("/time", "unit", "s");
  file.write("/wall_work", state.wall_work);
  file.write("/friction_loss", state.friction_loss);
  file.write("/shock_loss", state.shock_loss);
  for (const char* name : {"/wall_work", "/friction_loss", "/shock_loss"}) {
    file.write_attribute(name, "unit", "J");
  }

  if (state.halvings > 0) file.write("/halvings", state.halvings);
  if (scene.has_cohesion()) {
    file.write("/cohesion_loss", state.cohesion_loss);
    file.write_attribute("/cohesion_loss", "unit", "J");
  }

  const auto& disks = state.bodies;
  write_vectors(file, "/bodies/x", "m", disks, [](const Body<D>& d) { return d.x; });
  write_orientations(file, disks);
  write_velocities<D>(file, disks);
  write_turns(file, "/bodies/spin", "rad/s", disks, [](const Body<D>& d) { return d.spin; });

  if (scene.has_gates()) write_population(file, state);
  if (!scene.clusters.empty()) write_clusters(file, state);

  State<D> inside;
  if (state.cell.periodic()) {
    inside = wrapped_state(state);
    write_cell(file, inside);
  }
  const State<D>& drawn = state.cell.periodic() ? inside : state;
  const auto& walls = state.walls;
  write_vectors(file, "/walls/a", "m", walls, [](const Wall<D>& w) { return w.a; });
  write_vectors(file, "/walls/b", "m", walls, [](const Wall<D>& w) { return w.b; });
  write_vectors(file, "/walls/v", "m/s", walls, [](const Wall<D>& w) { return w.v; });
  write_wall_shapes(file, walls, view_box(drawn.bodies, walls));
  if (std::any_of(scene.walls.begin(), scene.walls.end(), has_schedule<D>)) {
    write_ints(file, "/walls/motion", walls,
               [](const Wall<D>& w) { return static_cast<int>(w.motion); });
    write_ints(file, "/walls/present", walls, [](const Wall<D>& w) { return w.present ? 1 : 0; });
    write_wall_drives(file, walls, scene.walls);
  }
  if constexpr (D == 2) write_rims(file, walls);

  const auto& contacts = state.contacts;
  using Outcome = ContactOutcome<D>;
  write_ints(file, "/contacts/i", contacts, [](const Outcome& c) { return c.contact.i; });
  write_ints(file, "/contacts/j", contacts, [](const Outcome& c) { return c.contact.j; });
  write_ints(file, "/contacts/status", contacts,
             [](const Outcome& c) { return static_cast<int>(c.status); });
  write_vectors(file, "/contacts/n", "1", contacts, [](const Outcome& c) { return c.contact.n; });
  write_doubles(file, "/contacts/gap", "m", contacts,
                [](const Outcome& c) { return c.contact.gap; });
  write_doubles(file, "/contacts/s_n", "N s", contacts, [](const Outcome& c) { return c.s_n; });
  write_turns(file, "/contacts/s_t", "N s", contacts, [](const Outcome& c) { return c.s_t; });
  write_doubles(file, "/contacts/u_n", "m/s", contacts, [](const Outcome& c) { return c.u_n; });
  write_turns(file, "/contacts/u_t", "m/s", contacts, [](const Outcome& c) { return c.u_t; });
  if (state.cell.periodic()) {
    write_ints(file, "/contacts/image_x", contacts,
               [](const Outcome& c) { return c.contact.image_x; });
    write_ints(file, "/contacts/image_y", contacts,
               [](const Outcome& c) { return c.contact.image_y; });
  }
  if (scene.has_cohesion()) {
    write_ints(file, "/contacts/bonded", contacts,
               [](const Outcome& c) { return c.bonded ? 1 : 0; });
  }
  if (scene.model == Model::kSpringDashpot) {
    write_turns(file, "/contacts/spring", "m", contacts, [](const Outcome& c) { return c.spring; });
  }
  if (scene.has_rolling()) {
    write_turns(file, "/contacts/moment", "N m s", contacts,
                [](const Outcome& c) { return c.moment; });
  }
  const double h = scene.step;
  write_doubles(file, "/contacts/force_n", "N", contacts,
                [&](const Outcome& c) { return c.s_n / h; });
  write_turns(file, "/contacts/force_t", "N", contacts,
              [&](const Outcome& c) { return Tangent<D>(c.s_t / h); });
  write_vectors(file, "/contacts/force", "N", contacts, [&](const Outcome& c) {
    return Vec<D>((c.s_n * c.contact.n + tangent_vector(c.contact.n, c.s_t)) / h);
  });
  write_vectors(file, "/contacts/point", "m", contacts, [&](const Outcome& c) {
    const Body<D>& body = drawn.bodies[to_size(c.contact.i)];
    return Vec<D>(body.x - body.radius * c.contact.n);
  });
  Hdf5Column branch(2 * D * contacts.size());
  for (const Outcome& c : contacts) {
    const auto [a, b] = drawn_branch(drawn, c.contact);
    branch.add(a);
    branch.add(b);
  }
  file.write_rows("/contacts/segment", branch.values(), D);
  write_point_numbers(file, "/contacts/points", 2 * contacts.size());
  write_stresses(file, state, h, stress);
  if (scene.observables) write_observables(file, scene, state);
  add_descriptions(file);
  file.close();
  target.commit();
}

template MeanStress<2> stress_of_sample(const State<2>&, double);
template MeanStress<3> stress_of_sample(const State<3>&, double);
template void write_frame_file(const std::filesystem::path&, const Scene<2>&, const State<2>&,
                               const MeanStress<2>&);
template void write_frame_file(const std::filesystem::path&, const Scene<3>&, const State<3>&,
                               const MeanStress<3>&);
template void write_wall_drives(Hdf5File&, const std::vector<Wall<2>>&,
                                const std::vector<Wall<2>>&);
template void write_wall_drives(Hdf5File&, const std::vector<Wall<3>>&,
                                const std::vector<Wall<3>>&);

}  // namespace bipot
