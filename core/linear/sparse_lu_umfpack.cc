#include <umfpack.h>

#include <memory>
#include <new>
#include <stdexcept>

#include "core/linear/dense_turn.h"
#include "core/linear/long_columns.h"
#include "core/linear/sparse_factor.h"

namespace bipot {

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
    const auto said = umfpack_dl_symbolic(m.size, m.size, m.start.data(), m.row.data(),
                                          m.value.data(), &f.symbolic, f.control, f.info);
    if (said == UMFPACK_ERROR_out_of_memory) throw std::bad_alloc();
    if (said != UMFPACK_OK) return false;
  }
  const DenseTurn turn;
  const auto said = umfpack_dl_numeric(m.start.data(), m.row.data(), m.value.data(), f.symbolic,
                                       &f.numeric, f.control, f.info);
  if (said == UMFPACK_OK) return true;
  umfpack_dl_free_numeric(&f.numeric);  // a singular matrix leaves a factor that must not be used
  if (said == UMFPACK_ERROR_out_of_memory) throw std::bad_alloc();
  return false;
}

Vector SparseLU::solve(const Eigen::Ref<const Vector>& b, int refinements) const {
  Impl& f = *impl_;
  if (f.numeric == nullptr) throw std::logic_error("SparseLU::solve without a factor");
  const DenseTurn turn;
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

const char* SparseLU::library() { return "UMFPACK"; }

std::size_t SparseLU::num_entries() const {
  return static_cast<std::size_t>(impl_->info[UMFPACK_LNZ] + impl_->info[UMFPACK_UNZ]);
}

}  // namespace bipot
