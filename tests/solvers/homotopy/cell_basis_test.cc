#include "solvers/homotopy/cell_basis.h"

#include "core/base/portable_random.h"
#include "core/base/triplets.h"
#include "tests/support/manufactured.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

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

/// A random problem of the plane and the point of its solution.
struct SolvedLaw {
  Manufactured m = manufactured_problem(2, 30, 40, 11);
  ContactProblem local = local_form(m.problem);
  LawProblem problem{local, Vector(local.W.diagonal())};
  Vector s = m.s.cwiseQuotient(problem.impulse_unit);
  LawPoint point = nearest_point(problem, s, problem.W* s + problem.b);
};

TEST(CellBasis, ExchangedColumnsSolveAsAFreshFactorDoes) {
  SolvedLaw law;
  const LawProblem& problem = law.problem;
  LawPoint& point = law.point;
  const Vector proximal = Vector::LinSpaced(problem.num_rows(), 1e-2, 3e-2);
  CellBasis updated(problem), fresh(problem);
  ASSERT_TRUE(updated.factor(point, proximal));
  const Vector g = Vector::LinSpaced(problem.num_rows(), -1, 2);
  Vector before, after, x, z;
  updated.solve(g, x);
  const Vector of_the_factor = x;
  // Few contacts, many exchanges: columns leave, come back, into their own slot or the other one.
  PortableRandom random(7);
  int exchanged = 0;
  for (int k = 0; k < 200; ++k) {
    const int contact = random.below(8), slot = 2 * contact + random.below(2);
    const auto slip = static_cast<unsigned>(random.below(2));
    const Crossing crossing =
        cross(point.cell[to_size(contact)], point.column[to_size(slot)], slip);
    const CellBasis::Entering entering = updated.entering(contact, crossing.enters, slot);
    if (std::abs(entering.pivot) < 1e-3 * entering.size) continue;
    updated.solve(g, before);
    ASSERT_TRUE(updated.exchange(entering));
    updated.solve(g, after);
    // The rule of the exchange: x_slot becomes x_slot / pivot.
    EXPECT_NEAR(after[slot], before[slot] / entering.pivot, 1e-7 * (1 + std::abs(after[slot])));
    point.cell[to_size(contact)] = crossing.cell;
    point.column[to_size(slot)] = crossing.enters;
    ASSERT_TRUE(fresh.factor(point, proximal));
    fresh.solve(g, z);
    EXPECT_LT((after - z).norm(), 1e-9 * z.norm());
    x = of_the_factor;
    updated.update(x);
    EXPECT_EQ(x, after);
    ++exchanged;
  }
  EXPECT_GE(exchanged, 100);
  EXPECT_FALSE(updated.full());  // eight contacts have sixteen columns that the factor has not
}

/// Columns that are prepared together enter as those that are solved for one by one.
TEST(CellBasis, PreparedColumnsEnterAsOthersDo) {
  const SolvedLaw law;
  const LawProblem& problem = law.problem;
  const LawPoint& point = law.point;
  const Vector proximal = Vector::Constant(problem.num_rows(), 1e-2);
  CellBasis together(problem), alone(problem);
  ASSERT_TRUE(together.factor(point, proximal));
  ASSERT_TRUE(alone.factor(point, proximal));
  std::vector<CellBasis::Candidate> candidates;
  for (int contact = 0; contact < problem.num_contacts(); ++contact) {
    const int slot = 2 * contact + contact % 2;
    const Crossing crossing = cross(point.cell[to_size(contact)], point.column[to_size(slot)], 0);
    const CellBasis::Candidate c{contact, crossing.enters, slot};
    if (together.is_unknown(c)) candidates.push_back(c);
    if (candidates.size() == kRightSides) break;
  }
  ASSERT_EQ(candidates.size(), to_size(kRightSides));
  together.prepare(candidates);
  for (const CellBasis::Candidate& c : candidates) {
    EXPECT_FALSE(together.is_unknown(c));
    EXPECT_TRUE(alone.is_unknown(c));
    const CellBasis::Entering one = together.entering(c.contact, c.column, c.slot);
    const CellBasis::Entering other = alone.entering(c.contact, c.column, c.slot);
    EXPECT_NEAR(one.pivot, other.pivot, 1e-9 * other.size) << c.contact;
    EXPECT_NEAR(one.size, other.size, 1e-9 * other.size);
    EXPECT_FALSE(alone.is_unknown(c));
  }
}

/// Sliding contacts with W_nn = mu W_nt, each coupled to some of a core of sticking contacts: the
/// own block of a sliding contact in B is singular but for delta, and the fronts, which eliminate
/// it before the core, have nothing but that rounding to divide by. B is well conditioned: the
/// couplings of the sliding contacts have full rank.
TEST(CellBasis, SmallPivotsOfTheFrontsAreLeftToExchangesOfAllRows) {
  constexpr int kSliding = 30, kCore = 100, kContacts = kSliding + kCore, kCoupled = 20;
  constexpr double kCoupling = 0.1, kCross = 0.9, kDelta = 1e-12;
  const Manufactured any = manufactured_problem(2, 200, kContacts, 5);
  const ContactProblem local = local_form(any.problem);
  LawProblem problem(local, Vector(local.W.diagonal()));
  Triplets entries;
  const auto couple = [&](int i, int k, double value) {
    entries.emplace_back(2 * i, 2 * k, value);
    entries.emplace_back(2 * k, 2 * i, value);
  };
  PortableRandom random(3);
  for (int i = 0; i < kContacts; ++i) {
    for (const int k : {0, 1}) entries.emplace_back(2 * i + k, 2 * i + k, 1);
    if (i >= kSliding) {
      for (int k = kSliding; k < i; ++k) couple(i, k, kCoupling / kCore);
      continue;
    }
    for (const int k : {0, 1}) entries.emplace_back(2 * i + k, 2 * i + 1 - k, kCross);
    couple(i, kSliding + i, 0.5);
    for (int k = 0; k < kCoupled; ++k) couple(i, kSliding + random.below(kCore), kCoupling);
  }
  problem.W.setFromTriplets(entries.begin(), entries.end());
  problem.mu.setConstant(1 / kCross);
  LawPoint point = nearest_point(problem, any.s, any.s);
  for (int i = 0; i < kContacts; ++i) {
    point.set(problem, i, i < kSliding ? Cell::kSlipPlus : Cell::kStick);
  }
  CellBasis basis(problem);
  ASSERT_TRUE(basis.factor(point, Vector::Constant(2 * kContacts, kDelta)));
  const Vector g = Vector::LinSpaced(2 * kContacts, -1, 2);
  basis.solve(g, point.value);
  Vector s, u;
  point.impulse(problem, s);
  point.velocity(problem, u);
  EXPECT_LT((u - problem.W * s - kDelta * s - g).norm(), 1e-12 * s.norm());
}

/// A W without symmetry, or in which a contact's two columns have other rows, or one with neither.
TEST(CellBasis, ReadsRowsAndColumnsOfAnyW) {
  const ContactProblem local = local_form(manufactured_problem(2, 20, 40, 5).problem);
  for (const bool skew : {false, true}) {
    for (const bool holes : {false, true}) {
      LawProblem problem(local, Vector(local.W.diagonal()));
      SparseMatrix& W = problem.W;
      if (skew) {
        for (int j = 0; j < W.cols(); ++j) {
          for (SparseMatrix::InnerIterator it(W, j); it; ++it) {
            if (it.row() < j) it.valueRef() *= 1.25;
          }
        }
      }
      if (holes)
        W.prune([](Eigen::Index i, Eigen::Index j, double) { return i == j || (i + j) % 3 != 0; });
      const Vector s = random_numbers(problem.num_rows(), 1);
      LawPoint point = nearest_point(problem, s, W * s + problem.b);
      point.sort_columns(problem);
      const Vector proximal = Vector::LinSpaced(problem.num_rows(), 0.5, 1),
                   g = random_numbers(problem.num_rows(), 2);
      CellBasis basis(problem);
      ASSERT_TRUE(basis.factor(point, proximal));
      Vector x;
      basis.solve(g, x);
      const auto Bx = product(problem, point, proximal, x);
      for (int i = 0; i < problem.num_rows(); ++i) {
        EXPECT_NEAR(static_cast<double>(Bx[to_size(i)]), g[i], 1e-8 * x.norm())
            << skew << holes << i;
      }
    }
  }
}

class CellBases : public testing::TestWithParam<int> {};

// With a proximal term of 1e-9 an error of rounding grows to 1e-7: refined three times it is gone,
// and refining in two parts is the same, bit for bit.
TEST_P(CellBases, RefinedSolutionsMeetTheEquations) {
  const ContactProblem problem = local_form(manufactured_problem(GetParam(), 30, 60, 5).problem);
  const LawProblem law(problem, Vector(problem.W.diagonal()));
  const Vector s = random_numbers(law.num_rows(), 1);
  LawPoint point = nearest_point(law, s, law.W * s + law.b);
  point.sort_columns(law);
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
