#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace bipot {

struct ListFlags {
  std::string what;  ///< "solvers" or "scenes"
  std::string name;  ///< of one solver; empty: all
  std::string json;
};

/// Declares `bipot list`.
CLI::App* add_list_command(CLI::App& app, ListFlags& flags);

int list_command(const ListFlags& flags);

}  // namespace bipot
