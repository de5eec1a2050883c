#pragma once

#include <vector>

#include "core/large_pages.h"
#include "solvers/kernels/disk_tiles.h"

namespace bipot {

/// Symmetric Gauss-Seidel with momentum for disks, vectorised, in the order of order_contacts():
/// eight rows of a packing that follow each other are in the lanes of a vector, each some contacts
/// behind the one before it. What each contact and body sees is the sweep contact after contact.
/// One thread; the paths of disk_kernels.h give the same bits.
template <int D>
class SymmetricSweep {
 public:
  SymmetricSweep(const ContactProblem& problem, const DiskStructure& disks,
                 const ContactScaling& equilibrated, double omega, const Execution& options);

  void reset(const Vector& s);
  /// The relaxation of the local updates, from here on.
  void relax(double omega) { omega_ = omega; }
  /// Without momentum from here; velocities are taken from the impulses anew, as rounding adds up.
  void refresh();
  const Vector& impulse();
  /// Forth and back from y = x + beta (x - x⁻). Returns (y - x⁺)·(x⁺ - x) in the scaled variables.
  double iterate(double beta);

 private:
  DiskTiles<D> disks_;
  const DiskKernels<D>& kernels_;
  double omega_;
  LargeVector<ImpulseBatch<D>> now_, before_, next_;
  LargeVector<BodyRow> velocity_, velocity_before_;
  Vector s_;
};

}  // namespace bipot
