#include <fmt/format.h>

#include <string>

#include "bench/command/commands.h"
#include "bench/page/run_page.h"

namespace bipot {
namespace {

struct PageFlags {
  std::string run;  ///< folder or run.h5
};

CommandDeclaration add_page(CommandLine& line, PageFlags& flags) {
  CommandDeclaration command =
      line.add_command("page", "Write index.html, which plays a run, into the run's folder");
  command.option("run", flags.run, "Run, finished or interrupted (folder or run.h5)",
                 {.required = true});
  command.footer(
      "The page is one file: a browser shows it without a network.\n"
      "Examples:\n"
      "  bipot page out/compaction");
  return command;
}

int run_page(const PageFlags& flags) {
  const RunPage page = write_run_page(flags.run);
  fmt::print("{}: {} frames, {:.1f} MB\n", page.path.string(), page.frames,
             1e-6 * static_cast<double>(page.bytes));
  return kExitConverged;
}

}  // namespace

ProgramCommand page_command(CommandLine& line) { return make_command(line, &add_page, &run_page); }

}  // namespace bipot
