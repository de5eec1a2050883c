#include "bench/measure/iteration_growth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/measure/moving_problems.h"
#include "bench/measure/problem_target.h"
#include "bench/problems/sphere_problems.h"
#include "solvers/registry.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

double disks_of(const std::string& family, int side) {
  const double n = side;
  const auto one_of = [&](const std::vector<std::string>& names) {
    return std::ranges::find(names, family) != names.end();
  };
  if (family == "pyramid") return n * (n + 1) / 2;
  if (one_of(sphere_family_names())) return spheres_in(family, side);
  if (one_of(moving_families())) return bodies_in(family, side);
  const double triangular = n * n - std::floor(n / 2);  // every second row has one disk less
  if (family == "triangular") return triangular;
  if (family == "diluted") return 0.9 * triangular;
  return n * n;
}

SolverOptions options_of(const SolverVariant& method, double tol, const GrowthRow::Limits& limits) {
  return {.tol = tol,
          .max_iterations = limits.max_iterations,
          .time_limit = limits.time_limit,
          .execution = {.threads = limits.threads},
          .parameters = method.parameters,
          .cancelled = limits.cancelled};
}

GrowthRow empty_row(const GrowthScene& scene, const GrowthScene::Problem& problem,
                    const SolverVariant& method, double tol) {
  return {.family = scene.family,
          .method = method.label,
          .tol = tol,
          .side = problem.side,
          .bodies = problem.bodies,
          .contacts = problem.problem.num_contacts()};
}

void fill(GrowthRow& row, const SolveResult& result) {
  row.status = result.status;
  row.iterations = result.iterations;
  row.error = result.error;
  row.setup_seconds = result.setup_seconds;
  row.solve_seconds = result.solve_seconds;
}

}  // namespace

GrowthScene::Problem make_growth_problem(const GrowthScene& scene, int side) {
  const GrowthScene usual;
  std::string target =
      fmt::format("{}:{}:mu={}:tilt={}", scene.family, side, scene.mu, scene.tilt_degrees);
  if (scene.mass_ratio != usual.mass_ratio) target += fmt::format(":ratio={}", scene.mass_ratio);
  if (scene.seed != usual.seed) target += fmt::format(":seed={}", scene.seed);
  TestProblem made = expand_targets({target}, {.scene_problems = 1}).front().load();
  return {std::move(made.problem), side, made.bodies};
}

int side_of(const std::string& family, double disks) {
  int side = 1;
  while (disks_of(family, side) < disks) ++side;
  const double above = disks_of(family, side), below = disks_of(family, side - 1);
  return side > 1 && disks - below < above - disks ? side - 1 : side;
}

GrowthRow growth_row(const GrowthScene& scene, const GrowthScene::Problem& problem,
                     const SolverVariant& method, double tol, const GrowthRow::Limits& limits) {
  GrowthRow row = empty_row(scene, problem, method, tol);
  fill(row, solve(method.solver, problem.problem, options_of(method, tol, limits)));
  return row;
}

std::vector<GrowthRow> growth_rows(const GrowthScene& scene, const GrowthScene::Problem& problem,
                                   const SolverVariant& method, std::span<const double> tols,
                                   const GrowthRow::Limits& limits) {
  std::vector<GrowthRow> rows;
  if (!require_solver(method.solver).path_ignores_tolerance) {
    for (const double tol : tols) rows.push_back(growth_row(scene, problem, method, tol, limits));
    return rows;
  }
  for (const double tol : tols) rows.push_back(empty_row(scene, problem, method, tol));
  SolverOptions options = options_of(method, *std::ranges::min_element(tols), limits);
  options.on_iteration = [&rows](const IterationRecord& record) {
    for (GrowthRow& row : rows) {
      if (row.status != SolveStatus::kNotRun || !(record.error.guarded() <= row.tol)) continue;
      row.status = SolveStatus::kConverged;
      row.iterations = record.iteration;
      row.error = record.error;
      row.solve_seconds = record.seconds;
    }
  };
  const SolveResult result = solve(method.solver, problem.problem, options);
  for (GrowthRow& row : rows) {
    if (row.status == SolveStatus::kConverged) {
      // The record's clock starts before the set-up.
      row.setup_seconds = std::min(result.setup_seconds, row.solve_seconds);
      row.solve_seconds -= row.setup_seconds;
    }
    if (row.status == SolveStatus::kNotRun || row.tol == options.tol) fill(row, result);
  }
  return rows;
}

std::vector<GrowthFit> fit_growth(std::span<const GrowthRow> rows, double least_disks) {
  std::vector<GrowthFit> fits;
  std::vector<std::map<std::size_t, const GrowthRow*>> members;
  for (const GrowthRow& row : rows) {
    std::size_t k = 0;
    while (k < fits.size() && (fits[k].family != row.family || fits[k].method != row.method ||
                               fits[k].tol != row.tol)) {
      ++k;
    }
    if (k == fits.size()) {
      fits.push_back(
          {.family = row.family, .method = row.method, .tol = row.tol, .least_disks = least_disks});
      members.emplace_back();
    }
    if (static_cast<double>(row.bodies) >= least_disks) members[k][row.bodies] = &row;
  }
  for (std::size_t k = 0; k < fits.size(); ++k) {
    std::vector<double> disks, iterations, seconds;
    for (const auto& [count, row] : members[k]) {
      if (!is_success(row->status)) {
        ++fits[k].not_met;
        continue;
      }
      disks.push_back(static_cast<double>(count));
      iterations.push_back(row->iterations);
      seconds.push_back(row->setup_seconds + row->solve_seconds);
    }
    fits[k].iterations = fit_power_law(disks, iterations);
    fits[k].seconds = fit_power_law(disks, seconds);
  }
  return fits;
}

std::string to_text(const PowerLaw& law) {
  const std::string points = fmt::format("{} point{}", law.points, law.points == 1 ? "" : "s");
  if (!std::isfinite(law.exponent)) return fmt::format("– ({})", points);
  if (!std::isfinite(law.confidence)) return fmt::format("{:.2f} ({})", law.exponent, points);
  return fmt::format("{:.2f} ± {:.2f} ({})", law.exponent, law.confidence, points);
}

Json to_json(const PowerLaw& law) {
  return {{"exponent", law.exponent},
          {"confidence_95", law.confidence},
          {"prefactor", law.prefactor},
          {"points", law.points}};
}

Json to_json(const GrowthFit& fit) {
  return {{"family", fit.family},
          {"method", fit.method},
          {"tol", fit.tol},
          {"least_disks", fit.least_disks},
          {"not_met", fit.not_met},
          {"iterations", to_json(fit.iterations)},
          {"seconds", to_json(fit.seconds)}};
}

Json to_json(const GrowthRow& row) {
  Json json{{"family", row.family},
            {"method", row.method},
            {"tol", row.tol},
            {"side", row.side},
            {"disks", row.bodies},
            {"contacts", row.contacts},
            {"status", to_string(row.status)},
            {"iterations", row.iterations},
            {"setup_seconds", row.setup_seconds},
            {"solve_seconds", row.solve_seconds}};
  add_error(json, row.error);
  return json;
}

}  // namespace bipot
