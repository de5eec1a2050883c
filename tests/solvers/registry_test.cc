#include "solvers/registry.h"

#include "solvers/solve.h"
#include "solvers/solve_run.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

std::vector<IterationRecord> history(const SolverEntry& entry, const ContactProblem& p,
                                     double tol) {
  std::vector<IterationRecord> records;
  SolverOptions options{.tol = tol, .max_iterations = 3000};
  options.on_iteration = [&](const IterationRecord& r) { records.push_back(r); };
  solve(entry, p, options);
  return records;
}

/// Whether the iterates to a loose tolerance are the first ones of those to a tight tolerance, bit
/// for bit, as far as the errors tell.
bool begins_alike(const SolverEntry& entry, const ContactProblem& p) {
  const auto loose = history(entry, p, 1e-3), tight = history(entry, p, 1e-9);
  if (loose.empty() || loose.size() > tight.size()) return false;
  for (std::size_t k = 0; k < loose.size(); ++k) {
    if (loose[k].iteration != tight[k].iteration ||
        loose[k].error.epsilon != tight[k].error.epsilon ||
        loose[k].error.eta != tight[k].error.eta ||
        loose[k].error.energy != tight[k].error.energy) {
      return false;
    }
  }
  return true;
}

TEST(Registry, RowsSayWhetherTheirPathIgnoresTheTolerance) {
  const ContactProblem bodies = triangular_lattice(6, {.tilt = 0.1});
  for (const ContactProblem& p : {bodies, local_form(bodies)}) {
    for (const SolverEntry& entry : solver_table()) {
      if (!entry.path_ignores_tolerance || p.num_contacts() > entry.max_contacts) continue;
      EXPECT_TRUE(begins_alike(entry, p)) << entry.name << ", W alone: " << !p.has_velocities();
    }
    // The comparison does see a solver that looks at its tolerance.
    SolverEntry looks = require_solver("pgs");
    looks.run = [](SolveRun& run) {
      SolverOptions own = run.options();
      own.parameters["omega"] = own.tol < 1e-6 ? "1.1" : "1";
      run.take(run.nested(require_solver("pgs"), own));
    };
    EXPECT_FALSE(begins_alike(looks, p));
  }
}

TEST(Registry, RefusesUnknownNamesWithTheNearestOneOrTheBuildOption) {
  EXPECT_EQ(&require_solver("pgs"), find_solver("pgs"));
  const auto refusal = [](std::string_view name) {
    return refusal_of<std::invalid_argument>([&] { require_solver(name); });
  };
  EXPECT_TRUE(says(refusal("apdg"), "apgd"));
  for (const char* optional : {"newton", "siconos:nsgs"}) {
    if (find_solver(optional) != nullptr) continue;
    EXPECT_TRUE(says(refusal(optional), "-DBIPOT_WITH_"));
  }
}

}  // namespace
}  // namespace bipot
