#include "core/linear/supernodal_solve.h"

#include <algorithm>

#include "core/base/instruction_sets.h"
#include "core/linear/dense_turn.h"

#define BIPOT_SLICES BIPOT_CLONES("arch=x86-64-v3", "default")

extern "C" {
void strsm_(const char* side, const char* uplo, const char* transa, const char* diag, const int* m,
            const int* n, const float* alpha, const float* a, const int* lda, float* b,
            const int* ldb);
}

namespace bipot {
namespace {

// Numbers in a register of 32 bytes; strips have up to four.
constexpr int kSlice = 8, kSlices = 4, kStrip = kSlices * kSlice;

using Slice = float __attribute__((vector_size(32), aligned(4), may_alias));

/// The strip of rows from `first` on: slices, and columns up to the end of its diagonal.
struct Strip {
  int slices, columns;
  Strip(int first, int columns_of_all, int rows)
      : slices(std::min((rows - first + kSlice - 1) / kSlice, kSlices)),
        columns(std::min(columns_of_all, first + kStrip)) {}
};

/// out = strip x; returns the end of the strip.
template <int kCount>
[[gnu::always_inline]] inline const Slice* multiply(const Slice* p, int columns, const float* x,
                                                    Slice* out) {
  Slice sum[std::size_t{kCount}] = {};
  for (int j = 0; j < columns; ++j, p += kCount) {
    for (int k = 0; k < kCount; ++k) sum[k] += p[k] * x[j];
  }
  for (int k = 0; k < kCount; ++k) out[k] = sum[k];
  return p;
}

/// sums += stripᵀ x, a slice of partial sums for each column.
template <int kCount>
[[gnu::always_inline]] inline const Slice* multiply_transposed(const Slice* p, int columns,
                                                               const Slice* x, Slice* sums) {
  Slice given[std::size_t{kCount}];
  for (int k = 0; k < kCount; ++k) given[k] = x[k];
  for (int j = 0; j < columns; ++j, p += kCount) {
    Slice sum = sums[j];
    for (int k = 0; k < kCount; ++k) sum += p[k] * given[k];
    sums[j] = sum;
  }
  return p;
}

// The two functions below choose a kernel by a switch each: a lambda would not be compiled for the
// instruction sets of its enclosing function.

/// out = M x, whole slices.
[[gnu::always_inline]] inline void all_strips(int columns, int rows, const float* values,
                                              const float* x, float* out) {
  const auto* p = reinterpret_cast<const Slice*>(values);
  auto* result = reinterpret_cast<Slice*>(out);
  for (int i = 0; i < rows; i += kStrip, result += kSlices) {
    const Strip strip(i, columns, rows);
    switch (strip.slices) {
      case 1:
        p = multiply<1>(p, strip.columns, x, result);
        break;
      case 2:
        p = multiply<2>(p, strip.columns, x, result);
        break;
      case 3:
        p = multiply<3>(p, strip.columns, x, result);
        break;
      default:
        p = multiply<kSlices>(p, strip.columns, x, result);
    }
  }
}
BIPOT_SLICES void multiply_strips(int columns, int rows, const float* values, const float* x,
                                  float* out) {
  all_strips(columns, rows, values, x, out);
}

/// out[j] = sum of the numbers of sums[j].
[[gnu::always_inline]] inline void add_slices(int columns, const Slice* sums, float* out) {
  for (int j = 0; j < columns; ++j) {
    const Slice& s = sums[j];
    out[j] = ((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7]));
  }
}

/// out = Mᵀ x, where x has whole slices, zeros at its end; partial: scratch, a slice a column.
[[gnu::always_inline]] inline void all_strips_transposed(int columns, int rows, const float* values,
                                                         const float* x, float* partial,
                                                         float* out) {
  const auto* p = reinterpret_cast<const Slice*>(values);
  const auto* given = reinterpret_cast<const Slice*>(x);
  auto* sums = reinterpret_cast<Slice*>(partial);
  for (int j = 0; j < columns; ++j) sums[j] = Slice{};
  for (int i = 0; i < rows; i += kStrip, given += kSlices) {
    const Strip strip(i, columns, rows);
    switch (strip.slices) {
      case 1:
        p = multiply_transposed<1>(p, strip.columns, given, sums);
        break;
      case 2:
        p = multiply_transposed<2>(p, strip.columns, given, sums);
        break;
      case 3:
        p = multiply_transposed<3>(p, strip.columns, given, sums);
        break;
      default:
        p = multiply_transposed<kSlices>(p, strip.columns, given, sums);
    }
  }
  add_slices(columns, sums, out);
}
BIPOT_SLICES void multiply_strips_transposed(int columns, int rows, const float* values,
                                             const float* x, float* partial, float* out) {
  all_strips_transposed(columns, rows, values, x, partial, out);
}

}  // namespace

std::size_t SupernodalSolve::num_entries(int columns, int rows) {
  std::size_t slices = 0;
  for (int i = 0; i < rows; i += kStrip) {
    const Strip strip(i, columns, rows);
    slices += to_size(strip.slices) * to_size(strip.columns);
  }
  return slices * kSlice;
}

void SupernodalSolve::begin(int supernodes, std::size_t entries) {
  blocks_.clear();
  blocks_.reserve(to_size(supernodes));
  value_.clear();
  value_.reserve(entries);
}

void SupernodalSolve::add(const Supernode& s) {
  blocks_.push_back({s.first, s.columns, s.rows, s.below, value_.size()});
  given_.resize(std::max(given_.size(), to_size(s.rows + kSlice)));
  result_.resize(std::max(result_.size(), to_size(s.rows + kStrip)));
  partial_.resize(std::max(partial_.size(), to_size(s.columns) * kSlice));
  inverse_.assign(to_size(s.rows) * to_size(s.columns), 0.0F);  // M by columns
  float* const M = inverse_.data();
  for (int j = 0; j < s.columns; ++j) {
    float* const column = M + static_cast<std::ptrdiff_t>(j) * s.rows;
    column[j] = 1;
    const float* const given = s.values + static_cast<std::ptrdiff_t>(j) * s.rows;
    std::copy(given + s.columns, given + s.rows, column + s.columns);
  }
  const float one = 1;
  {
    const DenseTurn turn;
    strsm_("R", "L", "N", "N", &s.rows, &s.columns, &one, s.values, &s.rows, M, &s.rows);
  }
  value_.resize(value_.size() + num_entries(s.columns, s.rows), 0.0F);
  float* out = value_.data() + blocks_.back().value;
  for (int i = 0; i < s.rows; i += kStrip) {
    const Strip strip(i, s.columns, s.rows);
    const int rows = std::min(kStrip, s.rows - i);
    for (int j = 0; j < strip.columns; ++j, out += strip.slices * kSlice) {
      const float* const from = M + static_cast<std::ptrdiff_t>(j) * s.rows + i;
      std::copy_n(from, rows, out);
    }
  }
}

void SupernodalSolve::solve(float* x) {
  float* const given = given_.data();
  float* const result = result_.data();
  for (const Block& b : blocks_) {
    float* const top = x + b.first;
    multiply_strips(b.columns, b.rows, value_.data() + b.value, top, result);
    std::copy_n(result, b.columns, top);
    const int* const row = b.below;
    for (int i = 0; i < b.rows - b.columns; ++i) x[row[i]] -= result[b.columns + i];
  }
  for (std::size_t k = blocks_.size(); k-- > 0;) {
    const Block& b = blocks_[k];
    float* const top = x + b.first;
    std::copy_n(top, b.columns, given);
    const int* const row = b.below;
    for (int i = 0; i < b.rows - b.columns; ++i) given[b.columns + i] = -x[row[i]];
    std::fill_n(given + b.rows, kSlice, 0.0F);
    multiply_strips_transposed(b.columns, b.rows, value_.data() + b.value, given, partial_.data(),
                               top);
  }
}

}  // namespace bipot
