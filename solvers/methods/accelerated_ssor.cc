#include "solvers/methods/accelerated_ssor.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "solvers/disks/deflated_sweep.h"
#include "solvers/disks/rolling_bodies.h"
#include "solvers/disks/symmetric_sweep.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/kernels/gradient_kernel.h"
#include "solvers/kernels/local_updates.h"
#include "solvers/kernels/stagnation_test.h"
#include "solvers/solve_run.h"

namespace bipot {
namespace {

/// Largest number of iterations between two looks at the clock.
constexpr int kUnwatched = 32;
/// Number of contacts from which packed contacts are streamed from memory.
constexpr int kStreamed = 20000;
/// Iterations of more than two sweeps diverge on large packings if omega is near 2.
constexpr double kOmegaOfMany = 1.6;

/// Disks along a side of a packing with this number of contacts.
double side_of(const ContactProblem& p) {
  const double disks = p.num_contacts() / 3.0;
  return p.plain_dim() == 3 ? std::cbrt(disks) : std::sqrt(disks);
}

/// Two sweeps allow a larger omega than one, more than two a smaller one.
double relaxation_of(double side, int sweeps) {
  return std::clamp(2 / (1 + 11 / side), 1.0,
                    sweeps == 2   ? 1.91
                    : sweeps == 1 ? 1.85
                                  : kOmegaOfMany);
}

/// Schedule of the variants of the iteration, beginning with over-relaxed sweeps and momentum.
class Turns {
 public:
  /// `relaxable`: the kernel can change omega.
  Turns(double omega, bool relaxable, int sweeps, int most_sweeps, double side)
      : omega_(omega),
        again_(relaxable ? std::min(omega, kOmegaOfMany) : omega),
        plain_(relaxable ? std::min(omega, 1.0) : omega),
        sweeps_(sweeps),
        most_sweeps_(std::max(sweeps, most_sweeps)),
        stagnation_(200 + static_cast<int>(3 * side)) {}

  double omega() const {
    if (turn_ != 0) return plain_;
    return changes_ == 0 ? omega_ : again_;
  }
  /// More sweeps if the error stagnates.
  int sweeps() const {
    const int more = sweeps_ * (changes_ == 0 ? 1 : changes_ < kTurns ? 4 : 8);
    return std::min(more, most_sweeps_);
  }
  bool momentum() const { return turn_ != 2; }
  /// True if this variant starts from the caller's start, false for the best impulse: the result of
  /// over-relaxation is no good start on piles.
  bool afresh() const { return turn_ == 1 && changes_ == 1; }
  /// Records the best error so far. True if the variant changes.
  bool advance(int iteration, double best_error) {
    if (!stagnation_.stagnates(iteration, best_error)) return false;
    ++changes_;
    turn_ = (turn_ + 1) % kTurns;
    if (turn_ == 1 && plain_ == omega_) turn_ = 2;  // it would be the turn before once more
    return true;
  }

 private:
  static constexpr int kTurns = 3;
  double omega_, again_, plain_;
  int sweeps_, most_sweeps_;
  StagnationTest stagnation_;
  int turn_ = 0, changes_ = 0;
};

/// The iteration contact after contact; see SymmetricSweep.
template <class Sweep, class Visit>
class ContactByContact {
 public:
  ContactByContact(const ContactProblem& p, const ContactScaling& scaling, Sweep& sweep,
                   const Visit& visit, int sweeps)
      : contacts_(p.num_contacts()),
        sweeps_(sweeps),
        weight_(scaling.impulse.cwiseAbs2()),
        sweep_(sweep),
        visit_(visit) {}

  void reset(const Vector& s) { now_ = before_ = s; }
  /// The local updates keep their omega, and no variant asks for another.
  void relax(double, int sweeps) { sweeps_ = sweeps; }
  void refresh() {}  // every iteration has the velocities of its y
  const Vector& impulse() const { return now_; }
  double iterate(double beta) {
    y_ = now_ + beta * (now_ - before_);
    sweep_.reset(y_);
    for (int k = 0; k < sweeps_; ++k) {
      for (int c = 0; c < contacts_; ++c) visit_(c);
    }
    for (int k = 0; k < sweeps_; ++k) {
      for (int c = contacts_ - 1; c >= 0; --c) visit_(c);
    }
    std::swap(before_, now_);
    now_ = sweep_.impulse();
    return weight_.dot((y_ - now_).cwiseProduct(now_ - before_));
  }

 private:
  int contacts_, sweeps_;
  Vector weight_;
  Sweep& sweep_;
  const Visit& visit_;
  Vector now_, before_, y_;
};

enum class StressesEnd {
  kNone,     ///< there are none: nothing was done
  kSolve,    ///< the solve is over
  kGivenUp,  ///< the error stands
};

/// Stand-in if there is no deflation.
struct NoStresses {
  static bool due(double) { return false; }
  static StressesEnd finish(int&, SolveRun&) { return StressesEnd::kNone; }
};

/// The last stage of the iteration on large packings, once.
class Stresses {
 public:
  Stresses(SymmetricSweep<2>& sweep, const DiskStructure& disks, int least,
           const Execution& execution)
      : sweep_(sweep),
        disks_(disks),
        execution_(execution),
        done_(static_cast<int>(disks.contacts.size()) < least) {}

  bool due(double best_error) const { return !done_ && best_error < kSettled; }
  /// Starts from the best impulse.
  StressesEnd finish(int& iteration, SolveRun& run) {
    done_ = true;
    DeflatedSweep kernel(sweep_, disks_, execution_);
    if (!kernel.has_stresses() || run.out_of_time()) return StressesEnd::kNone;
    sweep_.relax(kOmega, kSweeps);
    if (!kernel.reset(run.best_impulse())) return StressesEnd::kGivenUp;
    double mark = run.best_error();
    for (int since = 0; since < kPatience;) {
      const int count = run.undue(iteration, kJudged);
      for (int k = 0; k < count; ++k) {
        if (!kernel.iterate()) return StressesEnd::kGivenUp;
        ++iteration;
      }
      since += count;
      run.judge_next();
      // "moving": an unchanged impulse is no stall here, since the main iteration continues.
      if (run.stop(iteration, kernel.impulse(), kOmega, true)) return StressesEnd::kSolve;
      if (run.best_error() <= 0.5 * mark) {
        mark = run.best_error();
        since = 0;
      }
    }
    return StressesEnd::kGivenUp;
  }

 private:
  /// Error from which deflation starts: while it is above 1, the stresses load contacts that will
  /// slip, and moving packings need more iterations.
  static constexpr double kSettled = 0.5;
  static constexpr double kOmega = 1.5;
  static constexpr int kSweeps = 4;
  static constexpr int kPatience = 24;  ///< iterations in which the error has to halve
  /// Every sixth iteration is judged: judging costs as much as three.
  static constexpr int kJudged = 6;

  SymmetricSweep<2>& sweep_;
  const DiskStructure& disks_;
  Execution execution_;
  bool done_;
};

template <class Kernel, class Stresses>
void iterate(Kernel& kernel, Turns turns, Stresses stresses, SolveRun& run) {
  kernel.reset(run.start());
  run.end_setup();
  double t = 1, beta = 0;
  const auto begin_again = [&](const Vector& s) {
    kernel.reset(s);
    kernel.relax(turns.omega(), turns.sweeps());
    t = 1;
    beta = 0;
  };
  for (int iteration = 0;;) {
    if (run.due(iteration)) {
      if (run.stop(iteration, kernel.impulse(), turns.omega())) return;
      if (stresses.due(run.best_error())) {
        const StressesEnd end = stresses.finish(iteration, run);
        if (end == StressesEnd::kSolve) return;
        if (end == StressesEnd::kGivenUp) begin_again(run.best_impulse());
      }
      if (turns.advance(iteration, run.best_error())) {
        begin_again(turns.afresh() ? run.start() : run.best_impulse());
      }
    }
    const int count = run.undue(iteration, kUnwatched);
    for (int k = 0; k < count; ++k) {
      const bool uphill = kernel.iterate(beta) > 0;
      if (uphill) kernel.refresh();
      const double last = uphill || !turns.momentum() ? 1 : t;
      t = next_momentum(last);
      beta = (last - 1) / t;
    }
    iteration += count;
  }
}

}  // namespace

void solve_accelerated_ssor(SolveRun& run) {
  const Parameters& parameters = run.parameters();
  const ContactProblem& p = run.problem();
  const double given = parameters.number("omega");
  const int sweeps = parameters.integer("sweeps");
  const double side = side_of(p), omega = given > 0 ? given : relaxation_of(side, sweeps);
  const DelassusOperator& delassus = run.delassus();
  const Execution& execution = run.options().execution;
  ContactScaling scaling = equilibrated_scaling(p, delassus.diagonal());
  dispatch_rows(p, [&](auto d) {
    constexpr ContactRows D = d();
    const auto bodies = kernel_bodies<D>(p, delassus);
    const bool packed = bodies != nullptr;
    const Turns turns(omega, packed, sweeps, parameters.integer("most_sweeps"), side);
    run.judge_half_as_often(packed && p.num_contacts() >= kStreamed);
    if (packed) {
      SymmetricSweep<kKernelOf<D>> kernel(p, *bodies, scaling, omega, sweeps, execution);
      scaling = {};  // the kernel has its own
      if constexpr (D == 2 && !D.rolls) {
        const int least = parameters.integer("stresses_from");
        iterate(kernel, turns, Stresses(kernel, *bodies, least, execution), run);
      } else {
        iterate(kernel, turns, NoStresses(), run);
      }
      return;
    }
    with_local_updates<D>(p, delassus, {.omega = omega}, false,
                          [&](auto& sweep, const auto& visit) {
                            ContactByContact kernel(p, scaling, sweep, visit, sweeps);
                            iterate(kernel, turns, NoStresses(), run);
                          });
  });
}

}  // namespace bipot
