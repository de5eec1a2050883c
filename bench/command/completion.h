#pragma once

#include <string>
#include <vector>

#include "bench/command/command_tree.h"

namespace bipot {

/// Shells that completion_script() knows.
const std::vector<std::string>& completion_shells();

/// A script that completes commands, flags and their choices in one of these shells.
std::string completion_script(const CommandNode& program, const std::string& shell);

}  // namespace bipot
