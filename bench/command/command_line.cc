#include "bench/command/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "bench/command/help_text.h"

namespace bipot {
namespace {

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
    const std::string description = wrapped(make_option_desc(option), kColumn);
    if (description.empty()) return line + "\n";
    if (num_characters(line) + 1 > kColumn) {
      line += "\n" + std::string(kColumn, ' ');
    } else {
      line += std::string(kColumn - num_characters(line), ' ');
    }
    return line + description + "\n";
  }

  std::string make_subcommand(const CLI::App* command) const override {
    constexpr std::size_t kNames = 12;
    const std::string name = "  " + command->get_name();
    return name + std::string(kNames - std::min(kNames, num_characters(name)), ' ') +
           wrapped(command->get_description(), kNames) + "\n";
  }

  std::string make_option_opts(const CLI::Option* option) const override {
    if (option->get_type_size() == 0 || option->get_positional()) return {};
    const std::string type = option->get_type_name();
    std::string text = " " + type.substr(0, type.find(':'));
    if (const std::size_t open = type.find('{'); open != std::string::npos) {
      text = " " + type.substr(open + 1, type.find('}') - open - 1);
      std::replace(text.begin(), text.end(), ',', '|');
    }
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

template <class Value>
DeclaredOption declare(CLI::App* app, const std::string& name, Value& value,
                       const std::string& help) {
  return DeclaredOption(app->add_option(name, value, help));
}

template <class Value>
DeclaredOption declare_list(CLI::App* app, const std::string& name, Value& values,
                            const std::string& help) {
  CLI::Option* option = app->add_option(name, values, help);
  if (name.starts_with('-')) option->delimiter(',');
  return DeclaredOption(option);
}

}  // namespace

DeclaredOption& DeclaredOption::required() {
  option_->required();
  return *this;
}
DeclaredOption& DeclaredOption::value_name(const std::string& name) {
  option_->type_name(name);
  return *this;
}
DeclaredOption& DeclaredOption::group(const std::string& heading) {
  option_->group(heading);
  return *this;
}
DeclaredOption& DeclaredOption::hidden() { return group(""); }
DeclaredOption& DeclaredOption::show_default() {
  option_->capture_default_str();
  return *this;
}
DeclaredOption& DeclaredOption::positive() {
  option_->check(number_check("a positive number", [](double x) { return x > 0; }));
  return *this;
}
DeclaredOption& DeclaredOption::not_negative() {
  option_->check(number_check("a number of at least 0", [](double x) { return x >= 0; }));
  return *this;
}
DeclaredOption& DeclaredOption::between(int lowest, int highest) {
  option_->check(number_check(fmt::format("a number from {} to {}", lowest, highest),
                              [=](double x) { return x >= lowest && x <= highest; }));
  return *this;
}
DeclaredOption& DeclaredOption::one_of(const std::vector<std::string>& values) {
  option_->check(CLI::IsMember(values));
  return *this;
}

DeclaredOption CommandDeclaration::option(Text name, std::string& value, Text help) {
  return declare(app_, name, value, help);
}
DeclaredOption CommandDeclaration::option(Text name, std::optional<std::string>& value, Text help) {
  return declare(app_, name, value, help);
}
DeclaredOption CommandDeclaration::option(Text name, int& value, Text help) {
  return declare(app_, name, value, help);
}
DeclaredOption CommandDeclaration::option(Text name, std::optional<int>& value, Text help) {
  return declare(app_, name, value, help);
}
DeclaredOption CommandDeclaration::option(Text name, std::uint64_t& value, Text help) {
  return declare(app_, name, value, help);
}
DeclaredOption CommandDeclaration::option(Text name, double& value, Text help) {
  return declare(app_, name, value, help);
}
DeclaredOption CommandDeclaration::option(Text name, std::optional<double>& value, Text help) {
  return declare(app_, name, value, help);
}
DeclaredOption CommandDeclaration::option(Text name, std::vector<std::string>& values, Text help) {
  return declare_list(app_, name, values, help);
}
DeclaredOption CommandDeclaration::option(Text name, std::vector<double>& values, Text help) {
  return declare_list(app_, name, values, help);
}
DeclaredOption CommandDeclaration::flag(Text name, bool& value, Text help) {
  return DeclaredOption(app_->add_flag(name, value, help));
}
DeclaredOption CommandDeclaration::flag(Text name, const std::function<void()>& call, Text help) {
  return DeclaredOption(app_->add_flag_callback(name, call, help));
}
DeclaredOption CommandDeclaration::option(Text name,
                                          const std::function<void(const std::string&)>& call,
                                          Text help) {
  return DeclaredOption(app_->add_option_function<std::string>(name, call, help));
}
void CommandDeclaration::footer(Text text) { app_->footer(text); }
std::string CommandDeclaration::name() const { return app_->get_name(); }
bool CommandDeclaration::given() const { return app_->parsed(); }

CommandLine::CommandLine(const std::string& program, const std::string& description,
                         const std::string& version, const std::string& footer)
    : app_(std::make_unique<CLI::App>(description)) {
  app_->name(program);
  app_->formatter(std::make_shared<ScreenHelp>());  // commands inherit it
  app_->set_version_flag("--version", program + " " + version);
  app_->require_subcommand(1);
  app_->footer(footer);
}
CommandLine::~CommandLine() = default;

CommandDeclaration CommandLine::add_command(const std::string& name,
                                            const std::string& description) {
  return CommandDeclaration(app_->add_subcommand(name, description));
}

CommandLine::Parsed CommandLine::parse(int argc, const char* const* argv) {
  try {
    app_->parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (app_->exit(e) == 0) return {Parsed::Outcome::kAnswered, {}};
    return {Parsed::Outcome::kRefused, e.what()};
  }
  return {};
}

}  // namespace bipot
