#pragma once

#include <csignal>

namespace bipot {

/// During its life, Ctrl-C (SIGINT) and SIGTERM ask for an orderly end instead of killing: solvers
/// stop at their next iteration. A second signal kills.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  static bool requested();
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
