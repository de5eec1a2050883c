#include "solvers/systems/body_columns.h"

#include "tests/support/manufactured.h"
#include "tests/support/random_vector.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// What the fronts take, column by column in the order `place`: each entry of the lower triangle
/// once.
Eigen::MatrixXd taken(const BodyColumns& columns, const std::vector<int>& place,
                      const double* blocks) {
  const int n = static_cast<int>(place.size());
  std::vector<int> position(place.size());
  std::iota(position.begin(), position.end(), 0);
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, n);
  std::vector<double> column(place.size());
  const std::vector<double> scale(place.size(), 1.0);
  for (int j = 0; j < n; ++j) {
    std::fill(column.begin(), column.end(), 0.0);
    columns.add(j, blocks,
                {place.data(), position.data(), place[to_size(j)], column.data(), scale.data(), 1});
    for (int i = 0; i < n; ++i) {
      const double value = column[to_size(place[to_size(i)])];
      if (place[to_size(i)] < place[to_size(j)]) {
        EXPECT_EQ(value, 0) << i << " " << j;  // a front before took it
      } else {
        K(i, j) = K(j, i) = value;
      }
    }
  }
  return K;
}

TEST(BodyColumns, AreThoseOfTheDenseMatrix) {
  for (int dim = 1; dim <= 3; ++dim) {
    ContactProblem p = manufactured_problem(dim, 7, 12, 5).problem;
    p.A.coeffRef(1, 0) = p.A.coeffRef(0, 1) = 0.01;  // as tensors of inertia couple
    p.A.makeCompressed();
    const int m = p.num_rows(), n = p.num_dofs();
    const Vector scale = random_vector(m, 1).cwiseAbs() + Vector::Constant(m, 0.5);
    const BodyColumns columns(p, scale);
    std::vector<int> place(to_size(n));  // neither order
    for (int k = 0; k < n; ++k) place[to_size(k)] = k % 2 == 0 ? k / 2 : n - 1 - k / 2;
    const Eigen::MatrixXd G = Eigen::MatrixXd(p.H) * scale.asDiagonal();
    Eigen::MatrixXd R = Eigen::MatrixXd::Zero(m, m);
    std::vector<double> blocks;
    for (int c = 0; c < p.num_contacts(); ++c) {
      const Eigen::MatrixXd half =
          Eigen::Map<const Eigen::MatrixXd>(random_vector(dim * dim, 9).data(), dim, dim);
      const Eigen::MatrixXd block =
          half + half.transpose() + (3.0 + c) * Eigen::MatrixXd::Identity(dim, dim);
      R.block(c * dim, c * dim, dim, dim) = block;
      blocks.insert(blocks.end(), block.data(), block.data() + block.size());
    }
    const Eigen::MatrixXd K = Eigen::MatrixXd(p.A) + G * R * G.transpose();
    const Eigen::MatrixXd found = taken(columns, place, blocks.data());
    EXPECT_LT((found - K).norm(), 1e-14 * K.norm()) << dim;

    // The pattern has every entry, rows ascending, and fronts assembled from it solve with K.
    const BodyPattern pattern = columns.pattern();
    for (int j = 0; j < n; ++j) {
      const auto rows = std::vector<int>(pattern.row.begin() + pattern.start[to_size(j)],
                                         pattern.row.begin() + pattern.start[to_size(j) + 1]);
      EXPECT_TRUE(std::is_sorted(rows.begin(), rows.end()));
      for (int i = 0; i < n; ++i) {
        EXPECT_TRUE(K(i, j) == 0 || std::binary_search(rows.begin(), rows.end(), i));
      }
    }
    FrontalCholesky factor;
    factor.analyse(pattern);
    const auto add = [&](int j, const FrontalCholesky::Column& to) {
      columns.add(j, blocks.data(), to);
    };
    ASSERT_TRUE(factor.factor(add, columns.diagonal()));
    const Vector x = random_vector(n, 3);
    Vector solved = Vector::Zero(n);
    for (int k = 0; k < 4; ++k) {
      Vector correction = K * (x - solved);
      factor.solve(correction, correction);
      solved += correction;
    }
    EXPECT_LT((solved - x).norm(), 1e-9 * x.norm()) << dim;

    const Vector s = random_vector(m, 6), v = random_vector(n, 7), u = G.transpose() * v;
    Vector g;
    columns.residual(s, v, g);
    const double size = s.norm() * G.norm() + v.norm() * p.A.norm();
    EXPECT_LT((g - (G * s - p.A * v)).norm(), 1e-14 * size) << dim;
    dispatch_dim(dim, [&](auto d) {
      for (int c = 0; c < p.num_contacts(); ++c) {
        const Local<d()> own = columns.velocity<d()>(c, v);
        EXPECT_LT((own - u.segment<d()>(c * d())).norm(), 1e-14 * v.norm() * G.norm()) << dim;
      }
    });
  }
}

}  // namespace
}  // namespace bipot
