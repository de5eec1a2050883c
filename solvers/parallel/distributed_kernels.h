#pragma once

#include "solvers/kernels/contact_scaling.h"
#include "solvers/parallel/distributed_space.h"

namespace bipot {

/// spectral_estimate() of solvers/kernels/spectral_estimate.h from the same start vector.
double distributed_spectral_estimate(DistributedSpace& space, const Vector& scale);

/// spectral_bound(), ‖diag(scale) W diag(scale)‖_inf; where degrees of freedom stand on every
/// process, with their part bounded by the sum of its terms' sizes.
double distributed_spectral_bound(DistributedSpace& space, const Vector& scale);

/// Norms and products of Anderson's acceleration over all processes, a reduction each.
struct DistributedProducts {
  DistributedSpace& space;

  template <class A>
  double norm(const A& a) const {
    return space.norm(a);
  }
  Vector products(const Eigen::MatrixXd& columns, int size, const Vector& f) const;
};

}  // namespace bipot
