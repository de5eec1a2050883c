#include "bench/command/run_progress.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <fstream>

#include "core/base/counted.h"
#include "core/base/file_error.h"
#include "core/base/version.h"

namespace bipot {
namespace {

void append(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::app);
  file << text << std::flush;
  if (!file) throw FileError(path, "", "cannot write");
}

}  // namespace

RunProgress::RunProgress(long steps, bool quiet, const std::filesystem::path& folder, bool resume)
    : steps_(std::max(steps, 1L)), bar_(steps, quiet) {
  if (folder.empty()) return;
  log_ = folder / "run.log";
  std::error_code none;
  if (!resume) std::filesystem::remove(log_, none);
  append(log_, fmt::format("bipot {}, {} steps, started {:%Y-%m-%d %H:%M:%S} UTC\n",
                           program_version(), steps, fmt::gmtime(std::time(nullptr))));
}

template <int D>
void RunProgress::add(const StepReport<D>& report, long done, double time) {
  if (!report.converged) ++unsolved_;
  const double error = report.error.guarded();
  worst_ = std::max(worst_, error);
  const bool springs = std::isnan(error);
  const std::string note =
      fmt::format("t = {:.4g} s{}, {}", time,
                  springs ? "" : fmt::format(", {} unsolved, error {:.1e}", unsolved_, error),
                  counted(report.contacts, "contact"));
  bar_.update(done, note);
  const long tenths = 10 * done / steps_;
  if (log_.empty() || tenths <= tenths_) return;
  tenths_ = tenths;
  append(log_,
         fmt::format("{:3} %  step {}, {}{}, {:.1f} s\n", 10 * tenths, report.step, note,
                     springs ? "" : fmt::format(", worst error {:.1e}", worst_), watch_.seconds()));
}

void append_to_log(const std::filesystem::path& folder, const std::string& text) {
  append(folder / "run.log", text);
}

template void RunProgress::add(const StepReport<2>&, long, double);
template void RunProgress::add(const StepReport<3>&, long, double);

}  // namespace bipot
