#pragma once

namespace bipot {

/// The `bipot` command: reads the arguments, runs the command that they name and returns its
/// ExitCode. Every command reports refusals and failures on standard error and in the file of
/// --json (keys: data/manual/reference/files.md).
int bipot_command(int argc, const char* const* argv);

}  // namespace bipot
