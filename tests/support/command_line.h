#pragma once

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <string>

namespace bipot {

struct Outcome {
  int exit_code = -1;
  std::string out;  ///< standard output alone
};

/// Runs a program as a shell does.
inline Outcome run_command_line(const std::string& program, const std::string& arguments) {
  const std::string command = program + " " + arguments + " 2>/dev/null";
  Outcome outcome;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return outcome;
  std::array<char, 4096> buffer{};
  while (const std::size_t n = fread(buffer.data(), 1, buffer.size(), pipe)) {
    outcome.out.append(buffer.data(), n);
  }
  const int status = pclose(pipe);
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return outcome;
}

}  // namespace bipot
