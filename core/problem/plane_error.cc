#include "core/problem/plane_error.h"

#include <cstring>

#include "core/instruction_sets.h"

namespace bipot {
namespace {

constexpr int kEight = 8;
using Eight [[gnu::vector_size(64)]] = double;
using Whole [[gnu::vector_size(64)]] = long long;

[[gnu::always_inline]] inline Eight load(const double* from) {
  Eight eight;
  std::memcpy(&eight, from, sizeof eight);
  return eight;
}
[[gnu::always_inline]] inline Eight magnitude(Eight x) {
  return reinterpret_cast<Eight>(reinterpret_cast<Whole>(x) & 0x7fffffffffffffffLL);
}
[[gnu::always_inline]] inline Eight positive_part(Eight x) { return 0.5 * (x + magnitude(x)); }
[[gnu::always_inline]] inline Eight cut_off(Eight x, Eight radius) {
  const Eight above = x < -radius ? -radius : x;
  return above > radius ? radius : above;
}

/// A vector of the frame of eight contacts.
struct Frames {
  Eight n, t;
};
[[gnu::always_inline]] inline Frames frames_at(const double* pairs) {
  const Eight a = load(pairs), b = load(pairs + kEight);
  return {__builtin_shufflevector(a, b, 0, 2, 4, 6, 8, 10, 12, 14),
          __builtin_shufflevector(a, b, 1, 3, 5, 7, 9, 11, 13, 15)};
}
[[gnu::always_inline]] inline void put(const Frames& x, double* pairs) {
  const Eight a = __builtin_shufflevector(x.n, x.t, 0, 8, 1, 9, 2, 10, 3, 11),
              b = __builtin_shufflevector(x.n, x.t, 4, 12, 5, 13, 6, 14, 7, 15);
  std::memcpy(pairs, &a, sizeof a);
  std::memcpy(pairs + kEight, &b, sizeof b);
}
[[gnu::always_inline]] inline Frames quotient(const Frames& x, const Frames& y) {
  return {x.n / y.n, x.t / y.t};
}
[[gnu::always_inline]] inline Eight product(const Frames& x, const Frames& y) {
  return x.n * y.n + x.t * y.t;
}

/// project_coulomb_cone<2>().
[[gnu::always_inline]] inline Frames project(const Frames& tau, Eight mu) {
  const Eight edge = (tau.n + mu * magnitude(tau.t)) / (1 + mu * mu);
  const Eight sn = positive_part(edge > tau.n ? edge : tau.n);
  return {sn, cut_off(tau.t, mu * sn)};
}

/// |x - P_K(x - rho hat)|².
[[gnu::always_inline]] inline Eight missed(const Frames& x, const Frames& hat, Eight mu,
                                           Eight rho) {
  const Frames to = project({x.n - rho * hat.n, x.t - rho * hat.t}, mu);
  const Frames off{x.n - to.n, x.t - to.t};
  return product(off, off);
}

/// The sums of add_error_terms(), every eighth contact in the same one.
struct Sums {
  Eight friction{}, gap{}, gap_clipped{}, penetration{}, natural{}, moved{}, natural_rel{},
      impulse2{};
  Eight worst_gap = Eight{} - 1, worst_natural = Eight{} - 1;
  Whole worst_epsilon = Whole{} - 1, worst_eta = Whole{} - 1;
};

/// Eight contacts from `first` on, of which `valid` count; the arrays of p begin with them.
template <bool kScaled>
[[gnu::always_inline]] inline void add(const PlaneContacts& p, int first, int valid, Sums& e) {
  Frames x = frames_at(p.s), u = frames_at(p.u);
  const Frames b = frames_at(p.b);
  e.moved += product(x, {u.n - b.n, u.t - b.t});
  Eight mu = load(p.mu);
  if constexpr (kScaled) {
    const Frames r = frames_at(p.row_scale);
    x = quotient(x, r);
    u = quotient(u, r);
    mu = mu * r.n / r.t;
  }
  const Eight w_nn = load(p.w_nn), rho_nn = load(p.rho_nn), rho_nat = load(p.rho_nat);
  const Eight slip = magnitude(u.t);
  const Eight dissipated = mu * x.n * slip;
  const Eight tangential = positive_part(dissipated + x.t * u.t);
  const Eight opening = positive_part(u.n), closing = positive_part(-u.n);
  const Eight gap = tangential + x.n * magnitude(u.n);
  const Eight penetration = 0.5 * rho_nn * closing * closing;
  e.friction += dissipated;
  e.gap += gap;
  e.gap_clipped += tangential + x.n * opening;
  e.penetration += penetration;
  e.impulse2 += product(x, x);

  const Frames hat{u.n + mu * slip, u.t};
  const Whole lawful = (x.n == 0) & (u.n >= 0);
  const Eight natural = 0.5 * w_nn * missed(x, hat, mu, rho_nn);
  e.natural += lawful ? Eight{} : natural;
  e.natural_rel += lawful ? Eight{} : missed(x, hat, mu, rho_nat);

  const Whole number = Whole{0, 1, 2, 3, 4, 5, 6, 7};
  const Whole counts = number < valid;
  const Eight violation = gap + penetration;
  const Whole worse = counts & (violation > e.worst_gap);
  e.worst_gap = worse ? violation : e.worst_gap;
  e.worst_epsilon = worse ? number + first : e.worst_epsilon;
  const Whole farther = counts & ~lawful & (natural > e.worst_natural);
  e.worst_natural = farther ? natural : e.worst_natural;
  e.worst_eta = farther ? number + first : e.worst_eta;
}

[[gnu::always_inline]] inline double total(Eight x) {
  return ((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7]));
}
[[gnu::always_inline]] inline void find_worst(Eight values, Whole contacts, double& worst,
                                              int& contact) {
  for (int k = 0; k < kEight; ++k) {
    const int c = static_cast<int>(contacts[k]);
    if (c < 0 || values[k] < worst || (values[k] == worst && c > contact)) continue;
    worst = values[k];
    contact = c;
  }
}

/// The arrays of contacts [first, first + count), where count < 8, followed by contacts that add nothing.
struct LastContacts {
  double s[2 * kEight] = {}, u[2 * kEight] = {}, b[2 * kEight] = {}, row_scale[2 * kEight],
               mu[kEight] = {}, w_nn[kEight] = {}, rho_nn[kEight] = {}, rho_nat[kEight] = {};

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

PlaneContacts from(const PlaneContacts& p, int first) {
  const auto pairs = [&](const double* x) { return x == nullptr ? x : x + 2 * first; };
  return {pairs(p.s),   pairs(p.u),     pairs(p.b),       pairs(p.row_scale),
          p.mu + first, p.w_nn + first, p.rho_nn + first, p.rho_nat + first};
}

template <bool kScaled>
[[gnu::always_inline]] inline PieceSums sum(const PlaneContacts& p, int begin, int end) {
  Sums e;
  int c = begin;
  for (; c + kEight <= end; c += kEight) add<kScaled>(from(p, c), c, kEight, e);
  if (c < end) {
    const LastContacts last(p, c, end - c);
    add<kScaled>(last.arrays(), c, end - c, e);
  }
  PieceSums sums;
  sums.friction = total(e.friction);
  sums.gap = total(e.gap);
  sums.gap_clipped = total(e.gap_clipped);
  sums.penetration = total(e.penetration);
  sums.natural = total(e.natural);
  sums.moved = total(e.moved);
  sums.natural_rel = total(e.natural_rel);
  sums.impulse2 = total(e.impulse2);
  find_worst(e.worst_gap, e.worst_epsilon, sums.worst_gap, sums.worst_epsilon);
  find_worst(e.worst_natural, e.worst_eta, sums.worst_natural, sums.worst_eta);
  return sums;
}

template <bool kScaled>
[[gnu::always_inline]] inline void project_eight(const PlaneContacts& p, double* s) {
  Frames x = frames_at(s);
  Eight mu = load(p.mu);
  if constexpr (kScaled) {
    const Frames r = frames_at(p.row_scale);
    x = project(quotient(x, r), mu * r.n / r.t);
    put({x.n * r.n, x.t * r.t}, s);
  } else {
    put(project(x, mu), s);
  }
}

template <bool kScaled>
[[gnu::always_inline]] inline void project_all(const PlaneContacts& p, int begin, int end,
                                               double* s) {
  int c = begin;
  for (; c + kEight <= end; c += kEight) project_eight<kScaled>(from(p, c), s + 2 * c);
  if (c == end) return;
  LastContacts last(p, c, end - c);
  for (int k = 0; k < 2 * (end - c); ++k) last.s[k] = s[2 * c + k];
  project_eight<kScaled>(last.arrays(), last.s);
  for (int k = 0; k < 2 * (end - c); ++k) s[2 * c + k] = last.s[k];
}

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

BIPOT_EVERY_LEVEL void project_on_plane_cones(const PlaneContacts& p, int begin, int end,
                                              double* s) {
  if (p.row_scale != nullptr) {
    project_all<true>(p, begin, end, s);
  } else {
    project_all<false>(p, begin, end, s);
  }
}

BIPOT_EVERY_LEVEL PieceSums sum_plane_errors(const PlaneContacts& p, int begin, int end) {
  return p.row_scale != nullptr ? sum<true>(p, begin, end) : sum<false>(p, begin, end);
}

}  // namespace bipot
