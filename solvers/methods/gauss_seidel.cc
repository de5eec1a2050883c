#include "solvers/methods/gauss_seidel.h"

#include <cstdint>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/problem/delassus.h"
#include "solvers/disks/tiled_sweep.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/kernels/local_updates.h"
#include "solvers/monitor.h"
#include "solvers/parameters.h"

namespace bipot {
namespace {

/// The order in which the contacts of each sweep are visited.
class SweepOrder {
 public:
  SweepOrder(const std::string& name, int contacts, unsigned seed)
      : contacts_(contacts), symmetric_(name == "symmetric"), engine_(seed) {
    if (name == "shuffled") {
      order_.resize(to_size(contacts));
      std::iota(order_.begin(), order_.end(), 0);
    }
  }

  template <class Visit>
  void sweep(int iteration, Visit visit) {
    if (!order_.empty()) {
      shuffle();
      for (const int c : order_) visit(c);
    } else if (symmetric_ && iteration % 2 == 1) {
      for (int c = contacts_ - 1; c >= 0; --c) visit(c);
    } else {
      for (int c = 0; c < contacts_; ++c) visit(c);
    }
  }

 private:
  /// Fisher and Yates. std::shuffle may differ from one library to the next.
  void shuffle() {
    for (std::uint64_t n = order_.size(); n > 1; --n) {
      std::swap(order_[n - 1], order_[(engine_() * n) >> 32]);
    }
  }

  int contacts_ = 0;
  bool symmetric_ = false;
  std::vector<int> order_;  // empty unless shuffled
  std::mt19937 engine_;
};

/// Iterations that may be done without a look at the clock.
constexpr int kUnwatchedSweeps = 64;

template <int D>
void run_tiled(const ContactProblem& p, const DelassusOperator& delassus, const Vector& s0,
               double omega, const Execution& execution, IterationMonitor& monitor) {
  const ContactScaling scaling = equilibrated_scaling(p, delassus.diagonal());
  TiledSweep<D> sweep(p, *delassus.disks(), scaling, omega, execution);
  sweep.reset(s0);
  monitor.end_setup();
  int iteration = 0;
  while (!(monitor.due(iteration) && monitor.stop(iteration, sweep.impulse(), omega))) {
    const int count = monitor.undue(iteration, kUnwatchedSweeps);
    sweep.advance(count);
    iteration += count;
  }
}

template <int D>
void run(const ContactProblem& p, const DelassusOperator& delassus, const Vector& s0,
         bool explicit_delassus, SweepOrder& order, const LocalSettings& settings,
         IterationMonitor& monitor) {
  with_local_updates<D>(p, delassus, settings, explicit_delassus, [&](auto& sweep, auto visit) {
    sweep.reset(s0);
    monitor.end_setup();
    int iteration = 0;
    while (!(monitor.due(iteration) && monitor.stop(iteration, sweep.impulse(), settings.omega))) {
      order.sweep(iteration, visit);
      ++iteration;
    }
  });
}

}  // namespace

SolveResult solve_gauss_seidel(const ContactProblem& p, const SolverOptions& options) {
  const Parameters parameters(options.parameters, kGaussSeidelParameters);
  const LocalSettings settings{.exact = parameters.choice("local") == "exact",
                               .local_iterations = parameters.integer("local_iterations"),
                               .omega = parameters.number("omega")};
  SweepOrder order(parameters.choice("order"), p.num_contacts(),
                   static_cast<unsigned>(parameters.number("seed")));
  const bool explicit_delassus = parameters.choice("operator") == "explicit";
  IterationMonitor monitor(p, options);
  const DelassusOperator& delassus = monitor.evaluator().delassus();
  const Vector s0 = start_of(p, options);
  const bool tiled = parameters.choice("order") == "tiled";
  dispatch_dim(p.dim, [&](auto d) {
    if constexpr (d() < 3) {
      if (tiled && delassus.disks() && !explicit_delassus) {
        run_tiled<d()>(p, delassus, s0, settings.omega, options.execution, monitor);
        return;
      }
    }
    run<d()>(p, delassus, s0, explicit_delassus, order, settings, monitor);
  });
  return monitor.finish();
}

}  // namespace bipot
