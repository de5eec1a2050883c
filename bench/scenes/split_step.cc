#include "bench/scenes/split_step.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace bipot {
namespace {

/// Both lists are sorted by (i, j). Frames, velocities and statuses are those of the later part.
std::vector<ContactOutcome> added(const std::vector<ContactOutcome>& first,
                                  const std::vector<ContactOutcome>& second) {
  const auto key = [](const ContactOutcome& c) { return std::pair(c.contact.i, c.contact.j); };
  std::vector<ContactOutcome> sum;
  auto a = first.begin();
  for (const ContactOutcome& b : second) {
    for (; a != first.end() && key(*a) < key(b); ++a) sum.push_back(*a);
    ContactOutcome both = b;
    if (a != first.end() && key(*a) == key(b)) {
      both.s_n += a->s_n;
      both.s_t += a->s_t;
      ++a;
    }
    sum.push_back(both);
  }
  sum.insert(sum.end(), a, first.end());
  return sum;
}

/// The parts of one step so far.
class Parts {
 public:
  Parts(const Scene& scene, const StepSolver& solver, bool explicit_delassus, State start,
        int threads)
      : scene_(scene),
        solver_(solver),
        explicit_delassus_(explicit_delassus),
        threads_(threads),
        state_(std::move(start)) {}

  void take(double h, int halvings) {
    Scene part = scene_;
    part.step = h;
    TimeStepper stepper(part, solver_, explicit_delassus_, threads_);
    State next = state_;
    std::string why;
    try {
      const StepReport report = stepper.advance(next);
      if (report.converged) {
        add(report, std::move(next));
        return;
      }
      why = report.message;
    } catch (const StepFailure& failure) {
      if (failure.kind != StepFailure::Kind::kNumerical) throw;
      why = failure.what();
    }
    if (halvings == 0) {
      throw StepFailure(StepFailure::Kind::kNotConverged, state_,
                        fmt::format("not solved with a step of {:.3g} s either: {}", h, why));
    }
    take(0.5 * h, halvings - 1);
    take(0.5 * h, halvings - 1);
  }

  SplitStep finish(State& state) {
    const int step = state.step + 1;
    const double time = time_after_step(state, scene_.step);
    state = std::move(state_);
    state.contacts = std::move(contacts_);
    state.step = total_.step = step;
    state.time = total_.time = time;
    return {std::move(total_), parts_};
  }

 private:
  void add(const StepReport& part, State next) {
    const StepReport before = std::exchange(total_, part);
    if (parts_++ > 0) {
      total_.iterations += before.iterations;
      total_.energy.imbalance += before.energy.imbalance;
      total_.momentum_imbalance += before.momentum_imbalance;
      total_.penetration = std::max(total_.penetration, before.penetration);
      total_.contacts = std::max(total_.contacts, before.contacts);
      total_.active = std::max(total_.active, before.active);
      total_.detection_seconds += before.detection_seconds;
      total_.assembly_seconds += before.assembly_seconds;
      total_.solve_seconds += before.solve_seconds;
      if (before.error.guarded() > total_.error.guarded()) total_.error = before.error;
    }
    contacts_ = added(contacts_, next.contacts);
    state_ = std::move(next);
  }

  const Scene& scene_;
  const StepSolver& solver_;
  bool explicit_delassus_;
  int threads_;
  State state_;
  StepReport total_;
  std::vector<ContactOutcome> contacts_;
  int parts_ = 0;
};

}  // namespace

SplitStep advance_in_parts(const Scene& scene, const StepSolver& solver, bool explicit_delassus,
                           State& state, int threads) {
  Parts parts(scene, solver, explicit_delassus, state, threads);
  parts.take(0.5 * scene.step, kMostHalvings - 1);
  parts.take(0.5 * scene.step, kMostHalvings - 1);
  return parts.finish(state);
}

}  // namespace bipot
