#include "bench/command/run_processes.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <memory>
#include <stdexcept>

#include "core/file_error.h"
#include "core/files/scene_file.h"
#include "solvers/distributed/launch.h"

namespace bipot {
namespace {

std::unique_ptr<ProcessGroup> group_of_this_run;
std::FILE* own_voice = nullptr;  // standard error as it was

}  // namespace

bool on_several_processes() { return launched_processes() > 1; }
bool is_speaker() { return launched_rank() == 0; }
bool processes_have_met() { return on_several_processes() && group_of_this_run != nullptr; }

ProcessGroup& run_processes() {
  if (!group_of_this_run) group_of_this_run = launched_group();
  return *group_of_this_run;
}

void together(const std::function<void()>& prepare) {
  if (!on_several_processes()) {
    prepare();
    return;
  }
  ProcessGroup& group = run_processes();
  std::string failure;
  try {
    prepare();
  } catch (const std::exception& e) {
    failure = fmt::format("{}{}", static_cast<int>(exit_code_for(e)), e.what());
  }
  failure = group.first_text(failure);
  if (failure.empty()) return;
  throw CommonCommandFailure(static_cast<ExitCode>(failure.front() - '0'), failure.substr(1));
}

void keep_others_quiet() {
  if (!on_several_processes() || is_speaker()) return;
  own_voice = fdopen(dup(STDERR_FILENO), "w");
  if (std::freopen("/dev/null", "w", stdout) == nullptr ||
      std::freopen("/dev/null", "w", stderr) == nullptr) {
    throw std::runtime_error("/dev/null cannot be opened");
  }
}

void say_from_here(const std::string& message) {
  std::FILE* voice = own_voice != nullptr ? own_voice : stderr;
  fmt::print(voice, "bipot: process {} of {}: {}\n", launched_rank() + 1, launched_processes(),
             message);
  std::fflush(voice);
}

void refuse_on_several_processes(const CommonFlags& flags, const std::string& flag) {
  if (!on_several_processes()) return;
  if (!flag.empty()) {
    throw std::invalid_argument(fmt::format("{} runs on one process, not under mpirun", flag));
  }
  if (flags.threads > 1) {
    throw std::invalid_argument("several processes take one thread each: leave out --threads");
  }
}

ExitCode exit_code_for(const std::exception& e) {
  if (const auto* common = dynamic_cast<const CommonCommandFailure*>(&e)) return common->exit_code;
  if (dynamic_cast<const FileError*>(&e) != nullptr) return kExitIo;
  if (dynamic_cast<const std::invalid_argument*>(&e) != nullptr) return kExitBadInput;
  if (dynamic_cast<const SceneFileError*>(&e) != nullptr) return kExitBadInput;
  return kExitNumericalFailure;
}

Json to_json(const DistributedCounts& counts) {
  return {
      {"processes", counts.processes},           {"imbalance", counts.imbalance},
      {"most_contacts", counts.most_contacts},   {"most_halo", counts.most_halo},
      {"messages", counts.traffic.messages},     {"bytes", counts.traffic.bytes},
      {"reductions", counts.traffic.reductions}, {"reduced_bytes", counts.traffic.reduced_bytes}};
}

std::string to_text(const DistributedCounts& counts) {
  return fmt::format(
      "  processes {}, imbalance {:.2f}, at most {} contacts and {} copies of others' on one\n"
      "  sent by one: at most {} messages with {:.3e} bytes; {} reductions with {:.3e} bytes\n",
      counts.processes, counts.imbalance, counts.most_contacts, counts.most_halo,
      counts.traffic.messages, static_cast<double>(counts.traffic.bytes), counts.traffic.reductions,
      static_cast<double>(counts.traffic.reduced_bytes));
}

}  // namespace bipot
