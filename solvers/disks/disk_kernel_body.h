#pragma once

// The kernels for disks in vectors of BIPOT_WIDTH lanes. Each width is compiled once, with the
// flags of its instructions. Therefore everything here has internal linkage and uses nothing of the
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
/// The row at an offset.
inline const BodyRow& at(const BodyRow* rows, unsigned offset) {
  return *reinterpret_cast<const BodyRow*>(reinterpret_cast<const char*>(rows) + offset);
}
inline BodyRow& at(BodyRow* rows, unsigned offset) {
  return *reinterpret_cast<BodyRow*>(reinterpret_cast<char*>(rows) + offset);
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

/// Relative motion of the bodies of each lane: V_i - V_j and the sum of the spins.
struct Motion {
  Lanes x, y, spin;
};
/// Sign of the second body of a contact: velocity with opposite x and y, or like the first.
enum Second { kOpposed, kAlike };

#if BIPOT_WIDTH == 2
using PairBits = long long __attribute__((vector_size(16)));

/// The halves of a row: (x, spin) and (y, unused).
inline const Pair* half(const BodyRow& r) { return reinterpret_cast<const Pair*>(&r); }
inline Pair* half(BodyRow& r) { return reinterpret_cast<Pair*>(&r); }
/// (-x, spin), or both as they are.
template <Second kSecond>
inline Pair second(Pair x_spin) {
  if constexpr (kSecond == kAlike) return x_spin;
  const PairBits sign{static_cast<long long>(1ULL << 63), 0};
  return reinterpret_cast<Pair>(reinterpret_cast<PairBits>(x_spin) ^ sign);
}

/// y, with the opposite sign if the second body is opposed.
template <Second kSecond>
inline double second(double y) {
  return kSecond == kAlike ? y : -y;
}

/// `u`: the rows that `i` is relative to.
template <Second kSecond>
[[gnu::always_inline]] inline Motion gather(const BodyRow* u, const unsigned* i, const BodyRow* v,
                                            const unsigned* j) {
  const Pair a = half(at(u, i[0]))[0] + second<kSecond>(half(at(v, j[0]))[0]),
             b = half(at(u, i[1]))[0] + second<kSecond>(half(at(v, j[1]))[0]);
  return {__builtin_shufflevector(a, b, 0, 2),
          Lanes{at(u, i[0]).value[kRowY] + second<kSecond>(at(v, j[0]).value[kRowY]),
                at(u, i[1]).value[kRowY] + second<kSecond>(at(v, j[1]).value[kRowY])},
          __builtin_shufflevector(a, b, 1, 3)};
}
template <Second kSecond>
[[gnu::always_inline]] inline Motion gather(const BodyRow* v, const unsigned* i,
                                            const unsigned* j) {
  return gather<kSecond>(v, i, v, j);
}
/// Adds the wrench, times `inverse` if there is one, to body i and its opposite to body j.
template <bool kInverse, Second kSecond>
[[gnu::always_inline]] inline void scatter(const Motion& p, const unsigned* i, const unsigned* j,
                                           const BodyRow* inverse, BodyRow* to) {
  const Pair x_spin[2] = {__builtin_shufflevector(p.x, p.spin, 0, 2),
                          __builtin_shufflevector(p.x, p.spin, 1, 3)};
  for (int k = 0; k < 2; ++k) {
    BodyRow &a = at(to, i[k]), &b = at(to, j[k]);
    if constexpr (kInverse) {
      half(a)[0] += half(at(inverse, i[k]))[0] * x_spin[k];
      a.value[kRowY] += at(inverse, i[k]).value[kRowY] * p.y[k];
      half(b)[0] += half(at(inverse, j[k]))[0] * second<kSecond>(x_spin[k]);
      b.value[kRowY] += at(inverse, j[k]).value[kRowY] * second<kSecond>(p.y[k]);
    } else {
      half(a)[0] += x_spin[k];
      a.value[kRowY] += p.y[k];
      half(b)[0] += second<kSecond>(x_spin[k]);
      b.value[kRowY] += second<kSecond>(p.y[k]);
    }
  }
}
#else
/// x - x', spin + spin', y - y' in one instruction, the reason for the order in a row; or all sums.
template <Second kSecond>
inline Row with_second(Row a, Row b) {
  if constexpr (kSecond == kAlike) return a + b;
  return __builtin_ia32_addsubpd256(a, b);
}

/// with_second() of a row in memory.
template <Second kSecond>
inline Row with_second_of(const BodyRow& r, Row b) {
#if BIPOT_WIDTH == 8
  // Products with one are exact, so that this is the same sum, by an instruction that also loads.
  constexpr Row kSign{1, -1, 1, -1};
  if constexpr (kSecond == kOpposed) return _mm256_maskz_fnmadd_pd(kAllLanes, b, kSign, row(r));
#endif
  return with_second<kSecond>(row(r), b);
}

/// Adds the wrench, times `inverse` if there is one, to body i and its opposite to body j.
template <bool kInverse, Second kSecond>
[[gnu::always_inline]] inline void add(Row wrench, unsigned i, unsigned j, const BodyRow* inverse,
                                       BodyRow* to) {
  if constexpr (kInverse) {
    row(at(to, i)) += row(at(inverse, i)) * wrench;
    row(at(to, j)) = with_second_of<kSecond>(at(to, j), row(at(inverse, j)) * wrench);
  } else {
    row(at(to, i)) += wrench;
    row(at(to, j)) = with_second_of<kSecond>(at(to, j), wrench);
  }
}
#endif

#if BIPOT_WIDTH == 4
/// `u`: the rows that `i` is relative to.
template <Second kSecond>
[[gnu::always_inline]] inline Motion gather(const BodyRow* u, const unsigned* i, const BodyRow* v,
                                            const unsigned* j) {
  Row r[4];
  for (int k = 0; k < 4; ++k) r[k] = with_second<kSecond>(row(at(u, i[k])), row(at(v, j[k])));
  const Row even01 = __builtin_shufflevector(r[0], r[1], 0, 4, 2, 6);
  const Row even23 = __builtin_shufflevector(r[2], r[3], 0, 4, 2, 6);
  const Row odd01 = __builtin_shufflevector(r[0], r[1], 1, 5, 3, 7);
  const Row odd23 = __builtin_shufflevector(r[2], r[3], 1, 5, 3, 7);
  return {__builtin_shufflevector(even01, even23, 0, 1, 4, 5),
          __builtin_shufflevector(even01, even23, 2, 3, 6, 7),
          __builtin_shufflevector(odd01, odd23, 0, 1, 4, 5)};
}
template <Second kSecond>
[[gnu::always_inline]] inline Motion gather(const BodyRow* v, const unsigned* i,
                                            const unsigned* j) {
  return gather<kSecond>(v, i, v, j);
}
/// Calls add(row, lane) in the order of the lanes.
template <class Add>
[[gnu::always_inline]] inline void for_rows(const Motion& p, const Add& add) {
  const Row zero{};
  const Row even = __builtin_shufflevector(p.x, p.spin, 0, 4, 2, 6);
  const Row odd = __builtin_shufflevector(p.x, p.spin, 1, 5, 3, 7);
  const Row y_even = __builtin_shufflevector(p.y, zero, 0, 4, 2, 6);
  const Row y_odd = __builtin_shufflevector(p.y, zero, 1, 5, 3, 7);
  add(__builtin_shufflevector(even, y_even, 0, 1, 4, 5), 0);
  add(__builtin_shufflevector(odd, y_odd, 0, 1, 4, 5), 1);
  add(__builtin_shufflevector(even, y_even, 2, 3, 6, 7), 2);
  add(__builtin_shufflevector(odd, y_odd, 2, 3, 6, 7), 3);
}
template <bool kInverse, Second kSecond>
[[gnu::always_inline]] inline void scatter(const Motion& p, const unsigned* i, const unsigned* j,
                                           const BodyRow* inverse, BodyRow* to) {
  for_rows(p, [&](Row wrench, int k) { add<kInverse, kSecond>(wrench, i[k], j[k], inverse, to); });
}
#elif BIPOT_WIDTH == 8
/// Two rows in one register.
inline Lanes both(Row a, Row b) {
  return _mm512_maskz_insertf64x4(kAllLanes, _mm512_castpd256_pd512(a), b, 1);
}

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

/// The motion in rows of the lanes (0, 2), (1, 3), (4, 6), (5, 7).
[[gnu::always_inline]] inline Motion motion_of(Lanes a, Lanes b, Lanes c, Lanes d) {
  // (x, y) of two lanes alternately, and their spins.
  const Lanes even0 = first_of_pairs(a, b), odd0 = second_of_pairs(a, b);
  const Lanes even1 = first_of_pairs(c, d), odd1 = second_of_pairs(c, d);
  return {__builtin_shufflevector(even0, even1, 0, 1, 4, 5, 8, 9, 12, 13),
          __builtin_shufflevector(even0, even1, 2, 3, 6, 7, 10, 11, 14, 15),
          __builtin_shufflevector(odd0, odd1, 0, 1, 4, 5, 8, 9, 12, 13)};
}
/// Wrenches as rows of the same pairs.
struct WrenchRows {
  Lanes a, b, c, d;
};
[[gnu::always_inline]] inline WrenchRows rows_of(const Motion& p) {
  // (x, spin) of lanes 0, 2, 4, 6 and 1, 3, 5, 7; with y of the same lane, and 0, they form rows.
  const Lanes even = first_of_pairs(p.x, p.spin), odd = second_of_pairs(p.x, p.spin);
  const auto pair = [&](Lanes x_spin, long long at, long long y) {
    constexpr __mmask8 kNoFourth = 0x77;
    const Bits from{at, at + 1, 8 + y, 0, at + 2, at + 3, 10 + y, 0};
    return _mm512_maskz_permutex2var_pd(kNoFourth, x_spin, from, p.y);
  };
  return {pair(even, 0, 0), pair(odd, 0, 1), pair(even, 4, 4), pair(odd, 4, 5)};
}
inline Row lower(Lanes rows) { return __builtin_shufflevector(rows, rows, 0, 1, 2, 3); }
inline Row upper(Lanes rows) { return __builtin_shufflevector(rows, rows, 4, 5, 6, 7); }
/// Calls add(row, lane) in the order of the lanes.
template <class Add>
[[gnu::always_inline]] inline void for_rows(const WrenchRows& rows, const Add& add) {
  add(lower(rows.a), 0);
  add(lower(rows.b), 1);
  add(upper(rows.a), 2);
  add(upper(rows.b), 3);
  add(lower(rows.c), 4);
  add(lower(rows.d), 5);
  add(upper(rows.c), 6);
  add(upper(rows.d), 7);
}

template <Second kSecond>
[[gnu::always_inline]] inline Motion gather(const BodyRow* v, const unsigned* i,
                                            const unsigned* j) {
  const auto pair = [&](int k, int l) {
    return both(with_second<kSecond>(row(at(v, i[k])), row(at(v, j[k]))),
                with_second<kSecond>(row(at(v, i[l])), row(at(v, j[l]))));
  };
  return motion_of(pair(0, 2), pair(1, 3), pair(4, 6), pair(5, 7));
}
template <bool kInverse, Second kSecond>
[[gnu::always_inline]] inline void scatter(const Motion& p, const unsigned* i, const unsigned* j,
                                           const BodyRow* inverse, BodyRow* to) {
  for_rows(rows_of(p),
           [&](Row wrench, int k) { add<kInverse, kSecond>(wrench, i[k], j[k], inverse, to); });
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

/// Runs solve(batch, part, motion) -> wrench over all parts of the batches from `first` to before
/// `last`, downwards with kBack. In program order the bodies of a part are read before the previous
/// part writes to its own. The processor can then work on both at once. They share no body: neither
/// do the lanes of a batch nor two consecutive batches.
template <bool kBack, int D, class Solve>
[[gnu::always_inline]] inline void for_parts(const ContactBatch<D>* contact, int first, int last,
                                             BodyRow* velocity, const BodyRow* inverse,
                                             const Solve& solve) {
  struct Bodies {
    const unsigned *i = nullptr, *j = nullptr;
  };
  const auto bodies_of = [&](int batch, int part) {
    return Bodies{contact[batch].i + part * kWidth, contact[batch].j + part * kWidth};
  };
  const int batches = last - first, step = kBack ? -1 : 1;
  Motion wrench{};
  Bodies before;
  int k = kBack ? last - 1 : first;
  for (int n = 0; n < batches; ++n, k += step) {
#pragma GCC unroll 4
    for (int part = 0; part < kParts; ++part) {
      const Bodies bodies = bodies_of(k, part);
      const Motion motion = gather<kOpposed>(velocity, bodies.i, bodies.j);
      if (part > 0 || n > 0) {
        scatter<true, kOpposed>(wrench, before.i, before.j, inverse, velocity);
      }
      wrench = solve(k, part, motion);
      before = bodies;
    }
  }
  if (batches > 0) scatter<true, kOpposed>(wrench, before.i, before.j, inverse, velocity);
}

/// Sums for the rows of a block.
struct BlockRows {
#if BIPOT_WIDTH == 8
  Lanes pair[kLanes / 2];
#else
  BodyRow row[kLanes];
#endif
};

/// Relative motion of the lanes of a part, whose first bodies are those of a block.
[[gnu::always_inline]] inline Motion gather_block(const BodyRow* block, [[maybe_unused]] int part,
                                                  const BodyRow* velocity, const unsigned* j) {
#if BIPOT_WIDTH == 8
  constexpr Lanes kSign{1, -1, 1, -1, 1, -1, 1, -1};
  const auto pair = [&](int n, int k, int l) {
    return _mm512_fnmadd_pd(both(row(at(velocity, j[k])), row(at(velocity, j[l]))), kSign,
                            *reinterpret_cast<const TwoRows*>(block + 2 * n));
  };
  return motion_of(pair(0, 0, 2), pair(1, 1, 3), pair(2, 4, 6), pair(3, 5, 7));
#else
  unsigned i[kWidth];
  for (int k = 0; k < kWidth; ++k) {
    i[k] = static_cast<unsigned>(sizeof(BodyRow)) *
           static_cast<unsigned>(kRowOfLane[part * kWidth + k]);
  }
  return gather<kOpposed>(block, i, velocity, j);
#endif
}
/// Adds wrenches to the sum of a block and their opposites to the second bodies, which are all
/// different.
[[gnu::always_inline]] inline void scatter_block(const Motion& p, [[maybe_unused]] int part,
                                                 const unsigned* j, BlockRows& sum, BodyRow* to) {
#if BIPOT_WIDTH == 8
  const WrenchRows rows = rows_of(p);
  sum.pair[0] += rows.a;
  sum.pair[1] += rows.b;
  sum.pair[2] += rows.c;
  sum.pair[3] += rows.d;
  constexpr Lanes kSign{1, -1, 1, -1, 1, -1, 1, -1};
  const auto take = [&](Lanes wrenches, int k, int l) {
    BodyRow &first = at(to, j[k]), &other = at(to, j[l]);
    const Lanes taken = _mm512_fnmadd_pd(wrenches, kSign, both(row(first), row(other)));
    row(first) = lower(taken);
    row(other) = upper(taken);
  };
  take(rows.a, 0, 2);
  take(rows.b, 1, 3);
  take(rows.c, 4, 6);
  take(rows.d, 5, 7);
#elif BIPOT_WIDTH == 4
  for_rows(p, [&](Row wrench, int k) {
    row(sum.row[kRowOfLane[part * kWidth + k]]) += wrench;
    row(at(to, j[k])) = with_second_of<kOpposed>(at(to, j[k]), wrench);
  });
#else
  const Pair x_spin[2] = {__builtin_shufflevector(p.x, p.spin, 0, 2),
                          __builtin_shufflevector(p.x, p.spin, 1, 3)};
  for (int k = 0; k < 2; ++k) {
    BodyRow &a = sum.row[kRowOfLane[part * kWidth + k]], &b = at(to, j[k]);
    half(a)[0] += x_spin[k];
    a.value[kRowY] += p.y[k];
    half(b)[0] += second<kOpposed>(x_spin[k]);
    b.value[kRowY] += second<kOpposed>(p.y[k]);
  }
#endif
}
/// Row by row: a second body may just have been written, which would delay a load of eight values.
[[gnu::always_inline]] inline void add_block(const BlockRows& sum, BodyRow* rows) {
#if BIPOT_WIDTH == 8
  for (int n = 0; n < kLanes / 2; ++n) {
    row(rows[2 * n]) += lower(sum.pair[n]);
    row(rows[2 * n + 1]) += upper(sum.pair[n]);
  }
#else
  for (int n = 0; n < kLanes; ++n) {
    for (int k = 0; k < 4; ++k) rows[n].value[k] += sum.row[n].value[k];
  }
#endif
}

/// Runs solve(batch, part, motion) -> wrench over the batches of blocks: first those of a block,
/// whose first bodies have consecutive rows, then the loose ones. Velocities do not change.
///
/// The next part is gathered before this one scatters, so that the processor can overlap both. The
/// gather after the last part of a block may be useless: it reads any eight rows, which then need
/// not begin with a line of the cache.
template <int D, class Solve>
[[gnu::always_inline]] inline void for_blocks(const GradientTask<D>& a, const BodyBlock* block,
                                              const BodyBlock* last, const Solve& solve) {
  const auto seconds = [&](int k, int part) { return a.contact[k].j + part * kWidth; };
  const auto gathered = [&](int k, int part) {
    return gather_block(&at(a.velocity, a.contact[k].i[0]), part, a.velocity, seconds(k, part));
  };
  Motion motion = gathered(block->first, 0);
  for (; block != last; ++block) {
    const int loose = block->loose, end = block[1].first;
    if (block->first < loose) {
      BlockRows sum{};
      for (int k = block->first; k < loose; ++k) {
#pragma GCC unroll 4
        for (int part = 0; part < kParts; ++part) {
          const Motion wrench = solve(k, part, motion);
          motion = part + 1 < kParts ? gathered(k, part + 1) : gathered(k + 1, 0);
          scatter_block(wrench, part, seconds(k, part), sum, a.next_momentum);
        }
      }
      add_block(sum, &at(a.next_momentum, block->row));
    }
    for (int k = loose; k < end; ++k) {
#pragma GCC unroll 4
      for (int part = 0; part < kParts; ++part) {
        const unsigned *const i = a.contact[k].i + part * kWidth, *const j = seconds(k, part);
        scatter<false, kOpposed>(solve(k, part, gather<kOpposed>(a.velocity, i, j)), i, j, nullptr,
                                 a.next_momentum);
      }
    }
    if (loose < end) motion = gathered(end, 0);
  }
}

template <int D, bool kRelaxed>
void sweep_batches(const SweepTask<D>& task) {
  // A copy: the compiler cannot know that the stores leave the task unchanged.
  const SweepTask<D> a = task;
  const Lanes omega = all(a.omega);
  const auto relaxed = [&](Lanes x) {
    if constexpr (kRelaxed) x = omega * x;
    return x;
  };
  // Sums are arranged for a short dependency chain from the velocities to the wrench.
  const auto solve = [&](int k, int part, const Motion& v) {
    if (part == 0 && a.ask_ahead) {
      prefetch_item(a.contact, k + kAhead);
      prefetch_item(a.impulse, k + kAhead);
    }
    const ContactBatch<D>& c = a.contact[k];
    const LawBatch& law = a.laws[a.law[k]];
    ImpulseBatch<D>& impulse = a.impulse[k];
    const Lanes gx = load(c.gx, part), gy = load(c.gy, part);
    const Lanes x_n = load(impulse.x[0], part);
    const Lanes start_n = x_n - relaxed(load(c.b[0], part));
    const Lanes z_n = positive(start_n - (relaxed(gx) * v.x + relaxed(gy) * v.y));
    const Lanes normal = z_n - x_n;
    store(impulse.x[0], part, z_n);
    if constexpr (D == 1) {
      return Motion{gx * normal, gy * normal, Lanes{}};
    } else {
      const Lanes ratio = load(law.ratio, part), spin = load(c.spin, part);
      const Lanes tx = ratio * gy, ty = ratio * gx;
      const Lanes x_t = load(impulse.x[1], part);
      const Lanes start_t = x_t - relaxed(load(c.b[1], part));
      const Lanes turned = relaxed(ty) * v.y - relaxed(tx) * v.x;
      const Lanes trial = start_t - (turned - relaxed(spin) * v.spin);
      const Lanes z_t = cut_off(trial, load(law.mu, part) * z_n);
      const Lanes back = x_t - z_t;
      store(impulse.x[1], part, z_t);
      return Motion{gx * normal + tx * back, gy * normal - ty * back, spin * back};
    }
  };
  for_parts<false>(a.contact, 0, a.batches, a.velocity, a.inverse, solve);
}

template <int D>
void sweep(const SweepTask<D>& task) {
  if (task.omega == 1) {
    sweep_batches<D, false>(task);
  } else {
    sweep_batches<D, true>(task);
  }
}

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

/// kOuter: starts from y in the forward sweep, computes sums at the end of the backward sweep.
template <int D, bool kBack, bool kOuter>
void sweep_symmetric(const SymmetricTask<D>& task, Lanes* turn) {
  const SymmetricTask<D> a = task;
  const Lanes omega = all(a.omega), beta = all(a.beta);
  // Lists from memory are prefetched. Hardware does not predict the bodies of batches in descending
  // order: rows are prefetched as the task lists them.
  constexpr bool kStream = kBack || kOuter;
  const int batches = a.last_batch - a.first_batch;
  const int share = batches > 0 ? (a.num_coming + batches - 1) / batches : 0;
  int coming = 0;
  const auto solve = [&](int k, int part, const Motion& v) {
    if (kStream && part == 0 && a.ask_ahead) {
      const int ahead = kBack ? k - kAhead : k + kAhead;
      prefetch_item(a.contact, ahead);
      prefetch_item(a.next, ahead);
      if constexpr (kOuter) {
        prefetch_item(a.now, ahead);
        prefetch_item(a.before, ahead);
      }
      if constexpr (kBack) {
        const int end = coming + share < a.num_coming ? coming + share : a.num_coming;
        for (; coming < end; ++coming) {
          prefetch(at(a.velocity, a.coming[coming]));
          prefetch(at(a.inverse, a.coming[coming]));
        }
      }
    }
    const ContactBatch<D>& c = a.contact[k];
    const LawBatch& law = a.laws[a.law[k]];
    ImpulseBatch<D>& next = a.next[k];
    const auto extrapolated = [&](int row, Lanes now) {
      return now + beta * (now - load(a.before[k].x[row], part));
    };
    const auto put = [&](int row, Lanes from, Lanes z) {
      if constexpr (kBack && kOuter) {
        const Lanes now = load(a.now[k].x[row], part);
        turn[part] += (extrapolated(row, now) - z) * (z - now);
      }
      store(next.x[row], part, z);
      return z - from;
    };
    const auto start = [&](int row) {
      if constexpr (kBack || !kOuter) return load(next.x[row], part);
      return extrapolated(row, load(a.now[k].x[row], part));
    };
    const Lanes gx = load(c.gx, part), gy = load(c.gy, part);
    const Lanes x_n = start(0);
    const Lanes start_n = x_n - omega * load(c.b[0], part);
    const Lanes z_n = positive(start_n - (omega * gx * v.x + omega * gy * v.y));
    const Lanes normal = put(0, x_n, z_n);
    if constexpr (D == 1) {
      return Motion{gx * normal, gy * normal, Lanes{}};
    } else {
      const Lanes ratio = load(law.ratio, part), spin = load(c.spin, part);
      const Lanes tx = ratio * gy, ty = ratio * gx;
      const Lanes x_t = start(1);
      const Lanes start_t = x_t - omega * load(c.b[1], part);
      const Lanes turned = omega * ty * v.y - omega * tx * v.x;
      const Lanes trial = start_t - (turned - omega * spin * v.spin);
      const Lanes z_t = cut_off(trial, load(law.mu, part) * z_n);
      const Lanes change = put(1, x_t, z_t);
      return Motion{gx * normal - tx * change, gy * normal + ty * change,
                    negative_product(spin, change)};
    }
  };
  for_parts<kBack>(a.contact, a.first_batch, a.last_batch, a.velocity, a.inverse, solve);
}

template <int D>
void sweep_forth(const SymmetricTask<D>& task) {
  if (task.outer) {
    sweep_symmetric<D, false, true>(task, nullptr);
  } else {
    sweep_symmetric<D, false, false>(task, nullptr);
  }
}
template <int D>
void sweep_back(const SymmetricTask<D>& task, TurnSums& sums) {
  if (!task.outer) return sweep_symmetric<D, true, false>(task, nullptr);
  Lanes turn[kParts];
  for (int part = 0; part < kParts; ++part) turn[part] = load(sums.turn, part);
  sweep_symmetric<D, true, true>(task, turn);
  for (int part = 0; part < kParts; ++part) store(sums.turn, part, turn[part]);
}

/// Sums over pairs of rows, in parts: those of even and of odd rows are independent.
#if BIPOT_WIDTH == 8
using Energy = Lanes;
#else
struct Energy {
  Row even, odd;
};
#endif

/// 1/m, a²/I, 1/m, 0 from the last values of rows of velocity and of momentum.
#if BIPOT_WIDTH == 8
inline Lanes inverse_of(Lanes velocity, Lanes momentum) {
  constexpr __mmask8 kNoFourth = 0x77;
  const Bits from{3, 11, 3, 0, 7, 15, 7, 0};
  return _mm512_maskz_permutex2var_pd(kNoFourth, velocity, from, momentum);
}
/// Rows whose last values are those of `last`.
inline Lanes with_last(Lanes rows, Lanes last) {
  constexpr __mmask8 kFourth = 0x88;
  return _mm512_mask_blend_pd(kFourth, rows, last);
}
#else
inline Row inverse_of(Row velocity, Row momentum) {
  const Row inverse = __builtin_shufflevector(velocity, momentum, 3, 7, 3, 3);
  return __builtin_shufflevector(inverse, Row{}, 0, 1, 2, 4);
}
inline Row with_last(Row rows, Row last) { return __builtin_shufflevector(rows, last, 0, 1, 2, 7); }
#endif

/// Sets the velocities of a window's bodies at the extrapolated momentum; their next momentum
/// starts from 0.
template <int D>
[[gnu::always_inline]] inline void begin_bodies(const GradientTask<D>& a, unsigned first, int rows,
                                                Energy& energy) {
  const BodyRow *const now = &at(a.momentum, first), *const before = &at(a.momentum_before, first);
  BodyRow *const velocity = &at(a.velocity, first), *const next = &at(a.next_momentum, first);
  const auto begin = [&]<class Rows>(int k, Rows& sum) {
    if (a.ask_ahead) {
      prefetch_item(now, k + kRowsAhead);
      prefetch_item(before, k + kRowsAhead);
      prefetch_item(velocity, k + kRowsAhead);
      prefetch_item(next, k + kRowsAhead);
    }
    Rows& v = *reinterpret_cast<Rows*>(velocity + k);
    const Rows p = *reinterpret_cast<const Rows*>(now + k);
    const Rows change = p - *reinterpret_cast<const Rows*>(before + k);
    const Rows inverse = inverse_of(v, p), beta = Rows{} + a.beta;
    sum += inverse * change * change;
    v = with_last(inverse * (p + beta * change), v);
    *reinterpret_cast<Rows*>(next + k) = with_last(Rows{}, p);
  };
  for (int k = 0; k < rows; k += 2) {
#if BIPOT_WIDTH == 8
    begin(k, energy);
#else
    begin(k, energy.even);
    begin(k + 1, energy.odd);
#endif
  }
}

template <int D, GradientMap kMap>
void project(const GradientTask<D>& task, GradientSums& sums) {
  const GradientTask<D> a = task;
  const Lanes beta = all(a.beta);
  Lanes along[kParts] = {}, change2[kParts] = {};
  Energy energy{};
  const auto solve = [&](int k, int part, const Motion& v) {
    if (part == 0 && a.ask_ahead) {
      prefetch_item(a.contact, k + kAhead);
      prefetch_item(a.now, k + kAhead);
      prefetch_item(a.before, k + kAhead);
    }
    const ContactBatch<D>& c = a.contact[k];
    const LawBatch& law = a.laws[a.law[k]];
    const Lanes gx = load(c.gx, part), gy = load(c.gy, part), b_n = load(c.b[0], part);
    const Lanes x_n = load(a.now[k].x[0], part);
    const Lanes step_n = x_n - load(a.before[k].x[0], part);
    const Lanes y_n = x_n + beta * step_n;
    // Sums are arranged for a short dependency chain from the velocities to the wrench.
    const Lanes from_bodies_n = gx * v.x + gy * v.y;
    Lanes z_n = (y_n - b_n) - from_bodies_n;
    Motion wrench;
    if constexpr (D == 1) {
      z_n = positive(z_n);
      wrench = {gx * z_n, gy * z_n, Lanes{}};
    } else {
      const Lanes spin = load(c.spin, part), mu = load(law.mu, part), b_t = load(c.b[1], part);
      const Lanes tx = load(law.ratio, part) * gy, ty = load(law.ratio, part) * gx;
      const Lanes from_bodies_t = (ty * v.y - tx * v.x) - spin * v.spin;
      const Lanes x_t = load(a.now[k].x[1], part);
      const Lanes step_t = x_t - load(a.before[k].x[1], part);
      const Lanes y_t = x_t + beta * step_t;
      const Lanes tau_t = (y_t - b_t) - from_bodies_t;
      if constexpr (kMap == GradientMap::kFollowed) {
        const Lanes edge = (z_n + mu * magnitude(tau_t)) * load(law.cone, part);
        z_n = edge > z_n ? edge : z_n;
      }
      z_n = positive(z_n);
      const Lanes z_t = cut_off(tau_t, mu * z_n);
      const Lanes change = z_t - x_t;
      along[part] += step_t * change;
      change2[part] += change * change;
      store(a.next[k].x[1], part, z_t);
      wrench = {gx * z_n - tx * z_t, gy * z_n + ty * z_t, negative_product(spin, z_t)};
    }
    const Lanes change = z_n - x_n;
    along[part] += step_n * change;
    change2[part] += change * change;
    store(a.next[k].x[0], part, z_n);
    return wrench;
  };
  for (const BodyBlock* window = a.begin; window != a.end;) {
    const auto left = a.end - window;
    const BodyBlock* const end = window + (left < kWindowBlocks ? left : kWindowBlocks);
    begin_bodies(a, window->row, static_cast<int>(end - window) * kLanes, energy);
    for_blocks(a, window, end, solve);
    window = end;
  }
  *reinterpret_cast<Energy*>(sums.energy) = energy;
  for (int part = 0; part < kParts; ++part) {
    store(sums.along, part, along[part]);
    store(sums.change2, part, change2[part]);
  }
}

template <int D>
void gradient(const GradientTask<D>& task, GradientSums& sums) {
  if (task.map == GradientMap::kFollowed) {
    project<D, GradientMap::kFollowed>(task, sums);
  } else {
    project<D, GradientMap::kSplit>(task, sums);
  }
}

}  // namespace
}  // namespace bipot
