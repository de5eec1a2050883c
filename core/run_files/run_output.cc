#include "core/run_files/run_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <system_error>

#include "core/base/nearest_name.h"
#include "core/base/version.h"
#include "core/files/atomic_file.h"
#include "core/files/hdf5_columns.h"
#include "core/motion/force_balance.h"
#include "core/motion/population.h"
#include "core/motion/spring_dashpot_setup.h"
#include "core/run_files/frame_entries.h"
#include "core/run_files/frame_file.h"
#include "core/run_files/run_layout.h"
#include "core/scene/scene_box.h"
#include "core/scene/triangle_mesh.h"
#include "core/scene/wall_motion.h"
#include "core/scene/wall_pieces.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kIndexShare = 32;  // see RunWriter
constexpr const char* kMeasured = "/measured";

/// Writes the triangles of all meshes, and how many each wall has.
void write_triangles(Hdf5File& file, const std::vector<Wall<3>>& walls) {
  std::vector<int> counts;
  std::vector<double> corners;
  for (const Wall<3>& w : walls) {
    counts.push_back(w.mesh ? static_cast<int>(w.mesh->triangles.size()) : 0);
    if (!w.mesh) continue;
    for (const auto& triangle : w.mesh->triangles) {
      for (const Vec3& corner : triangle)
        corners.insert(corners.end(), corner.begin(), corner.end());
    }
  }
  if (corners.empty()) return;
  file.write("/walls/triangles", counts);
  file.write_rows("/walls/triangle", corners, 9, "m");
}

/// Writes the constant entries of the walls. Circles and walls moved across a force add datasets.
template <int D>
void write_wall_definitions(Hdf5File& file, const std::vector<Wall<D>>& walls) {
  const auto any = [&](const auto& is) { return std::any_of(walls.begin(), walls.end(), is); };
  file.write("/walls/name", names_of(walls));
  write_column(file, "/walls/shape", "", walls, &Wall<D>::shape);
  write_column(file, "/walls/motion", "", walls, &Wall<D>::motion);
  write_column(file, "/walls/material", "", walls, &Wall<D>::material);
  write_column(file, "/walls/normal", "1", walls, &Wall<D>::normal);
  write_column(file, "/walls/direction", "1", walls, &Wall<D>::direction);
  write_column(file, "/walls/mass", "kg", walls, &Wall<D>::mass);
  if (any([](const Wall<D>& w) { return w.shape == Wall<D>::Shape::kCone; })) {
    write_column(file, "/walls/radius_b", "m", walls, &Wall<D>::radius_b);
  }
  if constexpr (D == 3) write_triangles(file, walls);
  if (any([](const Wall<D>& w) { return w.is_circle() || w.is_surface(); })) {
    write_column(file, "/walls/radius", "m", walls, &Wall<D>::radius);
  }
  if (any([](const Wall<D>& w) { return !w.across.isZero(0); })) {
    write_column(file, "/walls/across", "m/s", walls, &Wall<D>::across);
  }
  write_wall_drives(file, walls, walls);
}

/// Writes the parameters of the spring-dashpot model for this scene.
template <int D>
void write_springs(Hdf5File& file, const Scene<D>& scene) {
  const SpringDashpotSetup setup = spring_dashpot_setup(scene);
  file.write("/dem/stiffness", setup.stiffness, "N/m");
  file.write("/dem/tangential_stiffness", setup.tangential_stiffness, "N/m");
  file.write("/dem/substep", setup.substep, "s");
  file.write("/dem/critical_step", setup.critical_step, "s");
}

template <int D>
XdmfIndex make_index(const Scene<D>& scene) {
  XdmfIndex::Contents has{.dimensions = D,
                          .bodies = scene.bodies.size(),
                          .bodies_change = scene.has_gates(),
                          .clusters = !scene.clusters.empty()};
  if constexpr (D == 2) {
    has.walls = scene.walls.size();
    has.circles = to_size(std::count_if(scene.walls.begin(), scene.walls.end(),
                                        [](const Wall<2>& w) { return w.is_circle(); }));
    has.cell_lines = scene.cell.in_y ? 4 : scene.cell.in_x ? 2 : 0;
  } else {
    has.walls = num_wall_pieces(scene.walls);
    has.cell_lines = scene.cell.in_y ? 12 : scene.cell.in_x ? 8 : 0;
  }
  return XdmfIndex(has);
}

/// A place for stand-ins.
template <int D>
Vec<D> some_place(const Scene<D>& scene) {
  if (!scene.bodies.empty()) return scene.bodies.front().x;
  return scene.inlets.empty() ? Vec<D>(Vec<D>::Zero()) : scene.inlets.front().lower;
}

/// Names and units of the columns of the ledger.
template <int D>
std::string ledger_header(bool dem, bool gates, bool accurate, bool cohesion) {
  const std::string area = D == 2 ? "area [m2]" : "volume [m3]";
  const std::string stress = D == 2 ? ",stress_xx [Pa],stress_yy [Pa],stress_xy [Pa]"
                                    : ",stress_xx [Pa],stress_yy [Pa],stress_zz [Pa]"
                                      ",stress_xy [Pa],stress_xz [Pa],stress_yz [Pa]";
  return "step,time [s],contacts,active,iterations,converged,epsilon,eta,raw42,natural_map"
         ",kinetic [J],potential [J],wall_work [J],friction_loss [J],shock_loss [J],imbalance [J]" +
         columns_of_axes<D>("momentum_", " [kg m/s]") +
         columns_of_axes<D>("momentum_imbalance_", " [kg m/s]") +
         ",penetration [m],overlap,travel," + area + stress + ",kinetic_pressure [Pa]" +
         (dem ? ",elastic [J]" : "") +
         (gates ? ",passed [J]" + columns_of_axes<D>("momentum_passed_", " [kg m/s]") : "") +
         (accurate ? ",parts,rejected,smallest_part [s],misplaced,limited_by" : "") +
         (cohesion ? ",cohesion_loss [J]" : "");
}

template <int D>
std::string walls_header() {
  return "step,time [s],wall" + columns_of_axes<D>("", " [m]") + columns_of_axes<D>("v", " [m/s]") +
         columns_of_axes<D>("force_", " [N]") + columns_of_axes<D>("reaction_", " [N]");
}

/// Motion of a wall, the force that drives it (nan without one) and that of the bodies on it.
template <int D>
std::string wall_row(const State<D>& state, const Wall<D>& wall, const Vec<D>& reaction) {
  std::string line = step_and_time(state.step, state.time) + "," + csv_cell(wall.name);
  const bool driven = wall.motion == Wall<D>::Motion::kDriven;
  const Vec<D> force = driven ? Vec<D>(wall.force * wall.direction) : Vec<D>::Constant(kNaN);
  add_numbers(line, wall.a, wall.v, force, reaction);
  return line;
}

/// A row of the ledger; `stress` is the sample's mean.
template <int D>
std::string ledger_row(const StepReport<D>& r, const MeanStress<D>& stress, bool dem) {
  const EnergyLedger& e = r.energy;
  std::string line = step_and_time(r.step, r.time);
  fmt::format_to(std::back_inserter(line), ",{},{},{},{}", r.contacts, r.active, r.iterations,
                 r.converged ? 1 : 0);
  add_numbers(line, r.error.epsilon, r.error.eta, r.error.raw42, r.error.natural_map, e.kinetic,
              e.potential, e.wall_work, e.friction_loss, e.shock_loss, e.imbalance, r.momentum,
              r.momentum_imbalance, r.penetration, r.overlap, r.travel, stress.area);
  const Mat<D> total = stress.total();
  add_numbers(line, Vec<D>(total.diagonal()));
  for (int k = 0; k < D; ++k) {
    for (int l = k + 1; l < D; ++l) add_numbers(line, 0.5 * (total(k, l) + total(l, k)));
  }
  add_numbers(line, stress.kinetic.trace() / D);
  if (dem) add_numbers(line, e.elastic);
  return line;
}

template <int D>
std::string trajectory_header() {
  return fmt::format("step,time [s],{}", kBodyName<D>) + columns_of_axes<D>("", " [m]") +
         (D == 2 ? ",angle [rad]" : "") + columns_of_axes<D>("v", " [m/s]") +
         (D == 2 ? ",spin [rad/s]" : columns_of_axes<D>("spin_", " [rad/s]"));
}

void add_motion(std::string& line, const Disk& d) { add_numbers(line, d.x, d.angle, d.v, d.spin); }
void add_motion(std::string& line, const Sphere& s) { add_numbers(line, s.x, s.v, s.spin); }

/// A stand-in contact for states without contacts: zeros.
void write_no_contact(Hdf5File& file, const Vec2& x) {
  file.write_rows("/no_contact/segment", std::vector<double>{x[0], x[1], x[0], x[1]}, 2);
  for (const char* name : {"gap", "s_n", "s_t", "u_n", "u_t", "force_n", "force_t"}) {
    file.write(std::string("/no_contact/") + name, 0.0);
  }
}
void write_no_contact(Hdf5File& file, const Vec3& x) {
  file.write_rows("/no_contact/segment", std::vector<double>{x[0], x[1], x[2], x[0], x[1], x[2]},
                  3);
  for (const char* name : {"gap", "s_n", "u_n", "force_n"}) {
    file.write(std::string("/no_contact/") + name, 0.0);
  }
  for (const char* name : {"s_t", "u_t", "force_t"}) {
    file.write_rows(std::string("/no_contact/") + name, std::vector<double>(3, 0.0), 3);
  }
}

/// What the rows of the observables are, also where a part of the run had none. Throws FileError for
/// a scene that measures something else: means would be of different things.
template <int D>
std::string measured(const fs::path& run, const Scene<D>& scene, bool resumes) {
  const std::string now = scene.observables ? definition_of(*scene.observables) : std::string();
  if (!resumes || !fs::exists(run)) return now;
  const Hdf5File file(run, Hdf5File::Mode::kRead);
  if (!file.exists(kMeasured)) return now;
  const std::string then = file.read_string(kMeasured);
  if (now.empty() || then == now) return then;
  if (now.starts_with(then + ";")) return now;  // more, in further columns
  throw FileError(run, kMeasured,
                  fmt::format("measured {}, this run {}: name another --out", then, now));
}

}  // namespace

template <int D>
RunWriter<D>::RunWriter(fs::path folder, const Scene<D>& scene, std::string scene_text,
                        int resume_after)
    : folder_(std::move(folder)),
      scene_(scene),
      scene_text_(std::move(scene_text)),
      xdmf_(make_index(scene)) {
  for (int disk : scene_.output.track) {
    if (disk < 0 || disk >= static_cast<int>(scene_.bodies.size())) {
      throw std::invalid_argument(fmt::format("there is no {} {} to track", kBodyName<D>, disk));
    }
  }
  std::error_code error;
  fs::create_directories(folder_ / "frames", error);
  if (error) throw FileError(folder_, "", "cannot create: " + error.message());
  measured_ = measured(folder_ / "run.h5", scene_, resume_after >= 0);
  for (int step : steps_in_folder(folder_)) {
    if (step > resume_after) {
      fs::remove(frame_path(folder_, step), error);
      if (error) {
        throw FileError(frame_path(folder_, step), "", "cannot remove: " + error.message());
      }
      continue;
    }
    const Hdf5File file(frame_path(folder_, step), Hdf5File::Mode::kRead);
    const std::string bodies = bodies_group(file);
    add_frame({step, file.read_double("/time"), file.size("/contacts/i"),
               file.exists(bodies + "stress"), file.size(bodies + "spin") / to_size(kSpins<D>),
               bodies});
  }
  std::string units;
  const auto begin = [&](std::optional<CsvFile>& file, const char* name, const std::string& head) {
    file.emplace(folder_ / name, head, resume_after);
    units += unit_rows(name, head);
  };
  if (scene_.output.ledger_every > 0) {
    const bool dem = scene_.model == Model::kSpringDashpot;
    begin(ledger_, "ledger.csv",
          ledger_header<D>(dem, scene_.has_gates(), scene_.accuracy > 0, scene_.has_cohesion()));
    if (scene_.has_gates()) begin(gates_, "gates.csv", gates_header(scene_));
    if (!scene_.walls.empty()) begin(walls_, "walls.csv", walls_header<D>());
  }
  if (scene_.observables) {
    observables_.emplace(folder_, scene_, resume_after);
    units += observables_->units();
  }
  if (!scene_.output.track.empty()) begin(trajectory_, "trajectory.csv", trajectory_header<D>());
  write_text_file(folder_ / "units.csv", kUnitsHeader + ("\n" + units));
  write_index();  // last: tables of another run are refused before
}

template <int D>
RunWriter<D>::~RunWriter() {
  try {
    close();
  } catch (const std::exception&) {
    // A destructor cannot report; close() does.
  }
}

template <int D>
void RunWriter<D>::write_run_file() const {
  AtomicFile target(folder_ / "run.h5");
  Hdf5File file(target.draft(), Hdf5File::Mode::kCreate);
  file.write("/format", kRunFormat);
  file.write("/format_version", kRunFormatVersion);
  file.write("/version", program_version());
  file.write("/title", scene_.title);
  file.write("/source", scene_.source);
  file.write("/scene", scene_text_);
  if (D == 3) file.write("/dimensions", D);
  if (!measured_.empty()) file.write(kMeasured, measured_);
  file.write("/gravity", std::span(scene_.gravity.data(), D), "m/s2");
  file.write("/time_step", scene_.step, "s");
  if (scene_.accuracy > 0) file.write("/accuracy", scene_.accuracy);
  file.write("/num_steps", scene_.num_steps);
  file.write("/contact_distance", scene_.contact_distance, "m");
  const bool dem = scene_.model == Model::kSpringDashpot;
  file.write("/model", dem ? "dem" : "nscd");
  if (dem) write_springs(file, scene_);
  file.write("/solver/name", scene_.solver.name);
  file.write("/solver/tol", scene_.solver.tol);
  file.write("/solver/stop", scene_.solver.stop);
  file.write("/solver/max_iterations", scene_.solver.max_iterations);
  file.write("/solver/warm_start", scene_.solver.warm_start ? 1 : 0);
  for (const auto& [name, value] : scene_.solver.parameters) {
    file.write("/solver/parameters/" + name, value);
  }
  file.write("/materials/name", scene_.materials);
  const std::size_t materials = std::max<std::size_t>(1, scene_.materials.size());
  const auto write_law = [&](const char* name, double ContactLaw::*member, const char* unit = "") {
    std::vector<double> table;
    for (const ContactLaw& law : scene_.laws) table.push_back(law.*member);
    file.write_rows(std::string("/materials/") + name, table, materials, unit);
  };
  write_law("mu", &ContactLaw::mu);
  write_law("e_n", &ContactLaw::e_n);
  write_law("e_t", &ContactLaw::e_t);
  if (scene_.has_rolling()) {
    write_law("mu_r", &ContactLaw::mu_r, "m");
    write_law("mu_spin", &ContactLaw::mu_spin, "m");
  }
  if (scene_.has_cohesion()) write_law("cohesion", &ContactLaw::cohesion, "N");

  const auto& disks = scene_.bodies;
  const bool any_glued =
      std::any_of(disks.begin(), disks.end(), [](const Body<D>& d) { return d.wall >= 0; });
  write_body_constants(file, disks, any_glued);
  write_wall_definitions(file, scene_.walls);
  if (scene_.cell.periodic()) write_cell_definition(file, scene_.cell);
  if (scene_.has_gates()) write_no_body<D>(file, some_place(scene_));
  if (!disks.empty() || scene_.has_gates()) {
    write_no_contact(file, some_place(scene_));
    write_point_numbers(file, "/no_contact/points", 2);
    for (const char* name : {"i", "j"}) file.write(std::string("/no_contact/") + name, -1);
    file.write("/no_contact/status", static_cast<int>(ContactStatus::kTakeOff));
  }
  file.create_group("/frames");
  for (const XdmfIndex::Frame& frame : frames_) {
    const std::string name = frame_name(frame.step);
    file.link("/frames/" + name, "frames/" + name + ".h5", "/");
  }
  add_descriptions(file);
  file.close();
  target.commit();
}

template <int D>
void RunWriter<D>::write_row(const State<D>& state, const StepReport<D>& r) {
  known_stress_ = {state.step, stress_of_sample(state, scene_.step)};
  std::string line = ledger_row(r, known_stress_.second, scene_.model == Model::kSpringDashpot);
  if (gates_) {
    add_numbers(line, r.energy.passed, passed(state).momentum);
  }
  if (scene_.accuracy > 0) {
    line += fmt::format(",{},{}", r.cut.parts, r.cut.rejected());
    add_numbers(line, r.cut.smallest, r.cut.misplaced);
    line += "," + csv_cell(r.cut.limited_by);
  }
  if (scene_.has_cohesion()) add_numbers(line, r.energy.cohesion_loss);
  ledger_->row(line);
  if (gates_) gates_->row(gates_row(scene_, state));
  if (walls_) {
    const std::vector<Vec<D>> reactions = wall_reactions(state, scene_.step);
    for (std::size_t k = 0; k < reactions.size(); ++k) {
      walls_->row(wall_row<D>(state, state.walls[k], reactions[k]));
    }
  }
}

template <int D>
void RunWriter<D>::step(const State<D>& state, const StepReport<D>& r) {
  beside_.check();
  if (ledger_) {
    if (r.step % scene_.output.ledger_every == 0) {
      write_row(state, r);
      left_out_.reset();
    } else {
      left_out_ = r;
    }
  }
  if (observables_) observables_->step(state);
  for (int disk : scene_.output.track) {
    const int index = body_index(state, disk);
    if (index < 0) continue;  // it has left
    std::string line = step_and_time(state.step, state.time) + fmt::format(",{}", disk);
    add_motion(line, state.bodies.at(to_size(index)));
    trajectory_->row(line);
  }
}

/// True if the frame still has to be written, once an earlier one is finished.
template <int D>
bool RunWriter<D>::is_due(const State<D>& state) {
  beside_.finish();
  if ((!scene_.has_gates() && state.bodies.size() != scene_.bodies.size()) ||
      state.population.numbers.size() != (scene_.has_gates() ? state.bodies.size() : 0) ||
      state.walls.size() != scene_.walls.size()) {
    throw std::invalid_argument("the state is not one of this scene");
  }
  if (frames_.empty() || frames_.back().step < state.step) return true;
  if (frames_.back().step == state.step) return false;
  throw std::invalid_argument(
      fmt::format("frame of step {} after that of step {}", state.step, frames_.back().step));
}

template <int D>
void RunWriter<D>::frame(const State<D>& state) {
  if (is_due(state)) write_frame(state, stress_if_known(state));
}

template <int D>
void RunWriter<D>::frame_beside(const State<D>& state) {
  if (!is_due(state)) return;
  beside_.begin(
      [this, copy = state, stress = stress_if_known(state)] { write_frame(copy, stress); });
}

/// The stress in the row of the same step, if that has just been written.
template <int D>
std::optional<MeanStress<D>> RunWriter<D>::stress_if_known(const State<D>& state) const {
  if (known_stress_.first != state.step) return std::nullopt;
  return known_stress_.second;
}

template <int D>
void RunWriter<D>::write_frame(const State<D>& state, const std::optional<MeanStress<D>>& stress) {
  write_frame_file(frame_path(folder_, state.step), scene_, state,
                   stress ? *stress : stress_of_sample(state, scene_.step));
  add_frame({state.step, state.time, state.contacts.size(), true, state.bodies.size(), "/bodies/"});
  if (frames_.size() - indexed_ >= 1 + frames_.size() / kIndexShare) write_index();
}

template <int D>
void RunWriter<D>::finish(const State<D>& last) {
  beside_.finish();
  if (left_out_ && left_out_->step == last.step) write_row(last, *left_out_);
  left_out_.reset();
  close();
}

template <int D>
void RunWriter<D>::close() {
  if (closed_) return;
  beside_.finish();
  closed_ = true;
  if (observables_) observables_->close();
  write_index();
}

template <int D>
void RunWriter<D>::add_frame(const XdmfIndex::Frame& frame) {
  frames_.push_back(frame);
  xdmf_.add(frame);
}

template <int D>
void RunWriter<D>::write_index() {
  write_run_file();
  xdmf_.write(folder_ / "run.xdmf");
  indexed_ = frames_.size();
}

template class RunWriter<2>;
template class RunWriter<3>;

}  // namespace bipot
