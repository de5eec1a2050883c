#pragma once

#include <string>

namespace bipot {

/// Origin of a measurement: the program and the machine.
struct BuildInfo {
  std::string version, commit, compiler, flags, build_type;
  std::string cpu;  ///< model name, "unknown" if the system does not give it
  int cores = 0;    ///< logical; the solvers use one
};
BuildInfo build_info();

/// The present time, as in "2026-11-20 16:50 UTC".
std::string date_and_time();

}  // namespace bipot
