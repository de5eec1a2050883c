#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/command/command_tree.h"

namespace CLI {
class App;
}  // namespace CLI

namespace bipot {

/// Properties of an option, a flag or an argument.
struct OptionTraits {
  bool required = false;
  /// The help shows the present value of the variable as the default.
  bool show_default = false;
  /// Its heading in the help; empty text: works, but does not show there.
  std::optional<std::string> group = {};
  // Other values are refused, NaN included.
  bool positive = false;
  bool not_negative = false;
  std::optional<std::pair<int, int>> between = {};
  std::vector<std::string> one_of = {};
  /// Values that the completion of shells proposes; others are taken as well.
  std::vector<std::string> suggest = {};
};

/// One of the program's commands. Values are written when the arguments are parsed: the variables
/// must live until then. A name without dashes is an argument, read by its position.
class CommandDeclaration {
 public:
  explicit CommandDeclaration(CLI::App* app) : app_(app) {}

  using Text = const std::string&;
  /// `name`: the flags, and how the help calls the value: "--json FILE". Value: std::string, int,
  /// double, optional ones of these, std::uint64_t; lists of strings and doubles, which options take
  /// separated by commas, arguments as words.
  template <class Value>
  void option(Text name, Value& value, Text help, const OptionTraits& traits = {});
  /// Called with the value at its position among the arguments.
  void option(Text name, const std::function<void(const std::string&)>& call, Text help,
              const OptionTraits& traits = {});
  void flag(Text name, bool& value, Text help, const OptionTraits& traits = {});
  /// Called at the position of the flag among the arguments.
  void flag(Text name, const std::function<void()>& call, Text help,
            const OptionTraits& traits = {});
  /// Text below the help.
  void footer(Text text);

  std::string name() const;
  /// True if the parsed arguments name this command.
  bool given() const;

 private:
  CLI::App* app_;
};

/// The program's arguments, with the commands `help`, `version` and `completion`, which it answers
/// itself. CLI11 is large: only command_line.cc includes it.
class CommandLine {
 public:
  CommandLine(const std::string& program, const std::string& description,
              const std::string& version, const std::string& footer);
  ~CommandLine();

  CommandDeclaration add_command(const std::string& name, const std::string& description);

  struct Parsed {
    enum class Outcome { kCommand, kAnswered, kRefused };
    Outcome outcome = Outcome::kCommand;  ///< kAnswered: a question, on standard output
    std::string refusal;                  ///< already on standard error
  };
  /// Exactly one command must be named. For an unknown one, or an unknown flag, the nearest is
  /// proposed.
  Parsed parse(int argc, const char* const* argv);
  /// All that is declared.
  CommandNode tree() const;

 private:
  Parsed answered_or_refused(std::vector<std::string> words);

  std::unique_ptr<CLI::App> app_;
  std::string version_;
  bool manual_page_ = false;   // help --man
  std::string asked_, shell_;  // help COMMAND, completion SHELL
};

/// The command as CommandLine::parse saw it, without --out, --json and --quiet. `{}` stands for the
/// targets, if they are given.
std::string typed_command(const std::vector<std::string>& targets = {});

}  // namespace bipot
