#include "bench/command/command_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>

#include "core/nearest_name.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

/// CLI11's own check lets NaN through.
const CLI::Validator kPositive(
    [](std::string& text) {
      double x = 0;
      return CLI::detail::lexical_cast(text, x) && x > 0
                 ? std::string{}
                 : "expected a positive number, got " + text;
    },
    "POSITIVE");

}  // namespace

void add_common_flags(CLI::App& command, CommonFlags& flags) {
  command.add_option("--out", flags.out, "Folder for the results")->type_name("DIR");
  command.add_flag("--quiet,-q", flags.quiet, "No progress, no summary on the terminal");
  command.add_option("--time-limit", flags.time_limit, "Wall-clock limit of the whole command")
      ->type_name("SECONDS")
      ->check(kPositive);
  command
      .add_option("--json", flags.json,
                  "Write the summary as JSON; '-' is standard output, with nothing else on it")
      ->type_name("FILE");
}

void add_solver_flags(CLI::App& command, SolverFlags& flags) {
  command.add_option("--solver", flags.name, "Solver; see `bipot list solvers`")->type_name("NAME");
  command.add_option("--tol", flags.tol, "Tolerance of the stop test")->check(kPositive);
  command.add_option("--stop", flags.stop, "Stop test: guarded, raw42 or impulse");
  command.add_option("--max-iterations", flags.max_iterations, "Iteration limit of one solve")
      ->check(CLI::NonNegativeNumber);
  // One flag a name; solvers that share it are listed with what it means to them.
  struct Meaning {
    std::string_view help;
    std::vector<std::string> solvers;
  };
  std::map<std::string_view, std::vector<Meaning>> flags_by_name;
  for (const SolverEntry& entry : solver_table()) {
    for (const ParameterSpec& spec : entry.parameters) {
      std::vector<Meaning>& meanings = flags_by_name[spec.name];
      auto at = std::find_if(meanings.begin(), meanings.end(),
                             [&](const Meaning& m) { return m.help == spec.help; });
      if (at == meanings.end()) at = meanings.insert(meanings.end(), {spec.help, {}});
      at->solvers.emplace_back(entry.name);
    }
  }
  for (const auto& [name, meanings] : flags_by_name) {
    std::string flag = "--" + std::string(name);
    std::replace(flag.begin(), flag.end(), '_', '-');
    std::string help;
    for (const Meaning& m : meanings) {
      help +=
          fmt::format("{}[{}] {}", help.empty() ? "" : "; ", fmt::join(m.solvers, ", "), m.help);
    }
    command
        .add_option_function<std::string>(
            flag,
            [&flags, key = std::string(name)](const std::string& value) {
              flags.parameters[key] = value;
            },
            help)
        ->group("Solver parameters");
  }
}

void add_warm_start_flags(CLI::App& command, SolverFlags& flags) {
  command.add_flag_callback(
      "--warm-start", [&flags] { flags.warm_start = true; },
      "Start each step from the impulses of the step before");
  command.add_flag_callback(
      "--no-warm-start", [&flags] { flags.warm_start = false; }, "Start each step from s = 0");
}

SolverChoice merged(const SolverChoice& base, const SolverFlags& flags) {
  SolverChoice choice = base;
  if (flags.name) {
    if (*flags.name != choice.name) choice.parameters.clear();
    choice.name = *flags.name;
  }
  if (flags.tol) choice.tol = *flags.tol;
  if (flags.stop) choice.stop = *flags.stop;
  if (flags.max_iterations) choice.max_iterations = *flags.max_iterations;
  if (flags.warm_start) choice.warm_start = *flags.warm_start;
  for (const auto& [name, value] : flags.parameters) choice.parameters[name] = value;
  return choice;
}

}  // namespace bipot
