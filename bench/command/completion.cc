#include "bench/command/completion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>

#include "bench/report/text_lines.h"
#include "core/base/nearest_name.h"

namespace bipot {
namespace {

using Words = std::vector<std::string>;

/// Whether a file may be the first argument of the command.
bool takes_files(const CommandNode& command) {
  const auto first = std::ranges::find_if(command.options,
                                          [](const CommandNode::Option& o) { return o.argument; });
  return first != command.options.end() && first->open;
}

/// What may follow a command: its visible flags, and the choices of its arguments.
Words words_after(const CommandNode& command) {
  Words words = names_of(command.commands);
  for (const CommandNode::Option& option : command.options) {
    if (option.hidden) continue;
    const Words& more = option.argument ? option.choices : option.names;
    words.insert(words.end(), more.begin(), more.end());
  }
  return words;
}

/// Text between single quotes of a shell.
std::string quoted(const std::string& text) { return "'" + replaced(text, "'", "'\\''") + "'"; }

std::string escaped(const std::string& text, const std::string& special) {
  std::string out;
  for (const char c : text) {
    if (special.find(c) != std::string::npos) out += '\\';
    out += c;
  }
  return out;
}

std::string bash_script(const CommandNode& program) {
  std::string choices, words;
  Words values;  // flags before any value: a file
  for (const CommandNode& command : program.commands) {
    words += fmt::format("      {}) words={}{} ;;\n", command.name,
                         quoted(fmt::format("{}", fmt::join(words_after(command), " "))),
                         takes_files(command) ? " files=yes" : "");
    for (const CommandNode::Option& option : command.options) {
      if (option.argument || option.value.empty()) continue;
      for (const std::string& name : option.names) {
        const std::string typed = quoted(command.name + " " + name);
        if (option.choices.empty()) {
          values.push_back(typed);
        } else {
          choices += fmt::format("    {}) words='{}' ;;\n", typed, fmt::join(option.choices, " "));
        }
      }
    }
  }
  return fmt::format(
      "# Completion of {0} for bash: source <({0} completion bash)\n"
      "_{0}() {{\n"
      "  local word=\"${{COMP_WORDS[COMP_CWORD]}}\" before=\"${{COMP_WORDS[COMP_CWORD-1]}}\"\n"
      "  local command='' words='' files='' k\n"
      "  for ((k = 1; k < COMP_CWORD; ++k)); do\n"
      "    case \"${{COMP_WORDS[k]}}\" in {1}) command=\"${{COMP_WORDS[k]}}\"; break ;; esac\n"
      "  done\n"
      "  case \"$command $before\" in\n{2}    {5}) ;;\n"
      "    *) case \"$command\" in\n      '') words={3} ;;\n{4}    esac ;;\n"
      "  esac\n"
      "  [ \"$words\" ] || files=yes\n"
      // A line each: names of files may have spaces.
      "  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$word\"\n"
      "    [ -z \"$files\" ] || compgen -f -- \"$word\")\n"
      "}}\n"
      "complete -o filenames -F _{0} {0}\n",
      program.name, fmt::join(names_of(program.commands), "|"), choices,
      quoted(fmt::format("{}", fmt::join(words_after(program), " "))), words,
      fmt::join(values, "|"));
}

std::string zsh_script(const CommandNode& program) {
  std::string commands, cases;
  for (const CommandNode& command : program.commands) {
    commands += "    " + quoted(escaped(command.name, ":") + ":" + command.help) + "\n";
    cases += fmt::format("    {})\n      _arguments", command.name);
    for (const CommandNode::Option& option : command.options) {
      if (option.hidden || option.argument) continue;
      const std::string values =
          option.choices.empty() ? "_files" : fmt::format("({})", fmt::join(option.choices, " "));
      for (const std::string& name : option.names) {
        cases +=
            " \\\n        " + quoted(fmt::format("{}[{}]{}", name, escaped(option.help, "[]\\"),
                                                 option.value.empty() ? "" : ":value:" + values));
      }
    }
    Words choices;
    for (const CommandNode::Option& option : command.options) {
      if (option.argument)
        choices.insert(choices.end(), option.choices.begin(), option.choices.end());
    }
    cases += fmt::format(" \\\n        '*:argument:{{compadd -- {}{}}}' ;;\n",
                         fmt::join(choices, " "), takes_files(command) ? "; _files" : "");
  }
  return fmt::format(
      "#compdef {0}\n"
      "# Completion of {0} for zsh: source <({0} completion zsh), or a file _{0} in $fpath\n"
      "_{0}() {{\n"
      "  local -a commands\n  commands=(\n{1}  )\n"
      "  if (( CURRENT == 2 )); then\n    _describe command commands\n    return\n  fi\n"
      "  local command=$words[2]\n"
      "  shift words\n  (( CURRENT-- ))\n"
      "  case $command in\n{2}  esac\n"
      "}}\n"
      "if [ \"$funcstack[1]\" = _{0} ]; then _{0} \"$@\"; else compdef _{0} {0}; fi\n",
      program.name, commands, cases);
}

std::string fish_script(const CommandNode& program) {
  std::string text =
      fmt::format("# Completion of {0} for fish: {0} completion fish | source\n", program.name);
  for (const CommandNode& command : program.commands) {
    text += fmt::format("complete -c {} -n __fish_use_subcommand -f -a {} -d {}\n", program.name,
                        command.name, quoted(escaped(command.help, "\\")));
    for (const CommandNode::Option& option : command.options) {
      if (option.hidden || (option.argument && option.choices.empty())) continue;
      text += fmt::format("complete -c {} -n '__fish_seen_subcommand_from {}'", program.name,
                          command.name);
      for (const std::string& name : option.names) {
        if (option.argument) continue;
        text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      }
      if (!option.value.empty() && !option.argument) text += " -r";
      if (!option.choices.empty()) {
        text += fmt::format("{} -a '{}'", option.argument && option.open ? "" : " -f",
                            fmt::join(option.choices, " "));
      }
      text += " -d " + quoted(escaped(option.help, "\\")) + "\n";
    }
  }
  return text;
}

}  // namespace

const std::vector<std::string>& completion_shells() {
  static const std::vector<std::string> shells = {"bash", "zsh", "fish"};
  return shells;
}

std::string completion_script(const CommandNode& program, const std::string& shell) {
  if (shell == "bash") return bash_script(program);
  if (shell == "zsh") return zsh_script(program);
  if (shell == "fish") return fish_script(program);
  throw std::invalid_argument("no completion for the shell " + shell);
}

}  // namespace bipot
