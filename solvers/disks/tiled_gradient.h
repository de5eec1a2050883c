#pragma once

#include <span>
#include <vector>

#include "core/base/large_pages.h"
#include "solvers/disks/body_blocks.h"
#include "solvers/disks/disk_tiles.h"
#include "solvers/kernels/gradient_kernel.h"

namespace bipot {

/// The accelerated projected gradient for disks or spheres (D = 3), vectorised, by blocks of bodies
/// (body_blocks.h).
///
/// A restart of momentum depends on sums over all contacts of the iteration before. Several
/// iterations are in flight (wavefront.h); they are computed as if there was no restart. If the
/// sums then ask for one, the iterations after it are discarded, and those before it are repeated
/// from saved data. The results are those of one iteration after the other.
template <int D>
class TiledGradient final : public GradientKernel {
 public:
  /// Contacts of the same bodies in other processes. Collective: every process calls.
  class Neighbours {
   public:
    virtual ~Neighbours() = default;
    /// Adds the impulses of other processes to the momentum (the rows of `tiles`, in the scale of
    /// DiskTiles::push). `x`: the scaled impulses here, all batches.
    virtual void complete(const DiskTiles<D>& tiles, std::span<const ImpulseBatch<D>> x,
                          std::span<RowOf<D>> momentum) = 0;
    /// Sums over all processes, from those of the contacts and bodies here. `now`, `before`: the
    /// momenta from which `here.energy` was computed.
    virtual Progress total(const DiskTiles<D>& tiles, const Progress& here,
                           std::span<const RowOf<D>> now, std::span<const RowOf<D>> before) = 0;
  };

  /// Keeps problem.u_free by reference. With neighbours, kept by reference, one iteration at a time.
  TiledGradient(const ContactProblem& problem, const BodiesOf<D>& bodies,
                const ContactScaling& scaling, const Execution& options,
                Neighbours* neighbours = nullptr);

  void reset(const Vector& s) override;
  const Vector& impulse() override;
  void follow(double kappa) override;
  void advance(int iterations, Control& control) override;

 private:
  static constexpr typename DiskTiles<D>::Streamed kStreamed{
      sizeof(ContactBatch<D>) + 4 * sizeof(ImpulseBatch<D>), 5 * sizeof(RowOf<D>)};
  /// Indices of the buffers of x and of the momentum; iteration k of a group reads two and writes
  /// one.
  struct Roles {
    int now = 0, before = 1, free[2] = {2, 3};
  };
  void set_step(double rho);
  int before_restart() const;
  Roles after(int iterations) const;
  void run(int iterations, const std::vector<double>& beta, const Control& control);
  Progress totals(int iteration, double beta) const;

  const Vector& u_free_;
  BodyBlocks blocks_;  // without its tiles, which disks_ has
  DiskTiles<D> disks_;
  const DiskKernels<D>& kernels_;
  Neighbours* const neighbours_;
  int threads_;
  Pipeline pipeline_;
  bool asks_ahead_;
  int group_;  // iterations between two looks at the sums
  LargeVector<ImpulseBatch<D>> impulse_[4];
  LargeVector<RowOf<D>> momentum_[4], velocity_;
  std::vector<GradientSums> sums_;  // of every iteration in flight and tile
  Roles roles_;
  double rho_ = 1;                 // step that the variables are scaled by
  double beta_ = 0, change2_ = 0;  // of the next iteration; of the last one
  int since_restart_ = 0, interval_ = 0;
  // Of the last two iterations, if there were two since the restart.
  double turn_ = 0, turn_before_ = 0;
  Vector s_;
};

}  // namespace bipot
