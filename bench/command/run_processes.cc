#include "bench/command/run_processes.h"

#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/base/interrupt.h"
#include "core/scene_files/scene_file.h"
#include "solvers/parallel/launch.h"

namespace bipot {
namespace {

std::unique_ptr<ProcessGroup> group_of_this_run;
std::FILE* own_voice = nullptr;  // standard error as it was

/// Mean over the steps.
Json to_json(const ProcessGroup::Traffic& traffic, int steps) {
  const double n = std::max(steps, 1);
  return {{"messages", static_cast<double>(traffic.messages) / n},
          {"bytes", static_cast<double>(traffic.bytes) / n},
          {"reductions", static_cast<double>(traffic.reductions) / n},
          {"reduced_bytes", static_cast<double>(traffic.reduced_bytes) / n}};
}

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
  const std::string text = fmt::format("bipot: process {} of {}: {}\n", launched_rank() + 1,
                                       launched_processes(), message);
  std::fputs(text.c_str(), voice);  // throws nothing
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
  if (dynamic_cast<const std::filesystem::filesystem_error*>(&e) != nullptr) return kExitIo;
  if (dynamic_cast<const std::invalid_argument*>(&e) != nullptr) return kExitBadInput;
  if (dynamic_cast<const SceneFileError*>(&e) != nullptr) return kExitBadInput;
  if (dynamic_cast<const Interrupted*>(&e) != nullptr) return kExitInterrupted;
  return kExitNumericalFailure;
}

Json to_json(const DistributedResult::Counts& counts) {
  return {
      {"processes", counts.processes},           {"imbalance", counts.imbalance},
      {"most_contacts", counts.most_contacts},   {"most_halo", counts.most_halo},
      {"messages", counts.traffic.messages},     {"bytes", counts.traffic.bytes},
      {"reductions", counts.traffic.reductions}, {"reduced_bytes", counts.traffic.reduced_bytes}};
}

std::string to_text(const DistributedResult::Counts& counts) {
  return fmt::format(
      "  processes {}, imbalance {:.2f}, at most {} contacts and {} copies of others' on one\n"
      "  sent by one: at most {} messages with {:.3e} bytes; {} reductions with {:.3e} bytes\n",
      counts.processes, counts.imbalance, counts.most_contacts, counts.most_halo,
      counts.traffic.messages, static_cast<double>(counts.traffic.bytes), counts.traffic.reductions,
      static_cast<double>(counts.traffic.reduced_bytes));
}

Json to_json(const DomainCounts& c, double peak_bytes) {
  return {{"most_bodies", c.most_bodies},
          {"most_ghosts", c.most_ghosts},
          {"most_contacts", c.most_contacts},
          {"most_halo", c.most_halo},
          {"imbalance", c.imbalance},
          {"cuts", c.cuts},
          {"migrated", c.migrated},
          {"gathers", c.gathers},
          {"peak_bytes", peak_bytes},
          {"a_step",
           {{"detection", to_json(c.detection, c.steps)},
            {"solve", to_json(c.solve, c.steps)},
            {"migration", to_json(c.migration, c.steps)},
            {"gathering", to_json(c.gathering, c.steps)}}}};
}

std::string to_text(const DomainCounts& c) {
  const double n = std::max(c.steps, 1);
  const auto sent = [&](const ProcessGroup::Traffic& t) {
    return fmt::format("{:.1f} messages, {:.3g} kB", static_cast<double>(t.messages) / n,
                       1e-3 * static_cast<double>(t.bytes) / n);
  };
  return fmt::format(
      "  one has      at most {} bodies and {} ghosts, {} contacts and {} of others; imbalance "
      "{:.2f}\n"
      "  moved        {} bodies to other processes, cells cut again {} times\n"
      "  one sends    a step: detection {}; solve {};\n"
      "               migration {}; {} gathered states {}\n",
      c.most_bodies, c.most_ghosts, c.most_contacts, c.most_halo, c.imbalance, c.migrated, c.cuts,
      sent(c.detection), sent(c.solve), sent(c.migration), c.gathers, sent(c.gathering));
}

}  // namespace bipot
