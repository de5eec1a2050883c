#include "bench/command/help_text.h"

#include <algorithm>
#include <sstream>

namespace bipot {
namespace {

constexpr std::size_t kColumn = 30;  // where descriptions begin

/// Characters, not bytes: all of UTF-8 but its continuation bytes.
std::size_t length(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

}  // namespace

std::string wrapped(const std::string& text, std::size_t indent, std::size_t width) {
  std::istringstream words(text);
  std::string out;
  std::size_t column = indent;
  for (std::string word; words >> word;) {
    const bool first = column == indent;
    if (!first && column + 1 + length(word) > width) {
      out += "\n" + std::string(indent, ' ');
      column = indent;
    } else if (!first) {
      out += ' ';
      ++column;
    }
    out += word;
    column += length(word);
  }
  return out;
}

ScreenHelp::ScreenHelp() { column_width(kColumn); }

std::string ScreenHelp::make_help(const CLI::App* app, std::string name,
                                  CLI::AppFormatMode mode) const {
  std::string text = Formatter::make_help(app, std::move(name), mode);
  for (std::size_t at; (at = text.find("\n\n\n")) != std::string::npos;) text.erase(at, 1);
  return text;
}

std::string ScreenHelp::make_option(const CLI::Option* option, bool is_positional) const {
  std::string line = "  " + make_option_name(option, is_positional) + make_option_opts(option);
  const std::string description = wrapped(make_option_desc(option), kColumn);
  if (description.empty()) return line + "\n";
  if (length(line) + 1 > kColumn) {
    line += "\n" + std::string(kColumn, ' ');
  } else {
    line += std::string(kColumn - length(line), ' ');
  }
  return line + description + "\n";
}

std::string ScreenHelp::make_subcommand(const CLI::App* command) const {
  constexpr std::size_t kNames = 12;
  const std::string name = "  " + command->get_name();
  return name + std::string(kNames - std::min(kNames, length(name)), ' ') +
         wrapped(command->get_description(), kNames) + "\n";
}

std::string ScreenHelp::make_option_opts(const CLI::Option* option) const {
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

}  // namespace bipot
