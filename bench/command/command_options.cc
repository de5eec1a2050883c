#include "bench/command/command_options.h"

#include <algorithm>
#include <set>
#include <string_view>

#include "solvers/registry.h"

namespace bipot {
namespace {

/// Of the flags in the help.
constexpr const char* kSolverGroup =
    "Solver (its parameters are flags too: bipot list solvers NAME)";

}  // namespace

void add_threads_flag(CommandDeclaration& command, int& threads) {
  command.option("--threads", threads, "Threads; every result has the same bits for any number")
      .value_name("N")
      .between(1, 1024);
}

void add_common_flags(CommandDeclaration& command, CommonFlags& flags) {
  command.option("--time-limit", flags.time_limit, "Wall-clock limit of the whole command")
      .value_name("SECONDS")
      .positive();
  add_threads_flag(command, flags.threads);
  command.flag("--quiet,-q", flags.quiet, "No progress, no summary on the terminal");
  command.option("--out", flags.out, "Folder for the results").value_name("DIR").group("Results");
  command
      .option("--json", flags.json,
              "Write the summary as JSON; '-': standard output, with nothing else")
      .value_name("FILE")
      .group("Results");
}

void add_reproducible_flag(CommandDeclaration& command, bool& reproducible) {
  command.flag("--reproducible", reproducible,
               "Exact sums: the same bits for any number of processes");
}

void add_solver_flags(CommandDeclaration& command, SolverFlags& flags) {
  command.option("--solver", flags.name, "One of `bipot list solvers`")
      .value_name("NAME")
      .group(kSolverGroup);
  command.option("--tol", flags.tol, "Tolerance of the stop test")
      .value_name("NUMBER")
      .positive()
      .group(kSolverGroup);
  command.option("--stop", flags.stop, "Stop test: guarded, raw42 or impulse")
      .value_name("NAME")
      .group(kSolverGroup);
  command.option("--max-iterations", flags.max_iterations, "Iteration limit of one solve")
      .value_name("N")
      .not_negative()
      .group(kSolverGroup);
  // One flag for each name, whichever solvers have it; `bipot list solvers NAME` explains it.
  std::set<std::string_view> names{kIslandsParameter.name};
  for (const SolverEntry& entry : solver_table()) {
    for (const ParameterSpec& spec : entry.parameters) names.insert(spec.name);
  }
  for (const std::string_view name : names) {
    const auto keep = [&flags, key = std::string(name)](const std::string& value) {
      flags.parameters[key] = value;
    };
    command.option(parameter_flag(name), keep, "").hidden();
  }
}

std::string parameter_flag(std::string_view name) {
  std::string flag = "--" + std::string(name);
  std::replace(flag.begin(), flag.end(), '_', '-');
  return flag;
}

void add_warm_start_flags(CommandDeclaration& command, SolverFlags& flags) {
  command
      .flag(
          "--warm-start", [&flags] { flags.warm_start = true; },
          "Start each step from the impulses of the step before")
      .group(kSolverGroup);
  command
      .flag(
          "--no-warm-start", [&flags] { flags.warm_start = false; }, "Start each step from s = 0")
      .group(kSolverGroup);
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
