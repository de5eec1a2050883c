#include "core/scene_files/scene_keys.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/base/nearest_name.h"

namespace bipot {
namespace {

using KeyWords = std::vector<std::string_view>;

struct TableKeys {
  std::string_view table;
  KeyWords keys;
};

// A key of a wall that changes with time has further readers: has_schedule() and walls_at()
// (wall_motion), next_change() and a_wall_jumps() (accurate_step.cc), travel_halvings()
// (split_step.cc), no_springs(), restart_mismatch(). A vector turns in rotate().
const std::vector<TableKeys>& all_tables() {
  static const std::vector<TableKeys> tables = {
      {"", {"title",  "dim",    "gravity", "rotate_degrees", "materials",   "model", "contact",
            "time",   "solver", "dem",     "output",         "observables", "tilt",  "start",
            "cell",   "pairs",  "disks",   "clusters",       "spheres",     "walls", "outlets",
            "inlets", "forces", "drag",    "pins",           "ropes"}},
      {"contact",
       {"mu", "mu_r", "mu_spin", "e_n", "e_t", "cohesion", "cohesion_range", "heal", "impact",
        "distance", "overlaps"}},
      {"pairs", {"between", "mu", "mu_r", "mu_spin", "e_n", "e_t", "cohesion"}},
      {"time", {"step", "steps", "duration", "travel", "accuracy"}},
      {"disks", {"arrangement", "position", "radius",    "columns",   "rows",    "corner",
                 "count",       "radii",    "fractions", "lognormal", "passing", "width",
                 "height",      "inside",   "spacing",   "seed",      "file",    "mass",
                 "density",     "inertia",  "velocity",  "spin",      "wall",    "material"}},
      {"spheres",
       {"arrangement", "position", "radius",    "columns",   "rows",    "layers", "corner",
        "count",       "radii",    "fractions", "lognormal", "passing", "width",  "depth",
        "height",      "inside",   "spacing",   "seed",      "file",    "mass",   "density",
        "inertia",     "velocity", "spin",      "material"}},
      {"clusters",
       {"parts",  "arrangement", "position", "degrees",  "axis",   "columns", "rows",    "layers",
        "corner", "count",       "width",    "depth",    "height", "inside",  "spacing", "seed",
        "mass",   "density",     "inertia",  "velocity", "spin",   "material"}},
      {"walls", {"name",    "point",     "normal",    "from",     "to",
                 "center",  "radius",    "hollow",    "radii",    "corners",
                 "file",    "scale",     "axis",      "spin",     "velocity",
                 "force",   "mass",      "direction", "speed",    "surface_velocity",
                 "starts",  "stops",     "removed",   "material", "times",
                 "factors", "frequency", "phase",     "grain",    "grain_ratio"}},
      {"forces", {"bodies", "force", "times", "factors", "frequency", "phase"}},
      {"drag", {"coefficient", "velocity"}},
      {"pins", {"bodies", "point"}},
      {"ropes", {"bodies", "from", "to", "length"}},
      {"solver", {"name", "tol", "stop", "max_iterations", "warm_start", "plan", "parameters"}},
      {"output", {"every", "ledger_every", "picture", "stress_picture", "page", "track"}},
      {"start", {"overlaps"}},
      {"tilt", {"degrees_per_second", "starts", "stops"}},
      {"dem", {"stiffness", "overlap", "tangential_ratio", "substep", "safety"}},
      {"cell",
       {"width", "height", "depth", "offset", "width_speed", "height_speed", "offset_speed",
        "pressure_x", "pressure_y", "shear_stress", "mass"}},
      {"outlets", {"name", "point", "normal", "lower", "upper"}},
      {"inlets",
       {"name", "lower", "upper", "rate", "radii", "fractions", "count", "mass", "density",
        "inertia", "velocity", "spin", "material", "seed", "starts", "stops"}},
      {"observables",
       {"every", "starts", "window", "profile", "profile_bins", "profile_range", "force_bins",
        "force_limit", "lines", "faces"}},
      {"observables.lines", {"name", "from", "to"}},
      {"observables.faces", {"name", "point", "normal", "radius", "size", "along"}},
  };
  return tables;
}

struct Synonym {
  KeyWords typed;
  KeyWords keys;  // the first one that the table takes is meant
};

/// Words of other programs and textbooks.
const std::vector<Synonym>& all_synonyms() {
  static const std::vector<Synonym> synonyms = {
      {{"friction", "friction_coefficient", "coefficient_of_friction", "frictioncoeff", "mu_s",
        "mu_d", "mu_k"},
       {"mu"}},
      {{"rolling_friction", "rolling_resistance", "mu_rolling"}, {"mu_r"}},
      {{"spinning_friction", "torsional_friction"}, {"mu_spin"}},
      {{"restitution", "restitution_coefficient", "coefficient_of_restitution", "cor", "e", "en",
        "damping"},
       {"e_n"}},
      {{"et"}, {"e_t"}},
      {{"adhesion"}, {"cohesion"}},
      {{"impact_law", "collision_law"}, {"impact"}},
      {{"dt", "timestep", "time_step", "step_size"}, {"step"}},
      {{"h"}, {"step", "height"}},
      {{"n_steps", "num_steps", "nsteps"}, {"steps"}},
      {{"end"}, {"duration", "to", "stops"}},
      {{"t_end", "end_time", "time", "total_time"}, {"duration"}},
      {{"start"}, {"from", "starts"}},
      {{"n"}, {"count", "rows", "steps", "normal"}},
      {{"number", "num", "number_of_disks"}, {"count"}},
      {{"type", "kind", "layout", "shape"}, {"arrangement"}},
      {{"r", "rad"}, {"radius", "radii"}},
      {{"radius", "sizes"}, {"radii"}},
      {{"radii"}, {"radius"}},
      {{"x", "pos", "center"}, {"position", "point"}},
      {{"centre"}, {"center", "position", "point"}},
      {{"position"}, {"point", "corner", "center"}},
      {{"origin"}, {"corner", "point"}},
      {{"rho"}, {"density"}},
      {{"m"}, {"mass"}},
      {{"moment_of_inertia"}, {"inertia"}},
      {{"v", "vel", "speed"}, {"velocity"}},
      {{"omega", "angular_velocity", "rotation"}, {"spin"}},
      {{"belt", "belt_speed"}, {"surface_velocity"}},
      {{"load"}, {"force"}},
      {{"wall", "planes", "lines", "boundaries"}, {"walls"}},
      {{"wall_height"}, {"height"}},
      {{"length"}, {"width"}},
      {{"g"}, {"gravity"}},
      {{"material_pairs", "interactions"}, {"pairs"}},
      {{"balls"}, {"spheres", "disks"}},
      {{"particles", "grains", "bodies"}, {"disks", "spheres"}},
      {{"circles", "disk"}, {"disks"}},
      {{"sphere"}, {"spheres"}},
      {{"container"}, {"inside"}},
      {{"filename", "path", "csv"}, {"file"}},
      {{"method"}, {"name"}},
      {{"tolerance", "eps"}, {"tol"}},
      {{"max_iter", "iterations"}, {"max_iterations"}},
      {{"save_every", "frames", "interval", "frequency"}, {"every"}},
      {{"periodic"}, {"cell"}},
      {{"joints", "hinges"}, {"pins"}},
      {{"cables", "strings"}, {"ropes"}},
      {{"period"}, {"cell", "width"}},
  };
  return synonyms;
}

struct Remark {
  KeyWords typed;
  std::string_view text;
  std::string_view beside = {};  // in tables with this key alone; empty: in all
};

/// What other programs have and this one has not, or has under no single key.
const std::vector<Remark>& all_remarks() {
  static const std::vector<Remark> remarks = {
      {{"fixed", "static", "glued", "frozen", "immobile", "dynamic"},
       "wall = \"NAME\" glues disks to a wall"},
      {{"boxes", "box", "polygons", "polygon", "rectangles", "blocks", "ellipses"},
       "bodies are disks, rigid clusters of disks, and spheres"},
      {{"young", "youngs_modulus", "young_modulus", "poisson", "kn", "k_n"},
       "bodies are rigid; model = \"dem\" has springs, with [dem] stiffness"},
      {{"diameter", "diameters", "d"}, "sizes are radii: give 'radius' or 'radii'"},
      {{"type", "kind", "shape"},
       "'point' and 'normal' make a half-plane, 'from' and 'to' a segment, 'center' and 'radius' a "
       "circle",
       "hollow"},
  };
  return remarks;
}

bool lists(const KeyWords& words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// The first meaning that `valid` has; empty: none.
std::string synonym_among(std::string_view typed, const std::vector<std::string>& valid) {
  for (const Synonym& synonym : all_synonyms()) {
    if (!lists(synonym.typed, typed)) continue;
    for (const std::string_view key : synonym.keys) {
      if (std::find(valid.begin(), valid.end(), key) != valid.end()) return std::string(key);
    }
  }
  return {};
}

/// The first table that takes the key; nullptr: none.
const TableKeys* table_with(std::string_view key) {
  const auto& tables = all_tables();
  const auto it = std::find_if(tables.begin(), tables.end(),
                               [&](const TableKeys& table) { return lists(table.keys, key); });
  return it == tables.end() ? nullptr : &*it;
}

/// True if the valid keys are a part of some table that has this key too, and no whole table.
bool is_part_of_its_table(std::string_view key, const std::vector<std::string>& valid) {
  bool takes = false;
  for (const TableKeys& table : all_tables()) {
    if (!std::ranges::all_of(valid, [&](const auto& known) { return lists(table.keys, known); })) {
      continue;
    }
    if (table.keys.size() == valid.size()) return false;
    takes = takes || lists(table.keys, key);
  }
  return takes;
}

/// " 'mu' belongs to [contact]", where the key or what it means has its place; empty: nowhere.
std::string other_place(std::string_view typed) {
  KeyWords meanings = {typed};
  for (const Synonym& synonym : all_synonyms()) {
    if (!lists(synonym.typed, typed)) continue;
    meanings.insert(meanings.end(), synonym.keys.begin(), synonym.keys.end());
  }
  for (const std::string_view key : meanings) {
    if (const TableKeys* place = table_with(key)) {
      return fmt::format("'{}' belongs to {}", key,
                         place->table.empty() ? "the top level, above all tables"
                                              : fmt::format("[{}]", place->table));
    }
  }
  return {};
}

}  // namespace

std::vector<std::string> keys_of_table(std::string_view table) {
  for (const TableKeys& known : all_tables()) {
    if (known.table == table) return {known.keys.begin(), known.keys.end()};
  }
  return {};
}

bool is_synonym(std::string_view typed, std::string_view key) {
  const auto& synonyms = all_synonyms();
  return std::any_of(synonyms.begin(), synonyms.end(), [&](const Synonym& synonym) {
    return lists(synonym.typed, typed) && lists(synonym.keys, key);
  });
}

std::string unknown_key_message(std::string_view typed, const std::vector<std::string>& valid) {
  for (const Remark& remark : all_remarks()) {
    const bool here = remark.beside.empty() ||
                      std::find(valid.begin(), valid.end(), remark.beside) != valid.end();
    if (here && lists(remark.typed, typed)) {
      return fmt::format("unknown key '{}': {}", typed, remark.text);
    }
  }
  if (const std::string meant = synonym_among(typed, valid); !meant.empty()) {
    return fmt::format("unknown key '{}'; did you mean '{}'? Valid: {}", typed, meant,
                       fmt::join(valid, ", "));
  }
  if (nearest_name(typed, valid).empty()) {
    if (is_part_of_its_table(typed, valid)) {
      return fmt::format(
          "unknown key '{}' here; it does not go with this arrangement, shape or motion. Valid: {}",
          typed, fmt::join(valid, ", "));
    }
    const bool of_a_solver = table_with(typed) == nullptr || typed == "seed";
    if (of_a_solver && std::ranges::find(valid, "parameters") != valid.end()) {
      return fmt::format(
          "unknown key '{}'; parameters of a solver stand in parameters = {{ {} = ... }}. Valid: {}",
          typed, typed, fmt::join(valid, ", "));
    }
    if (const std::string place = other_place(typed); !place.empty()) {
      return fmt::format("unknown key '{}' here; {}. Valid: {}", typed, place,
                         fmt::join(valid, ", "));
    }
  }
  return unknown_name_message("key", typed, valid);
}

}  // namespace bipot
