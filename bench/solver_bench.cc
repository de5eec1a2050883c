// Iterations, time and achieved error against the number of particles, one row per (family, solver,
// tolerance, size), as Google Benchmarks. Own flags beside --benchmark_*:
//   --solver=a,b  --family=square,triangular,pyramid,pile  --tol=1e-2,1e-4  --side=10,20,50
//   --mu=0.3  --tilt=10  --mass-ratio=1e6  --time-limit=10  --seed=1  --set=name:value (solver
//   parameter, repeatable)
// A pile of side n has n² disks, settled by a simulation first. A solve that does not converge is
// reported as an error row with its status, never averaged.

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <map>
#include <memory>
#include <numbers>

#include "bench/settled_pile.h"
#include "core/scene_family.h"
#include "core/time_stepping.h"
#include "solvers/registry.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

struct BenchFlags {
  std::vector<std::string> solvers = {"uzawa", "pgs"}, families = {"square", "triangular"};
  std::vector<double> tolerances = {1e-4};
  std::vector<int> sides = {10, 20, 30};
  std::vector<std::string> parameters;
  double mu = 0.3, tilt = 0, mass_ratio = 1, time_limit = 10;
  int seed = 1;
};

struct Problem {
  ContactProblem problem;
  std::size_t disks = 0;
};

/// One step's problem from rest; built once and shared by the rows that use it.
std::shared_ptr<const Problem> make_problem(const BenchFlags& flags, const std::string& family,
                                            int side) {
  static std::map<std::pair<std::string, int>, std::shared_ptr<const Problem>> cache;
  auto& slot = cache[{family, side}];
  if (slot) return slot;
  auto made = std::make_shared<Problem>();
  Scene scene;
  State state;
  if (family == "pile") {
    SettledPile pile = settle_pile(
        {.count = side * side, .mu = flags.mu, .seed = static_cast<std::uint64_t>(flags.seed)});
    scene = std::move(pile.scene);
    state = std::move(pile.state);
    // Gravity leans for this step alone: the pile that was at rest begins to flow.
    scene.gravity = Eigen::Rotation2D<double>(flags.tilt * std::numbers::pi / 180) * scene.gravity;
  } else {
    scene = make_family_scene(family, side,
                              {.mu = flags.mu,
                               .tilt_degrees = flags.tilt,
                               .mass_ratio = flags.mass_ratio,
                               .seed = static_cast<std::uint64_t>(flags.seed)});
    state = initial_state(scene);
  }
  made->disks = scene.disks.size();
  made->problem = step_problem(scene, state, false);
  slot = made;
  return slot;
}

void solve_row(benchmark::State& state, const BenchFlags& flags, const std::string& solver,
               const std::string& family, double tol, int side) {
  const auto shared = make_problem(flags, family, side);
  SolverOptions options;
  options.tol = tol;
  options.time_limit = flags.time_limit;
  for (const std::string& text : flags.parameters) {
    const std::size_t colon = text.find(':');
    options.parameters[text.substr(0, colon)] =
        colon == std::string::npos ? "" : text.substr(colon + 1);
  }
  SolveResult result;
  for (auto _ : state) {
    result = solve(solver, shared->problem, options);
    if (!is_success(result.status)) break;
  }
  const double contacts = shared->problem.num_contacts();
  state.counters["disks"] = static_cast<double>(shared->disks);
  state.counters["contacts"] = contacts;
  state.counters["iterations"] = result.iterations;
  state.counters["epsilon"] = result.error.epsilon;
  state.counters["eta"] = result.error.eta;
  state.counters["natural_map"] = result.error.natural_map;
  state.counters["setup_s"] = result.setup_seconds;
  state.counters["solve_s"] = result.solve_seconds;
  state.counters["ns_per_contact_it"] =
      1e9 * result.solve_seconds / (contacts * std::max(result.iterations, 1));
  if (!is_success(result.status)) {
    state.SkipWithError(fmt::format("{} after {} iterations, error {:.2e}",
                                    to_string(result.status), result.iterations,
                                    result.error.guarded())
                            .c_str());
  }
}

}  // namespace
}  // namespace bipot

int main(int argc, char** argv) {
  using namespace bipot;
  BenchFlags flags;
  CLI::App app{"Solver benchmark: iterations and time against the number of particles"};
  app.allow_extras();
  app.set_help_flag("--help-solver-bench");
  app.add_option("--solver", flags.solvers, "Solvers")->delimiter(',');
  app.add_option("--family", flags.families, "square, triangular, pyramid, random, pile")
      ->delimiter(',');
  app.add_option("--tol", flags.tolerances, "Tolerances of the guarded error")->delimiter(',');
  app.add_option("--side", flags.sides, "Disks along a side; rows of a pyramid")->delimiter(',');
  app.add_option("--set", flags.parameters, "Solver parameter, name:value");
  app.add_option("--mu", flags.mu, "Friction coefficient");
  app.add_option("--tilt", flags.tilt, "Tilt of gravity in degrees");
  app.add_option("--mass-ratio", flags.mass_ratio, "Masses log-uniform in [1, ratio] kg");
  app.add_option("--time-limit", flags.time_limit, "Seconds for one solve");
  app.add_option("--seed", flags.seed, "Seed of the piles");
  CLI11_PARSE(app, argc, argv);

  for (const std::string& family : flags.families) {
    for (const std::string& solver : flags.solvers) {
      for (const double tol : flags.tolerances) {
        for (const int side : flags.sides) {
          const std::string name = fmt::format("{}/{}/{:.0e}/{}", family, solver, tol, side);
          benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) {
            solve_row(state, flags, solver, family, tol, side);
          })->Unit(benchmark::kMillisecond);
        }
      }
    }
  }
  std::vector<std::string> rest = app.remaining();
  std::vector<char*> arguments{argv[0]};
  for (std::string& text : rest) arguments.push_back(text.data());
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
