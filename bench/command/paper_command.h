#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace bipot {

struct PaperFlags {
  std::vector<std::string> only;
  bool quick = false, quiet = false;
  std::string out = "out/paper";
  std::string json;
};

/// Declares `bipot paper`.
CLI::App* add_paper_command(CLI::App& app, PaperFlags& flags);

/// Makes the paper's figures and tables again: index page, results.json, pictures and their data.
/// Items of an earlier run into the same folder that are not run now stay. Returns an ExitCode.
/// Throws std::invalid_argument for an unknown item, FileError.
int paper_command(const PaperFlags& flags);

}  // namespace bipot
