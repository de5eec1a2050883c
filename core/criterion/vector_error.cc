#include "core/criterion/vector_error.h"

#include <cstring>
#include <utility>

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
template <int D>
struct LastContacts {
  static constexpr std::size_t kValues = std::size_t{D} * kLanes;
  double s[kValues] = {}, u[kValues] = {}, b[kValues] = {}, row_scale[kValues], mu[kLanes] = {},
         w_nn[kLanes] = {}, rho_nn[kLanes] = {}, rho_nat[kLanes] = {};

  LastContacts(const ContactArrays& p, int first, int count) {
    for (double& r : row_scale) r = 1;
    const auto copy = [&](double* to, const double* from, int size) {
      if (from == nullptr) return;
      for (int k = 0; k < size * count; ++k) to[k] = from[size * first + k];
    };
    copy(s, p.s, D);
    copy(u, p.u, D);
    copy(b, p.b, D);
    copy(row_scale, p.row_scale, D);
    copy(mu, p.mu, 1);
    copy(w_nn, p.w_nn, 1);
    copy(rho_nn, p.rho_nn, 1);
    copy(rho_nat, p.rho_nat, 1);
  }
  ContactArrays arrays() const { return {s, u, b, row_scale, mu, w_nn, rho_nn, rho_nat}; }
};

template <int D>
[[gnu::always_inline]] inline ContactArrays from(const ContactArrays& p, int first) {
  const auto frames = [&](const double* x) { return x == nullptr ? x : x + D * first; };
  return {frames(p.s),  frames(p.u),    frames(p.b),      frames(p.row_scale),
          p.mu + first, p.w_nn + first, p.rho_nn + first, p.rho_nat + first};
}

/// The criterion of kWidth contacts at once.
template <int kWidth, int D>
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
  using Frames = FrameVector<Values, D>;
  template <std::size_t... k>
  [[gnu::always_inline]] static Frames frames_at(const double* from, std::index_sequence<k...>) {
    const Values a = load(from), b = load(from + kWidth);
    if constexpr (D == 2) {
      return {__builtin_shufflevector(a, b, 2 * k...),
              __builtin_shufflevector(a, b, 2 * k + 1 ...)};
    } else {
      // From the first two registers, then from the third.
      const Values c = load(from + 2 * kWidth);
      constexpr std::size_t kTwo = 2 * kWidth;
      const Values x = __builtin_shufflevector(a, b, (3 * k < kTwo ? 3 * k : 0)...);
      const Values y = __builtin_shufflevector(a, b, (3 * k + 1 < kTwo ? 3 * k + 1 : 0)...);
      const Values z = __builtin_shufflevector(a, b, (3 * k + 2 < kTwo ? 3 * k + 2 : 0)...);
      return {__builtin_shufflevector(x, c, (3 * k < kTwo ? k : 3 * k - kWidth)...),
              __builtin_shufflevector(y, c, (3 * k + 1 < kTwo ? k : 3 * k + 1 - kWidth)...),
              __builtin_shufflevector(z, c, (3 * k + 2 < kTwo ? k : 3 * k + 2 - kWidth)...)};
    }
  }
  using Lane = std::make_index_sequence<std::size_t{kWidth}>;
  [[gnu::always_inline]] static Frames frames_at(const double* from) {
    return frames_at(from, Lane{});
  }
  /// Values kPart kWidth + k of the frames, one after the other.
  template <std::size_t kPart, std::size_t... k>
  [[gnu::always_inline]] static Values part_of(const Frames& x, std::index_sequence<k...>) {
    constexpr std::size_t kFirst = kPart * kWidth;
    const Values two = __builtin_shufflevector(
        x[0], x[1], ((kFirst + k) / D + ((kFirst + k) % D == 1 ? kWidth : 0))...);
    if constexpr (D == 2) {
      return two;
    } else {
      return __builtin_shufflevector(two, x[2],
                                     ((kFirst + k) % D == 2 ? (kFirst + k) / D + kWidth : k)...);
    }
  }
  [[gnu::always_inline]] static void put(const Frames& x, double* to) {
    const auto store = [&](const Values& values, int part) {
      std::memcpy(to + part * kWidth, &values, sizeof values);
    };
    store(part_of<0>(x, Lane{}), 0);
    store(part_of<1>(x, Lane{}), 1);
    if constexpr (D == 3) store(part_of<2>(x, Lane{}), 2);
  }
  /// The sums in one register each, and the worst contact of each lane.
  struct Sums : ErrorSumsOf<Values> {
    Values worst_gap = Values{} - 1, worst_natural = Values{} - 1;
    Whole worst_epsilon = Whole{} - 1, worst_eta = Whole{} - 1;
  };

  /// Contacts from `first` on; the arrays of p start with them.
  template <bool kScaled>
  [[gnu::always_inline]] static void add(const ContactArrays& p, int first, Sums& e) {
    Frames r;
    if constexpr (kScaled) r = frames_at(p.row_scale);
    const auto contacts = physical_contact(kScaled, frames_at(p.s), frames_at(p.u), frames_at(p.b),
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
  [[gnu::always_inline]] static PieceSums sum(const ContactArrays& p, int begin, int end) {
    Sums parts[std::size_t{kParts}];
    int c = begin;
    for (; c + kLanes <= end; c += kLanes) {
      for (int part = 0; part < kParts; ++part) {
        const int first = c + part * kWidth;
        add<kScaled>(from<D>(p, first), first, parts[part]);
      }
    }
    if (c < end) {
      const LastContacts<D> last(p, c, end - c);
      for (int part = 0; part < kParts; ++part) {
        const int first = part * kWidth;
        add<kScaled>(from<D>(last.arrays(), first), c + first, parts[part]);
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
  [[gnu::always_inline]] static PieceSums sum(const ContactArrays& p, int begin, int end) {
    return p.row_scale != nullptr ? sum<true>(p, begin, end) : sum<false>(p, begin, end);
  }

  template <bool kScaled>
  [[gnu::always_inline]] static void project_some(const ContactArrays& p, double* s) {
    Frames r;
    if constexpr (kScaled) r = frames_at(p.row_scale);
    put(physical_projection(kScaled, frames_at(s), r, load(p.mu)), s);
  }
  template <bool kScaled>
  [[gnu::always_inline]] static void project(const ContactArrays& p, int begin, int end,
                                             double* s) {
    int c = begin;
    for (; c + kWidth <= end; c += kWidth) project_some<kScaled>(from<D>(p, c), s + D * c);
    if (c == end) return;
    LastContacts<D> last(p, c, end - c);
    for (int k = 0; k < D * (end - c); ++k) last.s[k] = s[D * c + k];
    project_some<kScaled>(last.arrays(), last.s);
    for (int k = 0; k < D * (end - c); ++k) s[D * c + k] = last.s[k];
  }
  [[gnu::always_inline]] static void project(const ContactArrays& p, int begin, int end,
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

#define BIPOT_KERNEL_OF(how, width, project_name, sum_name, d)                   \
  how void project_name(const ContactArrays& p, int begin, int end, double* s) { \
    Kernel<width, d>::project(p, begin, end, s);                                 \
  }                                                                              \
  how PieceSums sum_name(const ContactArrays& p, int begin, int end) {           \
    return Kernel<width, d>::sum(p, begin, end);                                 \
  }
#define BIPOT_KERNEL(how, width)                                 \
  BIPOT_KERNEL_OF(how, width, project_on_plane, sum_of_plane, 2) \
  BIPOT_KERNEL_OF(how, width, project_on_space, sum_of_space, 3)
namespace {
#ifdef BIPOT_LEVELS
BIPOT_KERNEL(__attribute__((target("arch=x86-64-v4"))), 8)
BIPOT_KERNEL(__attribute__((target("arch=x86-64-v3"))), 4)
BIPOT_KERNEL(__attribute__((target("default"))), 2)
#else
BIPOT_KERNEL(, 2)
#endif
}  // namespace
#undef BIPOT_KERNEL
#undef BIPOT_KERNEL_OF

// g++ chooses among the levels where it compiles a call: a call from another source would always
// take the default.
void project_on_plane_cones(const ContactArrays& p, int begin, int end, double* s) {
  project_on_plane(p, begin, end, s);
}
PieceSums sum_plane_errors(const ContactArrays& p, int begin, int end) {
  return sum_of_plane(p, begin, end);
}
void project_on_space_cones(const ContactArrays& p, int begin, int end, double* s) {
  project_on_space(p, begin, end, s);
}
PieceSums sum_space_errors(const ContactArrays& p, int begin, int end) {
  return sum_of_space(p, begin, end);
}

}  // namespace bipot
