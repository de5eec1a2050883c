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
///     beta = max(0, g·(z - z⁻) / g⁻·z⁻),   p = z + beta p⁻,   alpha = -g·p / p·Wp,   y⁺ = y + alpha p.
///
/// S(y) obeys the law, y need not. A coarse space that leaves contacts at their edges alone, beside
/// projected sweeps: Kornhuber's truncated monotone multigrid (Numer. Math. 69, 1994); deflation of
/// conjugate gradients: Nicolaides (SIAM J. Numer. Anal. 24, 1987). Near a solution, where few contacts
/// change between open, stick and slip, all this is linear but for them. From far away, and with
/// friction, there is no proof that it descends.
class DeflatedSweep {
 public:
  DeflatedSweep(SymmetricSweep<2>& sweep, const DiskStructure& disks, const Execution& options);

  /// Whether there is anything to take out: a packing of some hundred disks.
  bool has_stresses() const { return modes_.num_nodes() > 0; }
  /// From s: S(s) is the first impulse(). False where no contact of it carries stresses.
  [[nodiscard]] bool reset(const Vector& s);
  /// False where it could not: from there only reset() goes on.
  [[nodiscard]] bool iterate();
  /// S(y). Not where iterate() returned false: it may be z by then.
  const Vector& impulse();

 private:
  SymmetricSweep<2>& sweep_;
  Execution options_;
  const StressKernels& kernels_;
  StressModes modes_;
  SymmetricSweep<2>::Swept at_;
  LargeVector<BodyRow> mass_, direction_, stress_, momentum_;
  std::vector<ConjugateSums> sums_;
  int since_renewal_ = 0;
  bool carried_ = false;  // stresses, as of the last renewal
  // z⁻·Wz⁻, z⁻·Wp⁻⁻, p⁻·Wp⁻, g⁻·z⁻, alpha⁻, beta⁻; no direction before where p⁻·Wp⁻ = 0.
  double zz_ = 0, zp_ = 0, pp_ = 0, gz_ = 0, alpha_ = 0, beta_ = 0;
  Vector s_;
};

}  // namespace bipot
