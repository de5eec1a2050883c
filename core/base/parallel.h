#pragma once

#include <vector>

namespace bipot {

/// A reference to a task: cheap to pass; it never outlives the call.
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

/// Calls task(phase, k) for first[phase] <= k < last[phase], phase after phase, the tasks of a
/// phase on at most `threads` threads. A task must not depend on others of its phase: then the
/// result has the same bits for any number of threads. If tasks throw, the exception of the first
/// task of the first phase is rethrown; later phases are not begun.
void run_phases(int threads, int phases, const int* first, const int* last, TaskRef task);

/// One phase: task(k) for 0 <= k < tasks.
template <class F>
void run_tasks(int threads, int tasks, F&& f) {
  const int first = 0;
  const auto call = [&f](int, int k) { f(k); };
  run_phases(threads, 1, &first, &tasks, call);
}

/// Calls member(rank, size) at the same time on each of a team of at most `threads` threads. The
/// size may be smaller if the system gives fewer. Members may wait for each other. They must not
/// throw.
void run_team(int threads, TaskRef member);

/// During its life, OpenMP loops of the libraries that this thread calls run on this thread alone.
class OneThread {
 public:
  OneThread();
  ~OneThread();
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int levels_ = 0;
};

/// Sums and other reductions work on parts of this many items, whatever the number of threads.
inline constexpr int kPieceItems = 2048;

/// Calls f(first, last) for parts of kPieceItems items each; the index of a part is first /
/// kPieceItems.
template <class F>
void run_pieces(int threads, int items, F&& f) {
  const int pieces = (items + kPieceItems - 1) / kPieceItems;
  run_tasks(threads, pieces, [&](int k) {
    const int first = k * kPieceItems;
    f(first, items - first < kPieceItems ? items : first + kPieceItems);
  });
}

/// Joins f(first, last) of the parts to `total`, in their order, by join(total, value): the same
/// bits for any number of threads.
template <class T, class F, class Join>
T join_pieces(int threads, int items, T total, F&& f, Join&& join) {
  struct Piece {
    T value;
  };
  std::vector<Piece> pieces(static_cast<unsigned>((items + kPieceItems - 1) / kPieceItems));
  run_pieces(threads, items, [&](int first, int last) {
    pieces[static_cast<unsigned>(first / kPieceItems)].value = f(first, last);
  });
  for (const Piece& piece : pieces) join(total, piece.value);
  return total;
}

}  // namespace bipot
