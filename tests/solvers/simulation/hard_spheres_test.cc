// Spheres that cost some solvers a hundred times what they cost others: three sizes settle, and
// free pyramids stand. In bipot_tests 12 layers, in bipot_long_tests (BIPOT_LONG_DRIFT) 40.

#include "solvers/solve.h"
#include "tests/support/scene_run.h"
#include "tests/support/scene_text.h"

namespace bipot {
namespace {

constexpr const char* kThreeSizes =
    R"(
dim = 3
materials = ["grain", "wall"]
contact = { mu = 0.8 }
pairs = [{ between = ["grain", "wall"], mu = 0 }]
time = { step = 2e-3, steps = 120 }
solver = { tol = 1e-3 }
walls = [{ point = [0, 0, 0], normal = [1, 0, 0], material = "wall" },
         { point = [0.4067, 0, 0], normal = [-1, 0, 0], material = "wall" },
         { point = [0, 0, 0], normal = [0, 1, 0], material = "wall" },
         { point = [0, 0.285, 0], normal = [0, -1, 0], material = "wall" },
         { point = [0, 0, 0], normal = [0, 0, 1], material = "wall" }]
)"
    "spheres = [{ arrangement = 'random', count = 945, radii = [0.005, 0.01, 0.015], width = 0.4067, "
    "depth = 0.285, spacing = 0, density = 580, material = 'grain' }]\n";

struct CostlyStep {
  double work = 0;  // iterations times contacts
  int step = -1;
  ContactProblem problem;
  Vector start;
};

// Work is counted in iterations over all contacts, those of `auto` in all its stages. A
// factorisation costs hundreds of sweeps, so that none may be needed where sweeps arrive. Those of
// `assor` go both ways.
TEST(HardSpheres, ThreeSizesSettleAtTheCostOfTheBestSolver) {
  const auto scene = scene_of<3>(kThreeSizes);
  std::vector<CostlyStep> costly(4);
  SceneRunOptions<3> options;
  options.on_step = [&](const SceneStep<3>& step) {
    const StepReport<3>& r = step.report;
    CostlyStep& cheapest =
        *std::min_element(costly.begin(), costly.end(),
                          [](const CostlyStep& a, const CostlyStep& b) { return a.work < b.work; });
    const double work = static_cast<double>(r.iterations) * r.contacts;
    if (work > cheapest.work) cheapest = {work, r.step, step.problem, step.start};
    return true;
  };
  State<3> state = initial_state(scene);
  const SceneRun<3> run = run_scene(scene, state, options);
  EXPECT_EQ(run.totals.converged, 120);
  EXPECT_GT(run.totals.max_contacts, 1500);
  int swept = 0;
  for (const CostlyStep& step : costly) {
    const auto solved = [&](const char* solver) {
      return solve(solver, step.problem, {.tol = 1e-3, .max_iterations = 20000, .s0 = step.start});
    };
    const SolveResult chosen = solved("auto");
    EXPECT_TRUE(is_success(chosen.status)) << chosen.message;
    int best = std::numeric_limits<int>::max();
    for (const char* solver : {"pgs", "assor"}) {
      const SolveResult r = solved(solver);
      if (is_success(r.status)) best = std::min(best, r.iterations);
    }
    if (best == std::numeric_limits<int>::max()) continue;  // sweeps alone do not solve it
    ++swept;
    EXPECT_LE(chosen.iterations, 3 * best) << "step " << step.step << ": " << chosen.message;
    for (const char* solver : {"admm", "ipm", "newton"}) {
      EXPECT_FALSE(says(chosen.message, solver)) << chosen.message;
    }
  }
  EXPECT_GE(swept, 3);
}

// A free pyramid of n layers, of k² spheres in layer k from the top: each in the hollow of four.
// With mu = 2 it stands, u = 0. The momentum of the layers 1 to k does not change, so that they
// hand on their weight m g Σ i² = m g k (k + 1) (2k + 1) / 6, to the layer k + 1 or to the ground.
TEST(HardSpheres, AFreePyramidStandsAndHandsOnItsWeight) {
#ifdef BIPOT_LONG_DRIFT
  constexpr int kLayers = 40;
#else
  constexpr int kLayers = 12;
#endif
  const double step = 5e-4;
  const auto scene = scene_of<3>(
      fmt::format("dim = 3\ncontact = {{ mu = 2 }}\ntime = {{ step = {}, steps = 1 }}\n"
                  "solver = {{ tol = 1e-4 }}\nwalls = [{{ point = [0, 0, 0], normal = [0, 0, 1] "
                  "}}]\n[[spheres]]\narrangement = 'pyramid'\nrows = {}\nradius = 0.1\nmass = 3\n",
                  step, kLayers));
  const double weight = 3 * 9.81 * step;  // as an impulse
  const State<3> end = solved_run(scene);
  // In free fall: velocity g h, energy m (g h)² / 2 each.
  for (const Sphere& s : end.bodies) {
    EXPECT_LE(std::hypot(s.v.norm(), s.radius * s.spin.norm()), 1e-3 * 9.81 * step);
  }
  std::vector<double> handed(kLayers + 1, 0);  // to the layer below k
  const auto layer = [&](int body) {           // from the top, 1 to n
    if (body >= static_cast<int>(end.bodies.size())) return kLayers + 1;
    const double height = end.bodies[to_size(body)].x[2] - 0.1;
    return kLayers - static_cast<int>(std::lround(height / (0.1 * std::sqrt(2.0))));
  };
  for (const ContactOutcome<3>& c : end.contacts) {
    const int i = layer(c.contact.i), j = layer(c.contact.j);
    if (i == j) continue;
    const double up = c.s_n * c.contact.n[2] + tangent_vector(c.contact.n, c.s_t)[2];
    handed[to_size(std::min(i, j))] += i < j ? up : -up;
  }
  for (int k = 1; k <= kLayers; ++k) {
    EXPECT_NEAR(handed[to_size(k)] / weight * 6 / (k * (k + 1) * (2 * k + 1)), 1, 1e-3) << k;
  }
}

}  // namespace
}  // namespace bipot
