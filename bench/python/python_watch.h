#pragma once

#include <chrono>
#include <exception>

namespace bipot {

/// Between a computation that runs without Python's lock and Python: asks a tenth of a second apart
/// whether Ctrl-C was pressed, and keeps what Python code that the computation called has thrown
/// until the computation is over. For one thread, the one that computes.
class PythonWatch {
 public:
  /// True: stop, something is to be thrown or stop() was called. Takes Python's lock where needed.
  bool stopped();
  /// Ends the computation without an exception.
  void stop() { stopped_ = true; }
  /// Ends the computation; `thrown` is thrown by rethrow(). The first one counts.
  void keep(std::exception_ptr thrown);
  /// Call with Python's lock held, once the computation is over.
  void rethrow() const;

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kPause{100};

  Clock::time_point next_ = Clock::now() + kPause;
  bool stopped_ = false;
  std::exception_ptr thrown_;
};

}  // namespace bipot
