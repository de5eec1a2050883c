#pragma once

// Vectors of BIPOT_WIDTH lanes for the kernels. Each width is compiled once, with the flags of its
// instructions. Therefore everything here has internal linkage and uses nothing of the
// standard library. Otherwise the linker might use a function with these instructions for all.

#if BIPOT_WIDTH == 8
#include <immintrin.h>
#endif

#include "solvers/disks/disk_kernel_tables.h"

namespace bipot {
namespace {

constexpr int kWidth = BIPOT_WIDTH;
constexpr int kParts = kLanes / kWidth;  // of a batch

// g++ accepts these attributes in a typedef only: NOLINTBEGIN(modernize-use-using)
typedef double Lanes __attribute__((vector_size(8 * kWidth), may_alias));
typedef long long Bits __attribute__((vector_size(8 * kWidth)));
typedef double Row __attribute__((vector_size(32), may_alias));
typedef double Pair __attribute__((vector_size(16), may_alias));
#if BIPOT_WIDTH == 8
typedef double TwoRows __attribute__((vector_size(64), may_alias, aligned(32)));
#endif
// NOLINTEND(modernize-use-using)

inline Lanes load(const double* from, int part) {
  return reinterpret_cast<const Lanes*>(from)[part];
}
inline void store(double* to, int part, Lanes x) { reinterpret_cast<Lanes*>(to)[part] = x; }
inline const Row& row(const BodyRow& r) { return *reinterpret_cast<const Row*>(&r); }
inline Row& row(BodyRow& r) { return *reinterpret_cast<Row*>(&r); }
/// The row at an offset, of disks or spheres.
template <class RowType>
inline const RowType& at(const RowType* rows, unsigned offset) {
  return *reinterpret_cast<const RowType*>(reinterpret_cast<const char*>(rows) + offset);
}
template <class RowType>
inline RowType& at(RowType* rows, unsigned offset) {
  return *reinterpret_cast<RowType*>(reinterpret_cast<char*>(rows) + offset);
}

#if BIPOT_WIDTH == 8
// Instructions that g++ does not generate for the operations below. They are used with a mask of
// all lanes, since the forms without mask start from an uninitialised value (warning of g++ 12).
constexpr __mmask8 kAllLanes = 0xff;
#endif

inline Lanes all(double x) { return Lanes{} + x; }
/// max(x, 0); NaN stays NaN. Written like the instruction, which compilers do not find otherwise.
inline Lanes positive(Lanes x) {
  const Lanes zero{};
#if BIPOT_WIDTH == 8
  return _mm512_maskz_max_pd(kAllLanes, zero, x);
#else
  return zero > x ? zero : x;
#endif
}
/// -(a b). Subtracted from zero, the product is rounded once, as it is by itself.
inline Lanes negative_product(Lanes a, Lanes b) {
#if BIPOT_WIDTH == 8
  return _mm512_fnmsub_pd(a, b, Lanes{});
#else
  return -(a * b);
#endif
}
inline Lanes magnitude(Lanes x) {
  return reinterpret_cast<Lanes>(reinterpret_cast<Bits>(x) & 0x7fffffffffffffffLL);
}
/// The smaller one, `b` if one is NaN. Written like the instruction, as positive() is.
inline Lanes lesser(Lanes a, Lanes b) {
#if BIPOT_WIDTH == 8
  return _mm512_maskz_min_pd(kAllLanes, a, b);
#else
  return a < b ? a : b;
#endif
}
/// x limited to [-radius, radius]; NaN stays NaN. By magnitude and sign: only one comparison
/// depends on the radius.
inline Lanes cut_off(Lanes x, Lanes radius) {
  const Bits sign = Bits{} + static_cast<long long>(1ULL << 63);
  const Lanes size = lesser(radius, magnitude(x));
  return reinterpret_cast<Lanes>(reinterpret_cast<Bits>(size) | (reinterpret_cast<Bits>(x) & sign));
}

#if BIPOT_WIDTH == 8
/// From here on rows must not be read in pairs before the next line of the cache.
inline bool starts_within_line(const BodyRow* rows) {
  return reinterpret_cast<decltype(sizeof(int))>(rows) % sizeof(Lanes) != 0;
}

inline Lanes first_of_pairs(Lanes a, Lanes b) {
  return __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
}
inline Lanes second_of_pairs(Lanes a, Lanes b) {
  return __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
}
/// Every second of four pairs, of two vectors.
inline Lanes even_pairs(Lanes a, Lanes b) {
  return __builtin_shufflevector(a, b, 0, 1, 4, 5, 8, 9, 12, 13);
}
inline Lanes odd_pairs(Lanes a, Lanes b) {
  return __builtin_shufflevector(a, b, 2, 3, 6, 7, 10, 11, 14, 15);
}
#elif BIPOT_WIDTH == 4
/// Value k of each row becomes row k.
[[gnu::always_inline]] inline void transpose(Row (&r)[4]) {
  const Row even01 = __builtin_shufflevector(r[0], r[1], 0, 4, 2, 6);
  const Row even23 = __builtin_shufflevector(r[2], r[3], 0, 4, 2, 6);
  const Row odd01 = __builtin_shufflevector(r[0], r[1], 1, 5, 3, 7);
  const Row odd23 = __builtin_shufflevector(r[2], r[3], 1, 5, 3, 7);
  r[0] = __builtin_shufflevector(even01, even23, 0, 1, 4, 5);
  r[1] = __builtin_shufflevector(odd01, odd23, 0, 1, 4, 5);
  r[2] = __builtin_shufflevector(even01, even23, 2, 3, 6, 7);
  r[3] = __builtin_shufflevector(odd01, odd23, 2, 3, 6, 7);
}
#endif

/// Prefetches the lines of the cache with data that are needed later.
template <class T>
inline void prefetch(const T& what) {
  constexpr unsigned kLine = 64;
  for (unsigned at = 0; at < sizeof(T); at += kLine) {
    __builtin_prefetch(reinterpret_cast<const char*>(&what) + at);
  }
}
/// The same for an item of a list, which may have ended before: nothing is read there.
template <class T>
inline void prefetch_item(const T* list, int k) {
  using Address = decltype(sizeof(T));
  const Address item = reinterpret_cast<Address>(list) + static_cast<Address>(k) * sizeof(T);
  prefetch(*reinterpret_cast<const T*>(item));
}

/// Number of batches by which streamed data are prefetched: from the shared cache they would come
/// too late.
constexpr int kAhead = 16;
/// The same for rows of bodies.
constexpr int kRowsAhead = 64;

void extrapolate_velocity(const ExtrapolationTask& task) {
  const ExtrapolationTask a = task;
  const auto extrapolated = [&]<class Rows>(int k, Rows beta) {
    if (a.ask_ahead) {
      prefetch_item(a.now, k + kRowsAhead);
      prefetch_item(a.before, k + kRowsAhead);
    }
    const Rows v = *reinterpret_cast<const Rows*>(a.now + k);
    Rows& before = *reinterpret_cast<Rows*>(a.before + k);
    before = v + beta * (v - before);
  };
  int k = 0;
#if BIPOT_WIDTH == 8
  if (starts_within_line(a.now) && k < a.rows) extrapolated(k++, Row{} + a.beta);
  for (; k + 1 < a.rows; k += 2) extrapolated(k, TwoRows{} + a.beta);
#endif
  for (; k < a.rows; ++k) extrapolated(k, Row{} + a.beta);
}

}  // namespace
}  // namespace bipot
