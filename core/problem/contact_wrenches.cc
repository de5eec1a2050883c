#include "core/problem/contact_wrenches.h"

#include <algorithm>

namespace bipot {

ContactWrenches::ContactWrenches(const SparseMatrix& H, int dim, const Vector& scale) : dim_(dim) {
  const int contacts = static_cast<int>(H.cols()) / dim;
  start_.reserve(to_size(contacts) + 1);
  start_.push_back(0);
  std::vector<int> own;
  for (int c = 0; c < contacts; ++c) {
    own.clear();
    for (int row = c * dim; row < (c + 1) * dim; ++row) {
      for (SparseMatrix::InnerIterator it(H, row); it; ++it) {
        if (it.value() != 0) own.push_back(static_cast<int>(it.row()));
      }
    }
    std::sort(own.begin(), own.end());
    own.erase(std::unique(own.begin(), own.end()), own.end());
    const std::size_t first = dof_.size();
    dof_.insert(dof_.end(), own.begin(), own.end());
    wrench_.resize(dof_.size() * to_size(dim), 0.0);
    for (int a = 0; a < dim; ++a) {
      const double factor = scale.size() == 0 ? 1 : scale[c * dim + a];
      for (SparseMatrix::InnerIterator it(H, c * dim + a); it; ++it) {
        if (it.value() == 0) continue;
        const auto k = std::lower_bound(own.begin(), own.end(), it.row()) - own.begin();
        wrench_[(first + to_size(k)) * to_size(dim) + to_size(a)] = it.value() * factor;
      }
    }
    start_.push_back(static_cast<int>(dof_.size()));
  }
  dof_.shrink_to_fit();
  wrench_.shrink_to_fit();
}

void ContactWrenches::renumber(const std::vector<int>& number) {
  for (int& dof : dof_) dof = number[to_size(dof)];
}

void ContactWrenches::momentum(const Eigen::Ref<const Vector>& s, Vector& g) const {
  g.setZero();
  dispatch_count(dim_, [&](auto d) {
    constexpr int D = d();
    for (int c = 0; c < num_contacts(); ++c) {
      const Local<D> push = s.segment<D>(c * D);
      for (int k = begin(c); k < end(c); ++k) {
        double sum = g[dof(k)];
        for (int a = 0; a < D; ++a) sum += wrench_[to_size(k) * to_size(D) + to_size(a)] * push[a];
        g[dof(k)] = sum;
      }
    }
  });
}

void ContactWrenches::velocity(const Vector& v, Vector& u) const {
  u.resize(static_cast<Eigen::Index>(num_contacts()) * dim_);
  dispatch_count(dim_, [&](auto d) {
    constexpr int D = d();
    for (int c = 0; c < num_contacts(); ++c) u.segment<D>(c * D) = velocity<D>(c, v);
  });
}

}  // namespace bipot
