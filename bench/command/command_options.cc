#include "bench/command/command_options.h"

#include <algorithm>
#include <set>
#include <string_view>

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

/// Of the flags in the help.
constexpr const char* kSolverGroup =
    "Solver (its parameters are flags too: bipot list solvers NAME)";

}  // namespace

void add_threads_flag(CLI::App& command, int& threads) {
  command
      .add_option("--threads", threads, "Threads; every result has the same bits for any number")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
}

void add_common_flags(CLI::App& command, CommonFlags& flags) {
  command.add_option("--time-limit", flags.time_limit, "Wall-clock limit of the whole command")
      ->type_name("SECONDS")
      ->check(kPositive);
  add_threads_flag(command, flags.threads);
  command.add_flag("--quiet,-q", flags.quiet, "No progress, no summary on the terminal");
  command.add_option("--out", flags.out, "Folder for the results")
      ->type_name("DIR")
      ->group("Results");
  command
      .add_option("--json", flags.json,
                  "Write the summary as JSON; '-': standard output, with nothing else")
      ->type_name("FILE")
      ->group("Results");
}

void add_solver_flags(CLI::App& command, SolverFlags& flags) {
  command.add_option("--solver", flags.name, "One of `bipot list solvers`")
      ->type_name("NAME")
      ->group(kSolverGroup);
  command.add_option("--tol", flags.tol, "Tolerance of the stop test")
      ->type_name("NUMBER")
      ->check(kPositive)
      ->group(kSolverGroup);
  command.add_option("--stop", flags.stop, "Stop test: guarded, raw42 or impulse")
      ->type_name("NAME")
      ->group(kSolverGroup);
  command.add_option("--max-iterations", flags.max_iterations, "Iteration limit of one solve")
      ->type_name("N")
      ->check(CLI::NonNegativeNumber)
      ->group(kSolverGroup);
  // One flag a name, whichever solvers have it; `bipot list solvers NAME` says what it means.
  std::set<std::string_view> names;
  for (const SolverEntry& entry : solver_table()) {
    for (const ParameterSpec& spec : entry.parameters) names.insert(spec.name);
  }
  for (const std::string_view name : names) {
    command
        .add_option_function<std::string>(
            parameter_flag(name), [&flags, key = std::string(name)](
                                      const std::string& value) { flags.parameters[key] = value; })
        ->group("");  // not in the help
  }
}

std::string parameter_flag(std::string_view name) {
  std::string flag = "--" + std::string(name);
  std::replace(flag.begin(), flag.end(), '_', '-');
  return flag;
}

void add_warm_start_flags(CLI::App& command, SolverFlags& flags) {
  command
      .add_flag_callback(
          "--warm-start", [&flags] { flags.warm_start = true; },
          "Start each step from the impulses of the step before")
      ->group(kSolverGroup);
  command
      .add_flag_callback(
          "--no-warm-start", [&flags] { flags.warm_start = false; }, "Start each step from s = 0")
      ->group(kSolverGroup);
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
