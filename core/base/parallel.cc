#include "core/base/parallel.h"

#ifdef _OPENMP
#include <omp.h>
#endif

#include <algorithm>
#include <exception>
#include <mutex>

namespace bipot {
namespace {

/// Keeps the exception of the first task in order.
class FirstFailure {
 public:
  void keep(int phase, int task, std::exception_ptr failure) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (failure_ && task_ <= task) return;
    failure_ = std::move(failure);
    task_ = task;
    phase_ = phase;
  }
  /// A thread may be a phase ahead of the others.
  bool any_up_to(int phase) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return failure_ && phase_ <= phase;
  }
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  std::mutex mutex_;
  std::exception_ptr failure_;
  int task_ = 0, phase_ = 0;
};

}  // namespace

void run_phases(int threads, int phases, const int* first, const int* last, TaskRef task) {
  int widest = 0;
  for (int phase = 0; phase < phases; ++phase) {
    widest = std::max(widest, last[phase] - first[phase]);
  }
  threads = std::min(threads, widest);
  if (threads <= 1) {
    for (int phase = 0; phase < phases; ++phase) {
      for (int k = first[phase]; k < last[phase]; ++k) task(phase, k);
    }
    return;
  }
  FirstFailure failure;
  // Neighbouring tasks run on the same thread, as they share data.
#pragma omp parallel num_threads(threads)
  for (int phase = 0; phase < phases; ++phase) {
#pragma omp for schedule(static)
    for (int k = first[phase]; k < last[phase]; ++k) {
      try {
        task(phase, k);
      } catch (...) {
        failure.keep(phase, k, std::current_exception());
      }
    }
    // The barrier after the loop has made it visible to all.
    if (failure.any_up_to(phase)) break;
  }
  failure.rethrow();
}

void run_team(int threads, TaskRef member) {
  if (threads <= 1) {
    member(0, 1);
    return;
  }
#pragma omp parallel num_threads(threads)
  {
#ifdef _OPENMP
    member(omp_get_thread_num(), omp_get_num_threads());
#else
    member(0, 1);
#endif
  }
}

#ifdef _OPENMP
OneThread::OneThread() : levels_(omp_get_max_active_levels()) { omp_set_max_active_levels(0); }
OneThread::~OneThread() { omp_set_max_active_levels(levels_); }
#else
OneThread::OneThread() = default;
OneThread::~OneThread() = default;
#endif

}  // namespace bipot
