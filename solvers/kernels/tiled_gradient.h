#pragma once

#include <vector>

#include "solvers/kernels/disk_tiles.h"
#include "solvers/kernels/gradient_kernel.h"

namespace bipot {

/// The accelerated projected gradient for disks, vectorised, in the order of DiskTiles.
///
/// Whether an iteration restarts momentum depends on sums over all contacts of the one before. So
/// that several iterations can be in flight (wavefront.h), they are computed as if there was no
/// restart; where the sums then ask for one, the iterations behind it are thrown away and those
/// before it done again from what was kept. The results are those of one iteration after the other.
template <int D>
class TiledGradient final : public GradientKernel {
 public:
  TiledGradient(const ContactProblem& problem, const DiskStructure& disks,
                const ContactScaling& scaling, const Execution& options);

  /// Starts from s without momentum.
  void reset(const Vector& s) override;
  const Vector& impulse() override;
  void advance(int iterations, GradientControl& control) override;

 private:
  struct Totals {
    double turn = 0, change2 = 0, energy = 0;
  };
  /// Buffers of x and of the momentum by number; iteration k of a group reads two and writes one.
  struct Roles {
    int now = 0, before = 1, free[2] = {2, 3};
  };
  Roles after(int iterations) const;
  void run(int iterations, const std::vector<double>& beta, const GradientControl& control);
  Totals totals(int iteration) const;

  DiskTiles<D> disks_;
  const DiskKernels<D>& kernels_;
  int threads_, depth_, group_;  // depth: of the wavefront; group: between two looks at the sums
  std::vector<ImpulseBatch<D>> impulse_[4];
  std::vector<BodyRow> momentum_[4], velocity_;
  std::vector<GradientSums> sums_;  // of every iteration in flight and tile
  Roles roles_;
  double beta_ = 0, change2_ = 0;  // of the next iteration; of the last one
  int since_restart_ = 0, interval_ = 0;
  Vector s_;
};

}  // namespace bipot
