#pragma once

#include <chrono>
#include <exception>

namespace bipot {

/// Connects Python with a computation that runs without Python's lock. It checks every tenth of a
/// second whether Ctrl-C was pressed. It keeps exceptions of Python code called by the computation
/// until that has ended. For one thread, the one that computes.
class PythonWatch {
 public:
  /// True: stop, because of an exception or stop(). Takes Python's lock if needed.
  bool stopped();
  /// Ends the computation without an exception.
  void stop() { stopped_ = true; }
  /// Ends the computation; `thrown` is thrown by rethrow(). The first one counts.
  void keep(std::exception_ptr thrown);
  /// True if something was kept.
  bool raised() const { return thrown_ != nullptr; }
  /// Call with Python's lock held, after the computation.
  void rethrow() const;

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kPause{100};

  Clock::time_point next_ = Clock::now() + kPause;
  bool stopped_ = false;
  std::exception_ptr thrown_;
};

}  // namespace bipot
