#include <fmt/format.h>

#include <string>

#include "bench/command/commands.h"
#include "bench/page/run_movie.h"
#include "core/base/interrupt.h"

namespace bipot {
namespace {

struct MovieFlags {
  std::string run;   ///< folder or run.h5
  std::string file;  ///< of the movie; empty: movie.mp4 in the folder
  int frames_a_second = 30;
};

CommandDeclaration add_movie(CommandLine& line, MovieFlags& flags) {
  CommandDeclaration command =
      line.add_command("movie", "Make an mp4 or a gif of a run, by the program ffmpeg");
  command.option("run", flags.run, "Run, finished or interrupted (folder or run.h5)",
                 {.required = true});
  command.option("--file FILE", flags.file,
                 "Name that ends with .mp4 or .gif (default: movie.mp4 in the folder)");
  command.option("--frames-a-second N", flags.frames_a_second, "Speed of the movie",
                 {.show_default = true, .between = {{1, 120}}});
  command.footer(
      "Examples:\n"
      "  bipot movie out/drum\n"
      "  bipot movie out/drum --file drum.gif --frames-a-second 25");
  return command;
}

int run_movie(const MovieFlags& flags) {
  const InterruptGuard interrupt;
  const auto file = write_run_movie(flags.run, flags.file, flags.frames_a_second);
  fmt::print("{}\n", file.string());
  return kExitConverged;
}

}  // namespace

ProgramCommand movie_command(CommandLine& line) {
  return make_command(line, &add_movie, &run_movie);
}

}  // namespace bipot
