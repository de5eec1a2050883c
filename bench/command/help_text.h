#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace bipot {

/// Words of `text` in lines of at most `width` characters, each but the first behind `indent`
/// spaces, which count. The first line is taken to begin at column `indent`.
std::string wrapped(const std::string& text, std::size_t indent, std::size_t width = 100);

/// Help on a screen: lines of at most 100 columns, choices as a|b, groups one line apart.
class ScreenHelp : public CLI::Formatter {
 public:
  ScreenHelp();
  std::string make_help(const CLI::App* app, std::string name,
                        CLI::AppFormatMode mode) const override;
  std::string make_option(const CLI::Option* option, bool is_positional) const override;
  std::string make_subcommand(const CLI::App* command) const override;
  std::string make_option_opts(const CLI::Option* option) const override;
};

}  // namespace bipot
