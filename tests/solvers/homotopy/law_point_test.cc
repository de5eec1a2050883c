#include "solvers/homotopy/law_point.h"

#include <gtest/gtest.h>

#include "tests/support/manufactured.h"
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

}  // namespace
}  // namespace bipot
