#include "solvers/homotopy/law_point.h"

#include <Eigen/LU>

#include "core/base/portable_random.h"
#include "tests/support/manufactured.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

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

// Each s - u in R³ belongs to one cell, which gives s and u again; the columns are a positive basis
// there. Beyond a face the way back is the same face, and the neighbour's cone is on its other side.
TEST(LawPoint, CellsWithRollingCoverTheLawAndJoinAlongFaces) {
  for (const int without : {0, 1, 2}) {  // a row without friction
    ContactProblem p = manufactured_rolling(3, 2, 1, 1).problem;
    p.mu[0] = without == 1 ? 0 : 0.5;
    p.mu_r[0] = without == 2 ? 0 : 0.3;
    const ContactProblem local = local_form(p);
    const LawProblem law(local, Vector(local.W.diagonal()));
    PortableRandom random(5);
    std::set<Cell> cells;
    for (int draw = 0; draw < 2000; ++draw) {
      Vector z(3);
      for (double& x : z) x = random.symmetric();
      const Vector s = Eigen::Vector3d(std::max(z[0], 0.0), 0, 0), u = s - z;
      LawPoint at = nearest_point(law, s, u);
      cells.insert(at.cell[0]);
      Vector impulse, velocity;
      at.impulse(law, impulse);
      at.velocity(law, velocity);
      EXPECT_LT((impulse - velocity - z).norm(), 1e-14);
      EXPECT_GE(at.bound.cwiseProduct(at.value).minCoeff(), 0);
      const auto columns = [&](const LawPoint& point) {
        Eigen::Matrix3d M;
        for (int slot = 0; slot < 3; ++slot) {
          const Column c = point.column[to_size(slot)];
          if (is_impulse(c)) {
            M.col(slot) << 1, law.tangent(0, c, 1), law.tangent(0, c, 2);
          } else {
            M.col(slot) = Eigen::Vector3d::Unit(static_cast<int>(c));
          }
        }
        return M;
      };
      EXPECT_GT(columns(at).determinant(), 0);
      for (int slot = 0; slot < 3; ++slot) {
        if (at.bound[slot] == 0) continue;
        LawPoint next = at;
        next.value[slot] = 0;
        const Crossing over = next.across(law, slot);
        next.cell[0] = over.cell;
        next.column[to_size(slot)] = over.enters;
        next.find_bounds(law);
        EXPECT_TRUE(next.bound[slot] == 0 || next.bound[slot] == over.growth);
        const Crossing back = next.across(law, slot);
        EXPECT_EQ(back.cell, at.cell[0]);
        EXPECT_EQ(back.enters, at.column[to_size(slot)]);
        EXPECT_EQ(back.growth, at.bound[slot]);
        next.sort_columns(law);
        EXPECT_GT(columns(next).determinant(), 0);
      }
    }
    // Take-off, four of sliding and rolling, four of one of them, two of neither.
    EXPECT_EQ(cells.size(), without == 0 ? 11u : 4u);
  }
}

}  // namespace
}  // namespace bipot
