#pragma once

#include <vector>

#include "core/base/types.h"
#include "core/problem/coulomb_cone.h"

namespace bipot {

/// W by contacts: those that a contact is coupled to, each with its d x d block, zeros included.
/// A product keeps d sums for each row, since one would wait for each of its additions.
class DelassusBlocks {
 public:
  /// Columns ascend in each row of W.
  DelassusBlocks(const SparseRows& W, int dim);

  /// The rows of W s of one contact; D is its number of rows.
  template <int D>
  Local<D> product(int contact, const double* s) const {
    double sums[to_size(D)][to_size(D)] = {};
    const double* block = block_.data() + to_size(start_[to_size(contact)]) * (D * D);
    for (int k = start_[to_size(contact)]; k < start_[to_size(contact) + 1]; ++k, block += D * D) {
      const double* const of = s + D * neighbour_[to_size(k)];
      for (int a = 0; a < D; ++a) {
        for (int b = 0; b < D; ++b) sums[a][b] += block[a * D + b] * of[b];
      }
    }
    Local<D> u = Local<D>::Zero();
    for (int a = 0; a < D; ++a) {
      for (int b = 0; b < D; ++b) u[a] += sums[a][b];
    }
    return u;
  }
  /// u = W s.
  void apply(const Eigen::Ref<const Vector>& s, Vector& u) const;

 private:
  template <int D>
  void fill(const SparseRows& W);

  int dim_;
  std::vector<int> start_, neighbour_;
  std::vector<double> block_;  // row-major
};

}  // namespace bipot
