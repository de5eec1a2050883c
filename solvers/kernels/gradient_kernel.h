#pragma once

#include "core/base/types.h"

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

/// Sums over all contacts of one step from x to x⁺ by way of y.
struct GradientProgress {
  double turn = 0;     ///< (y - x⁺)·(x⁺ - x): positive when momentum points uphill
  double change2 = 0;  ///< ‖x⁺ - x‖²
  double energy = 0;   ///< (x⁺ - x)·W(x⁺ - x)
};

/// Nesterov's (1 + sqrt(1 + 4 t²)) / 2.
double next_momentum(double t);

/// Steps of an accelerated projected gradient, which iterate_gradient() drives
/// (gradient_iteration.h).
class GradientKernel {
 public:
  virtual ~GradientKernel() = default;
  /// Starts from s without momentum.
  virtual void reset(const Vector& s) = 0;
  virtual const Vector& impulse() = 0;
  virtual void advance(int iterations, GradientControl& control) = 0;
};

}  // namespace bipot
