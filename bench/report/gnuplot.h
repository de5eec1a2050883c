#pragma once

#include <string>

namespace bipot {

/// Runs gnuplot with the script on its standard input, without the user's settings, and returns its
/// standard output. Throws FileError, with gnuplot's own text, if it cannot be run or refuses the
/// script.
std::string run_gnuplot(const std::string& script);

}  // namespace bipot
