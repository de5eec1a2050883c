#pragma once

#include "core/base/types.h"
#include "solvers/kernels/gradient_map.h"

namespace bipot {

/// Nesterov's (1 + sqrt(1 + 4 t²)) / 2.
double next_momentum(double t);

/// Steps of an accelerated projected gradient, driven by iterate_gradient() (gradient_iteration.h).
class GradientKernel {
 public:
  /// State of the steps of an accelerated projected gradient
  /// (solvers/methods/accelerated_gradient.h).
  struct Control {
    double lambda = 0;  ///< estimate of the largest eigenvalue; raised if it is too small
    double step = 1;    ///< rho = step / lambda
    GradientMap map = GradientMap::kSplit;
    double t = 1;  ///< Nesterov's sequence
  };
  /// Sums over all contacts of one step from x to x⁺ via y.
  struct Progress {
    double turn = 0;     ///< (y - x⁺)·(x⁺ - x): positive when momentum points uphill
    double change2 = 0;  ///< ‖x⁺ - x‖²
    double energy = 0;   ///< (x⁺ - x)·W(x⁺ - x)
  };
  virtual ~GradientKernel() = default;
  /// Starts from s without momentum and with sigma = 0.
  virtual void reset(const Vector& s) = 0;
  virtual const Vector& impulse() = 0;
  /// sigma <- sigma + kappa (mu |w_t| - sigma), for the map kFollowed.
  virtual void follow(double kappa) = 0;
  virtual void advance(int iterations, Control& control) = 0;
};

}  // namespace bipot
