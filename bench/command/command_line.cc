#include "bench/command/command_line.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>

#include "bench/command/completion.h"
#include "bench/command/manual_page.h"
#include "bench/command/say.h"
#include "bench/report/build_info.h"
#include "bench/report/text_lines.h"
#include "core/base/nearest_name.h"

namespace bipot {
namespace {

/// "{a,b}" of a type's name, without braces; empty: no choices. Suggestions are between < and >.
std::vector<std::string> choices_of(const CLI::Option* option, char begin = '{', char end = '}') {
  const std::string type = option->get_type_name();
  const std::size_t open = type.find(begin);
  if (open == std::string::npos) return {};
  return CLI::detail::split(type.substr(open + 1, type.find(end) - open - 1), ',');
}

/// What stands for the value of an option in the help; empty: a flag.
std::string value_of(const CLI::Option* option) {
  if (option->get_type_size() == 0) return {};
  const std::vector<std::string> choices = choices_of(option);
  if (!choices.empty()) return fmt::format("{}", fmt::join(choices, "|"));
  const std::string type = option->get_type_name();
  return type.substr(0, type.find(':'));
}

/// Help on a screen: lines of at most 100 columns, choices as a|b, groups separated by a line.
class ScreenHelp : public CLI::Formatter {
 public:
  ScreenHelp() { column_width(kColumn); }

  std::string make_help(const CLI::App* app, std::string name,
                        CLI::AppFormatMode mode) const override {
    std::string text = Formatter::make_help(app, std::move(name), mode);
    for (std::size_t at; (at = text.find("\n\n\n")) != std::string::npos;) text.erase(at, 1);
    return text;
  }

  std::string make_option(const CLI::Option* option, bool is_positional) const override {
    std::string line = "  " + make_option_name(option, is_positional) + make_option_opts(option);
    const std::string description = hanging_text(make_option_desc(option), kColumn);
    if (description.empty()) return line + "\n";
    if (letters(line) + 1 > kColumn) {
      line += "\n" + std::string(kColumn, ' ');
    } else {
      line += std::string(kColumn - letters(line), ' ');
    }
    return line + description + "\n";
  }

  std::string make_subcommand(const CLI::App* command) const override {
    constexpr std::size_t kNames = 14;
    const std::string name = "  " + command->get_name();
    return name + std::string(kNames - std::min(kNames, letters(name)), ' ') +
           hanging_text(command->get_description(), kNames) + "\n";
  }

  std::string make_option_opts(const CLI::Option* option) const override {
    if (option->get_type_size() == 0 || option->get_positional()) return {};
    std::string text = " " + value_of(option);
    if (!option->get_default_str().empty()) text += "=" + option->get_default_str();
    return text;
  }

 private:
  static constexpr std::size_t kColumn = 30;  // where descriptions begin
};

/// Refuses values that are not a number or do not satisfy `holds`. (CLI11's own checks let NaN
/// through.)
CLI::Validator number_check(const std::string& expected, const std::function<bool(double)>& holds) {
  return {[expected, holds](std::string& text) {
            double x = 0;
            return CLI::detail::lexical_cast(text, x) && holds(x)
                       ? std::string{}
                       : fmt::format("expected {}, got {}", expected, text);
          },
          ""};
}

void apply(const OptionTraits& traits, CLI::Option& option) {
  if (traits.required) option.required();
  if (traits.group) option.group(*traits.group);
  if (traits.show_default) option.capture_default_str();
  if (traits.positive) {
    option.check(
        number_check("a positive number", [](double x) { return x > 0 && std::isfinite(x); }));
  }
  if (traits.not_negative) {
    option.check(number_check("a number of at least 0",
                              [](double x) { return x >= 0 && std::isfinite(x); }));
  }
  if (traits.between) {
    const auto range = *traits.between;
    option.check(number_check(fmt::format("a number from {} to {}", range.first, range.second),
                              [=](double x) { return x >= range.first && x <= range.second; }));
  }
  if (!traits.one_of.empty()) {
    const auto check = [values = traits.one_of](std::string& text) {
      const bool known = std::ranges::find(values, text) != values.end();
      return known ? std::string() : unknown_name_message("value", text, values);
    };
    option.check(CLI::Validator(check, fmt::format("{{{}}}", fmt::join(traits.one_of, ","))));
  }
  if (!traits.suggest.empty()) {
    const auto any = [](const std::string&) { return std::string(); };
    option.check(CLI::Validator(any, fmt::format("<{}>", fmt::join(traits.suggest, ","))));
  }
}

/// Says in words what CLI11's conversion to this type would refuse.
template <class Whole>
CLI::Validator whole_number_check() {
  return {[](std::string& text) {
            Whole k = 0;
            return CLI::detail::lexical_cast(text, k)
                       ? std::string{}
                       : fmt::format("expected a whole number such as 10, got {}", text);
          },
          ""};
}

/// Adds an option by `add`, which takes its flags; the name of its value follows them.
void declare(const std::string& name, const OptionTraits& traits, const auto& add) {
  const std::size_t space = name.find(' ');
  CLI::Option* option = add(name.substr(0, space));
  if (space != std::string::npos) {
    const std::string value = name.substr(space + 1);
    const auto given = [value](const std::string& text) {
      return text.empty() ? "expected " + value + ", got an empty text" : std::string();
    };
    option->type_name(value)->check(CLI::Validator(given, ""));
  }
  apply(traits, *option);
}

std::vector<std::string> typed_words;  // behind the program's name

/// Flags of other programs, and what they are called here.
const std::vector<std::pair<std::string, std::string>> kFlagSynonyms = {
    {"-v", "--version"},
    {"--output", "--out"},
    {"-o", "--out"},
    {"--dt", "--step-size"},
    {"--timestep", "--step-size"},
    {"--time-step", "--step-size"},
    {"--method", "--solver"},
    {"--max-iter", "--max-iterations"},
    {"--maxiter", "--max-iterations"},
    {"--eps", "--tol"},
    {"-n", "--steps"},
    {"--num-steps", "--steps"},
    {"--step-size", "--step-factors"},
    {"--step-sizes", "--step-factors"},
    {"-j", "--threads"},
    {"--jobs", "--threads"},
    {"--cores", "--threads"},
    {"--resume", "--restart"},
    {"--continue", "--restart"},
    {"--silent", "--quiet"},
    {"--timeout", "--time-limit"},
    {"--goal", "--force-error"}};

/// The flag that may be meant; empty: none is near.
std::string meant_flag(const std::string& typed, const std::vector<std::string>& flags) {
  const auto known = [&](const std::string& flag) {
    return std::ranges::find(flags, flag) != flags.end();
  };
  for (const auto& [other, flag] : kFlagSynonyms) {
    if (other == typed && known(flag)) return flag;
  }
  if (typed.size() == 2) return {};  // every other letter would be near
  std::string nearest = nearest_name(typed, flags);
  if (!nearest.empty() || typed.size() < 5) return nearest;
  for (const std::string& flag : flags) {  // --tolerance, --thread
    if (flag.size() > 4 && (typed.starts_with(flag) || flag.starts_with(typed))) return flag;
  }
  return {};
}

CommandNode::Option node_of(const CLI::Option* option) {
  CommandNode::Option node{.argument =
                               option->get_lnames().empty() && option->get_snames().empty()};
  if (node.argument) {
    node.names = {option->get_name()};
  } else {
    for (const std::string& name : option->get_lnames()) node.names.push_back("--" + name);
    for (const std::string& name : option->get_snames()) node.names.push_back("-" + name);
  }
  node.value = value_of(option);
  node.choices = choices_of(option);
  node.open = node.choices.empty();
  if (node.open) node.choices = choices_of(option, '<', '>');
  node.help = option->get_description();
  node.hidden = option->get_group().empty();
  return node;
}

CommandNode node_of(const CLI::App* app) {
  CommandNode node{app->get_name(), app->get_description(), app->get_footer(), {}, {}};
  for (const CLI::Option* option : app->get_options()) node.options.push_back(node_of(option));
  for (const CLI::App* command : app->get_subcommands([](const CLI::App*) { return true; })) {
    node.commands.push_back(node_of(command));
  }
  return node;
}

/// What is wrong with the words, as far as names of commands and flags go; empty: nothing.
std::string unknown_name(const CommandNode& program, const std::vector<std::string>& words) {
  const CommandNode* at = &program;
  for (const std::string& word : words) {
    if (word.size() > 1 && word[0] == '-' && !std::isdigit(static_cast<unsigned char>(word[1]))) {
      const std::string typed = word.substr(0, word.find('='));
      std::vector<std::string> flags;
      for (const CommandNode::Option& option : at->options) {
        if (!option.argument) flags.insert(flags.end(), option.names.begin(), option.names.end());
      }
      if (std::ranges::find(flags, typed) != flags.end()) continue;
      const std::string meant = meant_flag(typed, flags);
      const std::string name = program.name + (at == &program ? "" : " " + at->name);
      return fmt::format("{}: unknown flag '{}'{} ({} --help lists the flags)", name, typed,
                         meant.empty() ? "" : fmt::format("; did you mean '{}'?", meant), name);
    }
    if (at != &program) continue;
    const std::vector<std::string> names = names_of(program.commands);
    const auto it = std::ranges::find(names, word);
    if (it == names.end()) {
      return program.name + ": " + unknown_name_message("command", word, names);
    }
    at = &program.commands[static_cast<std::size_t>(it - names.begin())];
  }
  return at != &program
             ? std::string()
             : program.name + ": name a command (" + program.name + " --help lists them)";
}

/// The program, and the command that the words name first.
std::string named_command(const CommandNode& program, const std::vector<std::string>& words) {
  const std::vector<std::string> names = names_of(program.commands);
  const auto named = std::find_first_of(words.begin(), words.end(), names.begin(), names.end());
  return program.name + (named == words.end() ? "" : " " + *named);
}

}  // namespace

template <class Value>
void CommandDeclaration::option(Text name, Value& value, Text help, const OptionTraits& traits) {
  declare(name, traits, [&](const std::string& flags) {
    CLI::Option* option = app_->add_option(flags, value, help);
    if constexpr (std::is_same_v<Value, std::uint64_t>) {
      option->check(whole_number_check<std::uint64_t>());
    } else if constexpr (std::is_same_v<Value, int> || std::is_same_v<Value, std::optional<int>>) {
      option->check(whole_number_check<int>());
    }
    if constexpr (requires { value.push_back(value[0]); } && !std::is_same_v<Value, std::string>) {
      if (flags.starts_with('-')) option->delimiter(',');
    }
    return option;
  });
}
#define BIPOT_OPTION(Value) \
  template void CommandDeclaration::option(Text, Value&, Text, const OptionTraits&)
BIPOT_OPTION(std::string);
BIPOT_OPTION(std::optional<std::string>);
BIPOT_OPTION(int);
BIPOT_OPTION(std::optional<int>);
BIPOT_OPTION(std::uint64_t);
BIPOT_OPTION(double);
BIPOT_OPTION(std::optional<double>);
BIPOT_OPTION(std::vector<std::string>);
BIPOT_OPTION(std::vector<double>);
#undef BIPOT_OPTION

void CommandDeclaration::option(Text name, const std::function<void(const std::string&)>& call,
                                Text help, const OptionTraits& traits) {
  declare(name, traits, [&](const std::string& flags) {
    return app_->add_option_function<std::string>(flags, call, help);
  });
}
void CommandDeclaration::flag(Text name, bool& value, Text help, const OptionTraits& traits) {
  apply(traits, *app_->add_flag(name, value, help));
}
void CommandDeclaration::flag(Text name, const std::function<void()>& call, Text help,
                              const OptionTraits& traits) {
  apply(traits, *app_->add_flag_callback(name, call, help));
}
void CommandDeclaration::footer(Text text) { app_->footer(text); }
std::string CommandDeclaration::name() const { return app_->get_name(); }
bool CommandDeclaration::given() const { return app_->parsed(); }

CommandLine::CommandLine(const std::string& program, const std::string& description,
                         const std::string& version, const std::string& footer)
    : app_(std::make_unique<CLI::App>(description)), version_(version) {
  app_->name(program);
  app_->formatter(std::make_shared<ScreenHelp>());  // commands inherit it
  app_->set_version_flag("-V,--version", [program, version] {
    return fmt::format("{} {} ({})", program, version, build_info().commit);
  });
  app_->require_subcommand(1);
  app_->footer(footer);
}
CommandLine::~CommandLine() = default;

CommandDeclaration CommandLine::add_command(const std::string& name,
                                            const std::string& description) {
  CLI::App* const command = app_->add_subcommand(name, description);
  command->footer("");  // that of the program would be repeated
  return CommandDeclaration(command);
}

CommandNode CommandLine::tree() const { return node_of(app_.get()); }

CommandLine::Parsed CommandLine::parse(int argc, const char* const* argv) {
  typed_words.assign(argv + 1, argv + argc);
  CommandDeclaration help = add_command("help", "Explain a command");
  help.flag("--man", manual_page_, "Print the manual page instead");
  add_command("version", "Print the version");
  add_command("completion", "Print a script that completes commands and flags in a shell")
      .option("shell", shell_, fmt::format("Its name: {}", fmt::join(completion_shells(), ", ")),
              {.required = true, .one_of = completion_shells()});
  help.option("command", asked_, "Name of a command", {.one_of = names_of(tree().commands)});
  // Questions in other words.
  std::vector<std::string> words = typed_words;
  if (words == std::vector<std::string>{"version"}) words = {"--version"};
  if (words == std::vector<std::string>{"help"}) words = {"--help"};
  if (words.size() == 2 && words[0] == "help" && !words[1].starts_with('-')) {
    if (const std::string unknown = unknown_name(tree(), {words[1]}); !unknown.empty()) {
      say("{}\n", unknown);
      return {Parsed::Outcome::kRefused, unknown};
    }
    words = {words[1], "--help"};
  }
  return answered_or_refused(std::move(words));
}

CommandLine::Parsed CommandLine::answered_or_refused(std::vector<std::string> words) {
  const std::vector<std::string> in_order = words;
  std::ranges::reverse(words);  // as CLI11 takes them
  try {
    app_->parse(std::move(words));
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) {
      app_->exit(e);
      return {Parsed::Outcome::kAnswered, {}};
    }
    std::string refusal = unknown_name(tree(), in_order);
    if (refusal.empty()) {
      const std::string name = named_command(tree(), in_order);
      refusal = fmt::format("{}: {} ({} --help explains)", name, e.what(), name);
    }
    say("{}\n", refusal);
    return {Parsed::Outcome::kRefused, refusal};
  }
  if (manual_page_) fmt::print("{}", manual_page(tree(), version_));
  if (!shell_.empty()) fmt::print("{}", completion_script(tree(), shell_));
  return {manual_page_ || !shell_.empty() ? Parsed::Outcome::kAnswered : Parsed::Outcome::kCommand,
          {}};
}

std::string typed_command(const std::vector<std::string>& targets) {
  std::string line = "bipot";
  bool named = false;  // the targets
  for (std::size_t k = 0; k < typed_words.size(); ++k) {
    const std::string& word = typed_words[k];
    if (word == "--quiet" || word == "-q" || word.starts_with("--out=") ||
        word.starts_with("--json=")) {
      continue;
    }
    if (word == "--out" || word == "--json") {
      ++k;
      continue;
    }
    if (std::ranges::find(targets, word) == targets.end()) {
      line += ' ' + shell_word(word);
    } else if (!std::exchange(named, true)) {
      line += " {}";
    }
  }
  return line;
}

}  // namespace bipot
