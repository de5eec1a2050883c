#include "bench/command/bipot_command.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "bench/command/command_line.h"
#include "bench/command/commands.h"
#include "bench/command/run_processes.h"
#include "bench/command/say.h"
#include "bench/report/json_output.h"
#include "core/base/printable_text.h"
#include "core/base/version.h"
#include "solvers/parallel/launch.h"

namespace bipot {
namespace {

/// The value of --json, read from the arguments themselves: it is then known for every command, and
/// even if they cannot be parsed.
std::string json_destination(int argc, const char* const* argv) {
  constexpr std::string_view kFlag = "--json";
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    if (word == kFlag && i + 1 < argc) return argv[i + 1];
    if (word.starts_with("--json=")) return std::string(word.substr(kFlag.size() + 1));
  }
  return {};
}

std::string_view status_of(ExitCode code) {
  switch (code) {
    case kExitIo:
      return "input or output failed";
    case kExitBadInput:
      return "invalid input";
    case kExitInterrupted:
      return "interrupted";
    case kExitNotConverged:
      return to_string(SolveStatus::kTimeLimit);
    default:
      return "numerical failure";
  }
}

/// The command named by the arguments; empty if there is none.
std::string command_name(const std::vector<ProgramCommand>& commands, int argc,
                         const char* const* argv) {
  for (int i = 1; i < argc; ++i) {
    for (const ProgramCommand& c : commands) {
      if (c.declaration.name() == argv[i]) return argv[i];
    }
  }
  return {};
}

/// Standard output under any of its names, and other open files: they are not replaced.
bool is_open_file(const std::string& destination) {
  const auto begins = [&](const char* with) { return destination.starts_with(with); };
  return destination == "-" || begins("/dev/std") || begins("/dev/fd/") || begins("/proc/");
}

/// Opens a pipe if somebody reads it within two seconds, else -1: a refusal does not wait for ever.
int opened_for_a_reader(const std::string& pipe) {
  for (int k = 0; k < 100; ++k) {
    const int file = ::open(pipe.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
    if (file >= 0 || errno != ENXIO) return file;
    ::usleep(20000);
  }
  return -1;
}

/// Writes a refusal into the JSON file as well. The result of an earlier command stays there.
void write_refusal(const std::string& destination, const std::string& command,
                   const std::string& message, ExitCode code) {
  if (destination.empty() || !is_speaker() || (destination == "-" && !std::cout)) return;
  std::error_code none;
  const auto status = is_open_file(destination) ? std::filesystem::file_status()
                                                : std::filesystem::status(destination, none);
  if (std::filesystem::is_directory(status)) return;  // said by who wanted to write there
  if (std::filesystem::is_regular_file(status) && std::filesystem::file_size(destination, none)) {
    say("bipot: {} is kept as it was\n", destination);
    return;
  }
  const bool pipe = std::filesystem::is_fifo(status);
  const int reader = pipe ? opened_for_a_reader(destination) : -1;
  if (pipe && reader < 0) return say("bipot: nobody reads {}\n", destination);
  try {
    write_json({{"command", command},
                {"version", program_version()},
                {"status", status_of(code)},
                {"message", message},
                {"exit_code", static_cast<int>(code)}},
               destination);
  } catch (const std::exception& e) {
    if (e.what() != message) say("bipot: {}\n", e.what());
  }
  if (pipe) ::close(reader);
}

/// The JSON of an earlier command may be replaced, a scene or a table must not.
void require_json_or_nothing(const std::string& destination) {
  std::error_code none;
  if (is_open_file(destination) || !std::filesystem::is_regular_file(destination, none) ||
      std::filesystem::file_size(destination, none) == 0) {
    return;
  }
  std::ifstream file(destination);
  if (!file || Json::accept(file)) return;
  throw std::invalid_argument("--json " + destination +
                              ": there is a file that is not JSON: name another one");
}

int run_command_line(int argc, const char* const* argv) {
  CommandLine line(
      "bipot", "Frictional contact of rigid disks and spheres: many solvers, one error measure.",
      program_version(),
      "Exit codes: 0 every solve met its tolerance; 1 some did not; 2 bad input; 3 numerical\n"
      "failure; 4 a file could not be read or written; 5 interrupted.\n"
      "Examples:\n"
      "  bipot run compaction --out out/compaction\n"
      "  bipot run scene.toml --solver assor --tol 1e-4\n"
      "  bipot solve problem.hdf5 --solver pgs --json -\n"
      "  bipot judge problem.hdf5 --impulses mine.npy\n"
      "  bipot advise scene.toml --write advised.toml\n"
      "  bipot compare square:30 pile:18 --quick --out out/compare\n"
      "  bipot paper --out out/paper\n"
      "  bipot trade my_scene.toml --out out/trade\n"
      "  bipot extremes --quick --out out/extremes\n"
      "  bipot validate --quick --out out/validate\n"
      "  bipot new heap > my.toml\n"
      "  bipot list solvers");
  const std::vector<ProgramCommand> commands = {
      run_command(line),      page_command(line),  movie_command(line),
      solve_command(line),    judge_command(line), leaderboard_command(line),
      compare_command(line),  tune_command(line),  advise_command(line),
      paper_command(line),    trade_command(line), extremes_command(line),
      validate_command(line), study_command(line), list_command(line),
      new_command(line),
  };
  const std::string json = json_destination(argc, argv);
  const auto refuse = [&](const std::string& message, ExitCode code) {
    write_refusal(json, command_name(commands, argc, argv), message, code);
    return static_cast<int>(code);
  };
  const auto words_of = [](const std::exception& e) {
    const bool full = dynamic_cast<const std::bad_alloc*>(&e) != nullptr;
    return full ? std::string("not enough memory") : printable(e.what());
  };
  const auto say_and_refuse = [&](const std::exception& e, ExitCode code) {
    const std::string message = words_of(e);
    say("bipot: {}\n", message);
    return refuse(message, code);
  };
  try {
    const CommandLine::Parsed parsed = line.parse(argc, argv);
    if (parsed.outcome == CommandLine::Parsed::Outcome::kAnswered) return kExitConverged;
    if (parsed.outcome == CommandLine::Parsed::Outcome::kRefused) {
      return refuse(parsed.refusal, kExitBadInput);
    }
    for (const ProgramCommand& c : commands) {
      if (!c.declaration.given()) continue;
      const std::string name = c.declaration.name();
      if (on_several_processes() && name != "solve" && name != "run") {
        throw std::invalid_argument(
            fmt::format("{} runs on one process; run and solve take several", name));
      }
      require_json_or_nothing(json);
      return c.run();
    }
    throw std::logic_error("no command was parsed");
  } catch (const CommonFailure& e) {
    return say_and_refuse(e, exit_code_for(e));
  } catch (const std::exception& e) {
    const ExitCode code = exit_code_for(e);
    if (!processes_have_met()) return say_and_refuse(e, code);
    // The other processes do not know, and wait.
    say_from_here(words_of(e));
    if (is_speaker()) refuse(words_of(e), code);
    end_all_processes(code);
  }
}

/// A script must not take the rest of an output for the whole.
int with_written_output(int exit_code) {
  errno = 0;
  std::cout.flush();
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout.good()) return exit_code;
  if (exit_code != kExitIo) {  // else it was said
    say("bipot: standard output: {}\n",
        errno != 0 ? std::strerror(errno) : "not everything was written");
  }
  // What is left in its buffer would fail again, in each library that flushes it.
  [[maybe_unused]] const std::FILE* nowhere = std::freopen("/dev/null", "w", stdout);
  return kExitIo;
}

}  // namespace

int bipot_command(int argc, const char* const* argv) {
  keep_others_quiet();
  const int exit_code = with_written_output(run_command_line(argc, argv));
  // The root process returns the exit code for all: mpirun would kill it if another one ended with
  // a failure.
  return is_speaker() ? exit_code : 0;
}

}  // namespace bipot
