#pragma once

// Sweeps of disks.

#include "solvers/disks/disk_motion.h"

namespace bipot {
namespace {

/// For for_parts(): the wrenches change the velocities.
template <int D>
struct DiskBodies {
  using Motion = Wrench;
  BodyRow* velocity;
  const BodyRow* inverse;

  [[gnu::always_inline]] Wrench gathered(const unsigned* i, const unsigned* j) const {
    return gather<kSecondOf<D>>(velocity, i, j);
  }
  [[gnu::always_inline]] void add(const Wrench& p, const unsigned* i, const unsigned* j) const {
    scatter<true, kSecondOf<D>>(p, i, j, inverse, velocity);
  }
};

template <int D, bool kBack, bool kOuter, bool kRelaxed>
[[gnu::flatten]] void sweep_symmetric(const SymmetricTask<D>& task, Lanes* turn) {
  // A copy: the compiler cannot know that the stores leave the task unchanged.
  const SymmetricTask<D> a = task;
  const Lanes omega = all(a.omega), beta = all(a.beta);
  const auto relaxed = [&](Lanes x) {
    if constexpr (kRelaxed) x = omega * x;
    return x;
  };
  SymmetricPrefetch<kBack, kOuter, D> prefetch_lists(a);
  // Sums are arranged for a short dependency chain from the velocities to the wrench.
  const auto solve = [&](int k, int part, const Motion& v) {
    prefetch_lists(a, k, part);
    const ContactBatch<D>& c = a.contact[k];
    const LawBatch& law = a.laws[a.law[k]];
    ImpulseBatch<D>& next = a.next[k];
    const auto extrapolated = [&](int row, Lanes now) {
      return now + beta * (now - load(a.before[k].x[row], part));
    };
    const auto put = [&](int row, Lanes z) {
      if constexpr (kBack && kOuter) {
        const Lanes now = load(a.now[k].x[row], part);
        turn[part] += (extrapolated(row, now) - z) * (z - now);
      }
      store(next.x[row], part, z);
    };
    const auto start = [&](int row) {
      if constexpr (kBack || !kOuter) return load(next.x[row], part);
      return extrapolated(row, load(a.now[k].x[row], part));
    };
    const Lanes gx = load(c.gx, part), gy = load(c.gy, part);
    const Lanes x_n = start(0);
    const Lanes start_n = x_n - relaxed(load(c.b[0], part));
    const Lanes z_n = positive(start_n - (relaxed(gx) * v.x + relaxed(gy) * v.y));
    const Lanes normal = z_n - x_n;
    put(0, z_n);
    if constexpr (D == 1) {
      return Motion{gx * normal, gy * normal, Lanes{}};
    } else {
      const Lanes ratio = load(law.ratio, part), spin = load(c.turns[kTurnSpin], part);
      const Lanes tx = ratio * gy, ty = ratio * gx;
      // The moment comes after the friction, and back before it. The first of them has changed the
      // velocity of the other.
      Lanes turned_by{}, slid_back{};
      const auto roll = [&] {
        if constexpr (D == kRollingDisks) {
          const Lanes x_m = start(2);
          const Lanes w =
              rolling_velocity(c, part, v) - load(c.turns[kTurnCoupling], part) * slid_back;
          const Lanes trial = x_m - relaxed(w + load(c.b[2], part));
          const Lanes z_m = cut_off(trial, load(law.mu_r, part) * z_n);
          turned_by = z_m - x_m;
          put(2, z_m);
        }
      };
      if constexpr (kBack) roll();
      const Lanes x_t = start(1);
      Lanes b_t = load(c.b[1], part);
      if constexpr (kBack && D == kRollingDisks) {
        b_t += load(c.turns[kTurnCoupling], part) * turned_by;
      }
      const Lanes start_t = x_t - relaxed(b_t);
      const Lanes turned = relaxed(ty) * v.y - relaxed(tx) * v.x;
      const Lanes trial = start_t - (turned - relaxed(spin) * v.spin);
      const Lanes z_t = cut_off(trial, load(law.mu, part) * z_n);
      slid_back = x_t - z_t;
      put(1, z_t);
      Wrench wrench{gx * normal + tx * slid_back, gy * normal - ty * slid_back, spin * slid_back};
      if constexpr (D == kRollingDisks) {
        if constexpr (!kBack) roll();
        add_moments(c, part, turned_by, wrench);
      }
      return wrench;
    }
  };
  for_parts<kBack>(DiskBodies<D>{a.velocity, a.inverse}, a.contact, a.first_batch, a.last_batch,
                   solve);
}

}  // namespace
}  // namespace bipot
