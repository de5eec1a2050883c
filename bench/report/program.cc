#include "bench/report/program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <memory>
#include <thread>

#include "core/base/file_error.h"
#include "core/base/interrupt.h"
#include "core/base/stopwatch.h"

namespace bipot {
namespace {

struct Close {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Close>;

/// Unnamed files instead of pipes, which could block.
File temporary() {
  File file(std::tmpfile());
  if (!file) throw FileError("temporary file", "", std::strerror(errno));
  // Programs started by this one must not inherit it.
  fcntl(fileno(file.get()), F_SETFD, FD_CLOEXEC);
  return file;
}

std::string content(std::FILE* file) {
  std::string text;
  std::rewind(file);
  std::array<char, 1 << 16> piece{};
  for (std::size_t n = 0; (n = std::fread(piece.data(), 1, piece.size(), file)) > 0;) {
    text.append(piece.data(), n);
  }
  return text;
}

/// The status of a process that ended. One that is too slow, or an interrupt, ends it.
int end_of(pid_t process, const std::string& program, double patience) {
  const Stopwatch since;
  const bool asked_before = InterruptGuard::requested();
  int status = 0;
  while (true) {
    const pid_t ended = waitpid(process, &status, WNOHANG);
    if (ended == process) return status;
    if (ended < 0 && errno != EINTR) throw FileError(program, "", std::strerror(errno));
    const bool asked = !asked_before && InterruptGuard::requested();
    if (asked || since.seconds() > patience) {
      kill(process, SIGKILL);
      waitpid(process, &status, 0);
      if (asked) throw Interrupted();
      throw FileError(program, "", "does not end");
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

}  // namespace

std::string run_program(std::vector<std::string> words, const std::string& input,
                        const std::string& purpose, double patience) {
  const File in = temporary(), out = temporary(), err = temporary();
  const bool written = std::fwrite(input.data(), 1, input.size(), in.get()) == input.size() &&
                       std::fflush(in.get()) == 0;
  if (!written) throw FileError("temporary file", "", "cannot be written");
  std::rewind(in.get());
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, fileno(in.get()), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(out.get()), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(err.get()), STDERR_FILENO);
  const std::string program = words.at(0);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t process = 0;
  const int failed =
      posix_spawnp(&process, program.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) {
    throw FileError(program, "",
                    fmt::format("cannot be run ({}); {}", std::strerror(failed), purpose));
  }
  const int status = end_of(process, program, patience);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw FileError(
        program, "",
        fmt::format("ended with {}: {}", WIFEXITED(status) ? WEXITSTATUS(status) : WTERMSIG(status),
                    content(err.get()).substr(0, 500)));
  }
  return content(out.get());
}

std::string run_gnuplot(const std::string& script) {
  constexpr double kPatience = 120;  // seconds for one chart
  return run_program({"gnuplot", "--default-settings"}, script,
                     "charts are drawn by it: install the package gnuplot-nox", kPatience);
}

}  // namespace bipot
