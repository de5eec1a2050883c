#pragma once

#include <algorithm>
#include <vector>

#include "core/motion/time_stepping.h"

namespace bipot {

/// The scene for a part of its step: without gates, since bodies come and go between whole steps.
template <int D>
Scene<D> part_of(Scene<D> scene) {
  scene.outlets.clear();
  scene.inlets.clear();
  return scene;
}

/// Scales the impulses, from which the next part starts, to its size.
template <int D>
void scale_impulses(std::vector<ContactOutcome<D>>& contacts, double factor) {
  for (ContactOutcome<D>& c : contacts) {
    c.s_n *= factor;
    c.s_t *= factor;
    c.moment *= factor;
  }
}

/// The parts of one step as one step. Losses, work, imbalances, iterations, times and the impulses
/// of each pair of bodies (core/motion/state.h) are summed, so that forces are those of the whole
/// step. The cost of rejected parts counts as well. The error is that of the worst part. Frames and
/// velocities of a contact are those of the last part that has it.
template <int D>
class SummedParts {
 public:
  /// `contacts`: of the state after the part.
  void add(const StepReport<D>& part, const std::vector<ContactOutcome<D>>& contacts);
  /// Parts that follow those so far.
  void add(const SummedParts& later) {
    if (later.count_ > 0) add(later.total_, later.contacts_);
    count_ += std::max(later.count_ - 1, 0);
    attempts_.add_cost(later.attempts_);
  }
  void add_rejected(const StepReport<D>& attempt) { attempts_.add_cost(attempt); }
  /// Rejects all parts so far.
  void reject_all() {
    attempts_.add_cost(total_);
    total_ = {};
    contacts_.clear();
    count_ = 0;
  }
  int count() const { return count_; }

  /// The report of the step of size h from the state `before`; `state`, at the end of the last
  /// part, gets number, time and contacts of the whole step.
  StepReport<D> finish(const State<D>& before, double h, State<D>& state);

 private:
  StepReport<D> total_, attempts_;  // of the parts taken; the cost of the others
  std::vector<ContactOutcome<D>> contacts_;
  int count_ = 0;
};

}  // namespace bipot
