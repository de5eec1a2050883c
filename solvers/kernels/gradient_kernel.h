#pragma once

#include "core/base/types.h"

namespace bipot {

/// State of the steps of an accelerated projected gradient
/// (solvers/methods/accelerated_gradient.h).
struct GradientControl {
  double lambda = 0;     ///< estimate of the largest eigenvalue; raised if it is too small
  double step = 1;       ///< rho = step / lambda
  bool cone = false;     ///< the projection on the cone with de Saxce's term, else the split one
  bool momentum = true;  ///< false: t = 1 throughout
  double t = 1;          ///< Nesterov's sequence
};

/// Sums over all contacts of one step from x to x⁺ via y.
struct GradientProgress {
  double turn = 0;     ///< (y - x⁺)·(x⁺ - x): positive when momentum points uphill
  double change2 = 0;  ///< ‖x⁺ - x‖²
  double energy = 0;   ///< (x⁺ - x)·W(x⁺ - x)
};

/// Nesterov's (1 + sqrt(1 + 4 t²)) / 2.
double next_momentum(double t);

/// Steps of an accelerated projected gradient, driven by iterate_gradient() (gradient_iteration.h).
class GradientKernel {
 public:
  virtual ~GradientKernel() = default;
  /// Starts from s without momentum.
  virtual void reset(const Vector& s) = 0;
  virtual const Vector& impulse() = 0;
  virtual void advance(int iterations, GradientControl& control) = 0;
};

}  // namespace bipot
