#include "bench/report/build_info.h"

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
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  const std::size_t length = std::strftime(text, sizeof text, "%Y-%m-%d %H:%M UTC", &utc);
  return {text, length};
}

}  // namespace bipot
