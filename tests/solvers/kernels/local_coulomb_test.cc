#include "solvers/kernels/local_coulomb.h"

#include "core/criterion/contact_error.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// A random positive definite block with coupling between normal and tangents.
template <int D>
LocalProblem<D> random_problem(std::mt19937& engine, double mu) {
  const auto draw = [&] { return static_cast<double>(engine()) * 0x1.0p-31 - 1; };
  Eigen::Matrix<double, D, D> root;
  for (int i = 0; i < D * D; ++i) root(i / D, i % D) = draw();
  Eigen::MatrixXd w = root * root.transpose();
  w.diagonal().array() += 0.05;
  LocalProblem<D> p = local_problem<D>(w, mu);
  for (int k = 0; k < D; ++k) p.q[k] = draw();
  return p;
}

template <int D>
double error(const LocalProblem<D>& p, const Local<D>& s) {
  ContactProblem problem{.dim = D,
                         .W = Eigen::MatrixXd(p.w).sparseView(),
                         .u_free = p.q,
                         .mu = Vector::Constant(1, p.mu)};
  return contact_error(problem, Vector(s)).guarded();
}

template <int D>
void solves_random_problems() {
  std::mt19937 engine(3);
  int slips = 0, sticks = 0, solved = 0;
  constexpr int kTrials = 500;
  for (int k = 0; k < kTrials; ++k) {
    const LocalProblem<D> p =
        random_problem<D>(engine, k % 3 == 0 ? 0.1 : (k % 3 == 1 ? 0.5 : 1.0));
    Local<D> s = Local<D>::Zero();
    if (!solve_local<D>(p, s)) continue;
    ++solved;
    EXPECT_LT(error<D>(p, s), 1e-9) << k;
    const Local<D> u = p.w * s + p.q;
    if (s[0] > 0 && u.norm() > 1e-9) ++slips;
    if (s[0] > 0 && u.norm() <= 1e-9) ++sticks;
  }
  // With strong coupling a single contact need not have a solution of the form that is looked for.
  EXPECT_GE(solved, kTrials * 99 / 100);
  EXPECT_GT(sticks, 20);
  EXPECT_GT(slips, D > 1 ? 20 : -1);
}

TEST(LocalCoulomb, ExactSolutionsSatisfyTheLaw) {
  solves_random_problems<1>();
  solves_random_problems<2>();
  solves_random_problems<3>();
}

TEST(LocalCoulomb, TakesOffWhenTheFreeVelocityOpens) {
  LocalProblem<3> p = local_problem<3>(Eigen::Matrix3d::Identity(), 0.5);
  p.q = Local<3>(0.1, 2, -3);
  Local<3> s(1, 0.2, 0);
  ASSERT_TRUE(solve_local<3>(p, s));
  EXPECT_EQ(s.norm(), 0);
}

// W = I, q = (-1, 3, 4): s_n = 1, friction mu against the direction (3, 4)/5.
TEST(LocalCoulomb, SlipOpposesTheSlidingDirection) {
  LocalProblem<3> p = local_problem<3>(Eigen::Matrix3d::Identity(), 0.5);
  p.q = Local<3>(-1, 3, 4);
  Local<3> s = Local<3>::Zero();
  ASSERT_TRUE(solve_local<3>(p, s));
  EXPECT_NEAR(s[0], 1, 1e-14);
  EXPECT_NEAR(s[1], -0.3, 1e-14);
  EXPECT_NEAR(s[2], -0.4, 1e-14);
}

TEST(LocalCoulomb, WithoutFrictionOnlyTheNormalPartActs) {
  std::mt19937 engine(5);
  LocalProblem<3> p = random_problem<3>(engine, 0);
  p.q[0] = -1;
  Local<3> s = Local<3>::Zero();
  ASSERT_TRUE(solve_local<3>(p, s));
  EXPECT_NEAR(s[0], 1 / p.w(0, 0), 1e-14);
  EXPECT_EQ(s[1], 0);
  EXPECT_EQ(s[2], 0);
}

TEST(LocalCoulomb, ASingularBlockIsSolvedOrRefused) {
  // No mobility along the second tangent: friction there has no effect on u.
  Eigen::Matrix3d w = Eigen::Matrix3d::Zero();
  w.diagonal() << 1, 1, 0;
  LocalProblem<3> p = local_problem<3>(w, 0.5);
  p.q = Local<3>(-1, 2, 0);
  Local<3> s = Local<3>::Zero();
  ASSERT_TRUE(solve_local<3>(p, s));
  EXPECT_LT(error<3>(p, s), 1e-9);
}

TEST(LocalCoulomb, RoundsOfProjectionsApproachTheExactSolution) {
  std::mt19937 engine(9);
  for (int k = 0; k < 50; ++k) {
    const LocalProblem<3> p = random_problem<3>(engine, 0.3);
    const Local<3> start = Local<3>::Zero();
    const double before = error<3>(p, improve_local<3>(p, start, p.q, 1, 1));
    const double after = error<3>(p, improve_local<3>(p, start, p.q, 1, 1000));
    EXPECT_LE(after, std::max(before, 1e-12)) << k;
    EXPECT_LT(after, 1e-3) << k;
  }
}

TEST(LocalCoulomb, OneRoundIsExactForADiagonalBlock) {
  LocalProblem<2> p = local_problem<2>(Eigen::Vector2d(2, 5).asDiagonal(), 0.5);
  p.q = Local<2>(-4, 20);
  const Local<2> s = improve_local<2>(p, Local<2>(0.3, 0.1), p.w * Local<2>(0.3, 0.1) + p.q, 1, 1);
  EXPECT_NEAR(s[0], 2, 1e-15);
  EXPECT_NEAR(s[1], -1, 1e-15);
}

}  // namespace
}  // namespace bipot
