#include "core/linear/supernodal_solve.h"

#include <algorithm>

#include "core/base/instruction_sets.h"

#define BIPOT_SLICES BIPOT_CLONES("arch=x86-64-v3", "default")

extern "C" {
void dtrsm_(const char* side, const char* uplo, const char* transa, const char* diag, const int* m,
            const int* n, const double* alpha, const double* a, const int* lda, double* b,
            const int* ldb);
}

namespace bipot {
namespace {

// Numbers in a register of 32 bytes; strips have up to four.
template <class Real>
constexpr int kSlice = static_cast<int>(32 / sizeof(Real));
constexpr int kSlices = 4;
template <class Real>
constexpr int kStrip = kSlices* kSlice<Real>;

template <class Real>
struct SliceOf;
template <>
struct SliceOf<double> {
  using Type = double __attribute__((vector_size(32), aligned(8), may_alias));
};
template <>
struct SliceOf<float> {
  using Type = float __attribute__((vector_size(32), aligned(4), may_alias));
};
template <class Real>
using Slice = typename SliceOf<Real>::Type;

/// The strip of rows from `first` on: slices, and columns up to the end of its diagonal.
template <class Real>
struct Strip {
  int slices, columns;
  Strip(int first, int columns_of_all, int rows)
      : slices(std::min((rows - first + kSlice<Real> - 1) / kSlice<Real>, kSlices)),
        columns(std::min(columns_of_all, first + kStrip<Real>)) {}
};

/// out = strip x; returns the end of the strip.
template <class Real, int kCount>
[[gnu::always_inline]] inline const Slice<Real>* multiply(const Slice<Real>* p, int columns,
                                                          const Real* x, Slice<Real>* out) {
  Slice<Real> sum[std::size_t{kCount}] = {};
  for (int j = 0; j < columns; ++j, p += kCount) {
    for (int k = 0; k < kCount; ++k) sum[k] += p[k] * x[j];
  }
  for (int k = 0; k < kCount; ++k) out[k] = sum[k];
  return p;
}

/// sums += stripᵀ x, a slice of partial sums for each column.
template <class Real, int kCount>
[[gnu::always_inline]] inline const Slice<Real>* multiply_transposed(const Slice<Real>* p,
                                                                     int columns,
                                                                     const Slice<Real>* x,
                                                                     Slice<Real>* sums) {
  Slice<Real> given[std::size_t{kCount}];
  for (int k = 0; k < kCount; ++k) given[k] = x[k];
  for (int j = 0; j < columns; ++j, p += kCount) {
    Slice<Real> sum = sums[j];
    for (int k = 0; k < kCount; ++k) sum += p[k] * given[k];
    sums[j] = sum;
  }
  return p;
}

// The two functions below choose a kernel by a switch each: a lambda would not be compiled for the
// instruction sets of its enclosing function.

/// out = M x, whole slices.
template <class Real>
[[gnu::always_inline]] inline void all_strips(int columns, int rows, const Real* values,
                                              const Real* x, Real* out) {
  const auto* p = reinterpret_cast<const Slice<Real>*>(values);
  auto* result = reinterpret_cast<Slice<Real>*>(out);
  for (int i = 0; i < rows; i += kStrip<Real>, result += kSlices) {
    const Strip<Real> strip(i, columns, rows);
    switch (strip.slices) {
      case 1:
        p = multiply<Real, 1>(p, strip.columns, x, result);
        break;
      case 2:
        p = multiply<Real, 2>(p, strip.columns, x, result);
        break;
      case 3:
        p = multiply<Real, 3>(p, strip.columns, x, result);
        break;
      default:
        p = multiply<Real, kSlices>(p, strip.columns, x, result);
    }
  }
}
BIPOT_SLICES void multiply_strips(int columns, int rows, const double* values, const double* x,
                                  double* out) {
  all_strips(columns, rows, values, x, out);
}
BIPOT_SLICES void multiply_strips(int columns, int rows, const float* values, const float* x,
                                  float* out) {
  all_strips(columns, rows, values, x, out);
}

/// out[j] = sum of the numbers of sums[j].
[[gnu::always_inline]] inline void add_slices(int columns, const Slice<double>* sums, double* out) {
  for (int j = 0; j < columns; ++j) {
    out[j] = (sums[j][0] + sums[j][1]) + (sums[j][2] + sums[j][3]);
  }
}
using Half = float __attribute__((vector_size(16), aligned(4), may_alias));
[[gnu::always_inline]] inline Half halved(const Slice<float>* sum) {
  const Half* const half = reinterpret_cast<const Half*>(sum);
  return half[0] + half[1];
}
/// Four columns at once: single sums would take as long as the products.
[[gnu::always_inline]] inline void add_slices(int columns, const Slice<float>* sums, float* out) {
  int j = 0;
  for (; j + 4 <= columns; j += 4) {
    const Half a = halved(sums + j), b = halved(sums + j + 1), c = halved(sums + j + 2),
               d = halved(sums + j + 3);
    const Half ab = __builtin_shufflevector(a, b, 0, 4, 1, 5) +
                    __builtin_shufflevector(a, b, 2, 6, 3, 7),
               cd = __builtin_shufflevector(c, d, 0, 4, 1, 5) +
                    __builtin_shufflevector(c, d, 2, 6, 3, 7);
    *reinterpret_cast<Half*>(out + j) =
        __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
  }
  for (; j < columns; ++j) {
    const Half a = halved(sums + j);
    out[j] = (a[0] + a[2]) + (a[1] + a[3]);
  }
}

/// out = Mᵀ x, where x has whole slices, zeros at its end; partial: workspace, a slice for each
/// column.
template <class Real>
[[gnu::always_inline]] inline void all_strips_transposed(int columns, int rows, const Real* values,
                                                         const Real* x, Real* partial, Real* out) {
  const auto* p = reinterpret_cast<const Slice<Real>*>(values);
  const auto* given = reinterpret_cast<const Slice<Real>*>(x);
  auto* sums = reinterpret_cast<Slice<Real>*>(partial);
  for (int j = 0; j < columns; ++j) sums[j] = Slice<Real>{};
  for (int i = 0; i < rows; i += kStrip<Real>, given += kSlices) {
    const Strip<Real> strip(i, columns, rows);
    switch (strip.slices) {
      case 1:
        p = multiply_transposed<Real, 1>(p, strip.columns, given, sums);
        break;
      case 2:
        p = multiply_transposed<Real, 2>(p, strip.columns, given, sums);
        break;
      case 3:
        p = multiply_transposed<Real, 3>(p, strip.columns, given, sums);
        break;
      default:
        p = multiply_transposed<Real, kSlices>(p, strip.columns, given, sums);
    }
  }
  add_slices(columns, sums, out);
}
BIPOT_SLICES void multiply_strips_transposed(int columns, int rows, const double* values,
                                             const double* x, double* partial, double* out) {
  all_strips_transposed(columns, rows, values, x, partial, out);
}
BIPOT_SLICES void multiply_strips_transposed(int columns, int rows, const float* values,
                                             const float* x, float* partial, float* out) {
  all_strips_transposed(columns, rows, values, x, partial, out);
}

}  // namespace

template <class Real>
std::size_t SupernodalSolve<Real>::num_entries(int columns, int rows) {
  std::size_t slices = 0;
  for (int i = 0; i < rows; i += kStrip<Real>) {
    const Strip<Real> strip(i, columns, rows);
    slices += to_size(strip.slices) * to_size(strip.columns);
  }
  return slices * kSlice<Real>;
}

template <class Real>
void SupernodalSolve<Real>::begin(int supernodes, std::size_t entries) {
  blocks_.clear();
  blocks_.reserve(to_size(supernodes));
  value_.clear();
  value_.reserve(entries);
}

template <class Real>
void SupernodalSolve<Real>::add(const Supernode& s) {
  blocks_.push_back({s.first, s.columns, s.rows, s.below, value_.size()});
  given_.resize(std::max(given_.size(), to_size(s.rows + kSlice<Real>)));
  result_.resize(std::max(result_.size(), to_size(s.rows + kStrip<Real>)));
  partial_.resize(std::max(partial_.size(), to_size(s.columns) * kSlice<Real>));
  inverse_.assign(to_size(s.rows) * to_size(s.columns), 0.0);  // M by columns
  double* const M = inverse_.data();
  for (int j = 0; j < s.columns; ++j) {
    double* const column = M + static_cast<std::ptrdiff_t>(j) * s.rows;
    column[j] = 1;
    const double* const given = s.values + static_cast<std::ptrdiff_t>(j) * s.rows;
    std::copy(given + s.columns, given + s.rows, column + s.columns);
  }
  const double one = 1;
  dtrsm_("R", "L", "N", "N", &s.rows, &s.columns, &one, s.values, &s.rows, M, &s.rows);
  value_.resize(value_.size() + num_entries(s.columns, s.rows), Real(0));
  Real* out = value_.data() + blocks_.back().value;
  for (int i = 0; i < s.rows; i += kStrip<Real>) {
    const Strip<Real> strip(i, s.columns, s.rows);
    const int rows = std::min(kStrip<Real>, s.rows - i);
    for (int j = 0; j < strip.columns; ++j, out += strip.slices * kSlice<Real>) {
      const double* const from = M + static_cast<std::ptrdiff_t>(j) * s.rows + i;
      std::transform(from, from + rows, out, [](double x) { return static_cast<Real>(x); });
    }
  }
}

template <class Real>
void SupernodalSolve<Real>::solve(Real* x) {
  Real* const given = given_.data();
  Real* const result = result_.data();
  for (const Block& b : blocks_) {
    Real* const top = x + b.first;
    multiply_strips(b.columns, b.rows, value_.data() + b.value, top, result);
    std::copy_n(result, b.columns, top);
    const int* const row = b.below;
    for (int i = 0; i < b.rows - b.columns; ++i) x[row[i]] -= result[b.columns + i];
  }
  for (std::size_t k = blocks_.size(); k-- > 0;) {
    const Block& b = blocks_[k];
    Real* const top = x + b.first;
    std::copy_n(top, b.columns, given);
    const int* const row = b.below;
    for (int i = 0; i < b.rows - b.columns; ++i) given[b.columns + i] = -x[row[i]];
    std::fill_n(given + b.rows, kSlice<Real>, Real(0));
    multiply_strips_transposed(b.columns, b.rows, value_.data() + b.value, given, partial_.data(),
                               top);
  }
}

template class SupernodalSolve<double>;
template class SupernodalSolve<float>;

}  // namespace bipot
