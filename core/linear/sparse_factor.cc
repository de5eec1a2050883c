#include "core/linear/sparse_factor.h"

#include <cholmod.h>
#include <umfpack.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "core/base/parallel.h"
#include "core/base/types.h"

namespace bipot {
/// Compressed columns with 64-bit indices and the last pattern: SuiteSparse's own layout.
struct LongColumns {
  std::vector<SuiteSparse_long> start, row;
  std::vector<double> value;
  SuiteSparse_long size = 0;

  /// Copies A (sorted, compressed). True if the pattern is that of the previous call.
  bool assign(const SparseMatrix& A, bool upper_only) {
    std::vector<SuiteSparse_long> new_start(to_size(A.cols()) + 1, 0), new_row;
    new_row.reserve(to_size(A.nonZeros()));
    value.clear();
    value.reserve(to_size(A.nonZeros()));
    for (int k = 0; k < A.outerSize(); ++k) {
      for (SparseMatrix::InnerIterator it(A, k); it; ++it) {
        if (upper_only && it.row() > it.col()) continue;
        new_row.push_back(it.row());
        value.push_back(it.value());
      }
      new_start[to_size(k) + 1] = static_cast<SuiteSparse_long>(new_row.size());
    }
    const bool same = size == A.cols() && new_start == start && new_row == row;
    size = A.cols();
    start = std::move(new_start);
    row = std::move(new_row);
    return same;
  }
};

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
  f.positive_definite = f.factor != nullptr && cholmod_l_factorize(&view, f.factor, &f.common) &&
                        f.common.status == CHOLMOD_OK && f.factor->minor == f.factor->n;
  return f.positive_definite;
}

Vector SparseCholesky::solve(const Eigen::Ref<const Vector>& b) const {
  if (!impl_->positive_definite) throw std::logic_error("SparseCholesky::solve without a factor");
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
  std::vector<Eigen::Triplet<double>> entries;
  for (int k = 0; k < B.outerSize(); ++k) {
    const Vector x = solve(Vector(B.col(k)));
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      if (x[i] != 0) entries.emplace_back(static_cast<int>(i), k, x[i]);
    }
  }
  SparseMatrix X(B.rows(), B.cols());
  X.setFromTriplets(entries.begin(), entries.end());
  return X;
}

std::size_t SparseCholesky::num_entries() const {
  const Impl& f = *impl_;
  if (!f.positive_definite) throw std::logic_error("SparseCholesky::num_entries without a factor");
  return f.factor->is_super != 0 ? f.factor->xsize : f.factor->nzmax;
}

struct SparseLU::Impl {
  double control[UMFPACK_CONTROL];
  double info[UMFPACK_INFO];
  LongColumns matrix;
  void* symbolic = nullptr;
  void* numeric = nullptr;

  Impl() { umfpack_dl_defaults(control); }
  ~Impl() {
    umfpack_dl_free_numeric(&numeric);
    umfpack_dl_free_symbolic(&symbolic);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
};

SparseLU::SparseLU(Strategy strategy) : impl_(std::make_unique<Impl>()) {
  if (strategy == Strategy::kSymmetric) {
    impl_->control[UMFPACK_STRATEGY] = UMFPACK_STRATEGY_SYMMETRIC;
  } else if (strategy == Strategy::kUnsymmetric) {
    impl_->control[UMFPACK_STRATEGY] = UMFPACK_STRATEGY_UNSYMMETRIC;
  }
  impl_->control[UMFPACK_ORDERING] = UMFPACK_ORDERING_METIS;
}
SparseLU::~SparseLU() = default;
SparseLU::SparseLU(SparseLU&&) noexcept = default;
SparseLU& SparseLU::operator=(SparseLU&&) noexcept = default;

bool SparseLU::factor(const SparseMatrix& A) {
  Impl& f = *impl_;
  const bool same = f.matrix.assign(A, false);
  umfpack_dl_free_numeric(&f.numeric);
  const LongColumns& m = f.matrix;
  if (!same || f.symbolic == nullptr) {
    umfpack_dl_free_symbolic(&f.symbolic);
    // METIS is better from a few thousand unknowns on; AMD is quicker below.
    f.control[UMFPACK_ORDERING] = m.size > 4000 ? UMFPACK_ORDERING_METIS : UMFPACK_ORDERING_AMD;
    if (umfpack_dl_symbolic(m.size, m.size, m.start.data(), m.row.data(), m.value.data(),
                            &f.symbolic, f.control, f.info) != UMFPACK_OK) {
      return false;
    }
  }
  if (umfpack_dl_numeric(m.start.data(), m.row.data(), m.value.data(), f.symbolic, &f.numeric,
                         f.control, f.info) != UMFPACK_OK) {
    umfpack_dl_free_numeric(&f.numeric);  // a singular matrix leaves a factor that must not be used
    return false;
  }
  return true;
}

Vector SparseLU::solve(const Eigen::Ref<const Vector>& b, int refinements) const {
  Impl& f = *impl_;
  if (f.numeric == nullptr) throw std::logic_error("SparseLU::solve without a factor");
  Vector rhs = b;
  Vector x(rhs.size());
  f.control[UMFPACK_IRSTEP] = refinements;
  const LongColumns& m = f.matrix;
  if (umfpack_dl_solve(UMFPACK_A, m.start.data(), m.row.data(), m.value.data(), x.data(),
                       rhs.data(), f.numeric, f.control, f.info) != UMFPACK_OK) {
    x.setConstant(kNaN);
  }
  return x;
}

int SparseLU::determinant_sign() const {
  const Impl& f = *impl_;
  if (f.numeric == nullptr) throw std::logic_error("SparseLU::determinant_sign without a factor");
  double mantissa = 0, exponent = 0;
  umfpack_dl_get_determinant(&mantissa, &exponent, f.numeric, nullptr);
  return mantissa > 0 ? 1 : (mantissa < 0 ? -1 : 0);
}

double SparseLU::rcond() const { return impl_->info[UMFPACK_RCOND]; }

std::size_t SparseLU::num_entries() const {
  return static_cast<std::size_t>(impl_->info[UMFPACK_LNZ] + impl_->info[UMFPACK_UNZ]);
}

}  // namespace bipot
