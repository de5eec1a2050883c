#include "core/problem/supernodal_solve.h"

#include <algorithm>

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__)
#define BIPOT_SLICES __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define BIPOT_SLICES
#endif

extern "C" {
void dtrsm_(const char* side, const char* uplo, const char* transa, const char* diag, const int* m,
            const int* n, const double* alpha, const double* a, const int* lda, double* b,
            const int* ldb);
}

namespace bipot {
namespace {

constexpr int kSlice = 4;

int slices_of(int count) { return (count + kSlice - 1) / kSlice; }

using Slice = double __attribute__((vector_size(kSlice * sizeof(double)), aligned(8), may_alias));

/// out[4 k ..] = sum_j slice_k[4 j ..] x[j], j from k * step to count. The slices stand one after the
/// other: one stream from memory, which is what takes the time.
BIPOT_SLICES void multiply_slices(int slices, int count, int step, const double* values,
                                  const double* x, double* out) {
  const auto* p = reinterpret_cast<const Slice*>(values);
  auto* result = reinterpret_cast<Slice*>(out);
  for (int k = 0; k < slices; ++k) {
    Slice sum{};
    for (int j = k * step; j < count; ++j) sum += *p++ * x[j];
    *result++ = sum;
  }
}

/// Zeros for so many more slices at the end; the first of them.
double* extended(std::vector<double>& numbers, int slices) {
  const std::size_t before = numbers.size();
  numbers.resize(before + to_size(slices) * kSlice, 0.0);
  return numbers.data() + before;
}

}  // namespace

void SupernodalSolve::begin(int size) {
  blocks_.clear();
  row_.clear();
  forward_.clear();
  backward_.clear();
  const std::size_t most = to_size(size + kSlice);
  given_.resize(most);
  result_.resize(most);
}

void SupernodalSolve::add(const Supernode& s) {
  blocks_.push_back({s.first, s.columns, s.rows, row_.size(), forward_.size(), backward_.size()});
  row_.insert(row_.end(), s.below, s.below + (s.rows - s.columns));
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
  double* out = extended(forward_, slices_of(s.rows) * s.columns);
  for (int i = 0; i < s.rows; i += kSlice) {
    const int lanes = std::min(kSlice, s.rows - i);
    for (int j = 0; j < s.columns; ++j, out += kSlice) {
      std::copy_n(M + static_cast<std::ptrdiff_t>(j) * s.rows + i, lanes, out);
    }
  }
  int slices = 0;
  for (int j = 0; j < s.columns; j += kSlice) slices += s.rows - j;
  out = extended(backward_, slices);
  for (int j = 0; j < s.columns; j += kSlice) {
    const int lanes = std::min(kSlice, s.columns - j);
    const double* const column = M + static_cast<std::ptrdiff_t>(j) * s.rows;
    for (int i = j; i < s.rows; ++i, out += kSlice) {  // above, a triangle is zero
      for (int lane = 0; lane < lanes; ++lane) {
        out[lane] = column[static_cast<std::ptrdiff_t>(lane) * s.rows + i];
      }
    }
  }
}

void SupernodalSolve::solve(double* x) {
  double* const given = given_.data();
  double* const result = result_.data();
  for (const Block& b : blocks_) {
    double* const top = x + b.first;
    multiply_slices(slices_of(b.rows), b.columns, 0, forward_.data() + b.forward, top, result);
    std::copy_n(result, b.columns, top);
    const int* const row = row_.data() + b.row;
    for (int i = 0; i < b.rows - b.columns; ++i) x[row[i]] -= result[b.columns + i];
  }
  for (std::size_t k = blocks_.size(); k-- > 0;) {
    const Block& b = blocks_[k];
    double* const top = x + b.first;
    std::copy_n(top, b.columns, given);
    const int* const row = row_.data() + b.row;
    for (int i = 0; i < b.rows - b.columns; ++i) given[b.columns + i] = -x[row[i]];
    multiply_slices(slices_of(b.columns), b.rows, kSlice, backward_.data() + b.backward, given,
                    result);
    std::copy_n(result, b.columns, top);
  }
}

}  // namespace bipot
