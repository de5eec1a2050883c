#pragma once

#include "core/base/large_pages.h"
#include "solvers/disks/disk_tiles.h"

namespace bipot {

/// Projected Gauss-Seidel for disks or spheres (D = 3), vectorised, in the order of DiskTiles.
/// Several sweeps are in flight at once (wavefront.h). Every contact and body sees the sequence of
/// updates of one sweep after the other.
template <int D>
class TiledSweep {
 public:
  TiledSweep(const ContactProblem& problem, const BodiesOf<D>& bodies,
             const ContactScaling& equilibrated, double omega, const Execution& options)
      : TiledSweep(problem, bodies, equilibrated, omega, options, tile_contacts(bodies)) {}
  /// The same with given tiles: those of given_order() make it the sweep contact after contact.
  TiledSweep(const ContactProblem& problem, const BodiesOf<D>& bodies,
             const ContactScaling& equilibrated, double omega, const Execution& options,
             ContactTiles tiles);

  void reset(const Vector& s);
  const Vector& impulse();
  void advance(int sweeps);

 private:
  static constexpr typename DiskTiles<D>::Streamed kStreamed{
      sizeof(ContactBatch<D>) + sizeof(ImpulseBatch<D>), 2 * sizeof(RowOf<D>)};
  DiskTiles<D> disks_;
  const DiskKernels<D>& kernels_;
  double omega_;
  int threads_;
  Pipeline pipeline_;
  bool asks_ahead_;
  LargeVector<ImpulseBatch<D>> impulse_;
  LargeVector<RowOf<D>> velocity_;
  Vector s_;
};

}  // namespace bipot
