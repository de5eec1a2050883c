#pragma once

#include <vector>

#include "core/base/large_pages.h"
#include "solvers/disks/stress_modes.h"
#include "solvers/disks/symmetric_sweep.h"

namespace bipot {

/// Conjugate gradients (Polak and Ribière) whose preconditioner is a symmetric sweep S, deflated by
/// smooth stresses P. With y the impulse and g = Wy + b,
///
///     z = S(y) - y,   z <- z - P (PᵀWP)⁻¹ Pᵀ(W S(y) + b),
///     beta = max(0, g·(z - z⁻) / g⁻·z⁻),   p = z + beta p⁻,
///     alpha = -g·p / p·Wp,   y⁺ = y + alpha p.
///
/// S(y) obeys the law, y need not. A coarse space beside projected sweeps that excludes contacts at
/// their edges: Kornhuber's truncated monotone multigrid (Numer. Math. 69, 1994). Deflation of
/// conjugate gradients: Nicolaides (SIAM J. Numer. Anal. 24, 1987).
///
/// Limits: near a solution few contacts change their status, and the map is linear but for them.
/// Far away, and with friction, descent is not proved.
class DeflatedSweep {
 public:
  DeflatedSweep(SymmetricSweep<2>& sweep, const DiskStructure& disks, const Execution& options);

  /// True if the packing has smooth stresses: it needs some hundred disks.
  bool has_stresses() const { return modes_.num_nodes() > 0; }
  /// Starts from s: S(s) is the first impulse(). False if no contact of it carries stresses.
  [[nodiscard]] bool reset(const Vector& s);
  /// False on failure: only reset() may follow.
  [[nodiscard]] bool iterate();
  /// S(y). Not after iterate() returned false: it may be z then.
  const Vector& impulse();

 private:
  SymmetricSweep<2>& sweep_;
  Execution options_;
  const StressKernels& kernels_;
  SweepSchedule tiles_in_order_;
  StressModes modes_;
  SymmetricSweep<2>::Swept at_;
  LargeVector<BodyRow> mass_, direction_, stress_, momentum_;
  std::vector<StressKernels::ConjugateSums> sums_;
  std::vector<StressKernels::LoadSums> loads_;  // of each tile
  int since_renewal_ = 0;
  bool carried_ = false;  // stresses, as of the last renewal
  // z⁻·Wz⁻, z⁻·Wp⁻⁻, p⁻·Wp⁻, g⁻·z⁻, alpha⁻, beta⁻; p⁻·Wp⁻ = 0: there is no previous direction.
  double zz_ = 0, zp_ = 0, pp_ = 0, gz_ = 0, alpha_ = 0, beta_ = 0;
  Vector s_;
};

}  // namespace bipot
