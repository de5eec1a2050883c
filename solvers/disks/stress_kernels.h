#pragma once

#include "solvers/disks/disk_kernels.h"

namespace bipot {

struct StressKernels {
  /// Impulses of contacts under stresses of their bodies, for the vector kernels. Each body has the
  /// row (σ_xx, σ_xy, σ_yy) in the places (x, a ω, y). With unit normal n, t = e3 x n and σ = share
  /// (σ_i + σ_j) a contact carries the impulse σ n, in the scaled variables of ContactBatch
  ///
  ///     x_n = (ratio / spin) n·σ n,     x_t = (1 / spin) t·σ n,     n = (ratio / spin) g.
  ///
  /// `share` is 1/2 between two bodies, 1 if one of them is fixed, 0 for contacts that carry
  /// nothing and for empty lanes.
  struct alignas(64) ShareBatch {
    double share[kLanes] = {};
  };
  /// Partial sums of b·z for each lane.
  struct alignas(64) LoadSums {
    double load[kLanes] = {};
  };
  /// Products in the mass of v(y), v(z) and v(p), in parts.
  struct alignas(32) ConjugateSums {
    double yz[4] = {}, zz[4] = {}, zp[4] = {};
  };
  /// The transpose: adds the rates w = g·(V_i - V_j) + b of all contacts, times their carried
  /// impulses, to the rows of both bodies.
  struct RatesTask : PackedContacts<2> {
    int batches = 0;
    const ShareBatch* share = nullptr;
    const BodyRow* velocity = nullptr;  ///< all rows
    BodyRow* rates = nullptr;           ///< all rows
  };
  /// z = x⁺ - y + the carried impulses, in place of x⁺. The carried impulses are added to the
  /// momentum of the bodies.
  struct ImpulseTask : PackedContacts<2> {
    int batches = 0;
    const ShareBatch* share = nullptr;
    const BodyRow* stress = nullptr;  ///< all rows
    const ImpulseBatch<2>* y = nullptr;
    ImpulseBatch<2>* swept = nullptr;  ///< x⁺, becomes z
    BodyRow* momentum = nullptr;       ///< all rows
  };
  /// v_z = v(x⁺) - v(y) + inverse ∘ momentum, in place of v(x⁺), over some rows.
  struct ConjugateTask {
    int rows = 0;
    const BodyRow *inverse = nullptr, *mass = nullptr, *momentum = nullptr;
    const BodyRow *velocity = nullptr, *direction = nullptr;  ///< of y, of p
    BodyRow* swept = nullptr;                                 ///< of x⁺, becomes that of z
  };
  /// p <- z + beta p, y <- y + alpha p over some batches, or over the velocities of some rows.
  template <class Item>
  struct FollowTask {
    int items = 0;
    double alpha = 0, beta = 0;
    const Item* z = nullptr;
    Item *p = nullptr, *y = nullptr;
  };
  void (*rates)(const RatesTask& task);
  void (*impulse)(const ImpulseTask& task, LoadSums& sums);
  void (*conjugate)(const ConjugateTask& task, ConjugateSums& sums);
  void (*follow_rows)(const FollowTask<BodyRow>& task);
  void (*follow)(const FollowTask<ImpulseBatch<2>>& task);
};

/// The kernels of one path; every path gives the same bits. Throws as disk_kernels().
const StressKernels& stress_kernels(SimdPath path);

}  // namespace bipot
