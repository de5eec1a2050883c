#pragma once

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

}  // namespace bipot
