#include "solvers/interior/taylor_path.h"

#include "core/problem/delassus.h"
#include "solvers/interior/equal_product_start.h"
#include "tests/support/manufactured.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(TaylorPath, SeriesOfOneContactIsItsAnalyticPath) {
  // s w = t c, W s + b - w = t p0: W s² + (b - t p0) s - t c = 0.
  const double W = 2, b = -3;
  const ContactProblem p = one_contact_problem(1, W, W, 0, b, Vector());
  const DelassusOperator delassus(p);
  InteriorSystem<1> system(p, delassus, ShiftedDelassus::Form::kAuto);
  const InteriorState<1> start = EqualProductStart{system}.cold(1.0, 10.0);
  const double c = start.X[0] * start.Y[0], p0 = start.p[0];
  TaylorPath<1> path(system, start);
  ASSERT_EQ(path.advance(), PathStep::kAdvanced);
  EXPECT_LT(path.t(), 1);
  for (const double part : {0.05, 0.1, 0.2}) {
    const auto at = path.point(part * path.reach());
    const double linear = b - at.t * p0;
    const double s = (-linear + std::sqrt(linear * linear + 4 * W * at.t * c)) / (2 * W);
    EXPECT_NEAR(at.X[0], s, 1e-12 * s) << part;
    EXPECT_NEAR(at.Y[0], at.t * c / s, 1e-12 * at.t * c / s) << part;
  }
  // The end of the reach is as inaccurate as the tolerance allows, not more accurate by chance.
  const double error =
      std::abs(path.point(path.reach()).X[0] * path.point(path.reach()).Y[0] / (path.t() * c) - 1);
  EXPECT_LE(error, 0.1);
  EXPECT_GT(error, 1e-4);
  // To the solution s = 1.5, w = 0.
  while (path.t() > 1e-14 && path.advance() == PathStep::kAdvanced) continue;
  EXPECT_NEAR(path.state().s[0], 1.5, 1e-10);
  EXPECT_EQ(path.folds(), 0);
}

template <ContactRows D>
void expect_series_accurate() {
  // The points of a series fulfil the path's equations.
  ContactProblem p =
      (D.rolls ? manufactured_rolling(D, 8, 12, 11) : manufactured_problem(D, 8, 12, 11)).problem;
  if (D > 1) p.mu[3] = 0;
  if (D.rolls) p.mu_r[3] = p.mu_r[4] = 0;
  const DelassusOperator delassus(p);
  InteriorSystem<D> system(p, delassus, ShiftedDelassus::Form::kAuto);
  EqualProductStart starts{system};
  const InteriorState<D> start = starts.cold(starts.spring_energy(), 10);
  const Vector c = system.products(start.X, start.Y);
  TaylorPath<D> path(system, start);
  ASSERT_EQ(path.advance(), PathStep::kAdvanced);
  const auto at = path.point(0.3 * path.reach());
  EXPECT_NE(at.t, 1);
  EXPECT_LT((system.products(at.X, at.Y) - at.t * c).norm(), 1e-8 * at.t * c.norm());
  InteriorState<D> z = start;
  z.X = at.X;
  z.Y = at.Y;
  system.recompute(z);
  EXPECT_LT((z.p - at.t * start.p).norm(), 1e-8 * start.p.norm());
}

TEST(TaylorPath, SeriesFulfilThePathsEquationsInEveryDimension) {
  expect_series_accurate<1>();
  expect_series_accurate<2>();
  expect_series_accurate<3>();
  expect_series_accurate<ContactRows(3, true)>();
  expect_series_accurate<ContactRows(6, true)>();
}

TEST(TaylorPath, TangentIsContinuousThroughFolds) {
  // The central path of a free pyramid folds. Between series the tangents continue each other: the
  // path advances in arclength, t turns without jumps.
  const ContactProblem p = lattice_step(Lattice::kPyramid, 20, 0.5, 0);
  const DelassusOperator delassus(p);
  InteriorSystem<2> system(p, delassus, ShiftedDelassus::Form::kAuto);
  EqualProductStart starts{system};
  TaylorPath<2> path(system, starts.cold(starts.spring_energy(), 10));
  int rises = 0, in_a_row = 0, doubts = 0;
  for (int k = 0; k < 150 && path.folds() < 4; ++k) {
    const double t = path.t();
    const auto before = path.state();
    const PathStep step = path.advance();
    ASSERT_NE(step, PathStep::kEnded) << k;
    in_a_row = step == PathStep::kRetracted ? in_a_row + 1 : 0;
    if (in_a_row == 6) ++doubts;  // six halvings: then the tangent is believed
    if (step == PathStep::kRetracted) continue;
    if (path.t() > t) ++rises;
    // A step is short in relative changes: no pair jumps to another branch.
    const double change = ((path.state().X - before.X).array() / before.X.array()).abs().maxCoeff();
    EXPECT_LT(change, 1e3) << k;
    EXPECT_GT(path.state().X.minCoeff(), 0);
    EXPECT_GT(path.state().Y.minCoeff(), 0);
  }
  EXPECT_GE(path.folds(), 2);
  EXPECT_GT(rises, 0) << "t rises beyond a fold";
  EXPECT_LE(doubts, path.folds());
}

TEST(TaylorPath, TakingTurnsChangesNoBit) {
  const ContactProblem p = lattice_step(Lattice::kPyramid, 6, 0.5, 0);
  const DelassusOperator delassus(p);
  InteriorSystem<2> system(p, delassus, ShiftedDelassus::Form::kAuto);
  EqualProductStart starts{system};
  const double energy = starts.spring_energy();
  const InteriorState<2> start = starts.cold(energy, 10);
  TaylorPath<2> whole(system, start), halves(system, start);
  TaylorPath<2> other(system, starts.cold(energy, 1));
  for (int k = 0; k < 10; ++k) whole.advance();
  for (int k = 0; k < 5; ++k) halves.advance();
  for (int k = 0; k < 3; ++k) other.advance();
  for (int k = 0; k < 5; ++k) halves.advance();
  EXPECT_EQ(whole.state().X, halves.state().X);
  EXPECT_EQ(whole.state().Y, halves.state().Y);
  EXPECT_EQ(whole.t(), halves.t());
  EXPECT_NE(whole.state().X, other.state().X);
}

}  // namespace
}  // namespace bipot
