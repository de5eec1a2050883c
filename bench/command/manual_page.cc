#include "bench/command/manual_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>

namespace bipot {
namespace {

/// Text as troff takes it: no escapes, no commands, dashes that can be copied.
std::string plain(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n')) out += "\\&";
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else {
      out += c;
    }
  }
  return out;
}

std::string option_text(const CommandNode::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.names) names.push_back("\\fB" + plain(name) + "\\fR");
  std::string text = fmt::format(".TP\n{}", fmt::join(names, ", "));
  if (!option.value.empty() && !option.argument) text += " \\fI" + plain(option.value) + "\\fR";
  return text + "\n" + plain(option.help) + "\n";
}

std::string command_text(const CommandNode& command) {
  std::string heading = command.name;
  for (const CommandNode::Option& option : command.options) {
    if (option.argument) heading += " " + option.names.front();
  }
  std::string text = ".SS " + plain(heading) + "\n" + plain(command.help) + ".\n";
  for (const CommandNode::Option& option : command.options) {
    if (!option.hidden) text += option_text(option);
  }
  if (!command.footer.empty()) text += ".PP\n.nf\n" + plain(command.footer) + "\n.fi\n";
  return text;
}

}  // namespace

std::string manual_page(const CommandNode& program, const std::string& version) {
  std::string title = program.name;
  std::ranges::transform(title, title.begin(),
                         [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  std::string text = fmt::format(
      ".TH {} 1 \"\" \"{} {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n"
      ".SH SYNOPSIS\n.B {}\n.I COMMAND\n[arguments and flags]\n.SH COMMANDS\n",
      title, program.name, plain(version), program.name, plain(program.help), program.name);
  for (const CommandNode& command : program.commands) text += command_text(command);
  return text + ".SH NOTES\n.nf\n" + plain(program.footer) + "\n.fi\n";
}

}  // namespace bipot
