#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/problem/delassus.h"
#include "solvers/disks/tiled_gradient.h"
#include "solvers/disks/tiled_sweep.h"
#include "solvers/kernels/contact_sweep.h"
#include "solvers/kernels/gradient_iteration.h"
#include "solvers/kernels/spectral_estimate.h"
#include "solvers/solve.h"
#include "tests/support/lattice_problem.h"

namespace bipot {
namespace {

constexpr SimdPath kPaths[] = {SimdPath::kPortable, SimdPath::kAvx2, SimdPath::kAvx512};

ContactProblem packing(int dim, bool square = false, int side = 30) {
  LatticeOptions o{.dim = dim, .tilt = 0.2, .e_n = 0.2, .e_t = dim == 1 ? 0 : 0.7};
  return square ? square_lattice(side, o) : triangular_lattice(side, o);
}

struct Setting {
  ContactProblem problem;
  DelassusOperator delassus;
  ContactScaling scaling;
  explicit Setting(ContactProblem p)
      : problem(std::move(p)),
        delassus(problem),
        scaling(equilibrated_scaling(problem, delassus.diagonal())) {}
  const DiskStructure& disks() const { return *delassus.disks(); }
  Vector zero() const { return Vector::Zero(problem.num_rows()); }
  double largest_eigenvalue() const {
    WholeSpace space(problem);
    return spectral_estimate(space, scaling.velocity);
  }
};

template <int D>
Vector swept(const Setting& at, double omega, const Execution& execution,
             const std::vector<int>& portions) {
  TiledSweep<D> sweep(at.problem, at.disks(), at.scaling, omega, execution);
  sweep.reset(at.zero());
  for (const int sweeps : portions) sweep.advance(sweeps);
  return sweep.impulse();
}

template <int D>
Vector descended(const Setting& at, bool cone, const Execution& execution,
                 const std::vector<int>& portions) {
  TiledGradient<D> gradient(at.problem, at.disks(), at.scaling, execution);
  gradient.reset(at.zero());
  GradientControl control;
  // Too small on purpose: it is raised on the way.
  control.lambda = 0.8 * at.largest_eigenvalue();
  control.cone = cone;
  for (const int iterations : portions) gradient.advance(iterations, control);
  return gradient.impulse();
}

const std::vector<int> kOneByOne(40, 1), kTogether{40}, kMixed{1, 2, 20, 7, 10};

/// Bits, not values: -0 is not 0 and a NaN is itself.
bool same_bits(const Vector& a, const Vector& b) {
  return a.size() == b.size() &&
         std::equal(a.data(), a.data() + a.size(), b.data(),
                    [](double x, double y) { return std::memcmp(&x, &y, sizeof(double)) == 0; });
}

template <int D>
void check_bits() {
  // Of 2, 5 and 7 disks a side many lanes are empty.
  for (const auto& [square, side] : {std::pair(false, 30), std::pair(true, 30), std::pair(true, 2),
                                     std::pair(false, 5), std::pair(true, 7)}) {
    const Setting at(packing(D, square, side));
    const Vector sweep = swept<D>(at, 1, {1, SimdPath::kPortable}, kOneByOne);
    const Vector relaxed = swept<D>(at, 1.5, {1, SimdPath::kPortable}, kOneByOne);
    const Vector split = descended<D>(at, false, {1, SimdPath::kPortable}, kOneByOne);
    const Vector cone = descended<D>(at, true, {1, SimdPath::kPortable}, kOneByOne);
    ASSERT_GT(split.norm(), 0);
    for (const SimdPath path : kPaths) {
      if (!has_path(path)) continue;
      for (int threads = 1; threads <= 4; ++threads) {
        const Execution e{threads, path};
        const std::string where = std::string(to_string(path)) + ", threads " +
                                  std::to_string(threads) + ", side " + std::to_string(side);
        const std::vector<int>& portions = threads % 2 == 0 ? kMixed : kTogether;
        EXPECT_TRUE(same_bits(swept<D>(at, 1, e, portions), sweep)) << where;
        EXPECT_TRUE(same_bits(swept<D>(at, 1.5, e, portions), relaxed)) << where;
        EXPECT_TRUE(same_bits(descended<D>(at, false, e, portions), split)) << where;
        EXPECT_TRUE(same_bits(descended<D>(at, true, e, portions), cone)) << where;
      }
    }
  }
}

TEST(TiledKernels, SameBitsForAllThreadsPathsAndPortionsWithFriction) { check_bits<2>(); }
TEST(TiledKernels, SameBitsForAllThreadsPathsAndPortionsWithoutFriction) { check_bits<1>(); }

// The tiled sweep is a Gauss-Seidel sweep in its own order: the scalar sweep in that order does the
// same to rounding.
TEST(TiledKernels, ATiledSweepIsTheScalarSweepInItsOrder) {
  const Setting at(packing(2));
  const ContactTiles tiles = tile_contacts(at.disks());
  DiskSweep<2> scalar(at.problem, at.disks());
  const Vector diagonal = at.delassus.diagonal();
  scalar.reset(at.zero());
  for (int c = 0; c < at.problem.num_contacts(); ++c) {
    scalar.set_steps(c, Local<2>(1.2 / diagonal[2 * c], 1.2 / diagonal[2 * c + 1]),
                     at.problem.mu[c]);
  }
  const auto num_tiles = static_cast<int>(tiles.tiles.size());
  const auto relax = [&](int tile) {
    const ContactTiles::Tile& at_tile = tiles.tiles[static_cast<std::size_t>(tile)];
    for (int lane = at_tile.first_batch * kLanes; lane < at_tile.last_batch * kLanes; ++lane) {
      const int c = tiles.contact[static_cast<std::size_t>(lane)];
      if (c >= 0) scalar.relax(c);
    }
  };
  for (int sweep = 0; sweep < 20; ++sweep) {
    // From both ends to the middle.
    for (int tile = 0; tile < num_tiles / 2; ++tile) relax(tile);
    for (int tile = num_tiles - 1; tile >= num_tiles / 2; --tile) relax(tile);
  }
  const Vector s = swept<2>(at, 1.2, {}, {20});
  EXPECT_LT((s - scalar.impulse()).norm(), 1e-12 * s.norm());
}

// The same iterates as through the Delassus operator, restarts and raised eigenvalues among them.
TEST(TiledKernels, ATiledGradientStepIsThatOfTheDelassusOperator) {
  for (const bool cone : {false, true}) {
    const Setting at(packing(2, false, 7));
    WholeSpace space(at.problem);
    SpaceSums sums{space};
    GradientIteration<2, SpaceSums> plain(at.problem, sums, at.scaling);
    plain.reset(at.zero());
    GradientControl control{.lambda = 0.8 * at.largest_eigenvalue(), .cone = cone};
    plain.advance(40, control);
    const Vector s = descended<2>(at, cone, {}, {40});
    EXPECT_LT((s - plain.impulse()).norm(), 1e-10 * s.norm()) << cone;
  }
}

// Whole solves. Few iterations: on a busy machine threads wait for each other at every wave.
TEST(TiledKernels, SolversReturnTheSameBitsForAllThreads) {
  const ContactProblem p = packing(2);
  for (const auto& [solver, parameters] :
       std::vector<std::pair<std::string, std::map<std::string, std::string>>>{
           {"pgs", {{"order", "tiled"}, {"omega", "1.7"}}}, {"apgd", {}}}) {
    SolverOptions options{.tol = 1e-6, .max_iterations = 50, .parameters = parameters};
    const SolveResult one = solve(solver, p, options);
    ASSERT_EQ(one.status, SolveStatus::kIterationLimit) << one.message;
    for (options.execution.threads = 2; options.execution.threads <= 4;
         ++options.execution.threads) {
      const SolveResult many = solve(solver, p, options);
      EXPECT_TRUE(same_bits(many.s, one.s)) << solver << options.execution.threads;
      EXPECT_EQ(many.iterations, one.iterations);
    }
  }
}

TEST(TiledKernels, TheTiledOrderNeedsAsManySweepsAsTheGivenOne) {
  for (const bool square : {false, true}) {
    const ContactProblem p = packing(2, square);
    SolverOptions options;
    options.tol = 1e-6;
    const SolveResult given = solve("pgs", p, options);
    options.parameters = {{"order", "tiled"}};
    const SolveResult tiled = solve("pgs", p, options);
    ASSERT_EQ(given.status, SolveStatus::kConverged) << given.message;
    ASSERT_EQ(tiled.status, SolveStatus::kConverged) << tiled.message;
    EXPECT_LT(tiled.iterations, 1.15 * given.iterations) << square;
  }
}

}  // namespace
}  // namespace bipot
