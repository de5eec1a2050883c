#pragma once

#include <csignal>
#include <stdexcept>

namespace bipot {

/// During its life, Ctrl-C (SIGINT) and SIGTERM ask for an orderly end instead of killing: solvers
/// stop at their next iteration. A second signal kills. A guard within another one adds nothing.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  static bool requested();
};

/// What ends work without a result of its own when an end was asked for.
struct Interrupted : std::runtime_error {
  Interrupted() : std::runtime_error("interrupted") {}
};

/// Threads that begin during its life leave these signals to the other threads.
class InterruptBlock {
 public:
  InterruptBlock();
  ~InterruptBlock();
  InterruptBlock(const InterruptBlock&) = delete;
  InterruptBlock& operator=(const InterruptBlock&) = delete;

 private:
  sigset_t before_;
};

}  // namespace bipot
