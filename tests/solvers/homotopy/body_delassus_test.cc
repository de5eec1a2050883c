#include "solvers/homotopy/body_delassus.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/problem/delassus.h"
#include "tests/support/manufactured.h"
#include "tests/support/random_vector.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

class BodyDelassusOf : public testing::TestWithParam<int> {};

TEST_P(BodyDelassusOf, HasTheEntriesOfW) {
  const int d = GetParam();
  const ContactProblem p = manufactured_problem(d, 30, 60, 5).problem;
  const int m = p.num_rows();
  const Vector scale = random_vector(m, 8).array().exp();
  ASSERT_TRUE(BodyDelassus::serves(p));
  const BodyDelassus delassus(p, scale);
  const Eigen::MatrixXd W =
      scale.asDiagonal() * Eigen::MatrixXd(assemble_delassus(p.A, p.H, d)) * scale.asDiagonal();
  Eigen::MatrixXd found = Eigen::MatrixXd::Zero(m, m);
  for (int i = p.num_contacts() - 1; i >= 0; --i) {
    int last = -1;
    for (const BodyDelassus::Block& block : delassus.blocks(i)) {
      EXPECT_GT(block.contact, last) << "ascending";
      last = block.contact;
      for (int a = 0; a < d; ++a) {
        for (int b = 0; b < d; ++b) found(last * d + a, i * d + b) = block.at[a][b];
      }
    }
  }
  EXPECT_LT((found - W).norm(), 1e-14 * W.norm());
  EXPECT_EQ(found, found.transpose()) << "to the last bit";

  const Vector s = random_vector(m, 3);
  Vector product = Vector::Ones(m);
  std::vector<double> velocity;
  delassus.move_bodies([&](int j) { return 2 * s[j]; }, velocity);
  for (int j = 0; j < m; ++j) product[j] += delassus.relative_velocity(j, velocity);
  EXPECT_LT((product - (2 * W * s + Vector::Ones(m))).norm(), 1e-13 * product.norm());

  // G = H S, by columns, entries and contacts of a degree of freedom.
  const Eigen::MatrixXd G = Eigen::MatrixXd(p.H) * scale.asDiagonal();
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(p.num_dofs(), m);
  for (int j = 0; j < m; ++j) {
    delassus.for_column_of_G(j, [&](int row, double value) { columns(row, j) = value; });
  }
  EXPECT_EQ(columns, G);
  for (int k = 0; k < p.num_dofs(); ++k) {
    EXPECT_EQ(delassus.mass(k), p.A.coeff(k, k));
    const std::span<const int> contacts = delassus.contacts_of(k);
    for (int j = 0; j < m; ++j) {
      EXPECT_EQ(delassus.entry_of_G(k, j), G(k, j));
      EXPECT_TRUE(G(k, j) == 0 || std::binary_search(contacts.begin(), contacts.end(), j / d));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Dims, BodyDelassusOf, testing::Values(1, 2));

/// A contact that moves nothing has a block of zeros.
TEST(BodyDelassus, HasTheOwnBlockOfEveryContact) {
  ContactProblem p = manufactured_problem(2, 5, 6, 5).problem;
  SparseMatrix H = p.H;
  H.prune([](Eigen::Index, Eigen::Index column, double) { return column / 2 != 3; });
  p.H = H;
  const Vector scale = Vector::Ones(p.num_rows());
  const BodyDelassus delassus(p, scale);
  ASSERT_EQ(delassus.blocks(3).size(), 1U);
  EXPECT_EQ(delassus.blocks(3)[0].contact, 3);
  EXPECT_EQ(delassus.blocks(3)[0].at[0][0], 0);
}

TEST(BodyDelassus, ServesPlaneProblemsOfBodies) {
  const ContactProblem p = manufactured_problem(2, 10, 12, 5).problem;
  EXPECT_TRUE(BodyDelassus::serves(p));
  EXPECT_FALSE(BodyDelassus::serves(local_form(p)));
  EXPECT_FALSE(BodyDelassus::serves(manufactured_problem(3, 10, 12, 5).problem));
  ContactProblem coupled = p;
  coupled.A.coeffRef(0, 1) = coupled.A.coeffRef(1, 0) = 0.1;
  coupled.A.makeCompressed();
  EXPECT_FALSE(BodyDelassus::serves(coupled));
}

}  // namespace
}  // namespace bipot
