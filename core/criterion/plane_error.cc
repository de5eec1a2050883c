#include "core/criterion/plane_error.h"

#include <cstring>

#include "core/base/instruction_sets.h"

namespace bipot {
namespace {

// Every kLanes-th contact is added to the same sum. So many sums lie in as many registers as the
// machine's width asks for: g++ makes twice as slow code of vectors that are wider than registers
// as of single numbers.
constexpr int kLanes = 8;

template <int kWidth>
struct Registers;
template <>
struct Registers<2> {
  using Values [[gnu::vector_size(16)]] = double;
  using Whole [[gnu::vector_size(16)]] = long long;
  [[maybe_unused]] static constexpr Whole kCount{0, 1};
};
template <>
struct Registers<4> {
  using Values [[gnu::vector_size(32)]] = double;
  using Whole [[gnu::vector_size(32)]] = long long;
  [[maybe_unused]] static constexpr Whole kCount{0, 1, 2, 3};
};
template <>
struct Registers<8> {
  using Values [[gnu::vector_size(64)]] = double;
  using Whole [[gnu::vector_size(64)]] = long long;
  [[maybe_unused]] static constexpr Whole kCount{0, 1, 2, 3, 4, 5, 6, 7};
};

/// The arrays of contacts [first, first + count), where count < kLanes, followed by contacts that
/// add nothing.
struct LastContacts {
  double s[2 * kLanes] = {}, u[2 * kLanes] = {}, b[2 * kLanes] = {}, row_scale[2 * kLanes],
               mu[kLanes] = {}, w_nn[kLanes] = {}, rho_nn[kLanes] = {}, rho_nat[kLanes] = {};

  LastContacts(const PlaneContacts& p, int first, int count) {
    for (double& r : row_scale) r = 1;
    const auto copy = [&](double* to, const double* from, int size) {
      if (from == nullptr) return;
      for (int k = 0; k < size * count; ++k) to[k] = from[size * first + k];
    };
    copy(s, p.s, 2);
    copy(u, p.u, 2);
    copy(b, p.b, 2);
    copy(row_scale, p.row_scale, 2);
    copy(mu, p.mu, 1);
    copy(w_nn, p.w_nn, 1);
    copy(rho_nn, p.rho_nn, 1);
    copy(rho_nat, p.rho_nat, 1);
  }
  PlaneContacts arrays() const { return {s, u, b, row_scale, mu, w_nn, rho_nn, rho_nat}; }
};

[[gnu::always_inline]] inline PlaneContacts from(const PlaneContacts& p, int first) {
  const auto pairs = [&](const double* x) { return x == nullptr ? x : x + 2 * first; };
  return {pairs(p.s),   pairs(p.u),     pairs(p.b),       pairs(p.row_scale),
          p.mu + first, p.w_nn + first, p.rho_nn + first, p.rho_nat + first};
}

/// The criterion of kWidth contacts at once.
template <int kWidth>
struct Kernel {
  using Values = typename Registers<kWidth>::Values;
  using Whole = typename Registers<kWidth>::Whole;
  static constexpr int kParts = kLanes / kWidth;

  [[gnu::always_inline]] static Values load(const double* from) {
    Values values;
    std::memcpy(&values, from, sizeof values);
    return values;
  }
  [[gnu::always_inline]] static Values magnitude(Values x) {
    return reinterpret_cast<Values>(reinterpret_cast<Whole>(x) & 0x7fffffffffffffffLL);
  }
  [[gnu::always_inline]] static Values positive_part(Values x) { return 0.5 * (x + magnitude(x)); }
  [[gnu::always_inline]] static Values cut_off(Values x, Values radius) {
    const Values above = x < -radius ? -radius : x;
    return above > radius ? radius : above;
  }

  /// A vector of the frame of each contact.
  struct Frames {
    Values n, t;
  };
  [[gnu::always_inline]] static Frames frames_at(const double* pairs) {
    const Values a = load(pairs), b = load(pairs + kWidth);
    if constexpr (kWidth == 2) {
      return {__builtin_shufflevector(a, b, 0, 2), __builtin_shufflevector(a, b, 1, 3)};
    } else if constexpr (kWidth == 4) {
      return {__builtin_shufflevector(a, b, 0, 2, 4, 6), __builtin_shufflevector(a, b, 1, 3, 5, 7)};
    } else {
      return {__builtin_shufflevector(a, b, 0, 2, 4, 6, 8, 10, 12, 14),
              __builtin_shufflevector(a, b, 1, 3, 5, 7, 9, 11, 13, 15)};
    }
  }
  [[gnu::always_inline]] static void put(const Frames& x, double* pairs) {
    Values a, b;
    if constexpr (kWidth == 2) {
      a = __builtin_shufflevector(x.n, x.t, 0, 2);
      b = __builtin_shufflevector(x.n, x.t, 1, 3);
    } else if constexpr (kWidth == 4) {
      a = __builtin_shufflevector(x.n, x.t, 0, 4, 1, 5);
      b = __builtin_shufflevector(x.n, x.t, 2, 6, 3, 7);
    } else {
      a = __builtin_shufflevector(x.n, x.t, 0, 8, 1, 9, 2, 10, 3, 11);
      b = __builtin_shufflevector(x.n, x.t, 4, 12, 5, 13, 6, 14, 7, 15);
    }
    std::memcpy(pairs, &a, sizeof a);
    std::memcpy(pairs + kWidth, &b, sizeof b);
  }
  [[gnu::always_inline]] static Frames quotient(const Frames& x, const Frames& y) {
    return {x.n / y.n, x.t / y.t};
  }
  [[gnu::always_inline]] static Values product(const Frames& x, const Frames& y) {
    return x.n * y.n + x.t * y.t;
  }

  /// project_coulomb_cone<2>().
  [[gnu::always_inline]] static Frames project(const Frames& tau, Values mu) {
    const Values edge = (tau.n + mu * magnitude(tau.t)) / (1 + mu * mu);
    const Values sn = positive_part(edge > tau.n ? edge : tau.n);
    return {sn, cut_off(tau.t, mu * sn)};
  }

  /// |x - P_K(x - rho hat)|².
  [[gnu::always_inline]] static Values missed(const Frames& x, const Frames& hat, Values mu,
                                              Values rho) {
    const Frames to = project({x.n - rho * hat.n, x.t - rho * hat.t}, mu);
    const Frames off{x.n - to.n, x.t - to.t};
    return product(off, off);
  }

  /// The sums of add_error_terms() in one register each.
  struct Sums {
    Values friction{}, gap{}, gap_clipped{}, penetration{}, natural{}, moved{}, natural_rel{},
        impulse2{};
    Values worst_gap = Values{} - 1, worst_natural = Values{} - 1;
    Whole worst_epsilon = Whole{} - 1, worst_eta = Whole{} - 1;
  };

  /// Contacts from `first` on, of which `valid` count; the arrays of p begin with them.
  template <bool kScaled>
  [[gnu::always_inline]] static void add(const PlaneContacts& p, int first, int valid, Sums& e) {
    Frames x = frames_at(p.s), u = frames_at(p.u);
    const Frames b = frames_at(p.b);
    e.moved += product(x, {u.n - b.n, u.t - b.t});
    Values mu = load(p.mu);
    if constexpr (kScaled) {
      const Frames r = frames_at(p.row_scale);
      x = quotient(x, r);
      u = quotient(u, r);
      mu = mu * r.n / r.t;
    }
    const Values w_nn = load(p.w_nn), rho_nn = load(p.rho_nn), rho_nat = load(p.rho_nat);
    const Values slip = magnitude(u.t);
    const Values dissipated = mu * x.n * slip;
    const Values tangential = positive_part(dissipated + x.t * u.t);
    const Values opening = positive_part(u.n), closing = positive_part(-u.n);
    const Values gap = tangential + x.n * magnitude(u.n);
    const Values penetration = 0.5 * rho_nn * closing * closing;
    e.friction += dissipated;
    e.gap += gap;
    e.gap_clipped += tangential + x.n * opening;
    e.penetration += penetration;
    e.impulse2 += product(x, x);

    const Frames hat{u.n + mu * slip, u.t};
    const Whole lawful = (x.n == 0) & (u.n >= 0);
    const Values natural = 0.5 * w_nn * missed(x, hat, mu, rho_nn);
    e.natural += lawful ? Values{} : natural;
    e.natural_rel += lawful ? Values{} : missed(x, hat, mu, rho_nat);

    const Whole counts = Registers<kWidth>::kCount < valid;
    const Whole contact = Registers<kWidth>::kCount + first;
    const Values violation = gap + penetration;
    const Whole worse = counts & (violation > e.worst_gap);
    e.worst_gap = worse ? violation : e.worst_gap;
    e.worst_epsilon = worse ? contact : e.worst_epsilon;
    const Whole farther = counts & ~lawful & (natural > e.worst_natural);
    e.worst_natural = farther ? natural : e.worst_natural;
    e.worst_eta = farther ? contact : e.worst_eta;
  }

  /// All lanes of one sum, in one order.
  [[gnu::always_inline]] static double total(const Sums* parts, Values Sums::*sum) {
    double lanes[kLanes];
    for (int k = 0; k < kLanes; ++k) lanes[k] = (parts[k / kWidth].*sum)[k % kWidth];
    return ((lanes[0] + lanes[1]) + (lanes[2] + lanes[3])) +
           ((lanes[4] + lanes[5]) + (lanes[6] + lanes[7]));
  }
  [[gnu::always_inline]] static void find_worst(const Sums* parts, Values Sums::*values,
                                                Whole Sums::*contacts, double& worst,
                                                int& contact) {
    for (int k = 0; k < kLanes; ++k) {
      const int c = static_cast<int>((parts[k / kWidth].*contacts)[k % kWidth]);
      const double value = (parts[k / kWidth].*values)[k % kWidth];
      if (c < 0 || value < worst || (value == worst && c > contact)) continue;
      worst = value;
      contact = c;
    }
  }

  template <bool kScaled>
  [[gnu::always_inline]] static PieceSums sum(const PlaneContacts& p, int begin, int end) {
    Sums parts[std::size_t{kParts}];
    int c = begin;
    for (; c + kLanes <= end; c += kLanes) {
      for (int part = 0; part < kParts; ++part) {
        const int first = c + part * kWidth;
        add<kScaled>(from(p, first), first, kWidth, parts[part]);
      }
    }
    if (c < end) {
      const LastContacts last(p, c, end - c);
      for (int part = 0; part < kParts; ++part) {
        const int first = part * kWidth;
        add<kScaled>(from(last.arrays(), first), c + first, end - c - first, parts[part]);
      }
    }
    PieceSums sums;
    sums.friction = total(parts, &Sums::friction);
    sums.gap = total(parts, &Sums::gap);
    sums.gap_clipped = total(parts, &Sums::gap_clipped);
    sums.penetration = total(parts, &Sums::penetration);
    sums.natural = total(parts, &Sums::natural);
    sums.moved = total(parts, &Sums::moved);
    sums.natural_rel = total(parts, &Sums::natural_rel);
    sums.impulse2 = total(parts, &Sums::impulse2);
    find_worst(parts, &Sums::worst_gap, &Sums::worst_epsilon, sums.worst_gap, sums.worst_epsilon);
    find_worst(parts, &Sums::worst_natural, &Sums::worst_eta, sums.worst_natural, sums.worst_eta);
    return sums;
  }
  [[gnu::always_inline]] static PieceSums sum(const PlaneContacts& p, int begin, int end) {
    return p.row_scale != nullptr ? sum<true>(p, begin, end) : sum<false>(p, begin, end);
  }

  template <bool kScaled>
  [[gnu::always_inline]] static void project_some(const PlaneContacts& p, double* s) {
    Frames x = frames_at(s);
    Values mu = load(p.mu);
    if constexpr (kScaled) {
      const Frames r = frames_at(p.row_scale);
      x = project(quotient(x, r), mu * r.n / r.t);
      put({x.n * r.n, x.t * r.t}, s);
    } else {
      put(project(x, mu), s);
    }
  }
  template <bool kScaled>
  [[gnu::always_inline]] static void project(const PlaneContacts& p, int begin, int end,
                                             double* s) {
    int c = begin;
    for (; c + kWidth <= end; c += kWidth) project_some<kScaled>(from(p, c), s + 2 * c);
    if (c == end) return;
    LastContacts last(p, c, end - c);
    for (int k = 0; k < 2 * (end - c); ++k) last.s[k] = s[2 * c + k];
    project_some<kScaled>(last.arrays(), last.s);
    for (int k = 0; k < 2 * (end - c); ++k) s[2 * c + k] = last.s[k];
  }
  [[gnu::always_inline]] static void project(const PlaneContacts& p, int begin, int end,
                                             double* s) {
    if (p.row_scale != nullptr) {
      project<true>(p, begin, end, s);
    } else {
      project<false>(p, begin, end, s);
    }
  }
};

}  // namespace

void PieceSums::add(const PieceSums& later) {
  *this += later;
  if (later.worst_gap > worst_gap) {
    worst_gap = later.worst_gap;
    worst_epsilon = later.worst_epsilon;
  }
  if (later.worst_natural > worst_natural) {
    worst_natural = later.worst_natural;
    worst_eta = later.worst_eta;
  }
}

#ifdef BIPOT_LEVELS
#define BIPOT_KERNEL(level, width)                                                              \
  __attribute__((target(level))) void project_on_plane_cones(const PlaneContacts& p, int begin, \
                                                             int end, double* s) {              \
    Kernel<width>::project(p, begin, end, s);                                                   \
  }                                                                                             \
  __attribute__((target(level))) PieceSums sum_plane_errors(const PlaneContacts& p, int begin,  \
                                                            int end) {                          \
    return Kernel<width>::sum(p, begin, end);                                                   \
  }
BIPOT_KERNEL("arch=x86-64-v4", 8)
BIPOT_KERNEL("arch=x86-64-v3", 4)
BIPOT_KERNEL("default", 2)
#undef BIPOT_KERNEL
#else
void project_on_plane_cones(const PlaneContacts& p, int begin, int end, double* s) {
  Kernel<2>::project(p, begin, end, s);
}
PieceSums sum_plane_errors(const PlaneContacts& p, int begin, int end) {
  return Kernel<2>::sum(p, begin, end);
}
#endif

}  // namespace bipot
