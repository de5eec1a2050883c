#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/command/command_options.h"
#include "bench/command/commands.h"
#include "bench/command/say.h"
#include "bench/command/watched.h"
#include "bench/compare/leaderboard_report.h"
#include "bench/problems/scene_catalogue.h"
#include "core/files/atomic_file.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

struct LeaderboardFlags : OutputFlags {
  std::vector<std::string> folders;
  std::vector<std::string> problems = {(data_folder() / "problems").string()};
  Leaderboard::Ours ours = {.solvers = {"auto"}};
  bool no_solvers = false;
};

CommandDeclaration add_leaderboard(CommandLine& line, LeaderboardFlags& flags) {
  CommandDeclaration command =
      line.add_command("leaderboard", "Judge impulses of anybody for many problems, on one page");
  command.option(
      "folders", flags.folders,
      "Folder of a contestant: PROBLEM.npy, .csv or .hdf5 for each problem, and times.csv "
      "with lines problem,seconds",
      {.required = true});
  command.option(
      "--problems FILES", flags.problems,
      "Problem files, folders of them, or other targets of compare (the shipped problems)");
  command.option("--solvers NAMES", flags.ours.solvers, "Solvers of this program that take part",
                 {.show_default = true});
  command.flag("--no-solvers", flags.no_solvers, "None of them does");
  command.option("--tol NUMBER", flags.ours.tol, "Their tolerance",
                 {.show_default = true, .positive = true});
  command.option("--time-limit SECONDS", flags.ours.time_limit,
                 "CPU seconds of one of their solves", {.show_default = true, .positive = true});
  add_output_flags(command, flags, "Folder for leaderboard.csv and index.html");
  command.footer("Example:\n  bipot leaderboard mine/ theirs/ --out out/leaderboard");
  return command;
}

int run_leaderboard(const LeaderboardFlags& flags) {
  const InterruptGuard interrupt;
  require_solvers(flags.ours.solvers);
  if (flags.no_solvers && flags.ours.solvers != LeaderboardFlags().ours.solvers) {
    throw std::invalid_argument("--solvers has no effect with --no-solvers");
  }
  const std::vector<ProblemSource> problems = expand_targets(flags.problems);
  flags.prepare(true);
  const Leaderboard board = watched(flags.silent(), [&](const Watch& watch) {
    Leaderboard::Ours ours = flags.ours;
    if (flags.no_solvers) ours.solvers.clear();
    ours.watch = watch;
    return make_leaderboard({flags.folders.begin(), flags.folders.end()}, problems, ours);
  });
  const Document summary = leaderboard_document(board, provenance("leaderboard", typed_command()));
  Document page = summary;
  page.fold("All impulses", leaderboard_rows(board), "rows");
  if (!flags.out.empty()) {
    const fs::path folder = flags.out;
    write_text_file(folder / "leaderboard.csv", to_csv(leaderboard_rows(board)));
    write_text_file(folder / "index.html", to_html(page));
  }
  flags.deliver(to_json(page), to_text(summary));
  for (const Leaderboard::Entry& e : board.entries) {
    if (!e.defect.empty() && e.defect != Leaderboard::Entry::kNoImpulse) {
      say("bipot: {}, {}: {}\n", e.who, e.problem, e.defect);
    }
  }
  return board.complete ? kExitConverged : kExitInterrupted;
}

}  // namespace

ProgramCommand leaderboard_command(CommandLine& line) {
  return make_command(line, &add_leaderboard, &run_leaderboard);
}

}  // namespace bipot
