#pragma once

// The projected gradient of disks.

#include "solvers/disks/disk_motion.h"

namespace bipot {
namespace {

/// Sums for the rows of a block.
struct BlockRows {
#if BIPOT_WIDTH == 8
  Lanes pair[kLanes / 2];
#else
  BodyRow row[kLanes];
#endif
};

/// Relative motion of the lanes of a part, whose first bodies are those of a block.
template <Second kSecond>
[[gnu::always_inline]] inline Motion gather_block(const BodyRow* block, [[maybe_unused]] int part,
                                                  const BodyRow* velocity, const unsigned* j) {
#if BIPOT_WIDTH == 8
  constexpr Lanes kSign = kSignOfSecond<kSecond>;
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
  return gather<kSecond>(block, i, velocity, j);
#endif
}
/// Adds wrenches to the sum of a block and their opposites to the second bodies, which are all
/// different.
template <Second kSecond>
[[gnu::always_inline]] inline void scatter_block(const Wrench& p, [[maybe_unused]] int part,
                                                 const unsigned* j, BlockRows& sum, BodyRow* to) {
#if BIPOT_WIDTH == 8
  const WrenchRows rows = rows_of<kSecond>(kSecond == kRolling ? on_first(p) : p);
  const WrenchRows others = kSecond == kRolling ? rows_of<kSecond>(on_second(p)) : rows;
  sum.pair[0] += rows.a;
  sum.pair[1] += rows.b;
  sum.pair[2] += rows.c;
  sum.pair[3] += rows.d;
  constexpr Lanes kSign = kSignOfSecond<kOfWrench<kSecond>>;
  const auto take = [&](Lanes wrenches, int k, int l) {
    BodyRow &first = at(to, j[k]), &other = at(to, j[l]);
    const Lanes taken = _mm512_fnmadd_pd(wrenches, kSign, both(row(first), row(other)));
    row(first) = lower(taken);
    row(other) = upper(taken);
  };
  take(others.a, 0, 2);
  take(others.b, 1, 3);
  take(others.c, 4, 6);
  take(others.d, 5, 7);
#elif BIPOT_WIDTH == 4
  for_rows<kSecond>(p, [&](Row wrench, Row other, int k) {
    row(sum.row[kRowOfLane[part * kWidth + k]]) += wrench;
    row(at(to, j[k])) = with_second_of<kOfWrench<kSecond>>(at(to, j[k]), other);
  });
#else
  for (int k = 0; k < 2; ++k) {
    add<false, kSecond>(p, k, nullptr, sum.row[kRowOfLane[part * kWidth + k]], nullptr,
                        at(to, j[k]));
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
  constexpr Second kSecond = kSecondOf<D>;
  const auto seconds = [&](int k, int part) { return a.contact[k].j + part * kWidth; };
  const auto gathered = [&](int k, int part) {
    return gather_block<kSecond>(&at(a.velocity, a.contact[k].i[0]), part, a.velocity,
                                 seconds(k, part));
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
          scatter_block<kSecond>(wrench, part, seconds(k, part), sum, a.next_momentum);
        }
      }
      add_block(sum, &at(a.next_momentum, block->row));
    }
    for (int k = loose; k < end; ++k) {
#pragma GCC unroll 4
      for (int part = 0; part < kParts; ++part) {
        const unsigned *const i = a.contact[k].i + part * kWidth, *const j = seconds(k, part);
        scatter<false, kSecond>(solve(k, part, gather<kSecond>(a.velocity, i, j)), i, j, nullptr,
                                a.next_momentum);
      }
    }
    if (loose < end) motion = gathered(end, 0);
  }
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
    const Rows change = p - *reinterpret_cast<const Rows*>(before + k), beta = Rows{} + a.beta;
    if constexpr (D == kRollingDisks) {
      const Rows inverse = *reinterpret_cast<const Rows*>(&at(a.inverse, first) + k);
      sum += inverse * change * change;
      v = inverse * (p + beta * change);
      *reinterpret_cast<Rows*>(next + k) = Rows{};
      return;
    }
    const Rows inverse = inverse_of(v, p);
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
[[gnu::flatten]] void project(const GradientTask<D>& task, GradientSums& sums) {
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
      const Lanes spin = load(c.turns[kTurnSpin], part), mu = load(law.mu, part),
                  b_t = load(c.b[1], part);
      const Lanes tx = load(law.ratio, part) * gy, ty = load(law.ratio, part) * gx;
      const Lanes from_bodies_t = (ty * v.y - tx * v.x) - spin * v.spin;
      const Lanes x_t = load(a.now[k].x[1], part);
      const Lanes step_t = x_t - load(a.before[k].x[1], part);
      const Lanes y_t = x_t + beta * step_t;
      const Lanes tau_t = (y_t - b_t) - from_bodies_t;
      Lanes tau_m, x_m, step_m;
      if constexpr (D == kRollingDisks) {
        x_m = load(a.now[k].x[2], part);
        step_m = x_m - load(a.before[k].x[2], part);
        tau_m = (x_m + beta * step_m - load(c.b[2], part)) - rolling_velocity(c, part, v);
      }
      if constexpr (kMap == GradientMap::kFollowed) {
        const Lanes slid = z_n + mu * magnitude(tau_t);
        Lanes edge = slid * load(law.cone, part);
        if constexpr (D == kRollingDisks) {
          const Lanes rolled = load(law.mu_r, part) * magnitude(tau_m);
          const Lanes one = (z_n + rolled) * load(law.rolling_cone, part);
          const Lanes both = (slid + rolled) * load(law.both_cones, part);
          edge = one > edge ? one : edge;
          edge = both > edge ? both : edge;
        }
        z_n = edge > z_n ? edge : z_n;
      }
      z_n = positive(z_n);
      const Lanes z_t = cut_off(tau_t, mu * z_n);
      const Lanes change = z_t - x_t;
      along[part] += step_t * change;
      change2[part] += change * change;
      store(a.next[k].x[1], part, z_t);
      wrench = {gx * z_n - tx * z_t, gy * z_n + ty * z_t, negative_product(spin, z_t)};
      if constexpr (D == kRollingDisks) {
        const Lanes z_m = cut_off(tau_m, load(law.mu_r, part) * z_n), turned = z_m - x_m;
        along[part] += step_m * turned;
        change2[part] += turned * turned;
        store(a.next[k].x[2], part, z_m);
        add_moments(c, part, z_m, wrench);
      }
    }
    const Lanes change = z_n - x_n;
    along[part] += step_n * change;
    change2[part] += change * change;
    store(a.next[k].x[0], part, z_n);
    return wrench;
  };
  for_windows(a, [&](const BodyBlock* window, const BodyBlock* end) {
    begin_bodies(a, window->row, static_cast<int>(end - window) * kLanes, energy);
    for_blocks(a, window, end, solve);
  });
  *reinterpret_cast<Energy*>(sums.energy) = energy;
  for (int part = 0; part < kParts; ++part) {
    store(sums.along, part, along[part]);
    store(sums.change2, part, change2[part]);
  }
}

}  // namespace
}  // namespace bipot
