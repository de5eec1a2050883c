#pragma once

#include <span>
#include <vector>

#include "core/base/large_pages.h"
#include "solvers/disks/disk_tiles.h"
#include "solvers/disks/quicker_team.h"
#include "solvers/disks/sweep_schedule.h"
#include "solvers/disks/tile_links.h"

namespace bipot {

/// Symmetric Gauss-Seidel with momentum for disks or spheres (D = 3), vectorised, in the order of
/// symmetric_order(). In large packings the lanes of a vector hold contacts of several rows, each
/// row some contacts behind the one before it. For every contact and body the result is that of
/// sweeps contact after contact. Any number of threads (sweep_schedule.h) and all paths of
/// disk_kernels.h give the same bits.
template <int D>
class SymmetricSweep {
 public:
  /// `sweeps`: number of sweeps each way in one iteration.
  SymmetricSweep(const ContactProblem& problem, const BodiesOf<D>& bodies,
                 const ContactScaling& equilibrated, double omega, int sweeps,
                 const Execution& options);

  void reset(const Vector& s);
  /// Sets the relaxation of the local updates and the number of sweeps each way.
  void relax(double omega, int sweeps);
  /// Restarts momentum, and recomputes velocities from the impulses to remove rounding.
  void refresh();
  const Vector& impulse();
  /// Symmetric sweep from y = x + beta (x - x⁻). Returns (y - x⁺)·(x⁺ - x) in the scaled variables.
  double iterate(double beta);

  /// State before and after a sweep for other iterations. Valid until the next call of a member.
  struct Swept {
    std::span<ImpulseBatch<D>> y, swept, spare;    ///< y, S(y), and a free one
    std::span<RowOf<D>> velocity, swept_velocity;  ///< of y, of S(y)
  };
  /// Symmetric sweep from y = the impulse, which stays; so do its velocities.
  Swept sweep();

  const DiskTiles<D>& disks() const { return disks_; }
  /// A schedule of sweeps over these tiles.
  SweepSchedule schedule(SweepSchedule::Sweeps sweeps) const;

 private:
  double sweep_from(double beta, const ImpulseBatch<D>* before);

  DiskTiles<D> disks_;
  TileLinks links_;
  const DiskKernels<D>& kernels_;
  double omega_;
  int sweeps_, threads_;
  bool asks_ahead_;
  SweepSchedule schedule_;
  QuickerTeam team_;
  std::vector<TurnSums> sums_;  // of each tile
  LargeVector<ImpulseBatch<D>> now_, before_, next_;
  LargeVector<RowOf<D>> velocity_, velocity_before_;
  Vector s_;
};

}  // namespace bipot
