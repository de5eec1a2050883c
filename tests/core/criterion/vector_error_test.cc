#include "core/criterion/vector_error.h"

#include "core/criterion/error_terms.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// Contacts of every status, with any numbers; only what the criterion reads is there.
struct AnyContacts {
  ContactProblem p;
  Vector s, u;
  ErrorWeights weights;

  AnyContacts(int contacts, bool scaled, unsigned seed, int d = 2) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-1, 1), positive(0.1, 2);
    const auto fill = [&](Vector& x, int size, auto& draw) {
      x.resize(size);
      for (double& value : x) value = draw(random);
    };
    p.dim = d;
    fill(p.mu, contacts, positive);
    fill(p.u_free, d * contacts, any);
    fill(s, d * contacts, any);
    fill(u, d * contacts, any);
    fill(weights.w_nn, contacts, positive);
    fill(weights.rho_nat, contacts, positive);
    weights.rho_nn = weights.w_nn.cwiseInverse();
    if (!scaled) return;
    fill(p.row_scale, d * contacts, positive);
    // Both tangents of a contact have one scale.
    for (int c = 0; c < contacts && d == 3; ++c) p.row_scale[3 * c + 2] = p.row_scale[3 * c + 1];
  }
  ContactArrays arrays() const {
    return {s.data(),
            u.data(),
            p.u_free.data(),
            p.row_scale.size() > 0 ? p.row_scale.data() : nullptr,
            p.mu.data(),
            weights.w_nn.data(),
            weights.rho_nn.data(),
            weights.rho_nat.data()};
  }
};

template <int D, bool kScaled>
void expect_as_one_by_one(int contacts, int begin, int end) {
  AnyContacts any(contacts, kScaled, static_cast<unsigned>(31 * contacts + begin), D);
  Vector projected = any.s;
  for (int c = begin; c < end; ++c) project_physically<D, kScaled>(any.p, c, 1, projected);
  (D == 2 ? project_on_plane_cones : project_on_space_cones)(any.arrays(), begin, end,
                                                             any.s.data());
  EXPECT_EQ(any.s, projected);  // to the bit, and nothing beside [begin, end)

  // Every eighth contact in the same sum, and these in one order: the same bits on every machine.
  PieceSums worst;
  ErrorSums lanes[8];
  for (int c = begin; c < end; ++c) {
    const ContactTerms terms =
        add_error_terms<D, kScaled>(any.p, c, any.s, any.u, any.weights, lanes[(c - begin) % 8]);
    PieceSums one{.worst_gap = terms.violation,
                  .worst_natural = terms.natural,
                  .worst_epsilon = c,
                  .worst_eta = terms.natural >= 0 ? c : -1};
    worst.add(one);
  }
  for (const int step : {1, 2, 4}) {
    for (int k = 0; k < 8; k += 2 * step) lanes[k] += lanes[k + step];
  }
  const ErrorSums& expected = lanes[0];
  const PieceSums sums = (D == 2 ? sum_plane_errors : sum_space_errors)(any.arrays(), begin, end);
  EXPECT_EQ(static_cast<const ErrorSums&>(sums), expected);
  EXPECT_EQ(sums.worst_epsilon, worst.worst_epsilon);
  EXPECT_EQ(sums.worst_eta, worst.worst_eta);
  EXPECT_EQ(sums.worst_gap, worst.worst_gap);
  EXPECT_EQ(sums.worst_natural, worst.worst_natural);
}

// Several at once and what is left over add up as contact by contact does, wherever a piece begins.
template <int D>
void check_all_lengths() {
  for (int contacts = 1; contacts <= 40; ++contacts) {
    expect_as_one_by_one<D, false>(contacts, 0, contacts);
    expect_as_one_by_one<D, true>(contacts, 0, contacts);
  }
  expect_as_one_by_one<D, false>(40, 3, 29);
  expect_as_one_by_one<D, true>(40, 3, 29);
}
TEST(VectorError, AddsUpAsContactByContact) {
  check_all_lengths<2>();
  check_all_lengths<3>();
}

// Of contacts that are as bad, the first one is named: three copies of one contact behind a better
// one.
TEST(VectorError, NamesTheFirstOfTheWorst) {
  AnyContacts any(12, false, 5);
  for (const int c : {0, 4, 9, 11}) {
    any.s.segment<2>(2 * c) << 1, 0;
    any.u.segment<2>(2 * c) << -100, 0;
    any.p.mu[c] = any.weights.w_nn[c] = any.weights.rho_nn[c] = 1;
  }
  any.u[0] = -1;
  const PieceSums sums = sum_plane_errors(any.arrays(), 0, 12);
  EXPECT_EQ(sums.worst_epsilon, 4);
  EXPECT_EQ(sums.worst_eta, 4);
}

// What obeys the law exactly adds nothing to the natural map and is nobody's worst.
TEST(VectorError, OpenContactsMissNothing) {
  AnyContacts any(9, false, 7);
  any.s.setZero();
  any.u.setOnes();
  const PieceSums sums = sum_plane_errors(any.arrays(), 0, 9);
  EXPECT_EQ(sums.natural, 0);
  EXPECT_EQ(sums.natural_rel, 0);
  EXPECT_EQ(sums.gap, 0);
  EXPECT_EQ(sums.worst_eta, -1);
}

// NaN is passed on: whoever compares sees that it is no error that was met.
TEST(VectorError, NothingHidesNaN) {
  for (const int contacts : {3, 8, 13}) {
    AnyContacts any(contacts, false, 11);
    any.u[2 * contacts - 1] = kNaN;
    EXPECT_TRUE(std::isnan(sum_plane_errors(any.arrays(), 0, contacts).gap));
  }
}

}  // namespace
}  // namespace bipot
