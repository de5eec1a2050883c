#include "solvers/gauss_seidel.h"

#include <cstdint>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/delassus.h"
#include "solvers/contact_sweep.h"
#include "solvers/local_coulomb.h"
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
      order_.resize(contacts);
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

struct Settings {
  bool exact = false;
  int local_iterations = 1;
  double omega = 1;
};

/// Local problems of all contacts and the update of one of them.
template <int D>
class LocalUpdates {
 public:
  LocalUpdates(const ContactProblem& p, const DelassusOperator& delassus, const Settings& settings)
      : settings_(settings) {
    problems_.reserve(p.num_contacts());
    for (int c = 0; c < p.num_contacts(); ++c) {
      problems_.push_back(local_problem<D>(delassus.diagonal_block(c), p.mu[c]));
    }
  }

  template <class Sweep>
  void operator()(int c, Sweep& sweep) {
    LocalProblem<D>& local = problems_[c];
    const Local<D> s = sweep.impulse(c);
    const Local<D> u = sweep.velocity(c);
    if (settings_.exact) {
      local.q = u - local.w * s;
      Local<D> solution = s;
      if (solve_local<D>(local, solution)) {
        const Local<D> relaxed = s + settings_.omega * (solution - s);
        sweep.set(c, settings_.omega == 1 ? solution
                                          : project_coulomb_cone<D>(relaxed, local.mu));
        return;
      }
    }
    sweep.set(c, improve_local<D>(local, s, u, settings_.omega,
                                  settings_.exact ? 1 : settings_.local_iterations));
  }

 private:
  Settings settings_;
  std::vector<LocalProblem<D>> problems_;
};

template <class Sweep, class Update>
void iterate(Sweep& sweep, SweepOrder& order, const Settings& settings, IterationMonitor& monitor,
             Update update) {
  int iteration = 0;
  while (!(monitor.due(iteration) &&
           monitor.stop(iteration, sweep.impulse(), settings.omega))) {
    order.sweep(iteration, update);
    ++iteration;
  }
}

template <int D>
void run_disks(const ContactProblem& p, const DiskStructure& disks, const Vector& diagonal,
               const Vector& s0, SweepOrder& order, const Settings& settings,
               IterationMonitor& monitor) {
  DiskSweep<D> sweep(p, disks);
  for (int c = 0; c < p.num_contacts(); ++c) {
    const Local<D> w = diagonal.segment<D>(c * D);
    sweep.set_steps(c, settings.omega * w.cwiseInverse(), p.mu[c]);
  }
  sweep.reset(s0);
  monitor.end_setup();
  iterate(sweep, order, settings, monitor, [&](int c) { sweep.relax(c); });
}

template <int D>
void run(const ContactProblem& p, const DelassusOperator& delassus, const Vector& s0,
         bool explicit_delassus, SweepOrder& order, const Settings& settings,
         IterationMonitor& monitor) {
  if constexpr (D < 3) {
    if (delassus.disks() && !explicit_delassus) {
      run_disks<D>(p, *delassus.disks(), delassus.diagonal(), s0, order, settings, monitor);
      return;
    }
  }
  LocalUpdates<D> update(p, delassus, settings);
  const auto sweep_with = [&](auto sweep) {
    sweep.reset(s0);
    monitor.end_setup();
    iterate(sweep, order, settings, monitor, [&](int c) { update(c, sweep); });
    return 0;
  };
  if (explicit_delassus) {
    with_explicit_sweep<D>(p, sweep_with);
  } else {
    with_sweep<D>(p, sweep_with);
  }
}

}  // namespace

SolveResult solve_gauss_seidel(const ContactProblem& p, const SolverOptions& options) {
  const Parameters parameters(options.parameters, kGaussSeidelParameters);
  const Settings settings{.exact = parameters.choice("local") == "exact",
                          .local_iterations = parameters.integer("local_iterations"),
                          .omega = parameters.number("omega")};
  SweepOrder order(parameters.choice("order"), p.num_contacts(),
                   static_cast<unsigned>(parameters.number("seed")));
  const bool explicit_delassus = parameters.choice("operator") == "explicit";
  IterationMonitor monitor(p, options);
  const DelassusOperator& delassus = monitor.evaluator().delassus();
  const Vector s0 = options.s0.size() != 0 ? options.s0 : Vector(Vector::Zero(p.num_rows()));
  dispatch_dim(p.dim, [&](auto d) {
    run<d()>(p, delassus, s0, explicit_delassus, order, settings, monitor);
    return 0;
  });
  return monitor.finish();
}

}  // namespace bipot
