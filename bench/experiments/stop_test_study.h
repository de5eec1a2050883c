#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/measure/reference_solution.h"
#include "bench/measure/solver_variant.h"
#include "bench/measure/test_problem.h"
#include "core/base/types.h"
#include "solvers/solver.h"

namespace bipot {

/// A problem on which stop tests are compared with the true error.
struct StopTestScene {
  std::string name;
  bool dynamic = false;  ///< something slides, flows or strikes; else at rest
  TestProblem given;
};

/// Result for a user who asks for `tol` by one stop test.
struct StopTestRow {
  std::string scene, solver;  ///< names as above
  bool dynamic = false;
  StopTest stop = StopTest::kGuarded;
  double tol = kNaN;
  bool met = false;
  int iterations = 0;
  double velocity = kNaN;  ///< TrueError's                                            [-]
};

struct StopTestOptions {
  std::vector<SolverVariant> solvers;
  std::vector<double> tols;  ///< from loose to tight
  int max_iterations = 30000;
  std::function<bool()> interrupted;  ///< asked between solves; may be empty
};

/// Solves the scene once for each solver, stop test (guarded, raw (42), difference) and tolerance,
/// cold. A test that is not met within the iterations is not met at tighter tolerances either (the
/// solvers' iterates must not depend on the tolerance). Those rows are filled in without a solve.
/// Empty if interrupted.
std::vector<StopTestRow> study_stop_tests(const StopTestScene& scene,
                                          const ReferenceSolution& reference,
                                          const StopTestOptions& options);

/// How well a test's number predicts the velocity error: statistics of error / tol over rows that
/// were met.
struct Prediction {
  int asked = 0, met = 0;
  int too_early = 0;       ///< met rows with error > 10 tol
  int too_late = 0;        ///< met rows with error < tol / 10
  double factor = kNaN;    ///< geometric mean of error / tol
  double spread = kNaN;    ///< exp of the standard deviation of ln(error / tol)
  double smallest = kNaN;  ///< of error / tol
  double largest = kNaN;
  double slope = kNaN;  ///< median exponent of error against tol, one per scene and solver
};
/// Of the wanted rows; empty: of all. Errors of exactly 0 count as too late and stay out of the
/// logarithms; errors that are not finite are left out. A slope needs three met rows of one scene
/// and solver, which must be consecutive.
Prediction predict(const std::vector<StopTestRow>& rows,
                   const std::function<bool(const StopTestRow&)>& wanted = {});

}  // namespace bipot
