#include "solvers/homotopy/proximal_term.h"

#include "tests/support/test.h"

namespace bipot {
namespace {

/// Contacts of unit mass that do not couple, mu = 0.5; W = 1 needs no scaling but that of the
/// speeds.
LawProblem apart(int dim, int contacts) {
  ContactProblem p{.dim = dim,
                   .u_free = Vector::Constant(dim * contacts, -1),
                   .mu = Vector::Constant(contacts, 0.5)};
  SparseMatrix one(dim * contacts, dim * contacts);
  one.setIdentity();
  p.W = one;
  return LawProblem(p, Vector::Ones(dim * contacts));
}

Vector term(const LawProblem& problem, const Vector& s, Cell cell, double delta) {
  LawPoint point = nearest_point(problem, s, problem.W * s + problem.b);
  for (int i = 0; i < problem.num_contacts(); ++i) point.set(problem, i, cell);
  Vector term;
  proximal_term(problem, point, s, delta, term);
  return term;
}

// Normal impulses 1, 2, 6, 0, 0.1, 80.9: the five that bear have the mean 18. Hence 18, 9, 180
// above 10, none and 18 / 80.9 = 0.2225 times delta: 10, 9, 3, 10, 10, 0.2225.
TEST(ProximalTerm, GoesWithTheMeanImpulseOverTheContactsOwn) {
  for (const int d : {1, 2}) {
    Vector s = Vector::Zero(6 * d);
    const double impulses[] = {1, 2, 6, 0, 0.1, 80.9};
    const double factors[] = {10, 9, 3, 10, 10, 18 / 80.9};
    for (int i = 0; i < 6; ++i) s[i * d] = impulses[i];
    const Vector at = term(apart(d, 6), s, Cell::kTakeOff, 1e-3);
    for (int row = 0; row < 6 * d; ++row) {
      EXPECT_NEAR(at[row], 1e-3 * factors[row / d], 1e-17) << row;
    }
  }
}

// One of a thousand bears 10^4 times the others: mean 11, its own 10^4, and a tenth is the least.
TEST(ProximalTerm, IsATenthAtLeast) {
  Vector s = Vector::Ones(1000);
  s[7] = 1e4;
  EXPECT_NEAR(term(apart(1, 1000), s, Cell::kTakeOff, 1)[7], 0.1, 1e-15);
}

// Equal impulses: the factor is 1, and a tenth where a contact sticks at less than 0.8 of the edge.
TEST(ProximalTerm, IsSmallWhereAContactSticksWellInside) {
  Vector s(6);
  s << 2, 0.79, 2, -0.79, 2, 0.81;  // the edge: 0.5 * 2 = 1
  const LawProblem problem = apart(2, 3);
  const Vector sticking = term(problem, s, Cell::kStick, 2);
  for (int row = 0; row < 6; ++row) EXPECT_NEAR(sticking[row], row < 4 ? 0.2 : 2, 1e-15) << row;
  const Vector open = term(problem, s, Cell::kTakeOff, 2);
  for (const double value : open) EXPECT_EQ(value, 2);
}

TEST(ProximalTerm, IsDeltaWhereNothingBears) {
  for (const double value : term(apart(2, 3), Vector::Zero(6), Cell::kTakeOff, 0.5)) {
    EXPECT_EQ(value, 0.5);
  }
}

}  // namespace
}  // namespace bipot
