#pragma once

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "bench/command/command_line.h"
#include "core/base/file_error.h"
#include "core/scene/scene.h"
#include "solvers/solver.h"

namespace bipot {

/// What `read` makes of a file. Throws FileError where it cannot be read; an existing file without
/// the required content is bad input.
template <class Read>
auto readable(const std::string& path, Read read) {
  if (::access(path.c_str(), R_OK) != 0) throw FileError(path, "", std::strerror(errno));
  try {
    return read();
  } catch (const FileError& e) {
    throw std::invalid_argument(e.what());
  }
}

/// Says on standard error what a command leaves out, once in a process; nothing where it is empty.
void warn_once(const std::string& text);

/// Where results go.
struct OutputFlags {
  std::string out, json;  ///< a folder; a file, "-": standard output
  bool quiet = false;

  /// True if standard output has nothing but JSON.
  bool silent() const { return quiet || json == "-"; }
  /// Before the work: makes the folder, and looks whether the file can be written and, for `charts`
  /// in the folder, whether they can be drawn. Throws FileError.
  void prepare(bool charts = false) const;
  /// After the work: writes the JSON if wanted. Unless silent, prints the text and, if there is a
  /// folder, a last line on where the results are. Throws FileError.
  void deliver(const nlohmann::ordered_json& results, const std::string& text,
               const std::string& place = {}) const;
};
/// --out with this help, --json and --quiet. Empty help: no --out.
void add_output_flags(CommandDeclaration& command, OutputFlags& flags,
                      const std::string& folder_help);

/// Flags common to `run` and `solve`.
struct CommonFlags : OutputFlags {
  double time_limit = kInfinity;  ///< wall seconds
  int threads = 1;                ///< they change no bit
};
void add_common_flags(CommandDeclaration& command, CommonFlags& flags,
                      const std::string& folder_help = "Folder for the results");
void add_threads_flag(CommandDeclaration& command, int& threads);
void add_reproducible_flag(CommandDeclaration& command, bool& reproducible);

/// Choices of the command line for the solver; unset entries leave the scene's or the default
/// choice.
struct SolverFlags {
  std::optional<std::string> name, stop;
  std::optional<double> tol;
  std::optional<int> max_iterations;
  std::optional<bool> warm_start;
  std::map<std::string, std::string> parameters;  ///< filled by parse callbacks
};
/// --solver, --tol, --stop, --max-iterations and, hidden in the help, one flag for each parameter
/// name in the solver table.
void add_solver_flags(CommandDeclaration& command, SolverFlags& flags);
/// The flag of a solver's parameter: --inner-iterations for inner_iterations.
std::string parameter_flag(std::string_view name);
/// --warm-start and --no-warm-start, for commands with more than one step.
void add_warm_start_flags(CommandDeclaration& command, SolverFlags& flags);

/// The scene's choice with the entries of the command line. If the command line names another
/// solver, parameters of the scene are dropped. Throws FileError or std::invalid_argument for a plan
/// that cannot be used.
SolverChoice merged(const SolverChoice& base, const SolverFlags& flags);

}  // namespace bipot
