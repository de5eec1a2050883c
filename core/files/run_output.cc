#include "core/files/run_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "core/files/atomic_file.h"
#include "core/files/hdf5_file.h"
#include "core/files/run_layout.h"
#include "core/motion/periodic_state.h"
#include "core/motion/spring_dashpot_setup.h"
#include "core/motion/stress_tensor.h"
#include "core/scene/scene_box.h"
#include "core/scene/wall_motion.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kIndexShare = 32;  // see RunWriter

/// Collects one column of numbers, or several, row by row.
class Column {
 public:
  explicit Column(std::size_t reserve) { values_.reserve(reserve); }
  void add(double x) { values_.push_back(x); }
  void add(const Vec2& x) {
    values_.push_back(x[0]);
    values_.push_back(x[1]);
  }
  std::span<const double> values() const { return values_; }

 private:
  std::vector<double> values_;
};

template <class Range, class Get>
void write_doubles(Hdf5File& file, const std::string& name, const char* unit, const Range& range,
                   Get&& get) {
  Column column(range.size());
  for (const auto& item : range) column.add(static_cast<double>(get(item)));
  file.write(name, column.values());
  file.write_attribute(name, "unit", unit);
}

template <class Range, class Get>
void write_vectors(Hdf5File& file, const std::string& name, const char* unit, const Range& range,
                   Get&& get) {
  Column column(2 * range.size());
  for (const auto& item : range) column.add(Vec2(get(item)));
  file.write_rows(name, column.values(), 2);
  file.write_attribute(name, "unit", unit);
}

template <class Range, class Get>
void write_ints(Hdf5File& file, const std::string& name, const Range& range, Get&& get) {
  std::vector<int> column;
  column.reserve(range.size());
  for (const auto& item : range) column.push_back(static_cast<int>(get(item)));
  file.write(name, column);
}

/// Stress of each disk and of the sample, spins from the contacts' moments (stress_tensor.h).
void write_stresses(Hdf5File& file, const State& state, double step) {
  const std::vector<double> moments = contact_moments(state);
  const std::vector<MeanStress> disks = disk_stresses(state, step, moments);
  Column tensors(6 * disks.size());
  for (const MeanStress& stress : disks) {
    const Mat2 s = stress.total();
    for (double x : {s(0, 0), 0.5 * (s(0, 1) + s(1, 0)), 0.0, s(1, 1), 0.0, 0.0}) tensors.add(x);
  }
  file.write_rows("/disks/stress", tensors.values(), 6);
  file.write_attribute("/disks/stress", "unit", "Pa");
  write_doubles(file, "/disks/pressure", "Pa", disks,
                [](const MeanStress& s) { return s.pressure(); });
  const double area = sample_area(state, step);
  file.write("/sample/area", area);
  file.write_attribute("/sample/area", "unit", "m2");
  if (!(area > 0)) return;
  const MeanStress sample = sample_stress(state, step, area, moments);
  for (const auto& [name, part] : {std::pair{"/sample/contact_stress", &sample.contact},
                                   {"/sample/kinetic_stress", &sample.kinetic},
                                   {"/sample/spin_stress", &sample.spin}}) {
    const Mat2& s = *part;
    file.write_rows(name, std::vector<double>{s(0, 0), s(0, 1), s(1, 0), s(1, 1)}, 2);
    file.write_attribute(name, "unit", "Pa");
  }
}

/// 0, 1, 2, ...: ParaView's readers want to be told which points make a cell.
void write_point_numbers(Hdf5File& file, const std::string& name, std::size_t points) {
  std::vector<int> numbers(points);
  for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k] = static_cast<int>(k);
  file.write(name, numbers);
}

/// What does not change of the walls. Circles and walls moved across a force add datasets of their own.
void write_wall_definitions(Hdf5File& file, const std::vector<Wall>& walls) {
  const auto any = [&](const auto& is) { return std::any_of(walls.begin(), walls.end(), is); };
  std::vector<std::string> names;
  for (const Wall& w : walls) names.push_back(w.name);
  file.write("/walls/name", names);
  write_ints(file, "/walls/shape", walls, [](const Wall& w) { return static_cast<int>(w.shape); });
  write_ints(file, "/walls/motion", walls,
             [](const Wall& w) { return static_cast<int>(w.motion); });
  write_ints(file, "/walls/material", walls, [](const Wall& w) { return w.material; });
  write_vectors(file, "/walls/normal", "1", walls, [](const Wall& w) { return w.normal; });
  write_vectors(file, "/walls/direction", "1", walls, [](const Wall& w) { return w.direction; });
  write_doubles(file, "/walls/force", "N", walls, [](const Wall& w) { return w.force; });
  write_doubles(file, "/walls/mass", "kg", walls, [](const Wall& w) { return w.mass; });
  if (any([](const Wall& w) { return w.is_circle(); })) {
    write_doubles(file, "/walls/radius", "m", walls, [](const Wall& w) { return w.radius; });
    write_doubles(file, "/walls/spin", "rad/s", walls, [](const Wall& w) { return w.spin; });
  }
  if (any([](const Wall& w) { return w.across != Vec2::Zero(); })) {
    write_vectors(file, "/walls/across", "m/s", walls, [](const Wall& w) { return w.across; });
  }
}

/// Width, height and offset of a periodic cell: how each moves, the stress on it, its mass.
void write_cell_definition(Hdf5File& file, const Cell& cell) {
  std::vector<int> motion;
  std::vector<double> stress, mass;
  for (int k = 0; k < 3; ++k) {
    motion.push_back(static_cast<int>(cell.side(k).motion));
    stress.push_back(cell.side(k).stress);
    mass.push_back(cell.side(k).mass);
  }
  file.write("/cell/periodic", std::vector<int>{cell.in_x ? 1 : 0, cell.in_y ? 1 : 0});
  file.write("/cell/motion", motion);
  file.write("/cell/stress", stress);
  file.write_attribute("/cell/stress", "unit", "Pa");
  file.write("/cell/mass", mass);
  file.write_attribute("/cell/mass", "unit", "kg");
}

/// The cell of a state, its outline as lines, and the disks where they lie in it.
void write_cell(Hdf5File& file, const State& state) {
  const Cell& cell = state.cell;
  std::vector<double> lengths, speeds;
  for (int k = 0; k < 3; ++k) {
    lengths.push_back(cell.side(k).length);
    speeds.push_back(cell.side(k).speed);
  }
  file.write("/cell/lengths", lengths);
  file.write_attribute("/cell/lengths", "unit", "m");
  file.write("/cell/speeds", speeds);
  file.write_attribute("/cell/speeds", "unit", "m/s");
  Column lines(16);
  for (const auto& [a, b] : cell_outline(cell, view_box(state.disks, state.walls))) {
    lines.add(a);
    lines.add(b);
  }
  write_point_numbers(file, "/cell/points", lines.values().size() / 2);
  file.write_rows("/cell/segment", lines.values(), 2);
  write_vectors(file, "/disks/x_in_cell", "m", state.disks, [](const Disk& d) { return d.x; });
}

/// Circles as polygons, closed: kRimPoints points each.
void write_rims(Hdf5File& file, const std::vector<Wall>& walls) {
  Column rim(0);
  for (const Wall& w : walls) {
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

}  // namespace

RunWriter::RunWriter(fs::path folder, const Scene& scene, std::string scene_text, int resume_after)
    : folder_(std::move(folder)),
      scene_(scene),
      scene_text_(std::move(scene_text)),
      xdmf_(scene.disks.size(), scene.walls.size(),
            to_size(std::count_if(scene.walls.begin(), scene.walls.end(),
                                  [](const Wall& w) { return w.is_circle(); })),
            scene.cell.in_y   ? 4
            : scene.cell.in_x ? 2
                              : 0) {
  for (int disk : scene_.output.track) {
    if (disk < 0 || disk >= static_cast<int>(scene_.disks.size())) {
      throw std::invalid_argument(fmt::format("there is no disk {} to track", disk));
    }
  }
  std::error_code error;
  fs::create_directories(folder_ / "frames", error);
  if (error) throw FileError(folder_, "", "cannot create: " + error.message());
  for (int step : steps_in_folder(folder_)) {
    if (step > resume_after) {
      fs::remove(frame_path(folder_, step), error);
      if (error) {
        throw FileError(frame_path(folder_, step), "", "cannot remove: " + error.message());
      }
      continue;
    }
    const Hdf5File file(frame_path(folder_, step), Hdf5File::Mode::kRead);
    add_frame(
        {step, file.read_double("/time"), file.size("/contacts/i"), file.exists("/disks/stress")});
  }
  write_index();
  if (scene_.output.ledger_every > 0) {
    const bool dem = scene_.model == Model::kSpringDashpot;
    ledger_.emplace(
        folder_ / "ledger.csv",
        std::string("step,time [s],contacts,active,iterations,converged,epsilon,eta,raw42,"
                    "natural_map,kinetic [J],potential [J],wall_work [J],friction_loss [J],"
                    "shock_loss [J],imbalance [J],momentum_x [kg m/s],momentum_y [kg m/s],"
                    "momentum_imbalance_x [kg m/s],momentum_imbalance_y [kg m/s],penetration [m],"
                    "area [m2],stress_xx [Pa],stress_yy [Pa],stress_xy [Pa],"
                    "kinetic_pressure [Pa]") +
            (dem ? ",elastic [J]" : ""),
        resume_after);
  }
  if (scene_.observables) observables_.emplace(folder_, scene_, resume_after);
  if (!scene_.output.track.empty()) {
    trajectory_.emplace(folder_ / "trajectory.csv",
                        "step,time [s],disk,x [m],y [m],angle [rad],vx [m/s],vy [m/s],"
                        "spin [rad/s]",
                        resume_after);
  }
}

RunWriter::~RunWriter() {
  try {
    close();
  } catch (const std::exception&) {
    // A destructor cannot report; close() does.
  }
}

void RunWriter::write_run_file() const {
  AtomicFile target(folder_ / "run.h5");
  Hdf5File file(target.draft(), Hdf5File::Mode::kCreate);
  file.write("/format", kRunFormat);
  file.write("/format_version", kRunFormatVersion);
  file.write("/version", BIPOT_VERSION);
  file.write("/title", scene_.title);
  file.write("/source", scene_.source);
  file.write("/scene", scene_text_);
  file.write("/gravity", std::vector<double>{scene_.gravity[0], scene_.gravity[1]});
  file.write_attribute("/gravity", "unit", "m/s2");
  file.write("/time_step", scene_.step);
  file.write_attribute("/time_step", "unit", "s");
  file.write("/num_steps", scene_.num_steps);
  file.write("/contact_distance", scene_.contact_distance);
  file.write_attribute("/contact_distance", "unit", "m");
  const bool dem = scene_.model == Model::kSpringDashpot;
  file.write("/model", dem ? "dem" : "nscd");
  if (dem) {
    const SpringDashpotSetup setup = spring_dashpot_setup(scene_);
    file.write("/dem/stiffness", setup.stiffness);
    file.write_attribute("/dem/stiffness", "unit", "N/m");
    file.write("/dem/tangential_stiffness", setup.tangential_stiffness);
    file.write_attribute("/dem/tangential_stiffness", "unit", "N/m");
    file.write("/dem/substep", setup.substep);
    file.write_attribute("/dem/substep", "unit", "s");
    file.write("/dem/critical_step", setup.critical_step);
    file.write_attribute("/dem/critical_step", "unit", "s");
  }
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
  const auto write_law = [&](const char* name, double ContactLaw::*member) {
    std::vector<double> table;
    for (const ContactLaw& law : scene_.laws) table.push_back(law.*member);
    file.write_rows(std::string("/materials/") + name, table, materials);
  };
  write_law("mu", &ContactLaw::mu);
  write_law("e_n", &ContactLaw::e_n);
  write_law("e_t", &ContactLaw::e_t);

  const auto& disks = scene_.disks;
  write_doubles(file, "/disks/radius", "m", disks, [](const Disk& d) { return d.radius; });
  write_doubles(file, "/disks/mass", "kg", disks, [](const Disk& d) { return d.mass; });
  write_doubles(file, "/disks/inertia", "kg m2", disks, [](const Disk& d) { return d.inertia; });
  write_ints(file, "/disks/material", disks, [](const Disk& d) { return d.material; });
  if (std::any_of(disks.begin(), disks.end(), [](const Disk& d) { return d.wall >= 0; })) {
    write_ints(file, "/disks/wall", disks, [](const Disk& d) { return d.wall; });
  }
  write_point_numbers(file, "/disks/points", disks.size());
  write_wall_definitions(file, scene_.walls);
  if (scene_.cell.periodic()) write_cell_definition(file, scene_.cell);
  if (!disks.empty()) {
    const Vec2& x = disks.front().x;
    file.write_rows("/no_contact/segment", std::vector<double>{x[0], x[1], x[0], x[1]}, 2);
    write_point_numbers(file, "/no_contact/points", 2);
    for (const char* name : {"i", "j"}) file.write(std::string("/no_contact/") + name, -1);
    file.write("/no_contact/status", static_cast<int>(ContactStatus::kTakeOff));
    for (const char* name : {"gap", "s_n", "s_t", "u_n", "u_t", "force_n", "force_t"}) {
      file.write(std::string("/no_contact/") + name, 0.0);
    }
  }
  file.create_group("/frames");
  for (const FrameEntry& frame : frames_) {
    const std::string name = frame_name(frame.step);
    file.link("/frames/" + name, "frames/" + name + ".h5", "/");
  }
  file.close();
  target.commit();
}

void RunWriter::write_frame_file(const State& state) const {
  AtomicFile target(frame_path(folder_, state.step));
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

  const auto& disks = state.disks;
  write_vectors(file, "/disks/x", "m", disks, [](const Disk& d) { return d.x; });
  write_doubles(file, "/disks/angle", "rad", disks, [](const Disk& d) { return d.angle; });
  Column velocity(3 * disks.size());
  for (const Disk& d : disks) {
    velocity.add(d.v);
    velocity.add(0.0);  // ParaView's vectors have three components
  }
  file.write_rows("/disks/v", velocity.values(), 3);
  file.write_attribute("/disks/v", "unit", "m/s");
  write_doubles(file, "/disks/spin", "rad/s", disks, [](const Disk& d) { return d.spin; });

  State inside;
  if (state.cell.periodic()) {
    inside = wrapped_state(state);
    write_cell(file, inside);
  }
  const auto& walls = state.walls;
  write_vectors(file, "/walls/a", "m", walls, [](const Wall& w) { return w.a; });
  write_vectors(file, "/walls/b", "m", walls, [](const Wall& w) { return w.b; });
  write_vectors(file, "/walls/v", "m/s", walls, [](const Wall& w) { return w.v; });
  Column lines(4 * walls.size());
  for (const auto& [first, last] : wall_lines(
           walls, state.cell.periodic() ? view_box(inside.disks, walls) : view_box(disks, walls))) {
    lines.add(first);
    lines.add(last);
  }
  file.write_rows("/walls/segment", lines.values(), 2);
  write_point_numbers(file, "/walls/points", 2 * walls.size());

  if (std::any_of(scene_.walls.begin(), scene_.walls.end(), has_schedule<2>)) {
    write_ints(file, "/walls/motion", walls,
               [](const Wall& w) { return static_cast<int>(w.motion); });
    write_ints(file, "/walls/present", walls, [](const Wall& w) { return w.present ? 1 : 0; });
  }
  write_rims(file, walls);

  const auto& contacts = state.contacts;
  using Outcome = ContactOutcome;
  write_ints(file, "/contacts/i", contacts, [](const Outcome& c) { return c.contact.i; });
  write_ints(file, "/contacts/j", contacts, [](const Outcome& c) { return c.contact.j; });
  write_ints(file, "/contacts/status", contacts,
             [](const Outcome& c) { return static_cast<int>(c.status); });
  write_vectors(file, "/contacts/n", "1", contacts, [](const Outcome& c) { return c.contact.n; });
  write_doubles(file, "/contacts/gap", "m", contacts,
                [](const Outcome& c) { return c.contact.gap; });
  write_doubles(file, "/contacts/s_n", "N s", contacts, [](const Outcome& c) { return c.s_n; });
  write_doubles(file, "/contacts/s_t", "N s", contacts, [](const Outcome& c) { return c.s_t; });
  write_doubles(file, "/contacts/u_n", "m/s", contacts, [](const Outcome& c) { return c.u_n; });
  write_doubles(file, "/contacts/u_t", "m/s", contacts, [](const Outcome& c) { return c.u_t; });
  if (state.cell.periodic()) {
    write_ints(file, "/contacts/image_x", contacts,
               [](const Outcome& c) { return c.contact.image_x; });
    write_ints(file, "/contacts/image_y", contacts,
               [](const Outcome& c) { return c.contact.image_y; });
  }
  if (scene_.model == Model::kSpringDashpot) {
    write_doubles(file, "/contacts/spring", "m", contacts,
                  [](const Outcome& c) { return c.spring; });
  }
  const double h = scene_.step;
  write_doubles(file, "/contacts/force_n", "N", contacts,
                [&](const Outcome& c) { return c.s_n / h; });
  write_doubles(file, "/contacts/force_t", "N", contacts,
                [&](const Outcome& c) { return c.s_t / h; });
  Column branch(4 * contacts.size());
  const State& drawn = state.cell.periodic() ? inside : state;
  for (const Outcome& c : contacts) {
    const auto [a, b] = drawn_branch(drawn, c.contact);
    branch.add(a);
    branch.add(b);
  }
  file.write_rows("/contacts/segment", branch.values(), 2);
  write_point_numbers(file, "/contacts/points", 2 * contacts.size());
  write_stresses(file, state, h);
  if (scene_.observables) write_observables(file, scene_, state);
  file.close();
  target.commit();
}

void RunWriter::step(const State& state, const StepReport& r) {
  if (ledger_) {
    const EnergyLedger& e = r.energy;
    const double area = sample_area(state, scene_.step);
    // Without disks there is no sample: not a number.
    const MeanStress stress = sample_stress(state, scene_.step, area, contact_moments(state));
    const Mat2 total = stress.total();
    std::string line = fmt::format(
        "{},{:.17g},{},{},{},{},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},"
        "{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},"
        "{:.17g}",
        r.step, r.time, r.contacts, r.active, r.iterations, r.converged ? 1 : 0, r.error.epsilon,
        r.error.eta, r.error.raw42, r.error.natural_map, e.kinetic, e.potential, e.wall_work,
        e.friction_loss, e.shock_loss, e.imbalance, r.momentum[0], r.momentum[1],
        r.momentum_imbalance[0], r.momentum_imbalance[1], r.penetration, area, total(0, 0),
        total(1, 1), 0.5 * (total(0, 1) + total(1, 0)), 0.5 * stress.kinetic.trace());
    if (scene_.model == Model::kSpringDashpot) line += fmt::format(",{:.17g}", e.elastic);
    if (r.step % scene_.output.ledger_every == 0) {
      ledger_->row(line);
      pending_row_.clear();
    } else {
      pending_row_ = std::move(line);
    }
  }
  if (observables_) observables_->step(state);
  for (int disk : scene_.output.track) {
    const Disk& d = state.disks.at(static_cast<std::size_t>(disk));
    trajectory_->row(fmt::format("{},{:.17g},{},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g}",
                                 state.step, state.time, disk, d.x[0], d.x[1], d.angle, d.v[0],
                                 d.v[1], d.spin));
  }
}

void RunWriter::frame(const State& state) {
  if (state.disks.size() != scene_.disks.size() || state.walls.size() != scene_.walls.size()) {
    throw std::invalid_argument("the state is not one of this scene");
  }
  if (!frames_.empty() && frames_.back().step >= state.step) {
    if (frames_.back().step == state.step) return;
    throw std::invalid_argument(
        fmt::format("frame of step {} after that of step {}", state.step, frames_.back().step));
  }
  write_frame_file(state);
  add_frame({state.step, state.time, state.contacts.size(), true});
  if (frames_.size() - indexed_ >= 1 + frames_.size() / kIndexShare) write_index();
}

void RunWriter::close() {
  if (closed_) return;
  closed_ = true;
  if (ledger_ && !pending_row_.empty()) ledger_->row(pending_row_);
  if (observables_) observables_->close();
  write_index();
}

void RunWriter::add_frame(const FrameEntry& frame) {
  frames_.push_back(frame);
  xdmf_.add(frame);
}

void RunWriter::write_index() {
  write_run_file();
  xdmf_.write(folder_ / "run.xdmf");
  indexed_ = frames_.size();
}

}  // namespace bipot
