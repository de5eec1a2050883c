#pragma once

#include <string>
#include <vector>

namespace bipot {

/// A command with its options and commands: what the help, the completion of shells and the manual
/// page are made of.
struct CommandNode {
  /// An option, a flag or an argument of a command, as the command line declares it.
  struct Option {
    std::vector<std::string> names;    ///< "--out", "-q"; of an argument its name without dashes
    std::string value;                 ///< what stands for its value: FILE, a|b; empty: a flag
    std::vector<std::string> choices;  ///< values to propose
    bool open = true;                  ///< others are taken as well
    std::string help;
    bool argument = false;
    bool hidden = false;  ///< works, but the help does not show it
  };
  std::string name, help, footer;
  std::vector<Option> options;
  std::vector<CommandNode> commands;
};

}  // namespace bipot
