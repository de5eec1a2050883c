// Every registered solver on every problem in data/problems: converged at 1e-8, with the errors and
// velocities confirmed by others, or an honest status within the time limit.

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "core/contact_error.h"
#include "core/delassus.h"
#include "core/problem_file.h"
#include "solvers/registry.h"
#include "solvers/solve.h"
#include "tests/naive_error.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> shipped_problems() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(BIPOT_SOURCE_DIR "/data/problems")) {
    if (entry.path().extension() == ".hdf5") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// Problems with several velocity solutions, compared by the errors alone: for each, the test
/// ShippedProblemsEvidence.SeveralVelocitySolutions holds two that obey the law.
const std::set<std::string> kSeveralVelocities = {"2d_pyramid_10", "2d_pyramid_20_mu05"};

class ShippedProblems : public testing::TestWithParam<std::string> {};

TEST_P(ShippedProblems, SolversAgreeOrSayThatTheyFailed) {
  const std::string name = GetParam();
  const ContactProblem p =
      read_problem(BIPOT_SOURCE_DIR "/data/problems/" + name + ".hdf5").problem;
  SolverOptions reference_options;
  reference_options.tol = 1e-11;
  reference_options.time_limit = 20;
  const SolveResult reference = solve("auto", p, reference_options);
  ASSERT_LE(reference.error.guarded(), 1e-9) << reference.message;
  const double scale = std::max(reference.u.norm(), 1e-2 * p.u_free.norm());

  int converged = 0;
  for (const SolverEntry& entry : solver_table()) {
    SCOPED_TRACE(std::string(entry.name));
    SolverOptions options;
    options.tol = 1e-8;
    options.time_limit = 0.5;
    const SolveResult r = solve(entry, p, options);
    if (p.dim > entry.max_dim || p.num_contacts() > entry.max_contacts) {
      EXPECT_EQ(r.status, SolveStatus::kInvalidInput) << r.message;
      continue;
    }
    if (!is_success(r.status)) {
      // Honest: it does not claim the tolerance, and says what it reached.
      EXPECT_NE(r.status, SolveStatus::kNotRun);
      EXPECT_NE(r.status, SolveStatus::kInvalidInput) << r.message;
      EXPECT_FALSE(r.message.empty());
      EXPECT_TRUE(r.s.allFinite());
      continue;
    }
    ++converged;
    const NaiveError naive = naive_error(p, r.s);
    EXPECT_LE(naive.guarded(), options.tol * (1 + 1e-5));
    EXPECT_NEAR(naive.natmap_scaled, r.error.natural_map, 1e-5 * r.error.natural_map + 1e-13);
    if (kSeveralVelocities.contains(name)) continue;
    EXPECT_LT((r.u - reference.u).norm(), 1e-6 * scale) << r.message;
    if (p.has_velocities()) {
      // Per-body resultants are momentum changes: unique where the velocities are.
      const Vector difference = p.H * (r.s - reference.s);
      EXPECT_LT(difference.norm(),
                1e-6 * (p.A * p.v_free).norm() + 1e-6 * (p.H * reference.s).norm());
    }
  }
  EXPECT_GE(converged, 3);
}

std::string test_name(const testing::TestParamInfo<std::string>& parameters) {
  std::string name = parameters.param;
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  return name;
}

INSTANTIATE_TEST_SUITE_P(, ShippedProblems, testing::ValuesIn(shipped_problems()), test_name);

}  // namespace
}  // namespace bipot
