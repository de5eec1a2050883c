#include "core/criterion/rounding_bound.h"

#include "core/criterion/extended_error.h"
#include "tests/support/manufactured.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// The impulse of the criterion's evaluation: on the cone to rounding.
Vector projected(const ContactProblem& p, const Vector& s) {
  ContactErrorEvaluator evaluate(p);
  evaluate(s);
  return evaluate.impulse();
}

double double_error(const ContactProblem& p, const Vector& s) {
  return contact_error(p, s).guarded();
}

TEST(RoundingBound, HoldsTheDifferenceOfBothPrecisions) {
  for (int dim = 1; dim <= 3; ++dim) {
    for (const double mu : {0.4, 30.0, 1e6}) {
      for (unsigned seed = 1; seed <= 20; ++seed) {
        Manufactured m = manufactured_problem(dim, 6, 9, seed, mu);
        if (seed % 2 == 0) m.problem.A = m.problem.H = SparseMatrix();  // W alone
        for (const double off : {0.0, 1e-9, 1e-3}) {
          Vector s = m.s;
          for (Eigen::Index i = 0; i < s.size(); ++i) {
            s[i] *= 1 + off * std::sin(7.0 * double(i) + seed);
          }
          s = projected(m.problem, s);
          const double bound = rounding_bound(m.problem, s, Precision::kDouble).guarded() +
                               rounding_bound(m.problem, s, Precision::kExtended).guarded();
          const double exact = extended_guarded_error(m.problem, s);
          EXPECT_LE(std::abs(double_error(m.problem, s) - exact), bound)
              << "d = " << dim << ", mu = " << mu << ", seed " << seed << ", off by " << off;
          EXPECT_LE(std::abs(exact - quadruple_guarded_error(m.problem, s)),
                    rounding_bound(m.problem, s, Precision::kExtended).guarded())
              << "d = " << dim << ", mu = " << mu << ", seed " << seed << ", off by " << off;
        }
      }
    }
  }
}

// A thousandth of the tolerance 1e-8 at the most: nobody notices that claims are proved.
TEST(RoundingBound, IsSmallWhereNothingIsLarge) {
  for (int dim = 1; dim <= 3; ++dim) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const Manufactured m = manufactured_problem(dim, 6, 9, seed, 0.4);
      EXPECT_LE(rounding_bound(m.problem, m.s, Precision::kDouble).guarded(), 1e-11);
      EXPECT_GT(rounding_bound(m.problem, m.s, Precision::kDouble).guarded(), 1e-16);
    }
  }
}

TEST(RoundingBound, GrowsWithFrictionAndWithSelfStress) {
  const Manufactured mild = manufactured_problem(2, 6, 9, 3, 1.0);
  const Manufactured rough = manufactured_problem(2, 6, 9, 3, 1e6);
  const double calm = rounding_bound(mild.problem, mild.s, Precision::kDouble).guarded();
  EXPECT_GT(rounding_bound(rough.problem, rough.s, Precision::kDouble).guarded(), 1e3 * calm);
  // One body of 1 kg between two walls, s = (S + 1, S), b = (-1, 1): u = 0 exactly, E = 1/2 J
  // whatever S. |s|ᵀ|W||s| = (2 S + 1)².
  double previous = 0;
  for (const double stress : {1.0, 1e3, 1e6}) {
    const ContactProblem p = delassus_problem(1, Eigen::Matrix2d{{1, -1}, {-1, 1}},
                                              Eigen::Vector2d(-1, 1), Vector::Zero(2));
    const double bound =
        rounding_bound(p, Eigen::Vector2d(stress + 1, stress), Precision::kDouble).epsilon;
    EXPECT_GT(bound, std::ldexp(stress * stress, -53));
    EXPECT_GT(bound, 100 * previous);
    previous = bound;
  }
}

TEST(RoundingBound, IsTwoThousandTimesSmallerInExtendedPrecision) {
  const Manufactured m = manufactured_problem(3, 6, 9, 3, 1e8);
  const double ratio = rounding_bound(m.problem, m.s, Precision::kDouble).guarded() /
                       rounding_bound(m.problem, m.s, Precision::kExtended).guarded();
  EXPECT_NEAR(ratio, 2048, 0.02 * 2048);  // 2^11; what is handed on in double is part of the latter
}

// With others of 1e9 times the energy an error and its rounding count 1e-9; with half of the
// tolerance to use both count twice.
TEST(RoundingBound, IsSharedAsTheErrorIs) {
  const Manufactured m = manufactured_problem(2, 6, 9, 3, 0.4);
  const RoundingBound alone = rounding_bound(m.problem, m.s, Precision::kDouble);
  ErrorShare share{.share = 0.5};
  const RoundingBound half = rounding_bound(m.problem, m.s, Precision::kDouble, share);
  EXPECT_NEAR(half.epsilon, 2 * alone.epsilon, 1e-12 * alone.epsilon);
  EXPECT_NEAR(half.eta, 2 * alone.eta, 1e-12 * alone.eta);
  share.share = 1;
  share.others.friction = 1e9 * contact_error(m.problem, m.s).friction_power;
  EXPECT_LT(rounding_bound(m.problem, m.s, Precision::kDouble, share).epsilon,
            1e-6 * alone.epsilon);
}

// A part with a millionth of the energy of the others: judged with them its rounding is nothing,
// and that counts, whatever it is beside its own energy.
TEST(RoundingBound, TakesTheSmallerOfTwoFigures) {
  const Manufactured m = manufactured_problem(2, 6, 9, 3, 1e6);
  ErrorShare share;
  share.others.friction = 1e6 * contact_error(m.problem, m.s).energy;
  const RoundingBound with_others = rounding_bound(m.problem, m.s, Precision::kDouble, share);
  share.alone = 12;
  const RoundingBound either = rounding_bound(m.problem, m.s, Precision::kDouble, share);
  EXPECT_LE(either.guarded(), 1.01 * with_others.guarded());
  EXPECT_LT(either.guarded(), 1e-2 * rounding_bound(m.problem, m.s, Precision::kDouble).guarded());
}

}  // namespace
}  // namespace bipot
