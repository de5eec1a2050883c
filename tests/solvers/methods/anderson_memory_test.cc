#include <Eigen/Dense>

#include "solvers/kernels/anderson_iteration.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

struct PlainProducts {
  Vector products(const Eigen::MatrixXd& columns, int size, const Vector& f) const {
    return columns.leftCols(size).transpose() * f;
  }
};

class AndersonMemoryTest : public testing::Test {
 protected:
  Vector random(int n) {
    Vector v(n);
    for (double& x : v) x = draw_(engine_);
    return v;
  }
  std::mt19937 engine_{5};
  std::uniform_real_distribution<double> draw_{-1, 1};
};

/// g - ΔG gamma of the last columns, gamma by a factorisation of ΔF that asks nothing.
TEST_F(AndersonMemoryTest, CombinesByLeastSquaresOverTheLastColumns) {
  const int rows = 30, columns = 4;
  PlainProducts plain;
  AndersonMemory<PlainProducts> memory(plain, rows, columns);
  Eigen::MatrixXd df(rows, 0), dg(rows, 0);
  Vector x;
  const auto append = [&](const Vector& f, const Vector& g) {
    memory.append(f, g);
    df.conservativeResize(rows, df.cols() + 1);
    dg.conservativeResize(rows, dg.cols() + 1);
    df.rightCols<1>() = f;
    dg.rightCols<1>() = g;
  };
  // Lengths from 1 to 1e-11: columns are of a converging iteration.
  for (int k = 0; k < 12; ++k) {
    append(std::pow(10.0, -k) * random(rows), random(rows));
    const int last = std::min(k + 1, columns);
    const Vector f = random(rows), g = random(rows);
    memory.combine(f, g, x);
    const Eigen::MatrixXd f_last = df.rightCols(last);
    const Vector unit = f_last.colwise().norm().cwiseInverse();
    const Vector gamma =
        (f_last * unit.asDiagonal()).colPivHouseholderQr().solve(f).cwiseProduct(unit);
    const Vector expected = g - dg.rightCols(last) * gamma;
    EXPECT_LT((x - expected).norm(), 1e-12 * expected.norm()) << k;
  }
  memory.clear();
  const Vector g = random(rows);
  memory.combine(random(rows), g, x);
  EXPECT_EQ(x, g);
}

/// A column that newer ones span is left out, and those older than it: what remains is solved as if
/// they had never been. After that the ring fills again.
TEST_F(AndersonMemoryTest, LeavesOutWhatNewerColumnsSpan) {
  const int rows = 20;
  PlainProducts plain;
  AndersonMemory<PlainProducts> memory(plain, rows, 5), fresh(plain, rows, 5);
  const Vector a = random(rows), b = random(rows), f = random(rows), g = random(rows);
  memory.append(random(rows), random(rows));
  memory.append(a + 2 * b, random(rows));
  const Vector da = random(rows), db = random(rows);
  for (auto* m : {&memory, &fresh}) {
    m->append(a, da);
    m->append(b, db);
  }
  Vector x, y;
  memory.combine(f, g, x);
  fresh.combine(f, g, y);
  EXPECT_LT((x - y).norm(), 1e-12 * y.norm());
  for (int k = 0; k < 9; ++k) {
    const Vector df = random(rows), dg = random(rows);
    memory.append(df, dg);
    fresh.append(df, dg);
    memory.combine(f, g, x);
    fresh.combine(f, g, y);
    EXPECT_LT((x - y).norm(), 1e-11 * y.norm()) << k;
  }
}

/// A difference of nothing, as where the iteration stands still, is no column.
TEST_F(AndersonMemoryTest, StandsStillWithoutNaN) {
  PlainProducts plain;
  AndersonMemory<PlainProducts> memory(plain, 6, 3);
  memory.append(Vector::Zero(6), Vector::Zero(6));
  Vector x;
  const Vector g = random(6);
  memory.combine(random(6), g, x);
  EXPECT_EQ(x, g);
  memory.append(random(6), random(6));
  memory.combine(random(6), g, x);
  EXPECT_TRUE(x.allFinite());
}

}  // namespace
}  // namespace bipot
