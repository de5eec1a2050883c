#pragma once

#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <system_error>
#include <utility>

#include "core/base/interrupt.h"

namespace bipot {

/// Writes on a thread while the caller goes on: one job at a time, in the order given. Signals that
/// ask for an orderly end go to the caller's thread. The end of a writer waits for its job, whose
/// exception is lost then: call finish() first.
class BackgroundWriter {
 public:
  /// finish(), then hands the job over; does it where there is no thread to be had.
  void begin(std::function<void()> job) {
    finish();
    const auto given = std::make_shared<std::function<void()>>(std::move(job));
    // The captured data go with the job, not with its result.
    const auto work = [given] { std::exchange(*given, nullptr)(); };
    try {
      const InterruptBlock block;
      job_ = std::async(std::launch::async, work);
      return;
    } catch (const std::system_error&) {
    }
    work();
  }
  /// Waits for a job under way, and rethrows its exception, once.
  void finish() {
    if (job_.valid()) job_.get();
  }
  /// Rethrows the exception of a job that has ended; does not wait.
  void check() {
    if (job_.valid() && job_.wait_for(std::chrono::seconds(0)) == std::future_status::ready)
      finish();
  }

 private:
  std::future<void> job_;
};

}  // namespace bipot
