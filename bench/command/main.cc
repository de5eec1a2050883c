// The `bipot` command.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <stdexcept>

#include "bench/command/advise_command.h"
#include "bench/command/compare_command.h"
#include "bench/command/exit_code.h"
#include "bench/command/list_command.h"
#include "bench/command/paper_command.h"
#include "bench/command/run_command.h"
#include "bench/command/solve_command.h"
#include "bench/command/trade_command.h"
#include "bench/report/json_output.h"
#include "core/file_error.h"
#include "core/files/scene_file.h"

int main(int argc, char** argv) {
  using namespace bipot;
  CLI::App app{"Frictional contact of rigid disks: one problem, many solvers, one error measure."};
  app.name("bipot");
  app.set_version_flag("--version", "bipot " BIPOT_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 every solve met its tolerance; 1 some did not; 2 bad input; 3 numerical\n"
      "failure; 4 a file could not be read or written; 5 interrupted.\n"
      "Examples:\n"
      "  bipot run compaction --out out/compaction\n"
      "  bipot run scene.toml --solver uzawa --rho paper --tol 1e-4\n"
      "  bipot solve problem.hdf5 --solver pgs --json -\n"
      "  bipot advise scene.toml --force-error 1e-2 --write advised.toml\n"
      "  bipot compare square:30 pile:18 --quick --out out/compare\n"
      "  bipot paper --out out/paper\n"
      "  bipot trade my_scene.toml --out out/trade\n"
      "  bipot list solvers");
  RunFlags run_flags;
  SolveFlags solve_flags;
  CompareFlags compare_flags;
  AdviseFlags advise_flags;
  PaperFlags paper_flags;
  TradeFlags trade_flags;
  ListFlags list_flags;
  const CLI::App* run = add_run_command(app, run_flags);
  const CLI::App* solve = add_solve_command(app, solve_flags);
  const CLI::App* compare = add_compare_command(app, compare_flags);
  const CLI::App* advise = add_advise_command(app, advise_flags);
  const CLI::App* paper = add_paper_command(app, paper_flags);
  const CLI::App* trade = add_trade_command(app, trade_flags);
  add_list_command(app, list_flags);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kExitConverged : kExitBadInput;
  }
  const auto refuse = [&](const char* message, ExitCode code) {
    fmt::print(stderr, "bipot: {}\n", message);
    // Whoever reads the JSON learns of it there as well.
    const std::string destination = run->parsed()      ? run_flags.common.json
                                    : solve->parsed()  ? solve_flags.common.json
                                    : advise->parsed() ? advise_flags.json
                                    : trade->parsed()  ? trade_flags.json
                                    : paper->parsed()  ? paper_flags.json
                                                       : std::string();
    if (!destination.empty()) {
      try {
        write_json({{"command", app.get_subcommands().front()->get_name()},
                    {"version", BIPOT_VERSION},
                    {"status", code == kExitIo         ? "input or output failed"
                               : code == kExitBadInput ? "invalid input"
                                                       : "numerical failure"},
                    {"message", message},
                    {"exit_code", static_cast<int>(code)}},
                   destination);
      } catch (const std::exception& e) {
        fmt::print(stderr, "bipot: {}\n", e.what());
      }
    }
    return code;
  };
  try {
    if (run->parsed()) return run_command(run_flags);
    if (solve->parsed()) return solve_command(solve_flags);
    if (compare->parsed()) return compare_command(compare_flags);
    if (advise->parsed()) return advise_command(advise_flags);
    if (paper->parsed()) return paper_command(paper_flags);
    if (trade->parsed()) return trade_command(trade_flags);
    return list_command(list_flags);
  } catch (const FileError& e) {
    return refuse(e.what(), kExitIo);
  } catch (const std::invalid_argument& e) {
    return refuse(e.what(), kExitBadInput);
  } catch (const SceneFileError& e) {
    return refuse(e.what(), kExitBadInput);
  } catch (const std::exception& e) {
    return refuse(e.what(), kExitNumericalFailure);
  }
}
