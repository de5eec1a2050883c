#include <klu.h>

#include <cmath>
#include <memory>
#include <new>
#include <stdexcept>

#include "core/base/types.h"
#include "core/linear/long_columns.h"
#include "core/linear/sparse_factor.h"

namespace bipot {
namespace {

/// -1 or +1: sign of the permutation.
int permutation_sign(const SuiteSparse_long* to, SuiteSparse_long size) {
  using Indices = Eigen::Matrix<SuiteSparse_long, Eigen::Dynamic, 1>;
  const Indices places = Eigen::Map<const Indices>(to, size);
  return static_cast<int>(
      Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, SuiteSparse_long>(places)
          .determinant());
}

}  // namespace

struct SparseLU::Impl {
  klu_l_common common;
  LongColumns matrix;
  klu_l_symbolic* symbolic = nullptr;
  klu_l_numeric* numeric = nullptr;

  Impl() { klu_l_defaults(&common); }
  ~Impl() {
    klu_l_free_numeric(&numeric, &common);
    klu_l_free_symbolic(&symbolic, &common);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
};

SparseLU::SparseLU(Strategy strategy) : impl_(std::make_unique<Impl>()) {
  // A pivot on the diagonal is taken if it is so large a part of its column.
  impl_->common.tol = strategy == Strategy::kUnsymmetric ? 1.0 : 0.1;
  impl_->common.btf = strategy == Strategy::kSymmetric ? 0 : 1;
}
SparseLU::~SparseLU() = default;
SparseLU::SparseLU(SparseLU&&) noexcept = default;
SparseLU& SparseLU::operator=(SparseLU&&) noexcept = default;

bool SparseLU::factor(const SparseMatrix& A) {
  Impl& f = *impl_;
  const bool same = f.matrix.assign(A, false);
  klu_l_free_numeric(&f.numeric, &f.common);
  LongColumns& m = f.matrix;
  if (!same || f.symbolic == nullptr) {
    klu_l_free_symbolic(&f.symbolic, &f.common);
    f.symbolic = klu_l_analyze(m.size, m.start.data(), m.row.data(), &f.common);
  }
  for (const double value : m.value) {
    if (!std::isfinite(value)) return false;
  }
  const auto require_memory = [&] {
    if (f.common.status == KLU_OUT_OF_MEMORY) throw std::bad_alloc();
  };
  require_memory();
  if (f.symbolic == nullptr) return false;
  f.numeric = klu_l_factor(m.start.data(), m.row.data(), m.value.data(), f.symbolic, &f.common);
  if (f.numeric != nullptr && f.common.status != KLU_OK) {
    klu_l_free_numeric(&f.numeric, &f.common);  // singular: a factor that must not be used
  }
  require_memory();
  return f.numeric != nullptr;
}

Vector SparseLU::solve(const Eigen::Ref<const Vector>& b, int refinements) const {
  Impl& f = *impl_;
  if (f.numeric == nullptr) throw std::logic_error("SparseLU::solve without a factor");
  const LongColumns& m = f.matrix;
  Vector x = Vector::Zero(b.size());
  Vector residual = b;
  for (int round = 0; round <= refinements; ++round) {
    klu_l_solve(f.symbolic, f.numeric, m.size, 1, residual.data(), &f.common);
    x += residual;
    if (round == refinements) break;
    residual = b;
    for (SuiteSparse_long j = 0; j < m.size; ++j) {
      for (SuiteSparse_long k = m.start[to_size(j)]; k < m.start[to_size(j) + 1]; ++k) {
        residual[m.row[to_size(k)]] -= m.value[to_size(k)] * x[j];
      }
    }
  }
  return x;
}

int SparseLU::determinant_sign() const {
  const Impl& f = *impl_;
  if (f.numeric == nullptr) throw std::logic_error("SparseLU::determinant_sign without a factor");
  // P R A Q = L U with 1 on the diagonal of L and a positive scaling R.
  const SuiteSparse_long size = f.matrix.size;
  int sign = permutation_sign(f.numeric->Pnum, size) * permutation_sign(f.symbolic->Q, size);
  const auto* pivots = static_cast<const double*>(f.numeric->Udiag);
  for (SuiteSparse_long k = 0; k < size; ++k) {
    if (pivots[k] < 0) sign = -sign;
  }
  return sign;
}

const char* SparseLU::library() { return "KLU"; }

std::size_t SparseLU::num_entries() const {
  const Impl& f = *impl_;
  if (f.numeric == nullptr) throw std::logic_error("SparseLU::num_entries without a factor");
  return to_size(f.numeric->lnz + f.numeric->unz + f.symbolic->nzoff);
}

}  // namespace bipot
