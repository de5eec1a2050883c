#include "core/criterion/plane_error.h"

#include <cstring>

#include "core/base/instruction_sets.h"
#include "core/criterion/contact_terms.h"

namespace bipot {
namespace {

// Every kLanes-th contact is added to the same sum. These sums lie in as many registers as the
// machine's width needs: g++ makes slow code of vectors that are wider than registers.
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

/// The arrays of the contacts [first, first + count) with count < kLanes, filled up with contacts
/// that add nothing.
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

  /// A vector of the frame of each contact.
  using Frames = FrameVector<Values, 2>;
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
      a = __builtin_shufflevector(x[0], x[1], 0, 2);
      b = __builtin_shufflevector(x[0], x[1], 1, 3);
    } else if constexpr (kWidth == 4) {
      a = __builtin_shufflevector(x[0], x[1], 0, 4, 1, 5);
      b = __builtin_shufflevector(x[0], x[1], 2, 6, 3, 7);
    } else {
      a = __builtin_shufflevector(x[0], x[1], 0, 8, 1, 9, 2, 10, 3, 11);
      b = __builtin_shufflevector(x[0], x[1], 4, 12, 5, 13, 6, 14, 7, 15);
    }
    std::memcpy(pairs, &a, sizeof a);
    std::memcpy(pairs + kWidth, &b, sizeof b);
  }
  /// The sums in one register each, and the worst contact of each lane.
  struct Sums : ErrorSumsOf<Values> {
    Values worst_gap = Values{} - 1, worst_natural = Values{} - 1;
    Whole worst_epsilon = Whole{} - 1, worst_eta = Whole{} - 1;
  };

  /// Contacts from `first` on; the arrays of p start with them.
  template <bool kScaled>
  [[gnu::always_inline]] static void add(const PlaneContacts& p, int first, Sums& e) {
    Frames r;
    if constexpr (kScaled) r = frames_at(p.row_scale);
    const auto contacts = physical_contact<kScaled>(frames_at(p.s), frames_at(p.u), frames_at(p.b),
                                                    r, load(p.mu), load(p.w_nn), load(p.rho_nn));
    const LawTerms<Values> law = law_terms(contacts);
    const ContactTerms<Values> terms = add_law_terms(contacts, law, e);
    add_reported_terms(contacts, law, load(p.rho_nat), e);

    const Whole contact = Registers<kWidth>::kCount + first;
    const Whole worse = terms.violation > e.worst_gap;
    e.worst_gap = worse ? terms.violation : e.worst_gap;
    e.worst_epsilon = worse ? contact : e.worst_epsilon;
    const Whole farther = terms.natural > e.worst_natural;
    e.worst_natural = farther ? terms.natural : e.worst_natural;
    e.worst_eta = farther ? contact : e.worst_eta;
  }

  /// All lanes of one sum, in one order.
  [[gnu::always_inline]] static double total(const Sums* parts, Values ErrorSumsOf<Values>::*sum) {
    double lanes[kLanes];
    for (int k = 0; k < kLanes; ++k) lanes[k] = (parts[k / kWidth].*sum)[k % kWidth];
    return ((lanes[0] + lanes[1]) + (lanes[2] + lanes[3])) +
           ((lanes[4] + lanes[5]) + (lanes[6] + lanes[7]));
  }
  /// The worst of the contacts before `end`, behind which those of LastContacts lie.
  [[gnu::always_inline]] static void find_worst(const Sums* parts, int end, Values Sums::*values,
                                                Whole Sums::*contacts, double& worst,
                                                int& contact) {
    for (int k = 0; k < kLanes; ++k) {
      const int c = static_cast<int>((parts[k / kWidth].*contacts)[k % kWidth]);
      const double value = (parts[k / kWidth].*values)[k % kWidth];
      if (c < 0 || c >= end || value < worst || (value == worst && c > contact)) continue;
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
        add<kScaled>(from(p, first), first, parts[part]);
      }
    }
    if (c < end) {
      const LastContacts last(p, c, end - c);
      for (int part = 0; part < kParts; ++part) {
        const int first = part * kWidth;
        add<kScaled>(from(last.arrays(), first), c + first, parts[part]);
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
    find_worst(parts, end, &Sums::worst_gap, &Sums::worst_epsilon, sums.worst_gap,
               sums.worst_epsilon);
    find_worst(parts, end, &Sums::worst_natural, &Sums::worst_eta, sums.worst_natural,
               sums.worst_eta);
    return sums;
  }
  [[gnu::always_inline]] static PieceSums sum(const PlaneContacts& p, int begin, int end) {
    return p.row_scale != nullptr ? sum<true>(p, begin, end) : sum<false>(p, begin, end);
  }

  template <bool kScaled>
  [[gnu::always_inline]] static void project_some(const PlaneContacts& p, double* s) {
    Frames r;
    if constexpr (kScaled) r = frames_at(p.row_scale);
    put(physical_projection<kScaled>(frames_at(s), r, load(p.mu)), s);
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
