#pragma once

#include <cstddef>
#include <vector>

#include "core/base/types.h"
#include "core/problem/coulomb_cone.h"

namespace bipot {

/// G = H diag(scale) contact by contact: the degrees of freedom that a contact acts on, each with
/// its d numbers of G. A product visits each of them once, and not once a row of the contact. The
/// terms of every sum keep their order: with scale 1 the bits are those of products by columns.
class ContactWrenches {
 public:
  /// `scale`: m, of the columns of H; empty: 1. `dim`: rows of a contact.
  ContactWrenches(const SparseMatrix& H, int dim, const Vector& scale = {});

  int num_contacts() const { return static_cast<int>(start_.size()) - 1; }
  /// Entries begin(c) .. end(c) - 1 are of contact c, by ascending degree of freedom.
  int begin(int contact) const { return start_[to_size(contact)]; }
  int end(int contact) const { return start_[to_size(contact) + 1]; }
  int size() const { return static_cast<int>(dof_.size()); }  ///< entries of all contacts
  int dof(int entry) const { return dof_[to_size(entry)]; }
  const double* row(int entry) const { return wrench_.data() + to_size(entry) * to_size(dim_); }

  /// Gives every degree of freedom another number, in the same order.
  void renumber(const std::vector<int>& number);

  /// g = G s: m -> n, with the size that g has.
  void momentum(const Eigen::Ref<const Vector>& s, Vector& g) const;
  /// The rows of u = Gᵀ v of one contact; D is its number of rows.
  template <int D>
  Local<D> velocity(int contact, const Vector& v) const {
    Local<D> u = Local<D>::Zero();
    for (int k = begin(contact); k < end(contact); ++k) {
      const double speed = v[dof(k)];
      for (int a = 0; a < D; ++a) u[a] += wrench_[to_size(k) * to_size(D) + to_size(a)] * speed;
    }
    return u;
  }
  /// u = Gᵀ v: n -> m.
  void velocity(const Vector& v, Vector& u) const;

 private:
  int dim_;
  std::vector<int> start_, dof_;
  std::vector<double> wrench_;
};

}  // namespace bipot
