#include "solvers/methods/gauss_seidel.h"

#include <cstdint>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/problem/delassus.h"
#include "solvers/disks/contact_order.h"
#include "solvers/disks/rolling_bodies.h"
#include "solvers/disks/tiled_sweep.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/parallel/split_sweep.h"
#include "solvers/solve_run.h"

namespace bipot {
namespace {

/// The order of the contacts in each sweep.
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

/// Largest number of iterations between two looks at the clock.
constexpr int kUnwatchedSweeps = 64;

/// Sweeps in vectors, tile by tile or contact after contact.
template <int D>
void sweep_vectors(SolveRun& run, const BodiesOf<D>& bodies, double omega, bool tiled) {
  const ContactProblem& p = run.problem();
  const ContactScaling scaling = equilibrated_scaling(p, run.delassus().diagonal());
  TiledSweep<D> sweep(p, bodies, scaling, omega, run.options().execution,
                      tiled ? tile_contacts(bodies) : given_order(bodies));
  sweep.reset(run.start());
  run.end_setup();
  int iteration = 0;
  while (!(run.due(iteration) && run.stop(iteration, sweep.impulse(), omega))) {
    const int count = run.undue(iteration, kUnwatchedSweeps);
    sweep.advance(count);
    iteration += count;
  }
}

template <ContactRows D>
void sweep_contacts(SolveRun& run, bool explicit_delassus, SweepOrder& order,
                    const LocalSettings& settings) {
  with_sweep_of<D>(run, settings, explicit_delassus, [&](auto& sweep, auto visit, auto meet) {
    sweep.reset(run.start());
    run.end_setup();
    int iteration = 0;
    while (!(run.due(iteration) && run.stop(iteration, sweep.impulse(), settings.omega))) {
      meet();
      order.sweep(iteration, visit);
      ++iteration;
    }
  });
}

}  // namespace

Parallel sweeps_in_parallel(const Parameters& parameters) {
  const std::string order = parameters.choice("order");
  const bool as_they_stand = order == "forward" || order == "symmetric";
  return as_they_stand && parameters.choice("operator") == "auto" ? Parallel::kYes : Parallel::kNo;
}

void solve_gauss_seidel(SolveRun& run) {
  const Parameters& parameters = run.parameters();
  const LocalSettings settings{.exact = parameters.choice("local") == "exact",
                               .local_iterations = parameters.integer("local_iterations"),
                               .omega = parameters.number("omega")};
  SweepOrder order(parameters.choice("order"), run.problem().num_contacts(),
                   static_cast<unsigned>(parameters.number("seed")));
  const bool explicit_delassus = parameters.choice("operator") == "explicit";
  const bool tiled = parameters.choice("order") == "tiled";
  // Spheres in the given order: vectors do the same contact after contact, if one round is all.
  const bool forward = parameters.choice("order") == "forward" && settings.one_round() &&
                       run.space().parts() == nullptr;
  dispatch_rows(run.problem(), [&](auto d) {
    constexpr ContactRows D = d();
    const bool in_vectors =
        ((tiled && settings.one_round()) || (forward && !D.in_plane())) && !explicit_delassus;
    const auto bodies = in_vectors ? kernel_bodies<D>(run.problem(), run.delassus()) : nullptr;
    if (bodies) return sweep_vectors<kKernelOf<D>>(run, *bodies, settings.omega, tiled);
    sweep_contacts<D>(run, explicit_delassus, order, settings);
    if (tiled) run.remark("; contacts as they stand, not tiled");
  });
}

}  // namespace bipot
