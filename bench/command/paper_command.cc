#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/command/command_options.h"
#include "bench/command/commands.h"
#include "bench/command/progress_bar.h"
#include "bench/experiments/claim_report.h"
#include "bench/experiments/paper_item.h"
#include "bench/measure/stopwatch.h"
#include "bench/report/build_info.h"
#include "core/base/file_error.h"
#include "core/base/interrupt.h"
#include "core/base/nearest_name.h"

namespace bipot {
namespace {

struct PaperFlags : OutputFlags {
  PaperFlags() { out = "out/paper"; }

  std::vector<std::string> only;
  bool quick = false;
};

namespace fs = std::filesystem;

constexpr const char* kTitle = "The paper's figures and tables, made again and checked";
constexpr const char* kIntroduction =
    "The paper is Fortin, Hjiaj and de Saxcé, An improved discrete element method based on a "
    "variational formulation of the frictional contact law, Computers and Geotechnics 29 (2002) "
    "609–640; numbers in parentheses are its equations. Each section says what the paper reports, "
    "then what this program finds. ε is the guarded error in the contact law (the larger of the "
    "guarded (42) and the natural map in energy) unless a text says raw (42). Every number of this "
    "page, and the points of every chart, stand in [results.json](results.json) beside it.";

ClaimReport::Item run_item(const PaperItem& item, const PaperItem::Context& context,
                           const std::string& command) {
  ClaimReport::Item entry{.name = std::string(item.name),
                          .title = std::string(item.title),
                          .command = command,
                          .quick = context.quick,
                          .build = build_info(),
                          .date = date_and_time()};
  const Stopwatch wall;
  const CpuStopwatch cpu;
  try {
    Findings result = item.run(context);
    if (context.interrupted()) {
      entry.status = ClaimReport::Item::Status::kInterrupted;
    } else {
      complete(result, command);
      for (const Findings::Figure& f : result.figures) {
        if (f.chart) {
          write_chart_files(context.out, f.name, *f.chart);
        } else if (!fs::is_regular_file(context.out / f.file)) {
          throw std::logic_error(fmt::format("figure {}: no file {}", f.name, f.file));
        }
      }
      entry.result = std::move(result);
      entry.status = ClaimReport::Item::Status::kDone;
    }
  } catch (const FileError&) {
    throw;  // no other item could write either
  } catch (const std::exception& e) {
    // A step cut short by Ctrl-C ends its item with an exception, too.
    const bool interrupted = context.interrupted();
    entry.status =
        interrupted ? ClaimReport::Item::Status::kInterrupted : ClaimReport::Item::Status::kFailed;
    if (!interrupted) entry.message = e.what();
  }
  entry.wall_seconds = wall.seconds();
  entry.cpu_seconds = cpu.seconds();
  return entry;
}

CommandDeclaration add_paper(CommandLine& line, PaperFlags& flags) {
  CommandDeclaration command = line.add_command(
      "paper", "The paper's figures and tables, made again and checked, as a page");
  command.option(
      "--only NAMES", flags.only,
      fmt::format("Items, separated by commas, of {}", fmt::join(names_of(paper_items()), ", ")));
  command.flag("--quick", flags.quick, "Small sizes, seconds");
  add_output_flags(
      command, flags,
      "Folder for index.html, results.json, pictures and their data (out/paper); items "
      "of an earlier run that are not run now stay");
  command.footer(
      "Ends with 1 when a check is refuted or an item failed; what a short run cannot decide is said.\n"
      "Examples:\n"
      "  bipot paper --out out/paper\n"
      "  bipot paper --only table1,fig10 --quick --json -");
  return command;
}

int run_paper(const PaperFlags& flags) {
  const std::vector<PaperItem>& items = paper_items();
  const std::vector<std::string> names = names_of(items);
  for (const std::string& name : flags.only) require_name("item", name, names);
  const auto chosen = [&](std::string_view name) {
    return flags.only.empty() || std::ranges::find(flags.only, name) != flags.only.end();
  };

  flags.prepare(true);
  const fs::path folder = flags.out;
  ClaimReport report{.command = typed_command(), .title = kTitle, .introduction = kIntroduction};
  const std::vector<ClaimReport::Item> before = read_items(folder / "results.json");
  for (const PaperItem& item : items) {
    ClaimReport::Item entry;
    for (const ClaimReport::Item& old : before) {
      if (old.name == item.name) entry = old;
    }
    entry.name = item.name;
    entry.title = item.title;
    if (entry.command.empty()) entry.command = fmt::format("bipot paper --only {}", item.name);
    report.items.push_back(std::move(entry));
  }

  const long total = static_cast<long>(
      std::ranges::count_if(names, [&](const auto& name) { return chosen(name); }));
  ProgressBar progress(total, flags.silent());
  const InterruptGuard interrupt;
  PaperItem::Context context{
      .out = folder, .quick = flags.quick, .interrupted = &InterruptGuard::requested};
  long done = 0;
  bool sound = true;
  std::string summary;
  for (std::size_t i = 0; i < items.size() && !InterruptGuard::requested(); ++i) {
    const PaperItem& item = items[i];
    if (!chosen(item.name)) continue;
    context.say = [&](const std::string& what) {
      progress.update(done, fmt::format("{}: {}", item.name, what));
    };
    context.say("");
    ClaimReport::Item entry =
        run_item(item, context,
                 fmt::format("bipot paper --only {}{}", item.name, flags.quick ? " --quick" : ""));
    progress.update(++done, "");
    if (entry.status == ClaimReport::Item::Status::kInterrupted) {
      // A result of an earlier run is better than none.
      if (report.items[i].status != ClaimReport::Item::Status::kDone) report.items[i] = entry;
      break;
    }
    sound =
        sound && entry.status == ClaimReport::Item::Status::kDone && entry.held() == entry.checks();
    summary +=
        entry.status == ClaimReport::Item::Status::kDone
            ? fmt::format("{:<11} {:>2} of {:>2} checks hold {:>7.1f} s\n", entry.name,
                          entry.held(), entry.checks(), entry.wall_seconds)
            : fmt::format("{:<11} {}: {}\n", entry.name, to_string(entry.status), entry.message);
    for (const Claim& n : entry.result.claims) {
      if (n.holds.value_or(n.reason.empty())) continue;
      summary += fmt::format("  {}: {}: {}, expected {}\n", n.holds ? "does not hold" : "undecided",
                             n.quantity, measured_text(n), n.expected);
    }
    report.items[i] = std::move(entry);
    write_report(folder, "results.json", report);
  }
  write_report(folder, "results.json", report);
  flags.deliver(to_json(report), summary, (folder / "index.html").string());
  if (InterruptGuard::requested()) return kExitInterrupted;
  return sound ? kExitConverged : kExitNotConverged;
}

}  // namespace

ProgramCommand paper_command(CommandLine& line) {
  return make_command(line, &add_paper, &run_paper);
}

}  // namespace bipot
