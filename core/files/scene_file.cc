#include "core/files/scene_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <sstream>

#include "core/nearest_name.h"
#include "core/scene/generators.h"
#include "core/types.h"

namespace bipot {
namespace {

/// A TOML table that knows its name and which keys were asked for: what is left over is unknown.
class Table {
 public:
  Table(const toml::table& table, std::string name, const std::string& source)
      : table_(table), name_(std::move(name)), source_(source) {}

  /// Refuses keys that nothing asked for. Call after the last access.
  void finish() const {
    for (const auto& [key, node] : table_) {
      const std::string text(key.str());
      if (known_.contains(text)) continue;
      fail_at(node, unknown_name_message("key", text, {known_.begin(), known_.end()}));
    }
  }

  [[noreturn]] void fail(std::string_view key, const std::string& message) const {
    const toml::node* node = table_.get(key);
    const std::string text = fmt::format("'{}': {}", key, message);
    if (node != nullptr) fail_at(*node, text);
    throw SceneFileError(
        fmt::format("{}: [{}] {}", source_, name_.empty() ? "top level" : name_, text));
  }

  bool has(std::string_view key) const {
    known_.emplace(key);
    return table_.contains(key);
  }

  std::optional<double> maybe_number(std::string_view key) const {
    if (!has(key)) return std::nullopt;
    return number_of(key, *table_.get(key));
  }
  double number(std::string_view key, double fallback) const {
    return maybe_number(key).value_or(fallback);
  }
  double number(std::string_view key) const {
    if (!has(key)) fail(key, "is missing");
    return *maybe_number(key);
  }
  double positive(std::string_view key) const {
    const double x = number(key);
    if (!(x > 0)) fail(key, fmt::format("expected a positive number, got {}", x));
    return x;
  }
  int integer(std::string_view key, int fallback) const {
    if (!has(key)) return fallback;
    const auto value = table_.get(key)->value_exact<std::int64_t>();
    if (!value) fail(key, "expected an integer");
    if (*value < std::numeric_limits<int>::min() || *value > std::numeric_limits<int>::max()) {
      fail(key, fmt::format("{} is out of range", *value));
    }
    return static_cast<int>(*value);
  }
  int natural(std::string_view key) const {
    if (!has(key)) fail(key, "is missing");
    const int value = integer(key, 0);
    if (value < 0) fail(key, fmt::format("expected a non-negative integer, got {}", value));
    return value;
  }
  bool boolean(std::string_view key, bool fallback) const {
    if (!has(key)) return fallback;
    const auto value = table_.get(key)->value_exact<bool>();
    if (!value) fail(key, "expected true or false");
    return *value;
  }
  std::string word(std::string_view key, std::string_view fallback) const {
    if (!has(key)) return std::string(fallback);
    const auto value = table_.get(key)->value_exact<std::string>();
    if (!value) fail(key, "expected a string");
    return *value;
  }
  std::string one_of(std::string_view key, std::string_view fallback,
                     const std::vector<std::string>& choices) const {
    std::string value = word(key, fallback);
    if (std::find(choices.begin(), choices.end(), value) == choices.end()) {
      fail(key, unknown_name_message("value", value, choices));
    }
    return value;
  }
  std::optional<Vec2> maybe_vec2(std::string_view key) const {
    if (!has(key)) return std::nullopt;
    const std::vector<double> values = numbers(key);
    if (values.size() != 2) fail(key, fmt::format("expected 2 numbers, got {}", values.size()));
    return Vec2(values[0], values[1]);
  }
  Vec2 vec2(std::string_view key, const Vec2& fallback) const {
    return maybe_vec2(key).value_or(fallback);
  }
  std::vector<double> numbers(std::string_view key) const {
    std::vector<double> values;
    if (!has(key)) return values;
    const toml::array* array = table_.get(key)->as_array();
    if (array == nullptr) fail(key, "expected an array of numbers");
    for (const toml::node& node : *array) values.push_back(number_of(key, node));
    return values;
  }
  std::vector<std::string> words(std::string_view key) const {
    std::vector<std::string> values;
    if (!has(key)) return values;
    const toml::array* array = table_.get(key)->as_array();
    if (array == nullptr) fail(key, "expected an array of strings");
    for (const toml::node& node : *array) {
      const auto value = node.value_exact<std::string>();
      if (!value) fail(key, "expected an array of strings");
      values.push_back(*value);
    }
    return values;
  }
  std::optional<Table> table(std::string_view key) const {
    if (!has(key)) return std::nullopt;
    const toml::table* table = table_.get(key)->as_table();
    if (table == nullptr) fail(key, "expected a table");
    return Table(*table, child_name(key), source_);
  }
  std::vector<Table> tables(std::string_view key) const {
    std::vector<Table> result;
    if (!has(key)) return result;
    const toml::array* array = table_.get(key)->as_array();
    if (array == nullptr) fail(key, fmt::format("expected an array of tables: [[{}]]", key));
    for (const toml::node& node : *array) {
      const toml::table* table = node.as_table();
      if (table == nullptr) fail(key, "expected an array of tables");
      result.emplace_back(*table, fmt::format("{}[{}]", child_name(key), result.size()), source_);
    }
    return result;
  }
  /// Every key with its value as text: parameters of a solver.
  std::map<std::string, std::string> texts() const {
    std::map<std::string, std::string> result;
    for (const auto& [key, node] : table_) {
      known_.emplace(key.str());
      if (const auto word = node.value_exact<std::string>()) {
        result[std::string(key.str())] = *word;
      } else if (const auto number = node.value<double>()) {
        result[std::string(key.str())] = fmt::format("{}", *number);
      } else {
        fail_at(node, "expected a string or a number");
      }
    }
    return result;
  }
  const std::string& name() const { return name_; }

 private:
  std::string child_name(std::string_view key) const {
    return name_.empty() ? std::string(key) : fmt::format("{}.{}", name_, key);
  }
  double number_of(std::string_view key, const toml::node& node) const {
    const bool numeric = node.is_integer() || node.is_floating_point();
    const std::optional<double> value = numeric ? node.value<double>() : std::nullopt;
    if (!value || !std::isfinite(*value)) fail(key, "expected a finite number");
    return *value;
  }
  [[noreturn]] void fail_at(const toml::node& node, const std::string& message) const {
    throw SceneFileError(fmt::format("{}:{}: [{}] {}", source_, node.source().begin.line,
                                     name_.empty() ? "top level" : name_, message));
  }

  const toml::table& table_;
  std::string name_;
  const std::string& source_;
  mutable std::set<std::string, std::less<>> known_;
};

int material_index(const Scene& scene, const Table& table, std::string_view key) {
  const std::string name = table.word(key, scene.materials.front());
  const auto it = std::find(scene.materials.begin(), scene.materials.end(), name);
  if (it == scene.materials.end()) {
    table.fail(key, unknown_name_message("material", name, scene.materials));
  }
  return static_cast<int>(it - scene.materials.begin());
}

ContactLaw read_law(const Table& table) {
  return {
      .mu = table.number("mu", 0), .e_n = table.number("e_n", 0), .e_t = table.number("e_t", 0)};
}

void read_materials(const Table& root, Scene& scene) {
  ContactLaw base;
  if (const auto table = root.table("contact")) {
    base = read_law(*table);
    if (const auto distance = table->maybe_number("distance")) {
      if (*distance < 0) table->fail("distance", "expected a number >= 0");
      scene.contact_distance = *distance;
    }
    table->finish();
  }
  scene.materials = root.words("materials");
  if (scene.materials.empty()) scene.materials = {"default"};
  const std::size_t count = scene.materials.size();
  if (std::set<std::string>(scene.materials.begin(), scene.materials.end()).size() != count) {
    root.fail("materials", "names must differ");
  }
  scene.laws.assign(count * count, base);
  for (const Table& table : root.tables("pairs")) {
    const std::vector<std::string> between = table.words("between");
    if (between.size() != 2) table.fail("between", "expected two material names");
    std::array<std::size_t, 2> index{};
    for (std::size_t k = 0; k < 2; ++k) {
      const auto it = std::find(scene.materials.begin(), scene.materials.end(), between[k]);
      if (it == scene.materials.end()) {
        table.fail("between", unknown_name_message("material", between[k], scene.materials));
      }
      index[k] = static_cast<std::size_t>(it - scene.materials.begin());
    }
    ContactLaw law = base;
    law.mu = table.number("mu", base.mu);
    law.e_n = table.number("e_n", base.e_n);
    law.e_t = table.number("e_t", base.e_t);
    scene.laws[index[0] * count + index[1]] = scene.laws[index[1] * count + index[0]] = law;
    table.finish();
  }
}

/// Mass, inertia, initial motion and material of a group's disks.
void read_common(const Table& table, const Scene& scene, std::vector<Disk>& disks) {
  const std::optional<double> density = table.maybe_number("density");
  const std::optional<double> mass = table.maybe_number("mass");
  if (density.has_value() == mass.has_value()) {
    table.fail("mass", "give either mass [kg] or density [kg/m³]");
  }
  if (density && !(*density > 0)) table.fail("density", "expected a positive number");
  if (mass && !(*mass > 0)) table.fail("mass", "expected a positive number");
  const std::optional<double> inertia = table.maybe_number("inertia");
  const Vec2 v = table.vec2("velocity", Vec2::Zero());
  const double spin = table.number("spin", 0);
  const int material = material_index(scene, table, "material");
  for (Disk& d : disks) {
    d.mass = mass ? *mass : *density * std::numbers::pi * d.radius * d.radius;
    d.inertia = inertia ? *inertia : 0.5 * d.mass * d.radius * d.radius;
    d.v = v;
    d.spin = spin;
    d.material = material;
  }
}

std::vector<RadiusClass> read_classes(const Table& table) {
  const std::vector<double> radii = table.numbers("radii");
  std::vector<double> fractions = table.numbers("fractions");
  if (radii.empty()) table.fail("radii", "is missing");
  if (fractions.empty()) fractions.assign(radii.size(), 1.0);
  if (fractions.size() != radii.size()) {
    table.fail("fractions", fmt::format("{} entries for {} radii", fractions.size(), radii.size()));
  }
  std::vector<RadiusClass> classes;
  for (std::size_t k = 0; k < radii.size(); ++k) classes.push_back({radii[k], fractions[k]});
  return classes;
}

std::vector<Disk> read_group(const Table& table) {
  static const std::vector<std::string> kArrangements = {"single", "rectangular", "triangular",
                                                         "pyramid", "random"};
  const std::string arrangement = table.one_of("arrangement", "single", kArrangements);
  if (arrangement == "single") {
    Disk disk;
    const auto position = table.maybe_vec2("position");
    if (!position) table.fail("position", "is missing");
    disk.x = *position;
    disk.radius = table.positive("radius");
    return {disk};
  }
  const Vec2 corner = table.vec2("corner", Vec2::Zero());
  if (arrangement == "random") {
    const int seed = table.integer("seed", 1);
    if (seed < 0) table.fail("seed", "expected a non-negative integer");
    const int count = table.natural("count");
    const double width = table.positive("width");
    const double spacing = table.number("spacing", 0.1);
    try {
      return random_filling(count, read_classes(table), width, spacing,
                            static_cast<std::uint64_t>(seed), corner);
    } catch (const std::invalid_argument& e) {
      table.fail("arrangement", e.what());
    }
  }
  const double radius = table.positive("radius");
  const int rows = table.natural("rows");
  if (arrangement == "pyramid") return pyramid(rows, radius, corner);
  const int columns = table.natural("columns");
  return arrangement == "rectangular" ? rectangular_lattice(columns, rows, radius, corner)
                                      : triangular_lattice(columns, rows, radius, corner);
}

Wall read_wall(const Table& table, const Scene& scene, std::size_t index) {
  Wall wall;
  wall.name = table.word("name", fmt::format("wall{}", index));
  const auto point = table.maybe_vec2("point");
  const auto from = table.maybe_vec2("from"), to = table.maybe_vec2("to");
  const auto normal = table.maybe_vec2("normal");
  if (point && normal && !from && !to) {
    wall.a = *point;
    if (!(normal->norm() > 0)) table.fail("normal", "must not be zero");
    wall.normal = normal->normalized();
  } else if (from && to && !point && !normal) {
    wall.shape = Wall::Shape::kSegment;
    wall.a = *from;
    wall.b = *to;
  } else {
    table.fail("point", "give point and normal (a half-plane) or from and to (a segment)");
  }
  wall.material = material_index(scene, table, "material");
  const auto velocity = table.maybe_vec2("velocity");
  const auto force = table.maybe_number("force");
  const auto direction = table.maybe_vec2("direction");
  const auto mass = table.maybe_number("mass");
  if (force || direction || mass) {
    if (!force || !mass) table.fail("force", "a driven wall needs force [N] and mass [kg]");
    if (velocity) {
      table.fail("velocity", "a wall is moved by a velocity or driven by a force, not both");
    }
    wall.motion = Wall::Motion::kDriven;
    wall.force = *force;
    wall.mass = *mass;
    if (!direction && wall.shape == Wall::Shape::kSegment) {
      table.fail("direction", "is missing for a driven segment");
    }
    const Vec2 axis = direction ? *direction : wall.normal;
    if (!(axis.norm() > 0)) table.fail("direction", "must not be zero");
    wall.direction = axis.normalized();
    wall.v = table.number("speed", 0) * wall.direction;
  } else if (velocity) {
    wall.motion = Wall::Motion::kMoving;
    wall.v = *velocity;
  }
  return wall;
}

void read_time(const Table& root, Scene& scene) {
  const auto table = root.table("time");
  if (!table) root.fail("time", "the table [time] is missing");
  scene.step = table->positive("step");
  const bool by_count = table->has("steps"), by_duration = table->has("duration");
  if (by_count == by_duration) table->fail("steps", "give either steps or duration [s]");
  if (by_count) {
    scene.num_steps = table->natural("steps");
  } else {
    const double steps = std::round(table->positive("duration") / scene.step);
    if (!(steps < std::numeric_limits<int>::max())) table->fail("duration", "is too many steps");
    scene.num_steps = static_cast<int>(steps);
  }
  table->finish();
}

void read_solver(const Table& root, Scene& scene) {
  const auto table = root.table("solver");
  if (!table) return;
  SolverChoice& s = scene.solver;
  s.name = table->word("name", s.name);
  s.tol = table->number("tol", s.tol);
  if (!(s.tol > 0)) table->fail("tol", "expected a positive number");
  s.stop = table->one_of("stop", s.stop, {"guarded", "raw42", "impulse"});
  s.max_iterations = table->integer("max_iterations", s.max_iterations);
  if (s.max_iterations < 0) table->fail("max_iterations", "expected a non-negative integer");
  s.warm_start = table->boolean("warm_start", s.warm_start);
  if (const auto parameters = table->table("parameters")) s.parameters = parameters->texts();
  table->finish();
}

void read_model(const Table& root, Scene& scene) {
  const std::string model = root.one_of("model", "nscd", {"nscd", "dem"});
  scene.model = model == "dem" ? Model::kSpringDashpot : Model::kNonsmooth;
  const auto table = root.table("dem");
  if (!table) return;
  SpringDashpotChoice& d = scene.dem;
  if (table->has("stiffness")) d.stiffness = table->positive("stiffness");
  d.overlap = table->number("overlap", d.overlap);
  d.tangential_ratio = table->number("tangential_ratio", d.tangential_ratio);
  if (table->has("substep")) d.substep = table->positive("substep");
  d.safety = table->number("safety", d.safety);
  table->finish();
}

void read_output(const Table& root, Scene& scene) {
  const auto table = root.table("output");
  if (!table) return;
  OutputChoice& o = scene.output;
  o.every = table->integer("every", o.every);
  o.ledger_every = table->integer("ledger_every", o.ledger_every);
  if (o.every < 0) table->fail("every", "expected a non-negative integer");
  if (o.ledger_every < 0) table->fail("ledger_every", "expected a non-negative integer");
  o.picture = table->boolean("picture", o.picture);
  o.stress_picture = table->boolean("stress_picture", o.stress_picture);
  for (double x : table->numbers("track")) {
    const bool is_index = x >= 0 && x <= std::numeric_limits<int>::max() && x == std::floor(x);
    if (!is_index) table->fail("track", "expected disk numbers");
    o.track.push_back(static_cast<int>(x));
  }
  table->finish();
}

/// Turns bodies and walls about the origin; gravity stays: a tilted box.
void rotate(Scene& scene, double degrees) {
  const Eigen::Rotation2D<double> turn(degrees * std::numbers::pi / 180);
  for (Disk& d : scene.disks) {
    d.x = turn * d.x;
    d.v = turn * d.v;
  }
  for (Wall& w : scene.walls) {
    w.a = turn * w.a;
    w.b = turn * w.b;
    w.normal = turn * w.normal;
    w.v = turn * w.v;
    w.direction = turn * w.direction;
  }
}

/// Touching lattices have gaps of rounding size: the default distance covers them, and is far below
/// anything that matters.
double default_contact_distance(const Scene& scene) {
  return scene.disks.empty() ? 0 : 1e-6 * smallest_radius(scene);
}

}  // namespace

Scene parse_scene(const std::string& text, const std::string& source) {
  toml::table parsed;
  try {
    parsed = toml::parse(text, source);
  } catch (const toml::parse_error& e) {
    throw SceneFileError(fmt::format("{}:{}: {}", source, e.source().begin.line, e.description()));
  }
  const Table root(parsed, "", source);
  Scene scene;
  scene.source = source;
  scene.title = root.word("title", "");
  scene.gravity = root.vec2("gravity", Vec2(0, -9.81));
  scene.contact_distance = -1;
  read_materials(root, scene);
  for (const Table& table : root.tables("disks")) {
    std::vector<Disk> disks = read_group(table);
    read_common(table, scene, disks);
    table.finish();
    scene.disks.insert(scene.disks.end(), disks.begin(), disks.end());
  }
  for (const Table& table : root.tables("walls")) {
    scene.walls.push_back(read_wall(table, scene, scene.walls.size()));
    table.finish();
  }
  if (const auto degrees = root.maybe_number("rotate_degrees")) rotate(scene, *degrees);
  read_time(root, scene);
  read_model(root, scene);
  read_solver(root, scene);
  read_output(root, scene);
  root.finish();
  if (scene.contact_distance < 0) {
    scene.contact_distance = default_contact_distance(scene);
  }
  if (auto defect = validate(scene); !defect.empty()) {
    throw SceneFileError(fmt::format("{}: {}", source, defect));
  }
  return scene;
}

Scene read_scene(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) throw SceneFileError(fmt::format("{}: cannot be opened", path.string()));
  std::ostringstream text;
  text << file.rdbuf();
  return parse_scene(text.str(), path.string());
}

}  // namespace bipot
