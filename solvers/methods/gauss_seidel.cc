#include "solvers/methods/gauss_seidel.h"

#include <cstdint>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/problem/delassus.h"
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
  dispatch_dim(p.dim, [&](auto d) {
    run<d()>(p, delassus, s0, explicit_delassus, order, settings, monitor);
  });
  return monitor.finish();
}

}  // namespace bipot
