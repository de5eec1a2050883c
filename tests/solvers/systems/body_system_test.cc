#include "solvers/systems/body_system.h"

#include "core/base/triplets.h"
#include "tests/support/manufactured.h"
#include "tests/support/random_vector.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// A mass matrix that couples the degrees of freedom of each body, as tensors of inertia do.
SparseMatrix coupled_masses(const ContactProblem& p, int of_body) {
  Triplets entries;
  for (int dof = 0; dof < p.num_dofs(); ++dof) {
    entries.emplace_back(dof, dof, 2 + 0.1 * dof);
    if (dof % of_body == 0) continue;
    entries.emplace_back(dof, dof - 1, 0.5);
    entries.emplace_back(dof - 1, dof, 0.5);
  }
  return from_triplets(p.num_dofs(), p.num_dofs(), entries);
}

TEST(BodySystem, IsTheDenseMatrixAndItsProducts) {
  for (int dim = 1; dim <= 3; ++dim) {
    ContactProblem p = manufactured_problem(dim, 7, 12, 5).problem;
    p.A = coupled_masses(p, dim == 3 ? 6 : 3);
    std::vector<int> dofs(to_size(p.num_dofs()));
    std::iota(dofs.begin(), dofs.end(), 0);
    const int m = p.num_rows();
    const Vector scale = random_vector(m, 1).cwiseAbs() + Vector::Constant(m, 0.5);
    BodySystem system(p, dofs, scale);
    const Eigen::MatrixXd G = Eigen::MatrixXd(p.H) * scale.asDiagonal();
    for (unsigned seed = 2; seed < 5; ++seed) {  // in the pattern of before
      const Vector blocks = random_vector(m * dim, seed);
      Eigen::MatrixXd R = Eigen::MatrixXd::Zero(m, m);
      for (int row = 0; row < m; ++row) {
        for (int b = 0; b < dim; ++b) R(row, row / dim * dim + b) = blocks[row * dim + b];
      }
      const Eigen::MatrixXd K = Eigen::MatrixXd(p.A) + G * R * G.transpose();
      const Eigen::MatrixXd found = system.assemble(blocks.data());
      EXPECT_LT((found - K).norm(), 1e-14 * K.norm()) << dim;
    }
    const Vector s = random_vector(m, 6), v = random_vector(p.num_dofs(), 7);
    Vector g, u;
    system.momentum(s, g);
    system.velocity(v, u);
    EXPECT_LT((g - G * s).norm(), 1e-14 * s.norm() * G.norm()) << dim;
    EXPECT_LT((u - G.transpose() * v).norm(), 1e-14 * v.norm() * G.norm()) << dim;
  }
}

/// Bodies without contacts are no unknowns; the others keep their order.
TEST(BodySystem, LeavesOutWhatNoContactActsOn) {
  ContactProblem p = manufactured_problem(2, 40, 8, 3).problem;
  const std::vector<int> dofs = BodySystem::touched(p);
  ASSERT_LT(static_cast<int>(dofs.size()), p.num_dofs());
  BodySystem system(p, dofs, Vector::Ones(p.num_rows()));
  EXPECT_EQ(system.size(), static_cast<int>(dofs.size()));
  const Vector s = random_vector(p.num_rows(), 9);
  Vector g;
  system.momentum(s, g);
  const Vector all = p.H * s;
  Vector rest = all;
  for (int i = 0; i < system.size(); ++i) {
    EXPECT_NEAR(g[i], all[dofs[to_size(i)]], 1e-14 * all.norm());
    rest[dofs[to_size(i)]] = 0;
  }
  EXPECT_EQ(rest.norm(), 0);
}

}  // namespace
}  // namespace bipot
