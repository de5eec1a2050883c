#pragma once

#include <string>

namespace bipot {

/// What made a measurement: the program and the machine.
struct BuildInfo {
  std::string version, commit, compiler, flags, build_type;
  std::string cpu;  ///< model name, "unknown" where the system does not say it
  int cores = 0;    ///< logical; the solvers use one
};
BuildInfo build_info();

/// When, as results say it: "2026-11-20 16:50 UTC".
std::string date_and_time();

}  // namespace bipot
