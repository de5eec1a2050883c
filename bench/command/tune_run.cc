#include "bench/command/tune_run.h"

#include <fmt/format.h>

#include <stdexcept>

#include "bench/command/command_options.h"
#include "bench/command/exit_code.h"
#include "bench/command/say.h"
#include "bench/command/watched.h"
#include "bench/report/document.h"
#include "bench/report/json_output.h"
#include "bench/tune/tuned_plan.h"
#include "core/files/atomic_file.h"

namespace bipot {

std::filesystem::path default_plan_file(const std::vector<std::string>& targets) {
  const std::filesystem::path first = targets.size() == 1 ? targets.front() : "";
  const bool scene = first.filename().string().find(".toml") != std::string::npos;
  return scene ? first.parent_path() / "plan.toml" : "plan.toml";
}

int tune_targets(const std::vector<std::string>& targets, TargetOptions scenes,
                 MeasureOptions options, int least_rows, const std::filesystem::path& plan,
                 bool quiet) {
  if (plan.has_parent_path()) {
    std::error_code failure;  // told by what is written
    std::filesystem::create_directories(plan.parent_path(), failure);
  }
  require_writable(plan.string());
  if (options.file.empty()) {
    options.file = plan;
    options.file.replace_extension(".csv");
  }
  std::vector<NamedFile> read;
  for (const std::string& target : targets) {
    read.push_back({"a target", target.substr(0, target.find(':', target.find(".toml")))});
  }
  require_apart({{"--out", plan.string()}, {"--rows", options.file.string()}}, read);
  options.warn = &warn_once;
  if (!quiet) scenes.warn = &warn_once;
  const std::vector<ProblemSource> sources = expand_targets(targets, scenes);
  const auto no_rows = [&] {
    return std::invalid_argument(
        options.file.string() +
        (sources.empty() ? " has no rows: name targets, whose solves are measured"
                         : " has no rows: nothing touches in the targets, or their runs fail"));
  };
  if (sources.empty() && !std::filesystem::exists(options.file)) throw no_rows();
  const std::size_t known = read_measured_rows(options.file).size();
  const std::vector<MeasuredRow> rows = watched(quiet, [&, options](const Watch& watch) mutable {
    options.watch = watch;
    return measure_rows(sources, options);
  });
  if (InterruptGuard::requested()) {
    say("bipot: stopped; the same command goes on from {}\n", options.file.string());
    return kExitInterrupted;
  }
  if (rows.empty()) throw no_rows();
  const TunedPlan made = tune_plan(rows, options.variants, least_rows);
  if (made.classes.empty()) {
    say("bipot: {}: none of the solvers for a plan solved any problem\n", options.file.string());
    return kExitNotConverged;
  }
  const std::string commit = provenance("tune", typed_command()).build.commit;
  write_text_file(plan.string(),
                  plan_text(made, fmt::format("# {}\n# {} rows; commit {}\n", typed_command(),
                                              rows.size(), commit)));
  if (!quiet) {
    fmt::print("{}\n{} class{} in {}, {} rows in {}, {} of them from before\n", regret_text(made),
               made.classes.size(), made.classes.size() == 1 ? "" : "es", plan.string(),
               rows.size(), options.file.string(), known);
  }
  return kExitConverged;
}

}  // namespace bipot
