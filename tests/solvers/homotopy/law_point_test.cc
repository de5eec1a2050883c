#include "solvers/homotopy/law_point.h"

#include <gtest/gtest.h>

#include "tests/support/manufactured.h"
#include "tests/support/random_vector.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

TEST(LawProblem, IsSymmetricToTheLastBitWhereWIsToRounding) {
  const ContactProblem p = manufactured_problem(2, 30, 60, 5).problem;
  const ContactProblem local = local_form(p);
  const LawProblem from_bodies(p, Vector(local.W.diagonal())),
      from_W(local, Vector(local.W.diagonal()));
  EXPECT_EQ((from_bodies.W - from_W.W).norm(), 0);
  EXPECT_EQ((SparseMatrix(from_W.W.transpose()) - from_W.W).norm(), 0);
  ContactProblem skew = local;
  skew.W.coeffRef(0, 1) += 1e-9;
  const LawProblem unsymmetric(skew, Vector(local.W.diagonal()));
  EXPECT_NE(unsymmetric.W.coeff(0, 1), unsymmetric.W.coeff(1, 0));
}

/// Kept, or read out of H; where the contact problem has no H it is kept.
TEST(LawProblem, VelocitiesAreThoseOfW) {
  for (const int d : {1, 2}) {
    const ContactProblem p = manufactured_problem(d, 30, 60, 5).problem;
    const ContactProblem local = local_form(p);
    const Vector diagonal = local.W.diagonal();
    const LawProblem kept(p, diagonal), of_bodies(p, diagonal, LawProblem::Delassus::kOfBodies);
    ASSERT_TRUE(of_bodies.bodies);
    EXPECT_EQ(of_bodies.W.size(), 0);
    const Vector s = random_vector(kept.num_rows(), 4);
    const Vector u = kept.W * s + kept.b;
    EXPECT_LT((of_bodies.velocity(s) - u).norm(), 1e-13 * u.norm()) << d;
    EXPECT_EQ(kept.velocity(s), u) << d;
    for (const LawProblem* law : {&kept, &of_bodies}) {
      Vector left = u - kept.b;
      law->subtract_product(s, left);
      EXPECT_LT(left.norm(), 1e-13 * u.norm()) << d;
    }
    const LawProblem without_bodies(local, diagonal, LawProblem::Delassus::kOfBodies);
    EXPECT_FALSE(without_bodies.bodies);
    EXPECT_EQ(without_bodies.W.rows(), kept.num_rows());
  }
}

}  // namespace
}  // namespace bipot
