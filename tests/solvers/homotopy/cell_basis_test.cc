#include "solvers/homotopy/cell_basis.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/manufactured.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

Vector random_numbers(int n, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Vector x(n);
  for (double& value : x) value = uniform(engine);
  return x;
}

/// B x of the point by the definition in cell_basis.h, in quadruple precision.
std::vector<__float128> product(const LawProblem& p, const LawPoint& point, const Vector& proximal,
                                const Vector& x) {
  std::vector<__float128> out(static_cast<std::size_t>(p.num_rows()), 0);
  const auto at = [&](int row) -> __float128& { return out[static_cast<std::size_t>(row)]; };
  for (int slot = 0; slot < p.num_rows(); ++slot) {
    const int contact = slot / p.dim, n = contact * p.dim;
    const Column column = point.column[static_cast<std::size_t>(slot)];
    if (!is_impulse(column)) {
      at(column == Column::kOpening ? n : n + 1) += x[slot];
      continue;
    }
    for (int k = 0; k < p.dim; ++k) {
      const __float128 part =
          k == 0 ? __float128(x[slot]) : __float128(p.tangent(contact, column)) * x[slot];
      for (int row = 0; row < p.num_rows(); ++row) at(row) -= p.W.coeff(row, n + k) * part;
      at(n + k) -= proximal[n + k] * part;
    }
  }
  return out;
}

class CellBases : public testing::TestWithParam<int> {};

// With a proximal term of 1e-9 an error of rounding grows to 1e-7: refined three times it is gone,
// and refining in two parts is the same, bit for bit.
TEST_P(CellBases, RefinedSolutionsMeetTheEquations) {
  const int d = GetParam();
  const ContactProblem problem = local_form(manufactured_problem(d, 30, 60, 5).problem);
  const LawProblem law(problem, Vector(problem.W.diagonal()));
  const Vector s = random_numbers(law.num_rows(), 1);
  LawPoint point = nearest_point(law, s, law.W * s + law.b);
  point.sort_columns(d);
  const Vector proximal = Vector::Constant(law.num_rows(), 1e-9);
  CellBasis basis(law);
  ASSERT_TRUE(basis.factor(point, proximal));

  const Vector g = random_numbers(law.num_rows(), 2), h = random_numbers(law.num_rows(), 3);
  Vector plain, refined, in_parts;
  basis.solve_refined(point, g, 0.3L, h, 0, plain);
  basis.solve_refined(point, g, 0.3L, h, 3, refined);
  basis.solve_refined(point, g, 0.3L, h, 1, in_parts);
  basis.refine(point, g, 0.3L, h, 2, in_parts);
  EXPECT_EQ(in_parts, refined);

  const auto error = [&](const Vector& x) {
    const auto b = product(law, point, proximal, x);
    double largest = 0;
    for (int i = 0; i < law.num_rows(); ++i) {
      const __float128 left = g[i] + __float128(0.3L) * h[i] - b[static_cast<std::size_t>(i)];
      largest = std::max(largest, std::abs(static_cast<double>(left)));
    }
    return largest / x.lpNorm<Eigen::Infinity>();
  };
  EXPECT_LT(error(refined), 4e-16);
  EXPECT_LT((plain - refined).norm(), 1e-4 * refined.norm());
}

INSTANTIATE_TEST_SUITE_P(Dims, CellBases, testing::Values(1, 2));

}  // namespace
}  // namespace bipot
