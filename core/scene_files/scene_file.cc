#include "core/scene_files/scene_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <string_view>
#include <utility>

#include "core/base/nearest_name.h"
#include "core/files/input_file.h"
#include "core/scene_files/scene_tables.h"

namespace bipot {
namespace {

/// What the table omits is that of `base`.
ContactLaw read_law(const SceneTable& table, const ContactLaw& base) {
  const ContactLaw law{.mu = table.number("mu", base.mu),
                       .e_n = table.number("e_n", base.e_n),
                       .e_t = table.number("e_t", base.e_t),
                       .cohesion = table.number("cohesion", base.cohesion),
                       .mu_r = table.number("mu_r", base.mu_r),
                       .mu_spin = table.number("mu_spin", base.mu_spin)};
  if (law.mu < 0) table.fail("mu", fmt::format("mu = {}, expected a number >= 0", law.mu));
  for (const auto& [key, value] : {std::pair{"cohesion", law.cohesion}, std::pair{"mu_r", law.mu_r},
                                   std::pair{"mu_spin", law.mu_spin}}) {
    if (value < 0) table.fail(key, "expected a number >= 0");
  }
  for (const auto& [key, e] : {std::pair{"e_n", law.e_n}, std::pair{"e_t", law.e_t}}) {
    if (e < 0 || e > 1) table.fail(key, fmt::format("{} = {}, expected 0 to 1", key, e));
  }
  return law;
}

template <int D>
void read_materials(const SceneTable& root, Scene<D>& scene) {
  ContactLaw base;
  if (const auto table = root.table("contact")) {
    base = read_law(*table, base);
    if (const auto distance = table->maybe_number("distance")) {
      if (*distance < 0) table->fail("distance", "expected a number >= 0");
      scene.contact_distance = *distance;
    }
    const std::string overlaps = table->one_of("overlaps", "keep", {"keep", "project", "predict"});
    scene.project_overlaps = overlaps == "project";
    scene.predict_gaps = overlaps == "predict";
    const std::string impact = table->one_of("impact", "newton", {"newton", "poisson", "fremond"});
    scene.impact = impact == "poisson"   ? ContactLaw::Impact::kPoisson
                   : impact == "fremond" ? ContactLaw::Impact::kFremond
                                         : ContactLaw::Impact::kNewton;
    scene.cohesion_range = table->number("cohesion_range", 0);
    scene.heal = table->boolean("heal", true);
  }
  scene.materials = root.words("materials");
  if (scene.materials.empty()) scene.materials = {"default"};
  const std::size_t count = scene.materials.size();
  constexpr std::size_t kMostMaterials = 1000;  // laws are a table of all pairs
  if (count > kMostMaterials) {
    root.fail("materials", fmt::format("{} names, expected at most {}", count, kMostMaterials));
  }
  if (std::set<std::string>(scene.materials.begin(), scene.materials.end()).size() != count) {
    root.fail("materials", "names must differ");
  }
  scene.laws.assign(count * count, base);
  std::set<std::pair<std::size_t, std::size_t>> seen;
  for (const SceneTable& table : root.tables("pairs")) {
    const std::vector<std::string> between = table.words("between");
    if (between.size() != 2) table.fail("between", "expected two material names");
    std::array<std::size_t, 2> index{};
    for (std::size_t k = 0; k < 2; ++k) {
      index[k] = table.index_of("between", "material", between[k], scene.materials);
    }
    if (!seen.emplace(std::minmax(index[0], index[1])).second) {
      table.fail("between", "an earlier entry has these materials");
    }
    const ContactLaw law = read_law(table, base);
    scene.laws[index[0] * count + index[1]] = scene.laws[index[1] * count + index[0]] = law;
  }
}

template <int D>
void read_start(const SceneTable& root, Scene<D>& scene) {
  const auto table = root.table("start");
  if (!table) return;
  const std::string overlaps =
      table->one_of("overlaps", "refuse", {"refuse", "allow", "push apart"});
  scene.start = overlaps == "allow"        ? StartChoice::kAllow
                : overlaps == "push apart" ? StartChoice::kPushApart
                                           : StartChoice::kRefuse;
}

template <int D>
void read_time(const SceneTable& root, std::optional<double> accuracy, Scene<D>& scene) {
  const auto table = root.table("time");
  if (!table) root.fail("time", "the table [time] is missing");
  scene.step = table->positive("step");
  scene.travel = table->number("travel", 0);
  scene.accuracy = accuracy.value_or(table->number("accuracy", 0));
  const bool by_count = table->has("steps"), by_duration = table->has("duration");
  if (by_count == by_duration) table->fail("steps", "give either steps or duration [s]");
  if (by_count) {
    scene.num_steps = table->natural("steps");
  } else {
    scene.duration = table->positive("duration");
    const double steps = std::round(scene.duration / scene.step);
    if (!(steps < std::numeric_limits<int>::max())) table->fail("duration", "is too many steps");
    scene.num_steps = static_cast<int>(steps);
  }
}

/// Errors of the solver are then small beside those of time.
constexpr double kTolOfAccuracy = 0.01;

template <int D>
void read_solver(const SceneTable& root, Scene<D>& scene) {
  SolverChoice& s = scene.solver;
  if (scene.accuracy > 0) s.tol = std::clamp(kTolOfAccuracy * scene.accuracy, 1e-12, 1e-4);
  const auto table = root.table("solver");
  if (!table) return;
  s.name = table->word("name", s.name);
  s.tol = table->number("tol", s.tol);
  if (!(s.tol > 0)) table->fail("tol", "expected a positive number");
  s.stop = table->one_of("stop", s.stop, {"guarded", "raw42", "impulse"});
  s.limits_iterations = table->has("max_iterations");
  s.max_iterations = table->integer("max_iterations", s.max_iterations);
  if (s.max_iterations < 0) table->fail("max_iterations", "expected a non-negative integer");
  s.warm_start = table->boolean("warm_start", s.warm_start);
  if (const auto parameters = table->table("parameters")) s.parameters = parameters->texts();
  if (const std::string plan = table->word("plan", ""); !plan.empty()) {
    s.parameters["plan"] = std::filesystem::absolute(table->folder() / plan).lexically_normal();
  }
}

template <int D>
void read_model(const SceneTable& root, Scene<D>& scene) {
  const std::string model = root.one_of("model", "nscd", {"nscd", "dem"});
  scene.model = model == "dem" ? Model::kSpringDashpot : Model::kNonsmooth;
  const auto contact = root.table("contact");
  if (model == "dem" && contact && contact->has("distance")) {
    contact->fail("distance", "belongs to rigid contacts: springs of the model 'dem' need none");
  }
  const auto table = root.table("dem");
  if (!table) return;
  SpringDashpotChoice& d = scene.dem;
  if (table->has("stiffness")) d.stiffness = table->positive("stiffness");
  d.overlap = table->number("overlap", d.overlap);
  d.tangential_ratio = table->number("tangential_ratio", d.tangential_ratio);
  if (table->has("substep")) d.substep = table->positive("substep");
  d.safety = table->number("safety", d.safety);
}

template <int D>
void read_output(const SceneTable& root, Scene<D>& scene) {
  const auto table = root.table("output");
  if (!table) return;
  OutputChoice& o = scene.output;
  o.every = table->integer("every", o.every);
  o.ledger_every = table->integer("ledger_every", o.ledger_every);
  if (o.every < 0) table->fail("every", "expected a non-negative integer");
  if (o.ledger_every < 0) table->fail("ledger_every", "expected a non-negative integer");
  o.picture = table->boolean("picture", o.picture);
  o.stress_picture = table->boolean("stress_picture", o.stress_picture);
  o.page = table->boolean("page", o.page);
  for (double x : table->numbers("track")) {
    const bool is_index = x >= 0 && x <= std::numeric_limits<int>::max() && x == std::floor(x);
    if (!is_index)
      table->fail("track", D == 2 ? "expected disk numbers" : "expected sphere numbers");
    o.track.push_back(static_cast<int>(x));
  }
}

template <int D>
void read_tilt(const SceneTable& root, Scene<D>& scene) {
  const auto table = root.table("tilt");
  if (!table) return;
  Tilt& tilt = scene.tilt;
  tilt.rate = table->number("degrees_per_second") * std::numbers::pi / 180;
  table->read_period(tilt.starts, tilt.stops);
}

template <int D>
void read_outside_forces(const SceneTable& root, Scene<D>& scene) {
  for (const SceneTable& table : root.tables("forces")) {
    const std::vector<double> range = table.numbers("bodies");
    const auto whole = [](double x) { return x >= 0 && x < 1e9 && x == std::floor(x); };
    if (range.size() != 2 || !whole(range[0]) || !whole(range[1])) {
      table.fail("bodies", "expected the numbers of the first and the last body");
    }
    scene.forces.push_back({.first = static_cast<int>(range[0]),
                            .last = static_cast<int>(range[1]),
                            .force = table.vec<D>("force"),
                            .time_factor = read_time_factor(table)});
  }
  const auto table = root.table("drag");
  if (!table) return;
  scene.drag.coefficient = table->positive("coefficient");
  scene.drag.velocity = table->vec_or_zero<D>("velocity");
}

/// Turns bodies, walls, forces and lines about the origin; gravity stays: a tilted box.
void rotate(Scene<2>& scene, double degrees) {
  const Eigen::Rotation2D<double> rotation(degrees * std::numbers::pi / 180);
  const auto turn = [&](auto&... vectors) { ((vectors = rotation * vectors), ...); };
  for (Disk& d : scene.bodies) turn(d.x, d.v);
  for (Cluster<2>& cluster : scene.clusters.bodies) turn(cluster.x, cluster.v);
  for (Vec2& arm : scene.clusters.arms) turn(arm);
  for (Scene<2>::Joint& joint : scene.joints) turn(joint.at_i, joint.at_j);
  for (Outlet<2>& outlet : scene.outlets) turn(outlet.point, outlet.normal);
  for (Wall<2>& w : scene.walls) {
    turn(w.a, w.b, w.normal, w.v, w.direction);
    if (w.across != Vec2::Zero()) turn(w.across);
    if (w.belt != Vec2::Zero()) turn(w.belt);
  }
  for (BodyForce<2>& force : scene.forces) turn(force.force);
  if (scene.observables) {
    for (FluxLine& line : scene.observables->crossings) turn(line.a, line.b);
  }
  turn(scene.drag.velocity);
}

void turn(const SceneTable& root, Scene<2>& scene) {
  const auto degrees = root.maybe_number("rotate_degrees");
  if (!degrees) return;
  if (scene.cell.periodic()) root.fail("rotate_degrees", "a periodic cell does not turn");
  if (scene.observables && scene.observables->profile) {
    root.fail("rotate_degrees", "a profile lies along an axis and does not turn");
  }
  rotate(scene, *degrees);
}

template <int D>
Scene<D> parse_in(const SceneTable& root, const std::string& source,
                  std::optional<double> accuracy) {
  Scene<D> scene{.title = root.word("title", ""),
                 .source = source,
                 .gravity = root.maybe_vec<D>("gravity").value_or(-9.81 * Vec<D>::Unit(D - 1)),
                 .contact_distance = -1};
  read_materials(root, scene);
  // Walls come first: disks may name them.
  for (const SceneTable& table : root.tables("walls")) {
    scene.walls.push_back(read_wall(table, scene, scene.walls.size()));
  }
  read_bodies(root, scene);
  read_joints(root, scene);
  read_gates(root, D == 2 && root.has("rotate_degrees"), scene);
  read_outside_forces(root, scene);
  scene.cell = read_cell(root, D);
  if (D == 3 && root.has("rotate_degrees")) {
    root.fail("rotate_degrees", "turns scenes in the plane alone");
  }
  read_tilt(root, scene);
  read_start(root, scene);
  read_time(root, accuracy, scene);
  read_model(root, scene);
  if (scene.has_gates() && scene.model == Model::kSpringDashpot) {
    root.fail("model", "'dem' has no outlets and inlets");
  }
  read_solver(root, scene);
  read_output(root, scene);
  scene.observables = read_observables<D>(root, scene.cell);
  if (D == 3 && scene.observables && !scene.observables->crossings.empty() &&
      !scene.clusters.empty()) {
    root.fail("observables", "faces do not measure the flux of clusters");
  }
  if constexpr (D == 2) turn(root, scene);
  root.finish();
  if (scene.contact_distance < 0) {
    scene.contact_distance = default_contact_distance(scene);
  }
  if (auto defect = validate(scene); !defect.empty()) {
    root.refuse(defect, accuracy ? "accuracy" : "");
  }
  const double apart = scene.contact_distance / smallest_radius(scene);
  if (apart > kDeepOverlap && !scene.predict_gaps) {
    Scene<D> predicting = scene;
    predicting.predict_gaps = true;
    scene.caution +=
        fmt::format("{}[contact] distance lets bodies rest {:.2g} of the smallest radius apart{}",
                    scene.caution.empty() ? "" : "; ", apart,
                    validate(predicting).empty() ? "; overlaps = \"predict\" does not" : "");
  }
  return scene;
}

/// The parser follows the parts of a dotted key by recursion, without a limit of its own.
bool has_endless_key(std::string_view text) {
  constexpr int kMostDots = 256;  // its limit for arrays and inline tables
  int dots = 0;
  char closing = 0;  // of a string or comment
  for (const char c : text) {
    if (closing != 0) {
      if (c == closing || c == '\n') closing = 0;
    } else if (c == '"' || c == '\'') {
      closing = c;
    } else if (c == '#') {
      closing = '\n';
    } else if (c == '.') {
      if (++dots > kMostDots) return true;
    } else if (std::string_view("=,[]{}\n").find(c) != std::string_view::npos) {
      dots = 0;
    }
  }
  return false;
}

}  // namespace

template <int D>
double default_contact_distance(const Scene<D>& scene) {
  const double smallest = smallest_radius(scene);
  const double share = scene.accuracy > 0 ? std::min(1e-6, 1e-2 * scene.accuracy) : 1e-6;
  return std::isfinite(smallest) ? share * smallest : 0;
}

template double default_contact_distance(const Scene<2>&);
template double default_contact_distance(const Scene<3>&);

AnyScene parse_any_scene(const std::string& text, const std::string& source,
                         std::optional<double> accuracy) {
  if (text.starts_with("\x89HDF")) {
    throw SceneFileError(
        fmt::format("{}: an HDF5 file, not a scene; 'bipot solve' takes contact problems", source));
  }
  if (has_endless_key(text)) {
    throw SceneFileError(fmt::format("{}: a key has more than 256 parts", source));
  }
  toml::table parsed;
  try {
    parsed = toml::parse(text, source);
  } catch (const toml::parse_error& e) {
    throw SceneFileError(fmt::format("{}:{}: {}", source, e.source().begin.line, e.description()));
  }
  const SceneTable root(parsed, "", "", source);
  const bool spheres = parsed.contains("spheres");
  if (spheres && parsed.contains("disks")) {
    throw SceneFileError(fmt::format(
        "{}:{}: [[disks]] and [[spheres]]: a scene has two dimensions or three, not both", source,
        parsed.get("spheres")->source().begin.line));
  }
  const int dim = root.integer("dim", spheres ? 3 : 2);
  if (dim != 2 && dim != 3) root.fail("dim", fmt::format("expected 2 or 3, got {}", dim));
  if (dim == 2 && spheres) root.fail("spheres", "need three dimensions: dim = 3");
  if (dim == 3) return parse_in<3>(root, source, accuracy);
  return parse_in<2>(root, source, accuracy);
}

Scene<2> parse_scene(const std::string& text, const std::string& source) {
  AnyScene scene = parse_any_scene(text, source);
  if (auto* flat = std::get_if<Scene<2>>(&scene)) return std::move(*flat);
  throw SceneFileError(
      fmt::format("{}: a scene in 3D (dim = 3); only 'bipot run' takes those", source));
}

Scene<2> read_scene(const std::filesystem::path& path) {
  return parse_scene(read_text_file(path), path.string());
}

AnyScene read_any_scene(const std::filesystem::path& path) {
  return parse_any_scene(read_text_file(path), path.string());
}

}  // namespace bipot
