#include "core/linear/sparse_factor.h"

#include <cholmod.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <stdexcept>

#include "core/base/parallel.h"
#include "core/base/triplets.h"
#include "core/linear/dense_turn.h"
#include "core/linear/long_columns.h"

namespace bipot {

struct SparseCholesky::Impl {
  cholmod_common common;
  LongColumns matrix;
  cholmod_factor* factor = nullptr;
  bool positive_definite = false;

  Impl() {
    cholmod_l_start(&common);
    common.print = 0;
    common.error_handler = nullptr;
    // The default for small matrices, L D Lᵀ, accepts negative pivots.
    common.final_ll = 1;
#ifndef BIPOT_WITH_GPL
    common.supernodal = CHOLMOD_SIMPLICIAL;
#endif
  }
  ~Impl() {
    cholmod_l_free_factor(&factor, &common);
    cholmod_l_finish(&common);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  cholmod_sparse view() {
    cholmod_sparse A{};
    A.nrow = A.ncol = static_cast<std::size_t>(matrix.size);
    A.nzmax = matrix.value.size();
    A.p = matrix.start.data();
    A.i = matrix.row.data();
    A.x = matrix.value.data();
    A.stype = 1;
    A.itype = CHOLMOD_LONG;
    A.xtype = CHOLMOD_REAL;
    A.dtype = CHOLMOD_DOUBLE;
    A.sorted = 1;
    A.packed = 1;
    return A;
  }
};

SparseCholesky::SparseCholesky() : impl_(std::make_unique<Impl>()) {}
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

bool SparseCholesky::factor(const SparseMatrix& A) {
  Impl& f = *impl_;
  const OneThread one_thread;  // CHOLMOD's loops ask for four each
  f.positive_definite = false;
  if (!f.matrix.assign(A, true) || f.factor == nullptr) {
    cholmod_sparse view = f.view();
    cholmod_l_free_factor(&f.factor, &f.common);
    f.factor = cholmod_l_analyze(&view, &f.common);
  }
  const auto finite = [](double x) { return std::isfinite(x); };
  if (!std::all_of(f.matrix.value.begin(), f.matrix.value.end(), finite)) {
    return false;  // CHOLMOD takes NaN for a positive pivot
  }
  cholmod_sparse view = f.view();
  const DenseTurn turn;
  f.positive_definite = f.factor != nullptr && cholmod_l_factorize(&view, f.factor, &f.common) &&
                        f.common.status == CHOLMOD_OK && f.factor->minor == f.factor->n;
  if (f.common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  return f.positive_definite;
}

Vector SparseCholesky::solve(const Eigen::Ref<const Vector>& b) const {
  if (!impl_->positive_definite) throw std::logic_error("SparseCholesky::solve without a factor");
  const DenseTurn turn;
  const OneThread one_thread;
  Vector rhs = b;
  cholmod_dense view{};
  view.nrow = view.d = view.nzmax = static_cast<std::size_t>(rhs.size());
  view.ncol = 1;
  view.x = rhs.data();
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  cholmod_dense* x = cholmod_l_solve(CHOLMOD_A, impl_->factor, &view, &impl_->common);
  if (x == nullptr) throw std::runtime_error("CHOLMOD: solve failed");
  Vector result = Eigen::Map<const Vector>(static_cast<const double*>(x->x), rhs.size());
  cholmod_l_free_dense(&x, &impl_->common);
  return result;
}

SparseMatrix SparseCholesky::solve(const SparseMatrix& B) const {
  Triplets entries;
  for (int k = 0; k < B.outerSize(); ++k) {
    const Vector x = solve(Vector(B.col(k)));
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      if (x[i] != 0) entries.emplace_back(static_cast<int>(i), k, x[i]);
    }
  }
  return from_triplets(B.rows(), B.cols(), entries);
}

std::size_t SparseCholesky::num_entries() const {
  const Impl& f = *impl_;
  if (!f.positive_definite) throw std::logic_error("SparseCholesky::num_entries without a factor");
  return f.factor->is_super != 0 ? f.factor->xsize : f.factor->nzmax;
}

}  // namespace bipot
