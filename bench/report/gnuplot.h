#pragma once

#include <string>

namespace bipot {

/// Runs gnuplot with the script on its standard input, without the user's settings, and returns
/// what it writes to standard output. Throws FileError, in gnuplot's own words, when it cannot be
/// run or refuses the script.
std::string run_gnuplot(const std::string& script);

}  // namespace bipot
