#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/command/command_options.h"
#include "bench/command/commands.h"
#include "bench/command/watched.h"
#include "bench/experiments/validation_report.h"
#include "core/base/nearest_name.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

struct ValidateFlags : OutputFlags {
  std::vector<std::string> only;
  Experiment::Context context;
};

/// True if a row was requested, by its name or the beginning of it.
bool asked_for(const ValidateFlags& flags, const ValidationRow& row) {
  return flags.only.empty() || std::ranges::any_of(flags.only, [&](const std::string& name) {
           return row.claim.name.starts_with(name);
         });
}

std::vector<Experiment> chosen_experiments(const ValidateFlags& flags) {
  std::vector<Experiment> all = validation_experiments();
  std::vector<std::string> names, quick_names;
  for (const Experiment& e : all) {
    for (const ValidationRow& row : e.rows) {
      names.push_back(row.claim.name);
      if (!e.quick_tols.empty()) quick_names.push_back(row.claim.name);
    }
  }
  const auto begins_none = [](const std::vector<std::string>& of, const std::string& wanted) {
    return std::ranges::none_of(of,
                                [&](const std::string& name) { return name.starts_with(wanted); });
  };
  for (const std::string& wanted : flags.only) {
    if (begins_none(names, wanted)) {
      throw std::invalid_argument(unknown_name_message("row", wanted, names));
    }
    if (flags.context.quick && begins_none(quick_names, wanted)) {
      throw std::invalid_argument(wanted + " has no short form: leave out --quick");
    }
  }
  std::erase_if(all, [&](const Experiment& e) {
    return (flags.context.quick && e.quick_tols.empty()) ||
           std::ranges::none_of(e.rows,
                                [&](const ValidationRow& row) { return asked_for(flags, row); });
  });
  return all;
}

CommandDeclaration add_validate(CommandLine& line, ValidateFlags& flags) {
  CommandDeclaration command = line.add_command(
      "validate", "Physics that is known beforehand, checked: at which tolerance does it break?");
  command.option("--only NAMES", flags.only,
                 "Rows, or how their names begin, separated by commas (default: all)");
  command.flag("--quick", flags.context.quick,
               "Fewer bodies, seeds and tolerances: seconds instead of up to half an hour");
  command.option("--solver", flags.context.solver, "Of every step, without islands",
                 {.show_default = true, .suggest = solver_names()});
  command.option("--max-iterations", flags.context.max_iterations, "Of a step",
                 {.show_default = true, .positive = true});
  add_output_flags(
      command, flags,
      "Folder for index.html, validate.json, validate.csv, verdicts.csv, charts and their data");
  command.footer(
      "Each row has its source, the expected value, what is measured at several tolerances, the\n"
      "error bar, and the loosest tolerance from which on it is right to 1 %.\n"
      "Ends with 1 when a row is refuted at the tightest tolerance: off by more than two error bars\n"
      "and what is allowed, or without a value. With 0 otherwise (between, a row is undecided).\n"
      "Examples:\n"
      "  bipot validate --quick --out out/validate\n"
      "  bipot validate --only disk,four_spheres\n"
      "  bipot validate --only shear --solver ipm");
  return command;
}

int run_validate(const ValidateFlags& flags) {
  const InterruptGuard interrupt;
  require_solver(flags.context.solver);
  const std::vector<Experiment> experiments = chosen_experiments(flags);
  flags.prepare(true);
  ValidationPage page{
      .command = typed_command(), .solver = flags.context.solver, .quick = flags.context.quick};
  watched(flags.silent(), [&](const Watch& watch) {
    Experiment::Context context = flags.context;
    context.stopped = watch.interrupted;
    long total = 0, done = 0;
    for (const Experiment& e : experiments) {
      total += static_cast<long>(flags.context.quick ? e.quick_tols.size() : e.tols.size());
    }
    for (const Experiment& e : experiments) {
      Experiment::Result result =
          run_experiment(e, context, [&] { watch.tell(done++, total, e.rows.front().claim.name); });
      // An interrupted measurement would only seem to fail.
      page.complete = result.complete;
      if (!page.complete) return;
      std::erase_if(result.rows, [&](const ValidationRow& row) { return !asked_for(flags, row); });
      page.add(std::move(result));
    }
    watch.tell(total, total, "");
  });
  if (!flags.out.empty()) write_validation(flags.out, page);
  flags.deliver(to_json(to_report(page)), to_text(page),
                (std::filesystem::path(flags.out) / "index.html").string());
  if (!page.complete) return kExitInterrupted;
  return page.failed() == 0 ? kExitConverged : kExitNotConverged;
}

}  // namespace

ProgramCommand validate_command(CommandLine& line) {
  return make_command(line, &add_validate, &run_validate);
}

}  // namespace bipot
