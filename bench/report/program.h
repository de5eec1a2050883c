#pragma once

#include <string>
#include <vector>

namespace bipot {

/// Runs another program, found on the path, with `input` on its standard input, and returns its
/// standard output. Throws FileError with the program's own text if it fails, with `purpose` if it
/// is not there, and if it takes longer than `patience` seconds; Interrupted if an end is asked for.
std::string run_program(std::vector<std::string> words, const std::string& input,
                        const std::string& purpose, double patience);

/// Runs gnuplot with the script on its standard input, without the user's settings, and returns its
/// standard output. Throws FileError, with gnuplot's own text, if it cannot be run or refuses the
/// script.
std::string run_gnuplot(const std::string& script);

}  // namespace bipot
