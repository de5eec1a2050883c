#pragma once

#include <string>

#include "bench/command/command_tree.h"

namespace bipot {

/// The manual page of a program, section 1, in the macros of man(7).
std::string manual_page(const CommandNode& program, const std::string& version);

}  // namespace bipot
