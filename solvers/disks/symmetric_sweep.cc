#include "solvers/disks/symmetric_sweep.h"

#include <algorithm>
#include <span>
#include <utility>

#include "core/base/parallel.h"
#include "core/base/stopwatch.h"
#include "solvers/disks/contact_order.h"

namespace bipot {
template <int D>
SymmetricSweep<D>::SymmetricSweep(const ContactProblem& problem, const BodiesOf<D>& bodies,
                                  const ContactScaling& equilibrated, double omega, int sweeps,
                                  const Execution& options)
    : disks_(problem, bodies, equilibrated, symmetric_order(bodies), options.threads),
      links_(tile_links(disks_.order(), bodies)),
      kernels_(disk_kernels<D>(options.path)),
      omega_(omega),
      sweeps_(sweeps),
      threads_(options.threads),
      asks_ahead_(disks_.asks_ahead(
          {sizeof(ContactBatch<D>) + 3 * sizeof(ImpulseBatch<D>), 3 * sizeof(RowOf<D>)})),
      schedule_(schedule({sweeps, sweeps})),
      team_(schedule_.threads()),
      sums_(to_size(disks_.num_tiles())),
      now_(to_size(disks_.num_batches())),
      before_(now_.size()),
      next_(now_.size()),
      velocity_(to_size(disks_.num_rows())),
      velocity_before_(velocity_.size()) {}

template <int D>
SweepSchedule SymmetricSweep<D>::schedule(SweepSchedule::Sweeps sweeps) const {
  std::vector<int> batches;
  for (int t = 0; t < disks_.num_tiles(); ++t) {
    batches.push_back(disks_.tile(t).last_batch - disks_.tile(t).first_batch);
  }
  return {links_, batches, sweeps, threads_};
}

template <int D>
void SymmetricSweep<D>::relax(double omega, int sweeps) {
  omega_ = omega;
  if (sweeps == sweeps_) return;
  sweeps_ = sweeps;
  schedule_ = schedule({sweeps_, sweeps_});
  team_ = QuickerTeam(schedule_.threads());
}

template <int D>
void SymmetricSweep<D>::reset(const Vector& s) {
  disks_.pack(s, now_);
  refresh();
}

template <int D>
void SymmetricSweep<D>::refresh() {
  disks_.velocities(now_, velocity_);
  run_pieces(threads_, disks_.num_batches(), [&](int first, int last) {
    std::copy(&now_[0] + first, &now_[0] + last, &before_[0] + first);
  });
  run_pieces(threads_, disks_.num_rows(), [&](int first, int last) {
    std::copy(&velocity_[0] + first, &velocity_[0] + last, &velocity_before_[0] + first);
  });
}

template <int D>
const Vector& SymmetricSweep<D>::impulse() {
  disks_.unpack(now_, s_);
  return s_;
}

template <int D>
double SymmetricSweep<D>::iterate(double beta) {
  const double turn = sweep_from(beta, before_.data());
  std::swap(velocity_, velocity_before_);
  std::swap(before_, next_);  // x⁻ was used for the last time
  std::swap(now_, before_);
  return turn;
}

template <int D>
typename SymmetricSweep<D>::Swept SymmetricSweep<D>::sweep() {
  sweep_from(0, now_.data());
  return {now_, next_, before_, velocity_, velocity_before_};
}

/// Leaves S(y) in next_ and its velocities in velocity_before_.
template <int D>
double SymmetricSweep<D>::sweep_from(double beta, const ImpulseBatch<D>* before) {
  const auto task_of = [&](const ContactTiles::Tile& tile) {
    SymmetricTask<D> task{disks_.packed()};
    task.first_batch = tile.first_batch;
    task.last_batch = tile.last_batch;
    task.ask_ahead = asks_ahead_;
    task.beta = beta;
    task.omega = omega_;
    task.now = now_.data();
    task.before = before;
    task.next = next_.data();
    task.velocity = velocity_before_.data();
    task.inverse = disks_.inverse();
    return task;
  };
  const auto forth = [&](const ContactTiles::Tile& tile, bool first) {
    SymmetricTask<D> task = task_of(tile);
    task.outer = first;
    task.ask_ahead = first && asks_ahead_;  // later, lists are in the cache
    if (first) {
      // No sweep has used these bodies yet.
      constexpr int kParts = static_cast<int>(sizeof(RowOf<D>) / sizeof(BodyRow));
      const auto rows = [&](auto& of) {
        return reinterpret_cast<BodyRow*>(of.data() + tile.first_row);
      };
      kernels_.extrapolate_velocity({kParts * (tile.last_row - tile.first_row), asks_ahead_, beta,
                                     rows(velocity_), rows(velocity_before_)});
    }
    kernels_.sweep_forth(task);
  };
  const auto back = [&](int t, bool last) {
    SymmetricTask<D> task = task_of(disks_.tile(t));
    task.outer = last;
    if (t > 0) {
      const std::span<const unsigned> coming = links_.coming.of(t - 1);
      task.coming = coming.data();
      task.num_coming = static_cast<int>(coming.size());
    }
    sums_[to_size(t)] = {};
    kernels_.sweep_back(task, sums_[to_size(t)]);
  };
  const Stopwatch watch;
  schedule_.run(team_.threads() == 1, [&](int sweep, int tile) {
    if (sweep < sweeps_) {
      forth(disks_.tile(tile), sweep == 0);
    } else {
      back(tile, sweep == 2 * sweeps_ - 1);
    }
  });
  team_.took(watch.seconds());
  double lanes[kLanes] = {}, turn = 0;
  for (const TurnSums& of : sums_) {
    for (int lane = 0; lane < kLanes; ++lane) lanes[lane] += of.turn[lane];
  }
  for (const double lane : lanes) turn += lane;
  return turn;
}

BIPOT_FOR_BODIES(template class SymmetricSweep);

}  // namespace bipot
