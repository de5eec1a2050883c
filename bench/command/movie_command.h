#pragma once

#include <string>

#include "bench/command/command_line.h"

namespace bipot {

struct MovieFlags {
  std::string run;   ///< folder or run.h5
  std::string file;  ///< of the movie; empty: movie.mp4 in the folder
  int frames_a_second = 30;
};

/// Declares `bipot movie`.
CommandDeclaration add_movie_command(CommandLine& line, MovieFlags& flags);

/// Makes a movie of a run. Returns an ExitCode.
int movie_command(const MovieFlags& flags);

}  // namespace bipot
