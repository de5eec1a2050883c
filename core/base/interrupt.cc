#include "core/base/interrupt.h"

#include <pthread.h>

namespace bipot {
namespace {

volatile std::sig_atomic_t interrupt_requested = 0;  // written by the signal handler alone
int guards = 0;                                      // alive

void on_signal(int signal) {
  interrupt_requested = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

InterruptGuard::InterruptGuard() {
  if (guards++ > 0) return;
  interrupt_requested = 0;
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
}

InterruptGuard::~InterruptGuard() {
  if (--guards > 0) return;
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

bool InterruptGuard::requested() { return interrupt_requested != 0; }

InterruptBlock::InterruptBlock() {
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGINT);
  sigaddset(&ends, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &ends, &before_);
}

InterruptBlock::~InterruptBlock() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

}  // namespace bipot
