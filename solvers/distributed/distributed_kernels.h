#pragma once

#include "solvers/distributed/distributed_space.h"
#include "solvers/kernels/contact_scaling.h"

namespace bipot {

/// spectral_estimate() of solvers/kernels/spectral_estimate.h from the same start vector.
double distributed_spectral_estimate(DistributedSpace& space, const Vector& scale);

/// spectral_bound(), ‖diag(scale) W diag(scale)‖_inf; where degrees of freedom stand on every
/// process, with their part bounded by the sum of its terms' sizes.
double distributed_spectral_bound(DistributedSpace& space, const Vector& scale);

/// Norms and products of Anderson's acceleration over all processes: orthogonalised by classical
/// Gram-Schmidt, twice, where one process takes the modified one: a reduction for each pass.
struct DistributedProducts {
  DistributedSpace& space;

  template <class A>
  double norm(const A& a) const {
    return space.norm(a);
  }
  Vector products(const Eigen::MatrixXd& q, int size, const Vector& f) const {
    return column_products(q, size, f);
  }
  template <class Column>
  void project_out(const Eigen::MatrixXd& q, int size, Column& column, Eigen::MatrixXd& r) const {
    if (size == 0) return;
    for (int pass = 0; pass < 2; ++pass) {
      const Vector dots = column_products(q, size, column);
      r.col(size).head(size) += dots;
      column -= q.leftCols(size) * dots;
    }
  }

 private:
  Vector column_products(const Eigen::MatrixXd& q, int size,
                         const Eigen::Ref<const Vector>& f) const;
};

}  // namespace bipot
