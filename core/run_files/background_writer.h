#pragma once

#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace bipot {

/// One thread that writes while the caller goes on: one job at a time, in the order given. The
/// thread starts with the first job. Signals that ask for an orderly end go to the caller's thread.
class BackgroundWriter {
 public:
  BackgroundWriter() = default;
  /// Waits for the job. An exception of it is lost here: call finish() first.
  ~BackgroundWriter();
  BackgroundWriter(const BackgroundWriter&) = delete;
  BackgroundWriter& operator=(const BackgroundWriter&) = delete;

  /// finish(), then hands the job over.
  void begin(std::function<void()> job);
  /// Waits for a job under way, and rethrows its exception, once.
  void finish();
  /// Rethrows the exception of a job that has ended; does not wait.
  void check();

 private:
  bool start();
  void work();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::function<void()> job_;  // that the thread has not begun
  bool under_way_ = false;
  std::exception_ptr failure_;
  bool over_ = false;
  std::thread thread_;
};

}  // namespace bipot
