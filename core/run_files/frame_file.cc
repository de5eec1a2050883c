#include "core/run_files/frame_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/files/atomic_file.h"
#include "core/files/hdf5_columns.h"
#include "core/motion/force_balance.h"
#include "core/motion/periodic_state.h"
#include "core/motion/sample_area.h"
#include "core/motion/sample_volume.h"
#include "core/run_files/frame_entries.h"
#include "core/run_files/observable_output.h"
#include "core/run_files/xdmf_index.h"
#include "core/scene/scene_box.h"
#include "core/scene/wall_motion.h"
#include "core/scene/wall_pieces.h"

namespace bipot {
namespace {

/// ParaView's symmetric tensors: xx, xy, xz, yy, yz, zz.
template <int D>
Eigen::Matrix<double, 6, 1> six_components(const Mat<D>& s) {
  Eigen::Matrix3d x = Eigen::Matrix3d::Zero();
  x.topLeftCorner<D, D>() = 0.5 * (s + s.transpose());
  return {x(0, 0), x(0, 1), x(0, 2), x(1, 1), x(1, 2), x(2, 2)};
}

/// Stress of each disk and of the sample. Changes of spin are those of the contact moments
/// (stress_tensor.h).
template <int D>
void write_stresses(Hdf5File& file, const State<D>& state, double step,
                    const MeanStress<D>& sample) {
  const std::vector<Spin<D>> moments = contact_moments(state);
  const std::vector<MeanStress<D>> disks = disk_stresses<D>(state, step, moments);
  write_column(file, "/bodies/stress", "Pa", disks,
               [](const MeanStress<D>& s) { return six_components<D>(s.total()); });
  write_column(file, "/bodies/pressure", "Pa", disks, &MeanStress<D>::pressure);
  file.write(D == 2 ? "/sample/area" : "/sample/volume", sample.area, D == 2 ? "m2" : "m3");
  if (!(sample.area > 0)) return;
  for (const auto& [name, part] : {std::pair{"/sample/contact_stress", &sample.contact},
                                   {"/sample/kinetic_stress", &sample.kinetic},
                                   {"/sample/spin_stress", &sample.spin}}) {
    const Eigen::Matrix<double, D, D, Eigen::RowMajor> rows = *part;
    file.write_rows(name, std::span(rows.data(), D * D), D, "Pa");
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
  Hdf5Column rim;
  for (const Wall<2>& w : walls) {
    if (!w.is_circle()) continue;
    for (int k = 0; k < kRimPoints; ++k) {
      const double angle = 2 * std::numbers::pi * k / (kRimPoints - 1);
      const double radius = w.present ? w.radius : 0;
      rim.add(Vec2(w.a + radius * Vec2(std::cos(angle), std::sin(angle))));
    }
  }
  if (rim.values().empty()) return;
  file.write_rows("/walls/rim", rim.values(), 2, "m");
  write_point_numbers(file, "/walls/rim_points", rim.values().size() / 2);
}

/// With three components, as ParaView's vectors have them.
template <int D>
Vec3 in_space(const Vec<D>& x) {
  Vec3 y = Vec3::Zero();
  y.head<D>() = x;
  return y;
}

}  // namespace

template <int D>
void write_wall_drives(Hdf5File& file, const std::vector<Wall<D>>& walls,
                       const std::vector<Wall<D>>& scene) {
  const auto any = [&](const auto& is) { return std::any_of(scene.begin(), scene.end(), is); };
  write_column(file, "/walls/force", "N", walls, &Wall<D>::force);
  if (any([](const Wall<D>& w) { return w.is_circle() || w.is_surface(); })) {
    write_column(file, "/walls/spin", "rad/s", walls, &Wall<D>::spin);
  }
  if (any([](const Wall<D>& w) { return !w.belt.isZero(0); })) {
    write_column(file, "/walls/belt", "m/s", walls, &Wall<D>::belt);
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
  file.write("/time", state.time, "s");
  file.write("/wall_work", state.wall_work, "J");
  file.write("/friction_loss", state.friction_loss, "J");
  file.write("/shock_loss", state.shock_loss, "J");
  if (state.halvings > 0) file.write("/halvings", state.halvings);
  if (scene.has_cohesion()) file.write("/cohesion_loss", state.cohesion_loss, "J");

  const auto& disks = state.bodies;
  write_column(file, "/bodies/x", "m", disks, &Body<D>::x);
  if constexpr (D == 2) {
    write_column(file, "/bodies/angle", "rad", disks, &Disk::angle);
  } else {
    write_column(file, "/bodies/orientation", "1", disks, &Sphere::orientation);
  }
  write_column(file, "/bodies/v", "m/s", disks, [](const Body<D>& d) { return in_space<D>(d.v); });
  write_column(file, "/bodies/spin", "rad/s", disks, &Body<D>::spin);

  if (scene.has_gates()) write_population(file, state);
  if (!scene.clusters.empty()) write_clusters(file, state);

  State<D> inside;
  if (state.cell.periodic()) {
    inside = wrapped_state(state);
    write_cell(file, inside);
  }
  const State<D>& drawn = state.cell.periodic() ? inside : state;
  const auto& walls = state.walls;
  write_column(file, "/walls/a", "m", walls, &Wall<D>::a);
  write_column(file, "/walls/b", "m", walls, &Wall<D>::b);
  write_column(file, "/walls/v", "m/s", walls, &Wall<D>::v);
  write_wall_shapes(file, walls, view_box(drawn.bodies, walls));
  if (std::any_of(scene.walls.begin(), scene.walls.end(), has_schedule<D>)) {
    write_column(file, "/walls/motion", "", walls, &Wall<D>::motion);
    write_column(file, "/walls/present", "", walls, &Wall<D>::present);
    write_wall_drives(file, walls, scene.walls);
  }
  if constexpr (D == 2) write_rims(file, walls);

  const auto& contacts = state.contacts;
  using Outcome = ContactOutcome<D>;
  write_column(file, "/contacts/i", "", contacts, [](const Outcome& c) { return c.contact.i; });
  write_column(file, "/contacts/j", "", contacts, [](const Outcome& c) { return c.contact.j; });
  write_column(file, "/contacts/status", "", contacts, &Outcome::status);
  write_column(file, "/contacts/n", "1", contacts, [](const Outcome& c) { return c.contact.n; });
  write_column(file, "/contacts/gap", "m", contacts,
               [](const Outcome& c) { return c.contact.gap; });
  write_column(file, "/contacts/s_n", "N s", contacts, &Outcome::s_n);
  write_column(file, "/contacts/s_t", "N s", contacts, &Outcome::s_t);
  write_column(file, "/contacts/u_n", "m/s", contacts, &Outcome::u_n);
  write_column(file, "/contacts/u_t", "m/s", contacts, &Outcome::u_t);
  if (state.cell.periodic()) {
    write_column(file, "/contacts/image_x", "", contacts,
                 [](const Outcome& c) { return c.contact.image_x; });
    write_column(file, "/contacts/image_y", "", contacts,
                 [](const Outcome& c) { return c.contact.image_y; });
  }
  if (scene.has_cohesion()) write_column(file, "/contacts/bonded", "", contacts, &Outcome::bonded);
  if (scene.model == Model::kSpringDashpot) {
    write_column(file, "/contacts/spring", "m", contacts, &Outcome::spring);
  }
  if (scene.has_rolling()) {
    write_column(file, "/contacts/moment", "N m s", contacts, &Outcome::moment);
  }
  const double h = scene.step;
  write_column(file, "/contacts/force_n", "N", contacts,
               [&](const Outcome& c) { return c.s_n / h; });
  write_column(file, "/contacts/force_t", "N", contacts,
               [&](const Outcome& c) { return Tangent<D>(c.s_t / h); });
  write_column(file, "/contacts/force", "N", contacts, [&](const Outcome& c) {
    return Vec<D>((c.s_n * c.contact.n + tangent_vector(c.contact.n, c.s_t)) / h);
  });
  write_column(file, "/contacts/point", "m", contacts, [&](const Outcome& c) {
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
