
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/command/command_options.h"
#include "bench/command/commands.h"
#include "bench/command/watched.h"
#include "bench/study/study.h"
#include "core/base/file_error.h"
#include "core/base/nearest_name.h"
#include "core/files/atomic_file.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

struct StudyFlags : OutputFlags {
  StudyFlags() { out = "out/study"; }

  std::vector<std::string> only;
  std::string rows;
  bool quick = false, draw = false;
};

CommandDeclaration add_study(CommandLine& line, StudyFlags& flags) {
  CommandDeclaration command = line.add_command(
      "study", "How exact must a contact solver be? Measures, and draws data/study anew");
  const std::vector<std::string> parts = names_of(Study::parts());
  command.option("--only PARTS", flags.only, "Parts, separated by commas (all)", {.one_of = parts});
  command.flag("--quick", flags.quick, "Small scenes, few seeds: minutes instead of hours");
  command.option("--rows FILE", flags.rows,
                 "CSV of the measurements, added to; those that are there are kept (DIR/rows.csv)");
  command.flag("--draw", flags.draw, "Measures nothing: figures and tables of the rows there are");
  add_output_flags(command, flags,
                   "Folder for index.html, figures, their data and rows.csv (out/study)");
  command.footer(
      "A stopped measurement goes on from its rows.\n"
      "Examples:\n"
      "  bipot study --quick\n"
      "  bipot study --only depth --out out/depth\n"
      "  bipot study --rows data/study/rows.csv --draw");
  return command;
}

int run_study(const StudyFlags& flags) {
  if (flags.draw && flags.quick) {
    throw std::invalid_argument("--quick has no effect with --draw, which measures nothing");
  }
  flags.prepare(true);
  const fs::path folder = flags.out;
  const fs::path rows = flags.rows.empty() ? folder / "rows.csv" : fs::path(flags.rows);
  std::vector<Study::Part> parts;
  for (const Study::Part& part : Study::parts()) {
    if (flags.only.empty() || std::ranges::find(flags.only, part.name) != flags.only.end()) {
      parts.push_back(part);
    }
  }
  bool complete = true;
  if (!flags.draw) {
    std::vector<Study::Job> jobs;
    for (const Study::Part& part : parts) {
      for (Study::Job& job : part.jobs(flags.quick)) jobs.push_back(std::move(job));
    }
    complete = watched(flags.silent(),
                       [&](const Watch& watch) { return Study::measure(rows, jobs, watch); });
  }
  if (flags.draw && !fs::exists(rows)) throw FileError(rows, "", "No such file or directory");
  const Study::Measured measured = Study::read(rows);
  Document page{.title = "How exact must a contact solver be?",
                .made = provenance("study", typed_command()),
                .contents = true};
  if (!complete) page.say("**Interrupted: rows are missing. The same command goes on.**");
  bool empty = true;
  for (const Study::Part& part : parts) {
    const bool any = std::ranges::any_of(
        measured, [&](const auto& entry) { return entry.first.part == part.name; });
    if (!any) continue;
    empty = false;
    page.heading(part.title, part.name);
    page.append(part.report(measured));
  }
  if (flags.draw && empty) throw FileError(rows, "", "has no measurements of these parts");
  write_figures(folder, page);
  write_text_file(folder / "index.html", to_html(page));
  Json json = to_json(page);
  json["complete"] = complete;
  flags.deliver(json, to_text(page), (folder / "index.html").string());
  return complete ? kExitConverged : kExitInterrupted;
}

}  // namespace

ProgramCommand study_command(CommandLine& line) {
  return make_command(line, &add_study, &run_study);
}

}  // namespace bipot
