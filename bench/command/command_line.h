#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bench/command/command_tree.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace bipot {

/// One of the program's commands. Values are written when the arguments are parsed: the variables
/// must live until then. A name without dashes is an argument, read by its position.
class CommandDeclaration {
 public:
  /// An option that was just declared; each call adds one property.
  class Option {
   public:
    explicit Option(CLI::Option* option) : option_(option) {}

    Option& required();
    /// Its heading in the help.
    Option& group(const std::string& heading);
    /// Works, but does not show in the help.
    Option& hidden();
    /// Shows the present value of the variable as the default.
    Option& show_default();
    /// Refuses other values, NaN included.
    Option& positive();
    Option& not_negative();
    Option& between(int lowest, int highest);
    Option& one_of(const std::vector<std::string>& values);
    /// Values that the completion of shells proposes; others are taken as well.
    Option& suggest(const std::vector<std::string>& values);

   private:
    CLI::Option* option_;
  };
  explicit CommandDeclaration(CLI::App* app) : app_(app) {}

  using Text = const std::string&;
  /// `name`: the flags, and how the help calls the value: "--json FILE". Value: std::string, int,
  /// double, optional ones of these, std::uint64_t; lists of strings and doubles, which options take
  /// separated by commas, arguments as words.
  template <class Value>
  Option option(Text name, Value& value, Text help);
  /// Called with the value at its position among the arguments.
  Option option(Text name, const std::function<void(const std::string&)>& call, Text help);
  Option flag(Text name, bool& value, Text help);
  /// Called at the position of the flag among the arguments.
  Option flag(Text name, const std::function<void()>& call, Text help);
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
