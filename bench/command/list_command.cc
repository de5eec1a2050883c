#include <fmt/format.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <variant>

#include "bench/command/command_options.h"
#include "bench/command/commands.h"
#include "bench/problems/scene_catalogue.h"
#include "bench/report/json_output.h"
#include "bench/report/text_lines.h"
#include "core/base/counted.h"
#include "core/base/file_error.h"
#include "core/problem_files/problem_file.h"
#include "core/scene_files/scene_file.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

struct ListFlags {
  std::string what;  ///< "solvers" or "scenes"
  std::string name;  ///< of one solver; empty: all
  std::string json;
};

std::string_view kind_of(const ParameterSpec& spec) {
  constexpr std::string_view kNames[] = {"number", "integer", "choice", "text"};
  return kNames[static_cast<int>(spec.kind)];
}

std::string_view default_of(const ParameterSpec& spec) {
  return spec.default_value.empty() ? "none" : spec.default_value;
}

std::string domain_of(const ParameterSpec& spec) {
  if (spec.kind == ParameterSpec::Kind::kChoice) return std::string(spec.choices);
  if (spec.kind == ParameterSpec::Kind::kText) return std::string(kind_of(spec));
  return fmt::format("{} in [{:.10g}, {:.10g}]", kind_of(spec), spec.minimum, spec.maximum);
}

Json to_json(const SolverEntry& entry) {
  const auto parameter_json = [](const ParameterSpec& spec) {
    return Json{{"name", spec.name},
                {"flag", parameter_flag(spec.name)},
                {"default", spec.default_value},
                {"domain", domain_of(spec)},
                {"unit", spec.unit},
                {"help", spec.help}};
  };
  return {{"name", entry.name},
          {"summary", entry.summary},
          {"max_dim", entry.max_dim},
          {"parameters", json_list(all_parameters(entry), parameter_json)}};
}

/// Those of the table, then the special ones.
template <class Show>
void each_solver(const Show& show) {
  for (const auto table : {solver_table(), special_solvers()}) {
    for (const SolverEntry& entry : table) show(entry);
  }
}

Json solvers_json() {
  auto rows = Json::array();
  each_solver([&](const SolverEntry& entry) { rows.push_back(to_json(entry)); });
  return rows;
}

/// Prints one solver and its parameters on a screen.
void print_solver(const SolverEntry& entry) {
  fmt::print("{}: {}\n", entry.name, hanging_text(entry.summary, entry.name.size() + 2));
  fmt::print("contacts of dimension up to {}", entry.max_dim);
  if (entry.max_contacts < std::numeric_limits<int>::max()) {
    fmt::print(", at most {} of them", entry.max_contacts);
  }
  fmt::print("\n");
  constexpr std::size_t kColumn = 24;
  for (const ParameterSpec& spec : all_parameters(entry)) {
    fmt::print("\n{:<{}}{}\n", parameter_flag(spec.name), kColumn,
               hanging_text(spec.help, kColumn));
    fmt::print("{:{}}default {}; {}{}\n", "", kColumn, default_of(spec), domain_of(spec),
               spec.unit.empty() ? "" : fmt::format("; unit: {}", spec.unit));
  }
}

void print_parameter(std::string_view solver, const ParameterSpec& spec) {
  fmt::print("{:<14}   {}\n", solver,
             hanging_text(fmt::format("{} = {}  ({})  {}", spec.name, default_of(spec),
                                      domain_of(spec), spec.help),
                          19));
}

void print_solvers() {
  each_solver([](const SolverEntry& entry) {
    fmt::print("{:<14} {}\n", entry.name, entry.summary);
    for (const ParameterSpec& spec : entry.parameters) print_parameter("", spec);
  });
  print_parameter("all of them", kIslandsParameter);
}

Json scenes_json() {
  auto rows = Json::array();
  for (const auto& path : shipped_scenes()) {
    rows.push_back(std::visit(
        [&](const auto& scene) {
          const bool flat = std::is_same_v<std::decay_t<decltype(scene)>, Scene<2>>;
          return Json{{"name", path.stem().string()},
                      {"title", scene.title},
                      {flat ? "disks" : "spheres", scene.bodies.size()},
                      {"walls", scene.walls.size()},
                      {"steps", scene.num_steps}};
        },
        read_any_scene(path)));
  }
  return rows;
}

Json problems_json() {
  auto rows = Json::array();
  for (const auto& path : shipped_problems()) {
    const ProblemFile file = read_problem(path);
    rows.push_back({{"name", path.stem().string()},
                    {"file", path.string()},
                    {"dim", file.problem.dim},
                    {"contacts", file.problem.num_contacts()}});
  }
  return rows;
}

void print_scenes() {
  for (const auto& row : scenes_json()) {
    const bool flat = row.contains("disks");
    fmt::print("{:<24} {:<12} {:<8} {:>5} steps  {}\n", row["name"].get<std::string>(),
               counted(row[flat ? "disks" : "spheres"].get<long>(), flat ? "disk" : "sphere"),
               counted(row["walls"].get<long>(), "wall"), row["steps"].get<int>(),
               row["title"].get<std::string>());
  }
}

void print_problems() {
  for (const auto& row : problems_json()) {
    fmt::print("{:<26} {}D  {:<14} {}\n", row["name"].get<std::string>(), row["dim"].get<int>(),
               counted(row["contacts"].get<long>(), "contact"), row["file"].get<std::string>());
  }
}

/// All names, a paragraph for each kind.
void print_names() {
  const auto print = [](const char* kind, const std::string& names) {
    constexpr std::size_t kColumn = 12;
    fmt::print("{:<{}}{}\n", kind, kColumn, hanging_text(names, kColumn));
  };
  const auto stems = [](const std::vector<std::filesystem::path>& paths) {
    std::string names;
    for (const auto& path : paths) names += path.stem().string() + " ";
    return names;
  };
  std::string solvers;
  each_solver([&](const SolverEntry& entry) { solvers += std::string(entry.name) + " "; });
  print("solvers", solvers);
  print("scenes", stems(shipped_scenes()));
  print("problems", stems(shipped_problems()));
  print("templates", stems(scene_templates()));
  fmt::print("More: bipot list solvers|scenes|problems, bipot new\n");
}

CommandDeclaration add_list(CommandLine& line, ListFlags& flags) {
  CommandDeclaration command =
      line.add_command("list", "List solvers, shipped scenes and shipped problems");
  command.option("what", flags.what, "Kind of things; without it all names",
                 {.one_of = {"solvers", "scenes", "problems"}});
  command.option("name", flags.name,
                 "One solver: its parameters with flag, default, range and unit");
  command.option("--json FILE", flags.json, "Write the list as JSON; '-' is standard output");
  command.footer(
      "Examples:\n"
      "  bipot list solvers\n"
      "  bipot list solvers pgs\n"
      "  bipot list scenes --json -");
  return command;
}

int run_list(const ListFlags& flags) {
  const bool solvers = flags.what == "solvers";
  if (!flags.name.empty()) {
    if (!solvers) throw std::invalid_argument(fmt::format("list {} takes no name", flags.what));
    const SolverEntry& entry = require_solver(flags.name);
    if (flags.json.empty()) {
      print_solver(entry);
    } else {
      write_json(to_json(entry), flags.json);
    }
    return kExitConverged;
  }
  if ((flags.what == "scenes" && shipped_scenes().empty()) ||
      (flags.what == "problems" && shipped_problems().empty())) {
    throw FileError(data_folder(), "",
                    fmt::format("has no shipped {}; BIPOT_DATA names their folder", flags.what));
  }
  if (!flags.json.empty()) {
    const auto rows_of = [](const std::string& what) {
      return what == "solvers"  ? solvers_json()
             : what == "scenes" ? scenes_json()
                                : problems_json();
    };
    write_json(flags.what.empty() ? Json{{"solvers", rows_of("solvers")},
                                         {"scenes", rows_of("scenes")},
                                         {"problems", rows_of("problems")}}
                                  : rows_of(flags.what),
               flags.json);
  } else if (solvers) {
    print_solvers();
  } else if (flags.what == "scenes") {
    print_scenes();
  } else if (flags.what == "problems") {
    print_problems();
  } else {
    print_names();
  }
  return kExitConverged;
}

}  // namespace

ProgramCommand list_command(CommandLine& line) { return make_command(line, &add_list, &run_list); }

}  // namespace bipot
