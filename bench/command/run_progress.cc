#include "bench/command/run_progress.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>
#include <fstream>

#include "bench/report/labels.h"
#include "core/base/counted.h"
#include "core/base/file_error.h"
#include "core/base/interrupt.h"
#include "core/base/version.h"

namespace bipot {
namespace {

void append(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::app);
  file << text << std::flush;
  if (!file) throw FileError(path, "", "cannot write");
}

}  // namespace

RunProgress::RunProgress(long steps, Options options)
    : steps_(std::max(steps, 1L)),
      options_(std::move(options)),
      bar_(steps, options_.quiet),
      tell_after_(options_.patience) {
  if (options_.folder.empty()) return;
  log_ = options_.folder / "run.log";
  std::error_code none;
  if (!options_.resume) std::filesystem::remove(log_, none);
  append(log_, fmt::format("bipot {}, {} steps, started {:%Y-%m-%d %H:%M:%S} UTC\n",
                           program_version(), steps, fmt::gmtime(std::time(nullptr))));
  const InterruptBlock leaves_signals_to_the_run;
  observer_ = std::thread([this] {
    const std::chrono::duration<double> pause(std::min(1.0, options_.patience));
    std::unique_lock lock(mutex_);
    try {
      while (!end_.wait_for(lock, pause, [this] { return over_; })) look_at_the_step();
    } catch (const std::exception&) {  // no log: the run itself meets it
    }
  });
}

RunProgress::~RunProgress() {
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  end_.notify_all();
  if (observer_.joinable()) observer_.join();
}

void RunProgress::look_at_the_step() {
  const double waited = watch_.seconds() - step_began_, error = error_;
  if (waited < options_.patience || done_ == steps_) return;
  const std::string state = fmt::format(
      "{:.0f} s so far{}", waited,
      std::isnan(error)
          ? ""
          : fmt::format(", best error {:.1e}, tolerance {}", error, tolerance_label(options_.tol)));
  bar_.update(done_, fmt::format("step {}: {}", options_.step + 1, state));
  if (waited < tell_after_) return;
  std::string text =
      fmt::format("step {} at t = {:.4g} s: {}\n", options_.step + 1, options_.time, state);
  if (!options_.hint.empty()) text += fmt::format("  {}\n", std::exchange(options_.hint, ""));
  while (tell_after_ <= waited) tell_after_ *= 2;
  bar_.say(text);
  append(log_, text);
}

template <int D>
void RunProgress::add(const StepReport<D>& report, long done, double time) {
  const std::lock_guard lock(mutex_);
  options_.step = report.step;
  options_.time = time;
  done_ = done;
  step_began_ = watch_.seconds();
  tell_after_ = options_.patience;
  error_ = kNaN;
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
