#pragma once

namespace bipot {

/// A task that is called by reference: cheap to hand over, and it never outlives the call.
class TaskRef {
 public:
  template <class F>
  TaskRef(const F& f)  // NOLINT: a lambda becomes a task by itself
      : object_(const_cast<void*>(static_cast<const void*>(&f))),
        call_([](void* object, int phase, int task) {
          (*static_cast<const F*>(object))(phase, task);
        }) {}
  void operator()(int phase, int task) const { call_(object_, phase, task); }

 private:
  void* object_;
  void (*call_)(void*, int, int);
};

/// Calls task(phase, k) for first[phase] <= k < last[phase], phase after phase, the tasks of a phase
/// on at most `threads` threads. A task must not depend on others of its phase: then the result has
/// the same bits for any number of threads. Of the exceptions that tasks throw, the one of the
/// first phase's first task is thrown again; later phases are not begun.
void run_phases(int threads, int phases, const int* first, const int* last, TaskRef task);

/// One phase: task(k) for 0 <= k < tasks.
template <class F>
void run_tasks(int threads, int tasks, F&& f) {
  const int first = 0;
  const auto call = [&f](int, int k) { f(k); };
  run_phases(threads, 1, &first, &tasks, call);
}

/// Calls member(rank, size) at the same time on each of a team of at most `threads` threads, whose
/// size may be less where the system gives fewer. Members may wait for each other. They must not
/// throw.
void run_team(int threads, TaskRef member);

/// While it lives, OpenMP loops of the libraries that this thread calls run on this thread alone,
/// however many they ask for.
class OneThread {
 public:
  OneThread();
  ~OneThread();
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int levels_ = 0;
};

/// Sums and other reductions work on pieces of this many items, whatever the number of threads.
inline constexpr int kPieceItems = 2048;

/// f(first, last) for pieces of kPieceItems items each; the piece's number is first / kPieceItems.
template <class F>
void run_pieces(int threads, int items, F&& f) {
  const int pieces = (items + kPieceItems - 1) / kPieceItems;
  run_tasks(threads, pieces, [&](int k) {
    const int first = k * kPieceItems;
    f(first, items - first < kPieceItems ? items : first + kPieceItems);
  });
}

}  // namespace bipot
