#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "bench/command/commands.h"
#include "bench/problems/scene_catalogue.h"
#include "core/base/nearest_name.h"
#include "core/files/input_file.h"

namespace bipot {
namespace {

struct NewFlags {
  std::string name;  ///< of a template; empty: they are listed
};

CommandDeclaration add_new(CommandLine& line, NewFlags& flags) {
  CommandDeclaration command = line.add_command("new", "Print a scene to begin with");
  command.option("template", flags.name, "Name of a scene; without it they are listed",
                 {.suggest = names_of(scene_templates())});
  command.footer("Example:\n  bipot new heap > my.toml");
  return command;
}

int run_new(const NewFlags& flags) {
  std::vector<std::string> names;
  for (const auto& path : scene_templates()) {
    const std::string text = read_text_file(path);
    names.push_back(path.stem().string());
    if (names.back() == flags.name) {
      fmt::print("{}", text);
      return kExitConverged;
    }
    if (flags.name.empty()) {  // the first line says what it is
      const std::string line = text.substr(0, text.find('\n'));
      fmt::print("{:<10} {}\n", names.back(), line.substr(std::min<std::size_t>(2, line.size())));
    }
  }
  if (flags.name.empty()) return kExitConverged;
  throw std::invalid_argument(unknown_name_message("template", flags.name, names));
}

}  // namespace

ProgramCommand new_command(CommandLine& line) { return make_command(line, &add_new, &run_new); }

}  // namespace bipot
