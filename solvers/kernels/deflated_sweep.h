#pragma once

#include "solvers/kernels/stress_modes.h"
#include "solvers/kernels/symmetric_sweep.h"

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

  /// From s: S(s) is the first impulse(). False where there are no stresses to take out.
  [[nodiscard]] bool reset(const Vector& s);
  /// False where it cannot go on.
  [[nodiscard]] bool iterate();
  /// S(y).
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
  // z⁻·Wz⁻, z⁻·Wp⁻, p⁻·Wp⁻, g⁻·z⁻, alpha⁻, beta⁻; no direction before where p⁻·Wp⁻ = 0.
  double zz_ = 0, zp_ = 0, pp_ = 0, gz_ = 0, alpha_ = 0, beta_ = 0;
  Vector s_;
};

}  // namespace bipot
