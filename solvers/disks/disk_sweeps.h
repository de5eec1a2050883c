#pragma once

// Sweeps of disks.

#include "solvers/disks/disk_motion.h"

namespace bipot {
namespace {

/// Runs solve(batch, part, motion) -> wrench over all parts of the batches from `first` to before
/// `last`, downwards with kBack. In program order the bodies of a part are read before the previous
/// part writes to its own. The processor can then work on both at once. They share no body: neither
/// do the lanes of a batch nor two consecutive batches.
template <bool kBack, int D, class Solve>
[[gnu::always_inline]] inline void for_parts(const ContactBatch<D>* contact, int first, int last,
                                             BodyRow* velocity, const BodyRow* inverse,
                                             const Solve& solve) {
  constexpr Second kSecond = kSecondOf<D>;
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
      const Motion motion = gather<kSecond>(velocity, bodies.i, bodies.j);
      if (part > 0 || n > 0) {
        scatter<true, kSecond>(wrench, before.i, before.j, inverse, velocity);
      }
      wrench = solve(k, part, motion);
      before = bodies;
    }
  }
  if (batches > 0) scatter<true, kSecond>(wrench, before.i, before.j, inverse, velocity);
}

template <int D, bool kRelaxed>
[[gnu::flatten]] void sweep_batches(const SweepTask<D>& task) {
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
      const Lanes ratio = load(law.ratio, part), spin = load(c.turns[kTurnSpin], part);
      const Lanes tx = ratio * gy, ty = ratio * gx;
      const Lanes x_t = load(impulse.x[1], part);
      const Lanes start_t = x_t - relaxed(load(c.b[1], part));
      const Lanes turned = relaxed(ty) * v.y - relaxed(tx) * v.x;
      const Lanes trial = start_t - (turned - relaxed(spin) * v.spin);
      const Lanes z_t = cut_off(trial, load(law.mu, part) * z_n);
      const Lanes back = x_t - z_t;
      store(impulse.x[1], part, z_t);
      Wrench wrench{gx * normal + tx * back, gy * normal - ty * back, spin * back};
      if constexpr (D == kRollingDisks) {
        // The slip has changed by now, and the contact's own rolling with it.
        const Lanes x_m = load(impulse.x[2], part);
        const Lanes w = rolling_velocity(c, part, v) - load(c.turns[kTurnCoupling], part) * back +
                        load(c.b[2], part);
        const Lanes z_m = cut_off(x_m - relaxed(w), load(law.mu_r, part) * z_n);
        store(impulse.x[2], part, z_m);
        add_moments(c, part, z_m - x_m, wrench);
      }
      return wrench;
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

/// kOuter: starts from y in the forward sweep, computes sums at the end of the backward sweep.
template <int D, bool kBack, bool kOuter>
[[gnu::flatten]] void sweep_symmetric(const SymmetricTask<D>& task, Lanes* turn) {
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
      const Lanes ratio = load(law.ratio, part), spin = load(c.turns[kTurnSpin], part);
      const Lanes tx = ratio * gy, ty = ratio * gx;
      // Back the moment comes before the friction.
      Lanes turned_by{}, slid_by{};
      const auto roll = [&] {
        if constexpr (D == kRollingDisks) {
          const Lanes x_m = start(2);
          const Lanes w =
              rolling_velocity(c, part, v) + load(c.turns[kTurnCoupling], part) * slid_by;
          const Lanes trial = x_m - omega * (w + load(c.b[2], part));
          turned_by = put(2, x_m, cut_off(trial, load(law.mu_r, part) * z_n));
        }
      };
      if constexpr (kBack) roll();
      const Lanes x_t = start(1);
      Lanes b_t = load(c.b[1], part);
      if constexpr (D == kRollingDisks) b_t += load(c.turns[kTurnCoupling], part) * turned_by;
      const Lanes start_t = x_t - omega * b_t;
      const Lanes turned = omega * ty * v.y - omega * tx * v.x;
      const Lanes trial = start_t - (turned - omega * spin * v.spin);
      const Lanes z_t = cut_off(trial, load(law.mu, part) * z_n);
      const Lanes change = put(1, x_t, z_t);
      Wrench wrench{gx * normal - tx * change, gy * normal + ty * change,
                    negative_product(spin, change)};
      if constexpr (D == kRollingDisks) {
        slid_by = change;
        if constexpr (!kBack) roll();
        add_moments(c, part, turned_by, wrench);
      }
      return wrench;
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

}  // namespace
}  // namespace bipot
