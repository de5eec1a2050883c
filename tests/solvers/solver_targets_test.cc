// What the solvers are known to reach, at sizes that take minutes. Label "long".

#include "bench/problems/settled_pile.h"
#include "core/scene/scene_family.h"
#include "tests/support/converged.h"

namespace bipot {
namespace {

ContactProblem first_step(const Scene<2>& scene) {
  return step_problem(scene, initial_state(scene));
}

SolverOptions to_tolerance(double tol) { return SolverOptions{.tol = tol, .time_limit = 60}; }

TEST(InteriorPointTargets, SettledPilesTakeAtMost150Iterations) {
  int solved = 0, runs = 0;
  for (const int count : {300, 1000, 3000}) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      for (const double mu : {0.1, 0.3, 0.5}) {
        const SettledPile pile =
            settle_pile({.count = count, .mu = mu, .seed = seed, .rest = 1e-7});
        EXPECT_TRUE(pile.at_rest) << count << " disks, mu " << mu << ", seed " << seed;
        const ContactProblem p = step_problem(pile.scene, pile.state);
        const SolveResult r = solve("ipm", p, to_tolerance(1e-8));
        ++runs;
        solved += is_success(r.status) && r.iterations <= 150 ? 1 : 0;
      }
    }
  }
  EXPECT_EQ(runs, 27);
  EXPECT_GE(solved, 26);
}

TEST(InteriorPointTargets, IterationsHardlyGrowWithTheLattice) {
  for (const char* family : {"square", "triangular"}) {
    for (const char* scale : {"0.1", "1", "10"}) {
      // Least squares: log10 of the iterations against the decade of disks, 10² to 10⁵.
      constexpr int kSides[] = {10, 32, 100, 316};
      double slope = 0;
      for (int decade = 0; decade < 4; ++decade) {
        SolverOptions options = to_tolerance(1e-8);
        options.time_limit = 400;
        options.parameters["start_scale"] = scale;
        const SolveResult r = solve(
            "ipm",
            first_step(make_family_scene(family, kSides[decade], {.mu = 0.3, .tilt_degrees = 10})),
            options);
        ASSERT_TRUE(is_success(r.status))
            << family << kSides[decade] << " x" << scale << ": " << r.message;
        EXPECT_LE(r.iterations, 40) << family << kSides[decade] << " x" << scale;
        slope += (decade - 1.5) * std::log10(r.iterations) / 5;  // 5 = sum of (decade - 1.5)²
      }
      EXPECT_LE(slope, 0.15) << family << " x" << scale;
    }
  }
}

TEST(AutoTargets, FreePyramidsAreSolvedInSeconds) {
  for (const int rows : {10, 20}) {
    for (const double mu : {0.3, 0.5}) {
      SolverOptions options = to_tolerance(1e-8);
      options.time_limit = 10;
      const SolveResult r =
          solve("auto", first_step(make_family_scene("pyramid", rows, {.mu = mu})), options);
      EXPECT_TRUE(is_success(r.status)) << rows << " rows, mu " << mu << ": " << r.message;
    }
  }
}

TEST(AutoTargets, PilesOfTenThousandDisksReach1em7) {
  for (const double mu : {0.3, 0.5}) {
    const SettledPile pile = settle_pile({.count = 10000, .mu = mu, .rest = 1e-7});
    SolverOptions options = to_tolerance(1e-7);
    options.time_limit = 20;
    const SolveResult r =
        converged(solve("auto", step_problem(pile.scene, pile.state), options), mu);
  }
}

}  // namespace
}  // namespace bipot
