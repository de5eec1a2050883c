#pragma once

// Rows of disks in lanes.

#include "solvers/disks/kernel_loops.h"

namespace bipot {
namespace {

/// Relative motion of the bodies of each lane: V_i - V_j, the sum of the spins, and with rolling
/// friction their difference.
struct Motion {
  Lanes x, y, spin, turn = Lanes{};
};
/// A wrench on body i and its opposite on body j, which turn alike. With rolling friction `turn` is
/// the spin part of j.
using Wrench = Motion;
/// That on either body, whose spin part stands in `turn` once more, as in rows with rolling friction.
inline Wrench on_first(const Wrench& p) { return {p.x, p.y, p.spin, p.spin}; }
inline Wrench on_second(const Wrench& p) { return {p.x, p.y, p.turn, p.turn}; }
/// Sign of the second body of a contact: velocity with opposite x and y, or like the first, or
/// all but the spin opposite.
enum Second { kOpposed, kAlike, kRolling };
template <int D>
constexpr Second kSecondOf = D == kRollingDisks ? kRolling : kOpposed;
/// The same of its wrench: that of rolling is opposed too, with a spin part of its own.
template <Second kSecond>
constexpr Second kOfWrench = kSecond == kRolling ? kOpposed : kSecond;

/// w_m - b_m of the contacts of a part.
inline Lanes rolling_velocity(const ContactBatch<kRollingDisks>& c, int part, const Motion& v) {
  return load(c.turns[kTurnHalf], part) * v.turn + load(c.turns[kTurnLean], part) * v.spin;
}
/// Adds their moments x_m to wrenches of the forces alone.
inline void add_moments(const ContactBatch<kRollingDisks>& c, int part, Lanes x_m, Wrench& wrench) {
  const Lanes alike = wrench.spin + load(c.turns[kTurnLean], part) * x_m;
  const Lanes opposed = load(c.turns[kTurnHalf], part) * x_m;
  wrench.spin = alike + opposed;
  wrench.turn = alike - opposed;
}

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
  Lanes turn{};
  if constexpr (kSecond == kRolling) {
    for (int k = 0; k < 2; ++k) {
      turn[k] = at(u, i[k]).value[kRowLast] - at(v, j[k]).value[kRowLast];
    }
  }
  return {__builtin_shufflevector(a, b, 0, 2),
          Lanes{at(u, i[0]).value[kRowY] + second<kSecond>(at(v, j[0]).value[kRowY]),
                at(u, i[1]).value[kRowY] + second<kSecond>(at(v, j[1]).value[kRowY])},
          __builtin_shufflevector(a, b, 1, 3), turn};
}
/// Adds the wrench of lane k, times inverses if they are given, to body a and its opposite to b.
template <bool kInverse, Second kSecond>
[[gnu::always_inline]] inline void add(const Wrench& p, int k, const BodyRow* inverse_a, BodyRow& a,
                                       const BodyRow* inverse_b, BodyRow& b) {
  constexpr Second kOther = kOfWrench<kSecond>;
  const Pair first{p.x[k], p.spin[k]};
  const Pair other = second<kOther>(Pair{p.x[k], kSecond == kRolling ? p.turn[k] : p.spin[k]});
  if constexpr (kInverse) {
    half(a)[0] += half(*inverse_a)[0] * first;
    a.value[kRowY] += inverse_a->value[kRowY] * p.y[k];
    half(b)[0] += half(*inverse_b)[0] * other;
    b.value[kRowY] += inverse_b->value[kRowY] * second<kOther>(p.y[k]);
  } else {
    half(a)[0] += first;
    a.value[kRowY] += p.y[k];
    half(b)[0] += other;
    b.value[kRowY] += second<kOther>(p.y[k]);
  }
  if constexpr (kSecond == kRolling) {
    a.value[kRowLast] = a.value[kRowSpin];
    b.value[kRowLast] = b.value[kRowSpin];
  }
}
/// Adds the wrench, times `inverse` if there is one, to body i and its opposite to body j.
template <bool kInverse, Second kSecond>
[[gnu::always_inline]] inline void scatter(const Wrench& p, const unsigned* i, const unsigned* j,
                                           const BodyRow* inverse, BodyRow* to) {
  for (int k = 0; k < 2; ++k) {
    add<kInverse, kSecond>(p, k, kInverse ? &at(inverse, i[k]) : nullptr, at(to, i[k]),
                           kInverse ? &at(inverse, j[k]) : nullptr, at(to, j[k]));
  }
}
#else
using RowBits = long long __attribute__((vector_size(32)));
/// The signs of these values changed, where the bit is set.
inline Row with_signs(Row a, RowBits signs) {
  return reinterpret_cast<Row>(reinterpret_cast<RowBits>(a) ^ signs);
}

/// x - x', spin + spin', y - y' in one instruction, the reason for the order in a row; or all sums.
template <Second kSecond>
inline Row with_second(Row a, Row b) {
  if constexpr (kSecond == kAlike) return a + b;
  if constexpr (kSecond == kRolling) {
    return a - with_signs(b, RowBits{0, static_cast<long long>(1ULL << 63), 0, 0});
  }
  return __builtin_ia32_addsubpd256(a, b);
}

/// with_second() of a row in memory.
template <Second kSecond>
inline Row with_second_of(const BodyRow& r, Row b) {
#if BIPOT_WIDTH == 8
  // Products with one are exact, so that this is the same sum, by an instruction that also loads.
  constexpr Row kSign{1, -1, 1, -1};
  if constexpr (kSecond != kAlike) return _mm256_maskz_fnmadd_pd(kAllLanes, b, kSign, row(r));
#endif
  return with_second<kSecond>(row(r), b);
}

/// Adds a wrench, times `inverse` if there is one, to body i and the opposite of `other` to body j.
template <bool kInverse, Second kSecond>
[[gnu::always_inline]] inline void add(Row wrench, Row other, unsigned i, unsigned j,
                                       const BodyRow* inverse, BodyRow* to) {
  if constexpr (kInverse) {
    row(at(to, i)) += row(at(inverse, i)) * wrench;
    row(at(to, j)) = with_second_of<kSecond>(at(to, j), row(at(inverse, j)) * other);
  } else {
    row(at(to, i)) += wrench;
    row(at(to, j)) = with_second_of<kSecond>(at(to, j), other);
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
  transpose(r);
  return {r[0], r[2], r[1], r[3]};
}
/// Calls add(row, row of the second body, lane) in the order of the lanes.
template <Second kSecond, class Add>
[[gnu::always_inline]] inline void for_rows(const Wrench& p, const Add& add) {
  const Wrench one = kSecond == kRolling ? on_first(p) : p, two = on_second(p);
  Row first[4] = {one.x, one.spin, one.y, one.turn}, other[4] = {two.x, two.spin, two.y, two.turn};
  transpose(first);
  if constexpr (kSecond == kRolling) transpose(other);
  for (int k = 0; k < 4; ++k) add(first[k], kSecond == kRolling ? other[k] : first[k], k);
}
#elif BIPOT_WIDTH == 8
/// Two rows in one register.
inline Lanes both(Row a, Row b) {
  return _mm512_maskz_insertf64x4(kAllLanes, _mm512_castpd256_pd512(a), b, 1);
}

/// Products with one are exact, so that differences with these signs are rounded once.
template <Second kSecond>
constexpr Lanes kSignOfSecond = {1, -1, 1, kSecond == kRolling ? 1 : -1,
                                 1, -1, 1, kSecond == kRolling ? 1 : -1};

/// The motion in rows of the lanes (0, 2), (1, 3), (4, 6), (5, 7).
[[gnu::always_inline]] inline Motion motion_of(Lanes a, Lanes b, Lanes c, Lanes d) {
  // (x, y) of two lanes alternately, and their spins.
  const Lanes even0 = first_of_pairs(a, b), odd0 = second_of_pairs(a, b);
  const Lanes even1 = first_of_pairs(c, d), odd1 = second_of_pairs(c, d);
  return {even_pairs(even0, even1), odd_pairs(even0, even1), even_pairs(odd0, odd1),
          odd_pairs(odd0, odd1)};
}
/// Wrenches as rows of the same pairs.
struct WrenchRows {
  Lanes a, b, c, d;
};
template <Second kSecond>
[[gnu::always_inline]] inline WrenchRows rows_of(const Wrench& p) {
  // (x, spin) of lanes 0, 2, 4, 6 and 1, 3, 5, 7; with y of the same lane, and 0, they form rows.
  const Lanes even = first_of_pairs(p.x, p.spin), odd = second_of_pairs(p.x, p.spin);
  if constexpr (kSecond == kRolling) {
    const Lanes y_even = first_of_pairs(p.y, p.turn), y_odd = second_of_pairs(p.y, p.turn);
    return {__builtin_shufflevector(even, y_even, 0, 1, 8, 9, 2, 3, 10, 11),
            __builtin_shufflevector(odd, y_odd, 0, 1, 8, 9, 2, 3, 10, 11),
            __builtin_shufflevector(even, y_even, 4, 5, 12, 13, 6, 7, 14, 15),
            __builtin_shufflevector(odd, y_odd, 4, 5, 12, 13, 6, 7, 14, 15)};
  }
  const auto pair = [&](Lanes x_spin, long long at, long long y) {
    constexpr __mmask8 kNoFourth = 0x77;
    const Bits from{at, at + 1, 8 + y, 0, at + 2, at + 3, 10 + y, 0};
    return _mm512_maskz_permutex2var_pd(kNoFourth, x_spin, from, p.y);
  };
  return {pair(even, 0, 0), pair(odd, 0, 1), pair(even, 4, 4), pair(odd, 4, 5)};
}
inline Row lower(Lanes rows) { return __builtin_shufflevector(rows, rows, 0, 1, 2, 3); }
inline Row upper(Lanes rows) { return __builtin_shufflevector(rows, rows, 4, 5, 6, 7); }
/// Calls add(row, row of the second body, lane) in the order of the lanes.
template <Second kSecond, class Add>
[[gnu::always_inline]] inline void for_rows(const Wrench& p, const Add& add) {
  const WrenchRows first = rows_of<kSecond>(kSecond == kRolling ? on_first(p) : p);
  const WrenchRows other = kSecond == kRolling ? rows_of<kSecond>(on_second(p)) : first;
  add(lower(first.a), lower(other.a), 0);
  add(lower(first.b), lower(other.b), 1);
  add(upper(first.a), upper(other.a), 2);
  add(upper(first.b), upper(other.b), 3);
  add(lower(first.c), lower(other.c), 4);
  add(lower(first.d), lower(other.d), 5);
  add(upper(first.c), upper(other.c), 6);
  add(upper(first.d), upper(other.d), 7);
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
#endif

#if BIPOT_WIDTH != 2
template <bool kInverse, Second kSecond>
[[gnu::always_inline]] inline void scatter(const Wrench& p, const unsigned* i, const unsigned* j,
                                           const BodyRow* inverse, BodyRow* to) {
  for_rows<kSecond>(p, [&](Row wrench, Row other, int k) {
    add<kInverse, kOfWrench<kSecond>>(wrench, other, i[k], j[k], inverse, to);
  });
}
#endif
#if BIPOT_WIDTH != 8
template <Second kSecond>
[[gnu::always_inline]] inline Motion gather(const BodyRow* v, const unsigned* i,
                                            const unsigned* j) {
  return gather<kSecond>(v, i, v, j);
}
#endif

}  // namespace
}  // namespace bipot
