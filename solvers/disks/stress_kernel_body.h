#pragma once

// The kernels of stress_kernels.h.

#include "solvers/disks/disk_motion.h"
#include "solvers/disks/stress_kernels.h"

namespace bipot {
namespace {

/// Impulses of a contact from stress, times its share: x_n = n·σ n `normal`, x_t = t·σ n
/// `tangential`.
struct StressToImpulse {
  Lanes xx, xy, yy;  ///< n_x², n_x n_y, n_y²
  Lanes normal, tangential;
};
inline StressToImpulse stress_to_impulse(const ContactBatch<2>& c, const LawBatch& law,
                                         const StressKernels::ShareBatch& share, int part) {
  const Lanes spin = load(c.turns[kTurnSpin], part), ratio = load(law.ratio, part), zero{};
  // Empty lanes have no spin and no share.
  const Lanes inverse = 1 / (spin == zero ? all(1) : spin), length = ratio * inverse;
  const Lanes nx = length * load(c.gx, part), ny = length * load(c.gy, part);
  const Lanes carried = load(share.share, part);
  return {nx * nx, nx * ny, ny * ny, carried * length, carried * inverse};
}

void stress_rates(const StressKernels::RatesTask& task) {
  const StressKernels::RatesTask a = task;
  for (int k = 0; k < a.batches; ++k) {
    prefetch_item(a.contact, k + kAhead);
    prefetch_item(a.share, k + kAhead);
    const ContactBatch<2>& c = a.contact[k];
    const LawBatch& law = a.laws[a.law[k]];
#pragma GCC unroll 4
    for (int part = 0; part < kParts; ++part) {
      const unsigned *i = c.i + part * kWidth, *j = c.j + part * kWidth;
      const Motion v = gather<kOpposed>(a.velocity, i, j);
      const StressToImpulse to = stress_to_impulse(c, law, a.share[k], part);
      const Lanes gx = load(c.gx, part), gy = load(c.gy, part), ratio = load(law.ratio, part);
      const Lanes w_n = gx * v.x + gy * v.y + load(c.b[0], part);
      const Lanes w_t = ratio * (gx * v.y - gy * v.x) - load(c.turns[kTurnSpin], part) * v.spin +
                        load(c.b[1], part);
      const Lanes normal = to.normal * w_n, tangential = to.tangential * w_t;
      const Motion rate{to.xx * normal - to.xy * tangential, to.yy * normal + to.xy * tangential,
                        2 * to.xy * normal + (to.xx - to.yy) * tangential};
      scatter<false, kAlike>(rate, i, j, nullptr, a.rates);
    }
  }
}

void stress_impulse(const StressKernels::ImpulseTask& task, StressKernels::LoadSums& sums) {
  const StressKernels::ImpulseTask a = task;
  Lanes sum[kParts] = {};
  for (int k = 0; k < a.batches; ++k) {
    prefetch_item(a.contact, k + kAhead);
    prefetch_item(a.share, k + kAhead);
    prefetch_item(a.y, k + kAhead);
    prefetch_item(a.swept, k + kAhead);
    const ContactBatch<2>& c = a.contact[k];
    const LawBatch& law = a.laws[a.law[k]];
#pragma GCC unroll 4
    for (int part = 0; part < kParts; ++part) {
      const unsigned *i = c.i + part * kWidth, *j = c.j + part * kWidth;
      const Motion stress = gather<kAlike>(a.stress, i, j);
      const StressToImpulse to = stress_to_impulse(c, law, a.share[k], part);
      const Lanes xx = stress.x, xy = stress.spin, yy = stress.y;
      const Lanes normal = to.normal * (to.xx * xx + 2 * to.xy * xy + to.yy * yy);
      const Lanes tangential = to.tangential * (to.xy * (yy - xx) + (to.xx - to.yy) * xy);
      double *z_n = a.swept[k].x[0], *z_t = a.swept[k].x[1];
      const Lanes change_n = load(z_n, part) - load(a.y[k].x[0], part) + normal;
      const Lanes change_t = load(z_t, part) - load(a.y[k].x[1], part) + tangential;
      store(z_n, part, change_n);
      store(z_t, part, change_t);
      sum[part] += load(c.b[0], part) * change_n + load(c.b[1], part) * change_t;
      const Lanes gx = load(c.gx, part), gy = load(c.gy, part);
      const Lanes turned = load(law.ratio, part) * tangential;
      const Motion wrench{gx * normal - gy * turned, gy * normal + gx * turned,
                          -(load(c.turns[kTurnSpin], part) * tangential)};
      scatter<false, kOpposed>(wrench, i, j, nullptr, a.momentum);
    }
  }
  for (int part = 0; part < kParts; ++part) store(sums.load, part, sum[part]);
}

void conjugate_rows(const StressKernels::ConjugateTask& task, StressKernels::ConjugateSums& sums) {
  const StressKernels::ConjugateTask a = task;
  Row yz{}, zz{}, zp{};
  for (int k = 0; k < a.rows; ++k) {
    const Row y = row(a.velocity[k]), mass = row(a.mass[k]);
    const Row z = row(a.swept[k]) - y + row(a.inverse[k]) * row(a.momentum[k]);
    row(a.swept[k]) = z;
    const Row weighed = mass * z;
    yz += weighed * y;
    zz += weighed * z;
    zp += weighed * row(a.direction[k]);
  }
  for (int k = 0; k < 4; ++k) {
    sums.yz[k] = yz[k];
    sums.zz[k] = zz[k];
    sums.zp[k] = zp[k];
  }
}

void follow_rows(const StressKernels::FollowTask<BodyRow>& task) {
  const StressKernels::FollowTask<BodyRow> a = task;
  const Row alpha = Row{} + a.alpha, beta = Row{} + a.beta;
  for (int k = 0; k < a.items; ++k) {
    const Row p = row(a.z[k]) + beta * row(a.p[k]);
    row(a.p[k]) = p;
    row(a.y[k]) += alpha * p;
  }
}

void follow(const StressKernels::FollowTask<ImpulseBatch<2>>& task) {
  const StressKernels::FollowTask<ImpulseBatch<2>> a = task;
  const Lanes alpha = all(a.alpha), beta = all(a.beta);
  for (int k = 0; k < a.items; ++k) {
    for (int part = 0; part < 2 * kParts; ++part) {  // both rows of a batch in sequence
      double *p_at = a.p[k].x[0], *y_at = a.y[k].x[0];
      const Lanes p = load(a.z[k].x[0], part) + beta * load(p_at, part);
      store(p_at, part, p);
      store(y_at, part, load(y_at, part) + alpha * p);
    }
  }
}

constexpr StressKernels kStressKernels = {&stress_rates, &stress_impulse, &conjugate_rows,
                                          &follow_rows, &follow};

}  // namespace
}  // namespace bipot
