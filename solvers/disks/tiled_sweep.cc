#include "solvers/disks/tiled_sweep.h"

#include <utility>

#include "solvers/disks/wavefront.h"

namespace bipot {

template <int D>
TiledSweep<D>::TiledSweep(const ContactProblem& problem, const BodiesOf<D>& bodies,
                          const ContactScaling& equilibrated, double omega,
                          const Execution& options, ContactTiles tiles)
    : disks_(problem, bodies, equilibrated, std::move(tiles), options.threads),
      kernels_(disk_kernels<D>(options.path)),
      omega_(omega),
      threads_(options.threads),
      pipeline_(disks_.pipeline(threads_, kStreamed)),
      asks_ahead_(disks_.asks_ahead(kStreamed)),
      impulse_(to_size(disks_.num_batches())),
      velocity_(to_size(disks_.num_rows())) {}

template <int D>
void TiledSweep<D>::reset(const Vector& s) {
  disks_.pack(s, impulse_);
  disks_.velocities(impulse_, velocity_);
}

template <int D>
const Vector& TiledSweep<D>::impulse() {
  disks_.unpack(impulse_, s_);
  return s_;
}

template <int D>
void TiledSweep<D>::advance(int sweeps) {
  run_wavefront(threads_, disks_.num_tiles(), sweeps, pipeline_, [&](int, int t) {
    const ContactTiles::Tile& tile = disks_.tile(t);
    SymmetricTask<D> task{disks_.packed(), tile.first_batch, tile.last_batch, false, asks_ahead_};
    task.omega = omega_;
    task.next = impulse_.data();
    task.velocity = velocity_.data();
    task.inverse = disks_.inverse();
    kernels_.sweep_forth(task);
  });
}

BIPOT_FOR_BODIES(template class TiledSweep);

}  // namespace bipot
