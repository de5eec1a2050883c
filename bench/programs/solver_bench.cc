// Iterations, time and achieved error against the number of particles, one row for each (family,
// solver, tolerance, size), as Google Benchmarks, and the power laws fitted to them (Fig. 14 of the
// paper). Own flags beside --benchmark_*:
//   --solver=a,b  --family=square,triangular,diluted,pyramid,random,pile,pour,collapse,tilt,
//   strike,cannonballs,cubic (the last two of spheres)  --tol=1e-2,1e-4
//   --side=10,20,50 or --sizes=100,1000,10000 (numbers of disks; the nearest side is taken)
//   --mu=0.3  --tilt=10  --mass-ratio=1e6  --time-limit=10  --threads=1  --seed=1  --set=name:value (solver
//   parameter, repeatable)  --fit-from=300 (smaller problems stay out of the fits)
//   --fit-out=FILE (rows and fits as JSON)
// Rows as JSON or CSV: --benchmark_out=FILE --benchmark_out_format=json|csv. A pile of side n has
// n² disks, settled by a simulation first. A moving scene (pour to strike) has n² disks too; its
// step is one of a run that is made once and cached. A solve that does not converge is an error row
// with its status, and is neither averaged nor fitted.

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/command/blas_kernels.h"
#include "bench/measure/iteration_growth.h"
#include "bench/measure/peak_memory.h"
#include "bench/measure/problem_target.h"
#include "bench/report/build_info.h"
#include "bench/report/json_output.h"
#include "core/base/nearest_name.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

struct BenchFlags {
  std::vector<std::string> solvers = {"uzawa", "pgs"}, families = {"square", "triangular"};
  std::vector<double> tolerances = {1e-4};
  std::vector<int> sides = {10, 20, 30};
  std::vector<double> sizes;
  std::vector<std::string> parameters;
  GrowthScene scene;
  GrowthRow::Limits limits = {.time_limit = 10};
  double fit_from = 300;
  std::string fit_out;
};

/// Built once and shared by the rows that use it.
std::shared_ptr<const GrowthScene::Problem> problem_of(const GrowthScene& scene, int side) {
  static std::map<std::pair<std::string, int>, std::shared_ptr<const GrowthScene::Problem>> cache;
  auto& slot = cache[{scene.family, side}];
  if (!slot) slot = std::make_shared<const GrowthScene::Problem>(make_growth_problem(scene, side));
  return slot;
}

void solve_row(benchmark::State& state, const BenchFlags& flags, const GrowthScene& scene,
               const SolverVariant& method, double tol, int side, std::vector<GrowthRow>& rows) {
  const auto problem = problem_of(scene, side);
  GrowthRow row;
  for ([[maybe_unused]] auto _ : state) {
    row = growth_row(scene, *problem, method, tol, flags.limits);
    if (!is_success(row.status)) break;
  }
  // Google Benchmark calls this several times to find its number of iterations.
  const auto before = std::ranges::find_if(rows, [&](const GrowthRow& r) {
    return r.family == row.family && r.method == row.method && r.tol == row.tol &&
           r.side == row.side;
  });
  if (before == rows.end()) {
    rows.push_back(row);
  } else {
    *before = row;
  }
  state.counters["disks"] = static_cast<double>(row.bodies);
  state.counters["contacts"] = row.contacts;
  state.counters["iterations"] = row.iterations;
  state.counters["epsilon"] = row.error.epsilon;
  state.counters["eta"] = row.error.eta;
  state.counters["natural_map"] = row.error.natural_map;
  state.counters["peak_MB"] = 1e-6 * peak_memory();  // of the process, so far
  state.counters["setup_s"] = row.setup_seconds;
  state.counters["solve_s"] = row.solve_seconds;
  state.counters["ns_per_contact_it"] =
      1e9 * row.solve_seconds / (static_cast<double>(row.contacts) * std::max(row.iterations, 1));
  if (!is_success(row.status)) {
    state.SkipWithError(fmt::format("{} after {} iterations, error {:.2e}", to_string(row.status),
                                    row.iterations, row.error.guarded())
                            .c_str());
  }
}

void report_fits(const BenchFlags& flags, const std::vector<GrowthRow>& rows, std::FILE* out) {
  const std::vector<GrowthFit> fits = fit_growth(rows, flags.fit_from);
  fmt::print(out, "\nExponents in the number of bodies, 95 % confidence, from {:g} bodies on\n",
             flags.fit_from);
  fmt::print(out, "{:<11} {:<10} {:>6}  {:<24}  {:<24}  {}\n", "family", "solver", "tol",
             "iterations", "time", "not met");
  for (const GrowthFit& fit : fits) {
    fmt::print(out, "{:<11} {:<10} {:>6.0e}  {:<24}  {:<24}  {}\n", fit.family, fit.method, fit.tol,
               to_text(fit.iterations), to_text(fit.seconds), fit.not_met);
  }
  if (flags.fit_out.empty()) return;
  const BuildInfo build = build_info();
  Json json{{"program", {{"version", build.version}, {"commit", build.commit}}},
            {"machine", {{"cpu", build.cpu}, {"cores", build.cores}}},
            {"mu", flags.scene.mu},
            {"tilt_degrees", flags.scene.tilt_degrees},
            {"mass_ratio", flags.scene.mass_ratio},
            {"seed", flags.scene.seed},
            {"time_limit", flags.limits.time_limit},
            {"fits", json_list(fits, [](const auto& fit) { return to_json(fit); })},
            {"rows", json_list(rows, [](const auto& row) { return to_json(row); })}};
  write_json(json, flags.fit_out);
}

void add_options(CLI::App& app, BenchFlags& flags) {
  app.allow_extras();  // Google Benchmark's own
  app.set_help_flag("--help,-h", "Print these flags and Google Benchmark's");
  app.add_option("--solver", flags.solvers, "Solvers")->delimiter(',');
  app.add_option(
         "--family", flags.families,
         "square, triangular, diluted, pyramid, random, pile, pour, collapse, tilt, strike, "
         "and of spheres cannonballs, cubic")
      ->delimiter(',');
  app.add_option("--tol", flags.tolerances, "Tolerances of the guarded error")->delimiter(',');
  CLI::Option* side =
      app.add_option("--side", flags.sides, "Bodies along a side; rows of a pyramid")
          ->delimiter(',')
          ->check(CLI::PositiveNumber);
  app.add_option("--sizes", flags.sizes, "Numbers of bodies; the nearest side is taken")
      ->delimiter(',')
      ->check(CLI::PositiveNumber)
      ->excludes(side);
  app.add_option("--set", flags.parameters, "Solver parameter, name:value");
  app.add_option("--mu", flags.scene.mu, "Friction coefficient");
  app.add_option("--tilt", flags.scene.tilt_degrees, "Tilt of gravity in degrees");
  app.add_option("--mass-ratio", flags.scene.mass_ratio, "Masses log-uniform in [1, ratio] kg");
  app.add_option("--time-limit", flags.limits.time_limit, "Seconds for one solve");
  app.add_option("--threads", flags.limits.threads, "Threads of the solver")
      ->check(CLI::PositiveNumber);
  app.add_option("--seed", flags.scene.seed, "Seed of masses, gaps and piles");
  app.add_option("--fit-from", flags.fit_from, "Fewest bodies of a problem that enters the fits");
  app.add_option("--fit-out", flags.fit_out, "Rows and fits as JSON")->type_name("FILE");
}

/// A benchmark for each family, solver, tolerance and side; they store their results in `rows`.
/// Throws std::invalid_argument for unknown families and solvers.
void register_rows(const BenchFlags& flags, std::vector<GrowthRow>& rows) {
  SolverVariant method;
  for (const std::string& text : flags.parameters) {
    const std::size_t colon = text.find(':');
    method.parameters[text.substr(0, colon)] =
        colon == std::string::npos ? "" : text.substr(colon + 1);
  }
  require_solvers(flags.solvers);
  const std::vector<std::string> valid = target_families();
  for (const std::string& family : flags.families) {
    require_name("family", family, valid);
    GrowthScene scene = flags.scene;
    scene.family = family;
    std::vector<int> sides = flags.sides;
    if (!flags.sizes.empty()) sides.clear();
    for (const double disks : flags.sizes) sides.push_back(side_of(family, disks));
    for (const std::string& solver : flags.solvers) {
      method.label = method.solver = solver;
      for (const double tol : flags.tolerances) {
        for (const int n : sides) {
          const std::string name = fmt::format("{}/{}/{:.0e}/{}", family, solver, tol, n);
          benchmark::RegisterBenchmark(name.c_str(), [=, &flags, &rows](benchmark::State& state) {
            solve_row(state, flags, scene, method, tol, n, rows);
          })->Unit(benchmark::kMillisecond);
        }
      }
    }
  }
}

}  // namespace
}  // namespace bipot

int main(int argc, char** argv) {
  bipot::take_kernels_of_this_processor(argv);
  using namespace bipot;
  BenchFlags flags;
  CLI::App app{"Solver benchmark: iterations and time against the number of particles"};
  add_options(app, flags);
  std::vector<GrowthRow> rows;
  try {
    app.parse(argc, argv);
    register_rows(flags, rows);
  } catch (const CLI::CallForHelp& e) {
    app.exit(e);
    fmt::print("\nFlags of Google Benchmark:\n");
    std::fflush(stdout);
    benchmark::PrintDefaultHelp();
    return 0;
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  } catch (const std::invalid_argument& e) {
    fmt::print(stderr, "solver_bench: {}\n", e.what());
    return 2;
  }
  std::vector<std::string> rest = app.remaining();
  // Readers of standard output must get the rows alone.
  const bool console = std::ranges::none_of(rest, [](const std::string& text) {
    return text.starts_with("--benchmark_format=") && text != "--benchmark_format=console";
  });
  std::vector<char*> arguments{argv[0]};
  for (std::string& text : rest) arguments.push_back(text.data());
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  try {
    if (!rows.empty()) report_fits(flags, rows, console ? stdout : stderr);
  } catch (const std::exception& e) {
    fmt::print(stderr, "solver_bench: {}\n", e.what());
    return 4;
  }
  return 0;
}
