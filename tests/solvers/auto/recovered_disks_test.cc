#include "solvers/auto/recovered_disks.h"

#include "core/problem/delassus.h"
#include "core/problem/disk_structure.h"
#include "tests/support/converged.h"
#include "tests/support/manufactured.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

/// Largest difference between W and that of the recovered disks, over the largest entry.
double difference(const ContactProblem& local, const ContactProblem& recovered) {
  const SparseRows again = assemble_delassus(recovered.A, recovered.H, recovered.dim);
  return Eigen::MatrixXd(local.W - again).cwiseAbs().maxCoeff() /
         Eigen::MatrixXd(local.W).cwiseAbs().maxCoeff();
}

TEST(RecoveredDisks, PackingsOfAllKindsHaveTheirWAgain) {
  for (const char* name :
       {"2d_pyramid_10.hdf5", "2d_pyramid_20_mu05.hdf5", "2d_tilt12_320.hdf5",
        "2d_pour300_392.hdf5", "2d_triangular_20_tilt10.hdf5", "2d_triangular_12_mass1e6.hdf5",
        "2d_strike12_450.hdf5", "2d_collapse14_260.hdf5"}) {
    const ContactProblem local = local_form(shipped_file(name));
    const auto recovered = recovered_disks(local);
    ASSERT_TRUE(recovered) << name;
    EXPECT_TRUE(disk_structure(*recovered)) << name;
    EXPECT_LT(difference(local, *recovered), 1e-11) << name;
    EXPECT_EQ(recovered->u_free, local.u_free);
  }
}

/// Two contacts of one disk of mass 2 and inertia 1 at the arm 1/2, 60 degrees apart: W_nn is 1/2,
/// coupled by cos 60° / 2 = 1/4. With an entry changed there are no disks.
TEST(RecoveredDisks, AWThatDisksCannotHaveIsLeftAlone) {
  ContactProblem p{.dim = 2, .u_free = Vector::Constant(4, -1), .mu = Vector::Constant(2, 0.3)};
  Eigen::Matrix4d W;
  const double sine = std::sqrt(3.0) / 4, spin = 0.25;
  W << 0.5, 0, 0.25, -sine,              //
      0, 0.5 + spin, sine, 0.25 + spin,  //
      0.25, sine, 0.5, 0,                //
      -sine, 0.25 + spin, 0, 0.5 + spin;
  p.W = W.sparseView();
  const auto one = recovered_disks(p);
  ASSERT_TRUE(one);
  EXPECT_EQ(one->num_dofs(), 3);
  EXPECT_NEAR(one->A.coeff(0, 0), 2, 1e-12);
  EXPECT_LT(difference(p, *one), 1e-14);
  // A heavier second partner of contact 0 is a disk of its own.
  W(0, 0) += 0.1;
  W(1, 1) += 0.15;
  p.W = W.sparseView();
  const auto two = recovered_disks(p);
  ASSERT_TRUE(two);
  EXPECT_EQ(two->num_dofs(), 6);
  EXPECT_LT(difference(p, *two), 1e-14);
  for (const auto& [i, j] : {std::pair{0, 2}, {0, 1}, {1, 3}}) {
    Eigen::Matrix4d other = W;
    other(i, j) += 1e-3;
    other(j, i) += i == j ? 0 : 1e-3;
    p.W = other.sparseView();
    EXPECT_FALSE(recovered_disks(p)) << i << ' ' << j;
  }
}

TEST(RecoveredDisks, OtherProblemsHaveNone) {
  EXPECT_FALSE(recovered_disks(shipped_file("2d_pyramid_10.hdf5")));  // has its bodies
  EXPECT_FALSE(recovered_disks(local_form(shipped_file("3d_sphere_pyramid_2.hdf5"))));
  EXPECT_FALSE(recovered_disks(local_form(manufactured_problem(2, 5, 10, 1).problem)));
}

/// The answer is judged by the W that was given.
TEST(RecoveredDisks, AutoSolvesByThemAndIsJudgedByW) {
  const ContactProblem local = local_form(shipped_file("2d_pour300_392.hdf5"));
  for (const double tol : {1e-2, 1e-8, 1e-11}) {
    const SolveResult result = converged(solve("auto", local, {.tol = tol}));
    EXPECT_LE(result.error.guarded(), tol);
    EXPECT_EQ(result.message.rfind("disks recovered from W: ", 0), 0u) << result.message;
  }
}

}  // namespace
}  // namespace bipot
