#include "core/run_files/background_writer.h"

#include <system_error>
#include <utility>

#include "core/base/interrupt.h"

namespace bipot {

BackgroundWriter::~BackgroundWriter() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    over_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void BackgroundWriter::begin(std::function<void()> job) {
  finish();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    job_ = std::move(job);
    under_way_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable() || start()) return;
  under_way_ = false;  // no thread to be had
  std::exchange(job_, nullptr)();
}

/// True if the system provides a thread.
bool BackgroundWriter::start() {
  const InterruptBlock block;
  try {
    thread_ = std::thread(&BackgroundWriter::work, this);
  } catch (const std::system_error&) {
  }
  return thread_.joinable();
}

void BackgroundWriter::finish() {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] { return !under_way_; });
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void BackgroundWriter::check() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void BackgroundWriter::work() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return job_ || over_; });
    if (!job_) return;
    std::function<void()> job = std::exchange(job_, nullptr);
    lock.unlock();
    std::exception_ptr failure;
    try {
      job();
    } catch (...) {
      failure = std::current_exception();
    }
    job = nullptr;  // frees the captured data before the next job comes
    lock.lock();
    failure_ = std::move(failure);
    under_way_ = false;
    changed_.notify_all();
  }
}

}  // namespace bipot
