#pragma once

// The kernels for spheres, with rolling friction (kRollingSpheres) or without.

#include "solvers/disks/kernel_loops.h"

namespace bipot {
namespace {

/// A vector in space for each lane.
struct Space {
  Lanes x, y, z;
};
[[gnu::always_inline]] inline Space operator+(const Space& a, const Space& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
[[gnu::always_inline]] inline Space operator-(const Space& a, const Space& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
[[gnu::always_inline]] inline Space operator*(Lanes factor, const Space& a) {
  return {factor * a.x, factor * a.y, factor * a.z};
}
[[gnu::always_inline]] inline Lanes dot(const Space& a, const Space& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
[[gnu::always_inline]] inline Space cross(const Space& a, const Space& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
[[gnu::always_inline]] inline Space load(const double (*from)[kLanes], int part) {
  return {load(from[0], part), load(from[1], part), load(from[2], part)};
}
[[gnu::always_inline]] inline void store(double (*to)[kLanes], int part, const Space& a) {
  store(to[0], part, a.x);
  store(to[1], part, a.y);
  store(to[2], part, a.z);
}
inline Lanes root(Lanes x) {
#if BIPOT_WIDTH == 8
  return _mm512_maskz_sqrt_pd(kAllLanes, x);
#elif BIPOT_WIDTH == 4
  return __builtin_ia32_sqrtpd256(x);
#else
  return Lanes{__builtin_sqrt(x[0]), __builtin_sqrt(x[1])};
#endif
}

/// V_i - V_j and w_i + w_j; or a force, opposite on body j, and the torque on either body.
struct SpaceMotion {
  Space v, w;
};
/// With the spins, or the torques, of either body.
struct RollingMotion {
  Space v, w_i, w_j;
};
/// Impulses or velocities of contacts with rolling friction.
struct Twist {
  Space force, moment;
};
[[gnu::always_inline]] inline Twist operator+(const Twist& a, const Twist& b) {
  return {a.force + b.force, a.moment + b.moment};
}
[[gnu::always_inline]] inline Twist operator-(const Twist& a, const Twist& b) {
  return {a.force - b.force, a.moment - b.moment};
}
[[gnu::always_inline]] inline Twist operator*(Lanes factor, const Twist& a) {
  return {factor * a.force, factor * a.moment};
}
[[gnu::always_inline]] inline Lanes dot(const Twist& a, const Twist& b) {
  return dot(a.force, b.force) + dot(a.moment, b.moment);
}

#if BIPOT_WIDTH == 8
inline const Lanes& whole(const SphereRow& r) { return *reinterpret_cast<const Lanes*>(&r); }
inline Lanes& whole(SphereRow& r) { return *reinterpret_cast<Lanes*>(&r); }
/// Products with one are exact, so that sums with these signs are rounded once.
constexpr Lanes kSecondSign{1, 1, 1, 1, -1, -1, -1, -1};

[[gnu::always_inline]] inline void gather(const SphereRow* v, const unsigned* i, const unsigned* j,
                                          SpaceMotion& to) {
  const auto both_of = [&](int k) {
    return _mm512_fnmadd_pd(whole(at(v, j[k])), kSecondSign, whole(at(v, i[k])));
  };
  // (x, z, a ω_x, a ω_z) and (y, 1/m, a ω_y, a²/I) of two lanes each.
  Lanes even[4], odd[4];
  for (int k = 0; k < 4; ++k) {
    const Lanes a = both_of(2 * k), b = both_of(2 * k + 1);
    even[k] = first_of_pairs(a, b);
    odd[k] = second_of_pairs(a, b);
  }
  const Lanes xw0 = even_pairs(even[0], even[1]), xw1 = even_pairs(even[2], even[3]);
  const Lanes zw0 = odd_pairs(even[0], even[1]), zw1 = odd_pairs(even[2], even[3]);
  const Lanes yw0 = even_pairs(odd[0], odd[1]), yw1 = even_pairs(odd[2], odd[3]);
  to = {{even_pairs(xw0, xw1), even_pairs(yw0, yw1), even_pairs(zw0, zw1)},
        {odd_pairs(xw0, xw1), odd_pairs(yw0, yw1), odd_pairs(zw0, zw1)}};
}
/// Calls add(row, lane) in the order of the lanes.
template <class Add>
[[gnu::always_inline]] inline void for_rows(const SpaceMotion& p, const Add& add) {
  const Lanes zero{};
  const auto rows = [&](const auto& pairs, Lanes* row) {
    const Lanes xy = pairs(p.v.x, p.v.y), z = pairs(p.v.z, zero);
    const Lanes turn_xy = pairs(p.w.x, p.w.y), turn_z = pairs(p.w.z, zero);
    const Lanes a = even_pairs(xy, z), b = odd_pairs(xy, z);
    const Lanes c = even_pairs(turn_xy, turn_z), d = odd_pairs(turn_xy, turn_z);
    row[0] = even_pairs(a, c);
    row[1] = even_pairs(b, d);
    row[2] = odd_pairs(a, c);
    row[3] = odd_pairs(b, d);
  };
  Lanes even[4], odd[4];
  rows([](Lanes a, Lanes b) { return first_of_pairs(a, b); }, even);
  rows([](Lanes a, Lanes b) { return second_of_pairs(a, b); }, odd);
  for (int k = 0; k < 4; ++k) {
    add(even[k], 2 * k);
    add(odd[k], 2 * k + 1);
  }
}
/// Adds the wrench to body i and its opposite to body j. kInverse: to velocities, times the inverse
/// masses in them.
template <bool kInverse>
[[gnu::always_inline]] inline void scatter(const SpaceMotion& p, const unsigned* i,
                                           const unsigned* j, SphereRow* to) {
  const auto weighted = [](Lanes row, Lanes wrench) {
    if constexpr (!kInverse) return wrench;
    return __builtin_shufflevector(row, row, 3, 3, 3, 3, 7, 7, 7, 7) * wrench;
  };
  for_rows(p, [&](Lanes wrench, int k) {
    Lanes& a = whole(at(to, i[k]));
    a += weighted(a, wrench);
    Lanes& b = whole(at(to, j[k]));
    b = _mm512_fnmadd_pd(weighted(b, wrench), kSecondSign, b);
  });
}
#else
/// The halves of a row: (x, y, z, 1/m) and (a ω, a²/I).
#if BIPOT_WIDTH == 4
using Half = Row;
inline const Row& half(const SphereRow& r, int k) { return reinterpret_cast<const Row*>(&r)[k]; }
inline Row& half(SphereRow& r, int k) { return reinterpret_cast<Row*>(&r)[k]; }
/// The first three values of four rows.
[[gnu::always_inline]] inline Space lanes_of(const Row* r) {
  Row lanes[4] = {r[0], r[1], r[2], r[3]};
  transpose(lanes);
  return {lanes[0], lanes[1], lanes[2]};
}
[[gnu::always_inline]] inline void rows_of(const Space& a, Row* row) {
  Row rows[4] = {a.x, a.y, a.z, Row{}};
  transpose(rows);
  for (int k = 0; k < 4; ++k) row[k] = rows[k];
}
inline Row inverse_in(Row half) { return __builtin_shufflevector(half, half, 3, 3, 3, 3); }
#else
struct Half {
  Pair xy, z;
};
inline Half operator+(Half a, Half b) { return {a.xy + b.xy, a.z + b.z}; }
inline Half operator-(Half a, Half b) { return {a.xy - b.xy, a.z - b.z}; }
inline Half operator*(Half a, Half b) { return {a.xy * b.xy, a.z * b.z}; }
inline const Half& half(const SphereRow& r, int k) { return reinterpret_cast<const Half*>(&r)[k]; }
inline Half& half(SphereRow& r, int k) { return reinterpret_cast<Half*>(&r)[k]; }
[[gnu::always_inline]] inline Space lanes_of(const Half* r) {
  return {__builtin_shufflevector(r[0].xy, r[1].xy, 0, 2),
          __builtin_shufflevector(r[0].xy, r[1].xy, 1, 3),
          __builtin_shufflevector(r[0].z, r[1].z, 0, 2)};
}
[[gnu::always_inline]] inline void rows_of(const Space& a, Half* row) {
  const Pair zero{};
  row[0] = {__builtin_shufflevector(a.x, a.y, 0, 2), __builtin_shufflevector(a.z, zero, 0, 2)};
  row[1] = {__builtin_shufflevector(a.x, a.y, 1, 3), __builtin_shufflevector(a.z, zero, 1, 3)};
}
inline Half inverse_in(Half half) {
  const Pair inverse = __builtin_shufflevector(half.z, half.z, 1, 1);
  return {inverse, inverse};
}
#endif

[[gnu::always_inline]] inline void gather(const SphereRow* v, const unsigned* i, const unsigned* j,
                                          SpaceMotion& to) {
  Half moved[kWidth], turned[kWidth];
  for (int k = 0; k < kWidth; ++k) {
    const SphereRow &a = at(v, i[k]), &b = at(v, j[k]);
    moved[k] = half(a, 0) - half(b, 0);
    turned[k] = half(a, 1) + half(b, 1);
  }
  to = {lanes_of(moved), lanes_of(turned)};
}
[[gnu::always_inline]] inline void gather(const SphereRow* v, const unsigned* i, const unsigned* j,
                                          RollingMotion& to) {
  Half moved[kWidth], first[kWidth], second[kWidth];
  for (int k = 0; k < kWidth; ++k) {
    const SphereRow &a = at(v, i[k]), &b = at(v, j[k]);
    moved[k] = half(a, 0) - half(b, 0);
    first[k] = half(a, 1);
    second[k] = half(b, 1);
  }
  to = {lanes_of(moved), lanes_of(first), lanes_of(second)};
}
template <bool kInverse>
[[gnu::always_inline]] inline void scatter(const Half* force, const Half* torque_i,
                                           const Half* torque_j, const unsigned* i,
                                           const unsigned* j, SphereRow* to) {
  const auto weighted = [](const Half& row, const Half& wrench) {
    if constexpr (!kInverse) return wrench;
    return inverse_in(row) * wrench;
  };
  for (int k = 0; k < kWidth; ++k) {
    SphereRow &a = at(to, i[k]), &b = at(to, j[k]);
    half(a, 0) = half(a, 0) + weighted(half(a, 0), force[k]);
    half(a, 1) = half(a, 1) + weighted(half(a, 1), torque_i[k]);
    half(b, 0) = half(b, 0) - weighted(half(b, 0), force[k]);
    half(b, 1) = half(b, 1) + weighted(half(b, 1), torque_j[k]);
  }
}
template <bool kInverse>
[[gnu::always_inline]] inline void scatter(const SpaceMotion& p, const unsigned* i,
                                           const unsigned* j, SphereRow* to) {
  Half force[kWidth], torque[kWidth];
  rows_of(p.v, force);
  rows_of(p.w, torque);
  scatter<kInverse>(force, torque, torque, i, j, to);
}
template <bool kInverse>
[[gnu::always_inline]] inline void scatter(const RollingMotion& p, const unsigned* i,
                                           const unsigned* j, SphereRow* to) {
  Half force[kWidth], first[kWidth], second[kWidth];
  rows_of(p.v, force);
  rows_of(p.w_i, first);
  rows_of(p.w_j, second);
  scatter<kInverse>(force, first, second, i, j, to);
}
#endif

/// x, no longer than the radius.
[[gnu::always_inline]] inline Space shortened(const Space& x, Lanes radius) {
  const Lanes length2 = dot(x, x), shrunk = radius / root(length2), one = all(1);
  const Lanes factor = length2 > radius * radius ? shrunk : one;
  return factor * x;
}
[[gnu::always_inline]] inline Lanes larger(Lanes a, Lanes b) { return a > b ? a : b; }

/// The wrench map of a part of a batch, and the law of its contacts.
struct SphereContacts {
  using Motion = SpaceMotion;
  using Impulse = Space;

  const LawBatch& law;
  int part;
  Space n;
  Lanes tangential, normal_excess;  ///< scale ratio; scale - scale ratio

  template <class Batch>
  [[gnu::always_inline]] SphereContacts(const Batch& batch, const LawBatch& of, int part_of)
      : law(of), part(part_of), n(load(batch.n, part)) {
    const Lanes scale = load(batch.scale, part);
    tangential = scale * load(law.ratio, part);
    normal_excess = scale - tangential;
  }
  [[gnu::always_inline]] static Space loaded(const double (*from)[kLanes], int part) {
    return load(from, part);
  }
  [[gnu::always_inline]] static void put(double (*to)[kLanes], int part, const Space& a) {
    store(to, part, a);
  }
  /// w - b.
  [[gnu::always_inline]] Space velocity(const SpaceMotion& m) const {
    return tangential * (m.v - cross(m.w, n)) + (normal_excess * dot(n, m.v)) * n;
  }
  /// Of impulses x. The torque on either body is opposite to n x (tangential force).
  [[gnu::always_inline]] SpaceMotion wrench(const Space& x) const {
    const Space pushed = tangential * x;
    return {pushed + (normal_excess * dot(n, x)) * n, cross(pushed, n)};
  }
  /// max(0, τ_n) and τ_t cut off, where τ = x - ω w. That is the exact solution of the contact for
  /// ω = 1, since its own block of W is diagonal with equal tangents.
  template <bool kBack>
  [[gnu::always_inline]] Space relaxed(const Space& x, Lanes omega, const SpaceMotion& motion,
                                       const Space& b) const {
    return projected<GradientMap::kSplit>(x - omega * (velocity(motion) + b));
  }
  /// The map of the gradient.
  template <GradientMap kMap>
  [[gnu::always_inline]] Space projected(const Space& tau) const {
    const Lanes mu = load(law.mu, part), along = dot(n, tau);
    const Space across = tau - along * n;
    Lanes normal = along;
    if constexpr (kMap == GradientMap::kFollowed) {
      const Lanes edge = (along + mu * root(dot(across, across))) * load(law.cone, part);
      normal = larger(edge, along);
    }
    normal = positive(normal);
    return normal * n + shortened(across, mu * normal);
  }
};

/// The same with rolling friction.
struct RollingContacts {
  using Motion = RollingMotion;
  using Impulse = Twist;

  SphereContacts slide;
  Lanes roll_i, roll_j, coupling;

  [[gnu::always_inline]] RollingContacts(const ContactBatch<kRollingSpheres>& batch,
                                         const LawBatch& law, int part)
      : slide(batch, law, part),
        roll_i(load(batch.roll[0], part)),
        roll_j(load(batch.roll[1], part)),
        coupling(load(batch.coupling, part)) {}
  [[gnu::always_inline]] static Twist loaded(const double (*from)[kLanes], int part) {
    return {load(from, part), load(from + 3, part)};
  }
  [[gnu::always_inline]] static void put(double (*to)[kLanes], int part, const Twist& a) {
    store(to, part, a.force);
    store(to + 3, part, a.moment);
  }
  [[gnu::always_inline]] Twist velocity(const RollingMotion& m) const {
    return {slide.velocity({m.v, m.w_i + m.w_j}), roll_i * m.w_i - roll_j * m.w_j};
  }
  [[gnu::always_inline]] RollingMotion wrench(const Twist& x) const {
    const SpaceMotion pushed = slide.wrench(x.force);
    return {pushed.v, pushed.w + roll_i * x.moment, pushed.w - roll_j * x.moment};
  }
  /// Normal, tangential and rolling impulses one after the other, the last two in the reverse order
  /// with kBack; each with the velocities that the one before has changed.
  template <bool kBack>
  [[gnu::always_inline]] Twist relaxed(const Twist& x, Lanes omega, const RollingMotion& motion,
                                       const Twist& b) const {
    const Space& n = slide.n;
    Twist w = velocity(motion) + b, z;
    const Lanes along = dot(n, x.force - omega * w.force), normal = positive(along);
    const auto slid = [&] {
      const Space tau = x.force - omega * w.force;
      z.force = normal * n + shortened(tau - along * n, load(slide.law.mu, slide.part) * normal);
    };
    if constexpr (kBack) {
      z.moment = turned(x.moment - omega * w.moment, normal);
      const Space turn = coupling * (z.moment - x.moment);
      w.force = w.force - slide.tangential * cross(turn, n);
      slid();
    } else {
      slid();
      w.moment = w.moment + coupling * cross(slide.tangential * (z.force - x.force), n);
      z.moment = turned(x.moment - omega * w.moment, normal);
    }
    return z;
  }
  /// The moments about the tangents and the normal, cut off.
  [[gnu::always_inline]] Space turned(const Space& tau, Lanes normal) const {
    const Space& n = slide.n;
    const Lanes along = dot(n, tau);
    const Lanes spin = cut_off(along, load(slide.law.mu_spin, slide.part) * normal);
    return spin * n + shortened(tau - along * n, load(slide.law.mu_r, slide.part) * normal);
  }
  /// On the cone (kFollowed): see onto_cone() in core/problem/coulomb_cone.h.
  template <GradientMap kMap>
  [[gnu::always_inline]] Twist projected(const Twist& tau) const {
    const Space& n = slide.n;
    const Lanes mu[3] = {load(slide.law.mu, slide.part), load(slide.law.mu_r, slide.part),
                         load(slide.law.mu_spin, slide.part)};
    const Lanes along = dot(n, tau.force);
    const Space across = tau.force - along * n;
    Lanes normal = along;
    if constexpr (kMap == GradientMap::kFollowed) {
      const Lanes turn = dot(n, tau.moment);
      const Space roll = tau.moment - turn * n;
      const Lanes pushed[3] = {mu[0] * root(dot(across, across)), mu[1] * root(dot(roll, roll)),
                               mu[2] * magnitude(turn)};
#pragma GCC unroll 8
      for (int set = 1; set < 8; ++set) {
        Lanes sum = along, weight = all(1);
#pragma GCC unroll 3
        for (int k = 0; k < 3; ++k) {
          if ((set >> k & 1) == 0) continue;
          sum += pushed[k];
          weight += mu[k] * mu[k];
        }
        normal = larger(sum / weight, normal);
      }
    }
    normal = positive(normal);
    return {normal * n + shortened(across, mu[0] * normal), turned(tau.moment, normal)};
  }
};

template <int D>
struct ContactsOf {
  using Type = SphereContacts;
};
template <>
struct ContactsOf<kRollingSpheres> {
  using Type = RollingContacts;
};

/// For for_parts(). kInverse: the wrenches change the velocities.
template <int D, bool kInverse>
struct SphereBodies {
  using Motion = typename ContactsOf<D>::Type::Motion;
  const SphereRow* velocity;
  SphereRow* to;

  [[gnu::always_inline]] Motion gathered(const unsigned* i, const unsigned* j) const {
    Motion motion;
    gather(velocity, i, j, motion);
    return motion;
  }
  [[gnu::always_inline]] void add(const Motion& p, const unsigned* i, const unsigned* j) const {
    scatter<kInverse>(p, i, j, to);
  }
};

template <int D, bool kBack, bool kOuter, bool kRelaxed>
void sweep_symmetric(const SymmetricTask<D>& task, Lanes* turn) {
  using Contacts = typename ContactsOf<D>::Type;
  using Impulse = typename Contacts::Impulse;
  const SymmetricTask<D> a = task;
  const Lanes omega = all(a.omega), beta = all(a.beta);
  SymmetricPrefetch<kBack, kOuter, D> prefetch_lists(a);
  const auto solve = [&](int k, int part, const typename Contacts::Motion& motion) {
    prefetch_lists(a, k, part);
    const auto extrapolated = [&](const Impulse& now) {
      return now + beta * (now - Contacts::loaded(a.before[k].x, part));
    };
    const Contacts c(a.contact[k], a.laws[a.law[k]], part);
    Impulse x;
    if constexpr (kBack || !kOuter) {
      x = Contacts::loaded(a.next[k].x, part);
    } else {
      x = extrapolated(Contacts::loaded(a.now[k].x, part));
    }
    const Impulse z =
        c.template relaxed<kBack>(x, omega, motion, Contacts::loaded(a.contact[k].b, part));
    if constexpr (kBack && kOuter) {
      const Impulse now = Contacts::loaded(a.now[k].x, part);
      turn[part] += dot(extrapolated(now) - z, z - now);
    }
    Contacts::put(a.next[k].x, part, z);
    return c.wrench(z - x);
  };
  for_parts<kBack>(SphereBodies<D, true>{a.velocity, a.velocity}, a.contact, a.first_batch,
                   a.last_batch, solve);
}

/// A row in registers, for what is done value by value.
#if BIPOT_WIDTH == 8
constexpr int kPiecesOfRow = 1;
using RowPiece = Lanes;
inline RowPiece inverse_in(RowPiece row) {
  return __builtin_shufflevector(row, row, 3, 3, 3, 3, 7, 7, 7, 7);
}
inline RowPiece with_inverse_of(RowPiece values, RowPiece row) {
  return __builtin_shufflevector(values, row, 0, 1, 2, 11, 4, 5, 6, 15);
}
#else
constexpr int kPiecesOfRow = 2;
using RowPiece = Row;
#if BIPOT_WIDTH == 2
inline Row inverse_in(Row half) { return __builtin_shufflevector(half, half, 3, 3, 3, 3); }
#endif
inline RowPiece with_inverse_of(RowPiece values, RowPiece row) {
  return __builtin_shufflevector(values, row, 0, 1, 2, 7);
}
#endif

/// Sets the velocities of some spheres at the extrapolated momentum; their next momentum starts
/// from 0.
template <int D>
[[gnu::always_inline]] inline void begin_spheres(const GradientTask<D>& a, unsigned first, int rows,
                                                 RowPiece* energy) {
  const SphereRow *const now = &at(a.momentum, first), *const before =
                                                           &at(a.momentum_before, first);
  SphereRow *const velocity = &at(a.velocity, first), *const next = &at(a.next_momentum, first);
  const RowPiece beta = RowPiece{} + a.beta;
  for (int k = 0; k < rows; ++k) {
    if (a.ask_ahead) {
      prefetch_item(now, k + kRowsAhead);
      prefetch_item(before, k + kRowsAhead);
      prefetch_item(velocity, k + kRowsAhead);
      prefetch_item(next, k + kRowsAhead);
    }
    for (int piece = 0; piece < kPiecesOfRow; ++piece) {
      RowPiece& v = reinterpret_cast<RowPiece*>(velocity + k)[piece];
      const RowPiece p = reinterpret_cast<const RowPiece*>(now + k)[piece];
      const RowPiece change = p - reinterpret_cast<const RowPiece*>(before + k)[piece];
      const RowPiece inverse = inverse_in(v);
      energy[piece] += inverse * change * change;
      v = with_inverse_of(inverse * (p + beta * change), v);
      reinterpret_cast<RowPiece*>(next + k)[piece] = RowPiece{};
    }
  }
}

template <int D, GradientMap kMap>
void project(const GradientTask<D>& task, GradientSums& sums) {
  using Contacts = typename ContactsOf<D>::Type;
  const GradientTask<D> a = task;
  const Lanes beta = all(a.beta);
  Lanes along[kParts] = {}, change2[kParts] = {};
  RowPiece energy[kPiecesOfRow] = {};
  const auto solve = [&](int k, int part, const typename Contacts::Motion& motion) {
    if (part == 0 && a.ask_ahead) {
      prefetch_item(a.contact, k + kAhead);
      prefetch_item(a.now, k + kAhead);
      prefetch_item(a.before, k + kAhead);
    }
    const Contacts c(a.contact[k], a.laws[a.law[k]], part);
    const auto x = Contacts::loaded(a.now[k].x, part);
    const auto step = x - Contacts::loaded(a.before[k].x, part);
    const auto y = x + beta * step;
    const auto w = c.velocity(motion) + Contacts::loaded(a.contact[k].b, part);
    const auto z = c.template projected<kMap>(y - w);
    const auto change = z - x;
    along[part] += dot(step, change);
    change2[part] += dot(change, change);
    Contacts::put(a.next[k].x, part, z);
    return c.wrench(z);
  };
  const SphereBodies<D, false> bodies{a.velocity, a.next_momentum};
  for_windows(a, [&](const BodyBlock* window, const BodyBlock* end) {
    begin_spheres(a, window->row, static_cast<int>(end - window) * kLanes, energy);
    for_parts<false>(bodies, a.contact, window->first, end->first, solve);
  });
  for (int piece = 0; piece < kPiecesOfRow; ++piece) {
    reinterpret_cast<RowPiece*>(sums.energy)[piece] = energy[piece];
  }
  for (int part = 0; part < kParts; ++part) {
    store(sums.along, part, along[part]);
    store(sums.change2, part, change2[part]);
  }
}

}  // namespace
}  // namespace bipot
