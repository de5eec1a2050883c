#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bench/measure/solver_variant.h"
#include "bench/measure/statistics.h"
#include "bench/report/json_output.h"
#include "solvers/solver.h"

namespace bipot {

/// Growth of iterations and time of a solver with the number of disks (Fig. 14 of the paper),
/// shared by `solver_bench` and `bipot paper`.

/// A scene of any size; one step of it is the problem.
struct GrowthScene {
  struct Problem {
    ContactProblem problem;
    int side = 0;
    std::size_t bodies = 0;
  };
  std::string family = "square";  ///< one of target_families() (problem_target.h)
  double mu = 0.3;
  double tilt_degrees = 0;
  double mass_ratio = 1;
  std::uint64_t seed = 1;
};

/// The target of that family and size; of a moving one the step at 0.65 of the run. Throws
/// std::invalid_argument for an unknown family, or numbers that it does not take.
GrowthScene::Problem make_growth_problem(const GrowthScene& scene, int side);
/// The side whose number of disks is nearest to `disks`.
int side_of(const std::string& family, double disks);

/// One solver on one problem at one tolerance, from s = 0.
struct GrowthRow {
  struct Limits {
    double time_limit = kInfinity;  ///< wall seconds of a solve
    int max_iterations = 1000000;
    int threads = 1;
    std::function<bool()> cancelled;  ///< may be empty
  };
  std::string family, method;
  double tol = 0;
  int side = 0;
  std::size_t bodies = 0;
  int contacts = 0;
  SolveStatus status = SolveStatus::kNotRun;
  int iterations = 0;
  ContactError error;
  double setup_seconds = 0, solve_seconds = 0;  ///< wall
};

GrowthRow growth_row(const GrowthScene& scene, const GrowthScene::Problem& problem,
                     const SolverVariant& method, double tol, const GrowthRow::Limits& limits);

/// Rows for several tolerances, in their order. If the solver's iterates do not depend on the
/// tolerance, one solve gives all. A row then ends at the first judged iteration that meets it, and
/// its time is the time until then.
std::vector<GrowthRow> growth_rows(const GrowthScene& scene, const GrowthScene::Problem& problem,
                                   const SolverVariant& method, std::span<const double> tols,
                                   const GrowthRow::Limits& limits);

/// Power laws in the number of disks for one family, method and tolerance.
struct GrowthFit {
  std::string family, method;
  double tol = 0;
  PowerLaw iterations, seconds;
  double least_disks = 0;  ///< smaller problems are left out ("small samples apart")
  int not_met = 0;         ///< number of rows from least_disks on that missed the tolerance
};
/// Fits in order of appearance. Only rows that met their tolerance count; of rows with the same
/// number of disks the last.
std::vector<GrowthFit> fit_growth(std::span<const GrowthRow> rows, double least_disks);

/// As "1.04 ± 0.03 (5 points)", "– (1 point)".
std::string to_text(const PowerLaw& law);
Json to_json(const PowerLaw& law);
Json to_json(const GrowthFit& fit);
Json to_json(const GrowthRow& row);

}  // namespace bipot
