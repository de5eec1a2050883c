#pragma once

#include <vector>

#include "solvers/kernels/disk_tiles.h"

namespace bipot {

/// What the steps of an accelerated projected gradient carry along
/// (solvers/methods/accelerated_gradient.h).
struct GradientControl {
  double lambda = 0;     ///< estimate of the largest eigenvalue; raised where it proves too small
  double step = 1;       ///< rho = step / lambda
  bool cone = false;     ///< the projection on the cone with de Saxce's term, else the split one
  bool momentum = true;  ///< false: t = 1 throughout
  double t = 1;          ///< Nesterov's sequence
};

/// Nesterov's (1 + sqrt(1 + 4 t²)) / 2.
double next_momentum(double t);

/// The accelerated projected gradient for disks, vectorised, in the order of DiskTiles.
///
/// Whether an iteration restarts momentum depends on sums over all contacts of the one before. So
/// that several iterations can be in flight (wavefront.h), they are computed as if there was no
/// restart; where the sums then ask for one, the iterations behind it are thrown away and those
/// before it done again from what was kept. The results are those of one iteration after the other.
template <int D>
class TiledGradient {
 public:
  TiledGradient(const ContactProblem& problem, const DiskStructure& disks,
                const ContactScaling& scaling, const Execution& options);

  /// Starts from s without momentum.
  void reset(const Vector& s);
  const Vector& impulse();
  void advance(int iterations, GradientControl& control);

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
