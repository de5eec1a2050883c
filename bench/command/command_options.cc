#include "bench/command/command_options.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>
#include <system_error>

#include "bench/command/say.h"
#include "bench/report/chart.h"
#include "bench/report/json_output.h"
#include "solvers/auto/plan.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

/// Of the flags in the help.
constexpr const char* kSolverGroup =
    "Solver (its parameters are flags too: bipot list solvers NAME)";

}  // namespace

void warn_once(const std::string& text) {
  static std::set<std::string> said;
  if (!text.empty() && said.insert(text).second) say("bipot: warning: {}\n", text);
}

void OutputFlags::prepare(bool charts) const {
  if (!out.empty()) {
    if (charts) require_plotting_tool();
    std::error_code failure;
    std::filesystem::create_directories(out, failure);
    if (failure) throw FileError(out, "", "cannot create: " + failure.message());
  }
  require_writable(json);
}

void OutputFlags::deliver(const Json& results, const std::string& text,
                          const std::string& place) const {
  if (!json.empty()) write_json(results, json);
  if (silent()) return;
  fmt::print("{}", text);
  if (!out.empty() && !place.empty()) fmt::print("{}\n", place);
}

void add_output_flags(CommandDeclaration& command, OutputFlags& flags,
                      const std::string& folder_help) {
  if (!folder_help.empty()) {
    command.option("--out DIR", flags.out, folder_help, {.group = "Results"});
  }
  command.option("--json FILE", flags.json,
                 "Write the results as JSON; '-': standard output, with nothing else",
                 {.group = "Results"});
  command.flag("--quiet,-q", flags.quiet, "No progress, no summary on the terminal");
}

void add_threads_flag(CommandDeclaration& command, int& threads) {
  command.option("--threads N", threads, "Threads; every result has the same bits for any number",
                 {.between = {{1, 1024}}});
}

void add_common_flags(CommandDeclaration& command, CommonFlags& flags,
                      const std::string& folder_help) {
  command.option("--time-limit SECONDS", flags.time_limit, "Wall-clock limit of the whole command",
                 {.positive = true});
  add_threads_flag(command, flags.threads);
  add_output_flags(command, flags, folder_help);
}

void add_reproducible_flag(CommandDeclaration& command, bool& reproducible) {
  command.flag("--reproducible", reproducible,
               "Exact sums: the same bits for any number of processes");
}

void add_solver_flags(CommandDeclaration& command, SolverFlags& flags) {
  command.option("--solver NAME", flags.name,
                 "One of `bipot list solvers` (the scene's, else auto)",
                 {.group = kSolverGroup, .suggest = all_solver_names()});
  command.option("--tol NUMBER", flags.tol, "Tolerance of the stop test (the scene's, else 1e-8)",
                 {.group = kSolverGroup, .positive = true});
  command.option("--stop NAME", flags.stop, "Stop test: guarded, raw42 or impulse",
                 {.group = kSolverGroup, .suggest = {"guarded", "raw42", "impulse"}});
  command.option("--max-iterations N", flags.max_iterations, "Iteration limit of one solve",
                 {.group = kSolverGroup, .not_negative = true});
  // One flag for each name, whichever solvers have it; `bipot list solvers NAME` explains it.
  std::set<std::string_view> names{kIslandsParameter.name};
  for (const SolverEntry& entry : solver_table()) {
    for (const ParameterSpec& spec : entry.parameters) names.insert(spec.name);
  }
  for (const std::string_view name : names) {
    const std::function<void(const std::string&)> keep =
        [&flags, key = std::string(name)](const std::string& value) {
          flags.parameters[key] = value;
        };
    command.option(parameter_flag(name), keep, "", {.group = ""});
  }
}

std::string parameter_flag(std::string_view name) {
  std::string flag = "--" + std::string(name);
  std::ranges::replace(flag, '_', '-');
  return flag;
}

void add_warm_start_flags(CommandDeclaration& command, SolverFlags& flags) {
  command.flag("--warm-start", [&flags] { flags.warm_start = true; },
               "Start each step from the impulses of the step before", {.group = kSolverGroup});
  command.flag("--no-warm-start", [&flags] { flags.warm_start = false; },
               "Start each step from s = 0", {.group = kSolverGroup});
}

SolverChoice merged(const SolverChoice& base, const SolverFlags& flags) {
  SolverChoice choice = base;
  if (flags.name) {
    if (*flags.name != choice.name) choice.parameters.clear();
    choice.name = *flags.name;
  }
  if (flags.tol) choice.tol = *flags.tol;
  if (flags.stop) choice.stop = *flags.stop;
  if (flags.max_iterations) {
    choice.max_iterations = *flags.max_iterations;
    choice.limits_iterations = true;
  }
  if (flags.warm_start) choice.warm_start = *flags.warm_start;
  for (const auto& [name, value] : flags.parameters) choice.parameters[name] = value;
  if (const auto plan = choice.parameters.find("plan");
      choice.name == "auto" && plan != choice.parameters.end() && !plan->second.empty()) {
    readable(plan->second, [&] { return read_plan(plan->second); });
  }
  return choice;
}

}  // namespace bipot
