#include "bench/report/build_info.h"

#include <fmt/chrono.h>

#include <ctime>
#include <fstream>
#include <thread>

#include "build_commit.h"
#include "core/base/version.h"

namespace bipot {

BuildInfo build_info() {
  BuildInfo info{.version = program_version(),
                 .commit = BIPOT_COMMIT,
                 .compiler = BIPOT_COMPILER,
                 .flags = BIPOT_FLAGS,
                 .build_type = BIPOT_BUILD_TYPE,
                 .cpu = "unknown",
                 .cores = static_cast<int>(std::thread::hardware_concurrency())};
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) {
      info.cpu = line.substr(colon + 2);
      break;
    }
  }
  return info;
}

std::string date_and_time() {
  return fmt::format("{:%Y-%m-%d %H:%M} UTC", fmt::gmtime(std::time(nullptr)));
}

}  // namespace bipot
