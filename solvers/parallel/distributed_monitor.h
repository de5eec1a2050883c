#pragma once

#include <algorithm>
#include <functional>
#include <limits>

#include "core/base/stopwatch.h"
#include "core/criterion/error_terms.h"
#include "solvers/parallel/distributed_space.h"
#include "solvers/solver.h"

namespace bipot {

struct DistributedSolver;

/// The criterion of core/criterion/contact_error.h of a problem that lies on several processes: the
/// same terms of the same contacts, added up over all of them in one reduction. Collective; all
/// processes get the same.
class DistributedError {
 public:
  explicit DistributedError(DistributedSpace& space);

  /// Projects s, takes its velocity, judges. `more`: numbers that are to be added up with the sums
  /// of the criterion, in the same reduction. The worst contacts are left open (-1).
  ContactError operator()(const Vector& s, std::span<double> more = {});
  /// The same with the worst contacts' numbers in the whole problem: two more reductions.
  ContactError with_worst(const Vector& s);

  const Vector& impulse() const { return s_; }
  const Vector& velocity() const { return u_; }

 private:
  struct Worst {
    double violation = -1, natural = -1;
    int epsilon = -1, eta = -1;
  };
  ErrorSums local_sums(ExactSum* exact);
  int number_of_largest(double value, int contact);

  DistributedSpace& space_;
  ErrorWeights weights_;
  Worst worst_;
  Vector s_, u_;
};

/// IterationMonitor (solvers/monitor.h) for a problem that lies on several processes: the same
/// cadence, the same tests, the same messages. All processes stop at the same iteration: whether one
/// is out of time or was interrupted is asked with every judgement and every kPolled iterations.
class DistributedMonitor {
 public:
  /// `claim`: the last word on an impulse that meets the guarded test (proved_claim.h); the same
  /// on all processes.
  using Claim = std::function<bool(const Vector& s, const ContactError& error)>;
  /// A led solver (DistributedSolver::led) from the start s, rows that are here: its impulse and the
  /// number of its iterations.
  using Lead = std::function<Vector(const DistributedSolver& solver, const Vector& s,
                                    double seconds, int& iterations)>;
  /// Keeps references to the first three; evaluate's last impulse is overwritten.
  DistributedMonitor(DistributedSpace& space, DistributedError& evaluate,
                     const SolverOptions& options, Claim claim, Lead lead);

  bool due(int iteration);
  int undue(int iteration, int most) const;
  bool stop(int iteration, const Vector& s, double step = std::numeric_limits<double>::quiet_NaN(),
            bool moving = false);
  /// For a method that takes a led solver as a stage, within the time that is left. The next stop()
  /// judges, whatever the cadence.
  Vector lead(const DistributedSolver& solver, const Vector& s, int& iterations) {
    next_ = 0;
    return lead_(solver, s, std::max(options_.time_limit - watch_.seconds(), 1e-9), iterations);
  }
  void end_setup() { setup_seconds_ = watch_.seconds(); }
  double last_error() const { return last_.guarded(); }
  double best_error() const { return best_error_; }
  const Vector& best_impulse() const { return best_s_; }
  DistributedSpace& space() { return space_; }
  const SolverOptions& options() const { return options_; }

  /// As IterationMonitor's; s has the rows that are here.
  SolveResult finish();

 private:
  bool late() const { return watch_.seconds() >= options_.time_limit; }
  bool cancelled() const { return options_.cancelled && options_.cancelled(); }

  static constexpr int kPolled = 64;
  DistributedSpace& space_;
  DistributedError& evaluate_;
  const SolverOptions& options_;
  Claim claim_;
  Lead lead_;
  Stopwatch watch_;
  double setup_seconds_ = 0, free_energy_ = 0;
  ContactError last_;
  double best_error_ = std::numeric_limits<double>::infinity();
  Vector best_s_, previous_;
  int previous_iteration_ = -1, next_ = 0, next_poll_ = kPolled, iterations_ = 0;
  SolveStatus status_ = SolveStatus::kNotRun;
  std::string message_;
};

}  // namespace bipot
