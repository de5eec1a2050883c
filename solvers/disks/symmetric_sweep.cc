#include "solvers/disks/symmetric_sweep.h"

#include <algorithm>
#include <span>
#include <utility>

#include "core/base/parallel.h"
#include "core/base/stopwatch.h"

namespace bipot {
namespace {

/// One thread, if a sweep can follow only near the end of the one before: a second one would wait.
int threads_of(const TileLinks& links, int threads) {
  const int tiles = static_cast<int>(links.ready_up.size());
  return 3 * std::max(links.ready_up.front(), links.ready_down.front()) < tiles ? threads : 1;
}

}  // namespace

template <int D>
SymmetricSweep<D>::SymmetricSweep(const ContactProblem& problem, const BodiesOf<D>& bodies,
                                  const ContactScaling& equilibrated, double omega, int sweeps,
                                  const Execution& options)
    : SymmetricSweep(problem, bodies, equilibrated, omega, sweeps, options,
                     symmetric_order(bodies)) {}

template <int D>
SymmetricSweep<D>::SymmetricSweep(const ContactProblem& problem, const BodiesOf<D>& bodies,
                                  const ContactScaling& equilibrated, double omega, int sweeps,
                                  const Execution& options, ContactTiles order)
    : links_(tile_links(order, bodies)),
      disks_(problem, bodies, equilibrated, std::move(order)),
      kernels_(disk_kernels<D>(options.path)),
      omega_(omega),
      sweeps_(sweeps),
      team_(threads_of(links_, options.threads)),
      asks_ahead_(disks_.asks_ahead(
          {sizeof(ContactBatch<D>) + 3 * sizeof(ImpulseBatch<D>), 3 * sizeof(RowOf<D>)})),
      forth_(links_.ready_up),
      back_(links_.ready_down),
      now_(to_size(disks_.num_batches())),
      next_(now_.size()),
      velocity_(to_size(disks_.num_rows())) {}

template <int D>
void SymmetricSweep<D>::reset(const Vector& s) {
  disks_.pack(s, now_);
  refresh();
}

template <int D>
void SymmetricSweep<D>::refresh() {
  disks_.velocities(now_, velocity_);
  before_ = now_;
  velocity_before_ = velocity_;
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
    SymmetricTask<D> task{.first_batch = tile.first_batch,
                          .last_batch = tile.last_batch,
                          .ask_ahead = asks_ahead_,
                          .beta = beta,
                          .omega = omega_,
                          .contact = disks_.contacts(disks_.tile(0)),
                          .law = disks_.law_numbers(disks_.tile(0)),
                          .laws = disks_.laws(),
                          .now = now_.data(),
                          .before = before};
    task.next = next_.data();
    task.velocity = velocity_before_.data();
    task.inverse = disks_.inverse();
    return task;
  };
  const auto forth = [&](int sweep, int place) {
    const ContactTiles::Tile& tile = disks_.tile(place);
    SymmetricTask<D> task = task_of(tile);
    task.outer = sweep == 0;
    if (task.outer) {
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
  TurnSums sums;
  const auto back = [&](int sweep, int place) {
    const int t = disks_.num_tiles() - 1 - place;
    SymmetricTask<D> task = task_of(disks_.tile(t));
    task.outer = sweep == sweeps_ - 1;
    if (t > 0) {
      const std::span<const unsigned> coming = links_.coming_to(t - 1);
      task.coming = coming.data();
      task.num_coming = static_cast<int>(coming.size());
    }
    kernels_.sweep_back(task, sums);
  };
  forth_.begin(sweeps_);
  back_.begin(sweeps_);
  const Stopwatch watch;
  run_team(std::min(team_.threads(), sweeps_), [&](int rank, int size) {
    forth_.run(rank, size, forth);
    // The last forward member is at the place where the first backward one begins.
    back_.run(size - 1 - rank, size, back);
  });
  team_.took(watch.seconds());
  double turn = 0;
  for (const double lane : sums.turn) turn += lane;
  return turn;
}

template class SymmetricSweep<1>;
template class SymmetricSweep<2>;
template class SymmetricSweep<3>;

}  // namespace bipot
