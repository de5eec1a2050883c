#include "solvers/registry.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "core/base/nearest_name.h"

namespace bipot {

const SolverEntry* find_solver(std::string_view name) {
  for (const auto table : {solver_table(), special_solvers()}) {
    for (const SolverEntry& entry : table) {
      if (entry.name == name) return &entry;
    }
  }
  return nullptr;
}

const SolverEntry& require_solver(std::string_view name) {
  const SolverEntry* entry = find_solver(name);
  if (entry == nullptr) throw std::invalid_argument(unknown_solver_message(name));
  return *entry;
}

void require_solvers(std::span<const std::string> names) {
  for (const std::string& name : names) {
    require_solver(name);
    if (std::ranges::count(names, name) > 1) {
      throw std::invalid_argument(fmt::format("solver '{}' is named twice", name));
    }
  }
}

std::vector<ParameterSpec> all_parameters(const SolverEntry& entry) {
  std::vector<ParameterSpec> all(entry.parameters.begin(), entry.parameters.end());
  const auto is_islands = [](const ParameterSpec& s) { return s.name == kIslandsParameter.name; };
  if (std::none_of(all.begin(), all.end(), is_islands)) all.push_back(kIslandsParameter);
  return all;
}

std::vector<std::string> solver_names() { return names_of(solver_table()); }

std::vector<std::string> all_solver_names() {
  std::vector<std::string> names = solver_names();
  for (const SolverEntry& entry : special_solvers()) names.emplace_back(entry.name);
  return names;
}

std::string unknown_solver_message(std::string_view name) {
  [[maybe_unused]] const auto lacks = [&](const char* option, const char* package) {
    return fmt::format("solver '{}' is not in this build: configure with -D{}=ON (needs {})", name,
                       option, package);
  };
#ifndef BIPOT_WITH_SICONOS
  if (name.starts_with("siconos:")) return lacks("BIPOT_WITH_SICONOS", "libsiconos-numerics-dev");
#endif
#ifndef BIPOT_WITH_PETSC
  if (name == "newton") return lacks("BIPOT_WITH_PETSC", "petsc-dev");
#endif
  return unknown_name_message("solver", name, all_solver_names());
}

}  // namespace bipot
