#include "bench/compare/popular_settings.h"

#include "bench/compare/settings_report.h"
#include "core/problem/coulomb_cone.h"
#include "solvers/solve.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

TestProblem lattice_problem() {
  return {.origin = "test", .problem = lattice_step(Lattice::kTriangular, 6, 0.3, 10)};
}

SettingStudy::Row run_code(const std::string& code, const TestProblem& problem) {
  const auto& all = popular_settings();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const PopularSetting& s) { return s.code == code; });
  if (found == all.end()) {
    ADD_FAILURE() << code;
    return {};
  }
  return run_popular(*found, problem, nullptr, {.time_limit = 20});
}

// A number of sweeps is that of the solver: its error after as many.
TEST(PopularSettings, SweepsAreThoseOfTheRow) {
  const TestProblem p = lattice_problem();
  const SettingStudy::Row eight = run_code("game engine, 8", p);
  EXPECT_EQ(eight.iterations, 8);
  EXPECT_EQ(eight.end, "most iterations");
  double after_eight = kNaN;
  SolverOptions options{.tol = 1e-14, .max_iterations = 8};
  options.on_iteration = [&](const IterationRecord& r) {
    if (r.iteration == 8) after_eight = r.error.guarded();
  };
  solve("pgs", p.problem, options);
  EXPECT_EQ(eight.error.guarded(), after_eight);
  EXPECT_LT(run_code("game engine, 30", p).error.guarded(), after_eight);
}

// Siconos' test is met at its first iterate within it, and not before.
TEST(PopularSettings, StopsAtTheFirstIterateThatItsOwnTestTakes) {
  const TestProblem p = lattice_problem();
  const SettingStudy::Row row = run_code("Siconos, its benchmark", p);
  ASSERT_EQ(row.end, "test");
  EXPECT_LE(row.own, 1e-2);
  EXPECT_LT(row.iterations, 100);
  EXPECT_GT(row.iterations, 1);
  EXPECT_GT(row.error.guarded(), 0);
  // Tighter tolerances mean smaller errors, and 1e-2 is the setting's own.
  EXPECT_EQ(row.at_tolerance[0], row.error.guarded());
  EXPECT_LT(row.at_tolerance[3], 1e-2 * row.at_tolerance[0]);
}

// LMGC90 looks at its norm every 50 sweeps. An iterate that one sweep makes exact ends the solve: one
// contact that sticks, W = 1, b = (-1, 0.1).
TEST(PopularSettings, LooksAsOftenAsTheCodeDoes) {
  const SettingStudy::Row row = run_code("LMGC90", lattice_problem());
  EXPECT_EQ(row.end, "test");
  EXPECT_EQ(row.iterations % 50, 0);
  const TestProblem p{.origin = "test",
                      .problem = one_contact_problem(2, 1, 1, 0.5, -1, Vector{{0.1}})};
  const SettingStudy::Row one = run_code("LMGC90", p);
  EXPECT_EQ(one.end, "stalled");
  EXPECT_LE(one.error.guarded(), 1e-12);
}

// W = 1, b = (-1, 0): half the way to the solution x = 1 leaves s = V = 1/2, R = 3/4, and the halved
// sums (1/4 + 1)/2 = 5/8. LMGC90's numbers are 0.5 / (5/8)^½ and twice 0.5 · 0.75 / (5/8) = 0.6.
TEST(PopularSettings, TheQuadraticNormIsThatOfTheCode) {
  const TestProblem p{.origin = "test",
                      .problem = one_contact_problem(2, 1, 1, 0.5, -1, Vector{{0}})};
  const PopularSetting half{.solver = "pgs",
                            .parameters = {{"local", "exact"}, {"omega", "0.5"}},
                            .test = PopularSetting::Test::kQuadratic,
                            .tol = 1e-9,
                            .most = 1};
  EXPECT_NEAR(run_popular(half, p, nullptr, {.time_limit = 20}).own, 0.5 / std::sqrt(0.625), 1e-14);
}

// W = 1, b = (-1, -4), mu = 1/2. Chrono's law lifts the block: s = (2.4, 1.2). SCoPI repeats it with
// q = mu |u_t| added: q = 1.4, then (1 - q, 4) is projected, and so on, towards Coulomb's s_n = 1,
// u_t = -3.5, q = 1.75. From one round to the next q - 1.75 changes by the factor
// -mu ds_t/dq = ½ · ½ /(1 + ¼) = 0.2 in size, and |q - q⁻| <= 1e-2 (q + 1) after some rounds.
TEST(PopularSettings, FixedPointsApproachCoulombsLaw) {
  const TestProblem p{.origin = "test",
                      .problem = one_contact_problem(2, 1, 1, 0.5, -1, Vector{{-4}})};
  const SettingStudy::Row chrono = run_code("Chrono", p), scopi = run_code("SCoPI", p);
  EXPECT_GT(chrono.error.guarded(), 0.1);
  EXPECT_EQ(scopi.end, "test");
  EXPECT_LE(scopi.iterations, 6 * 80);
  EXPECT_LT(scopi.error.guarded(), 0.05);
  EXPECT_LT(scopi.at_tolerance[3], 1e-5);
}

TEST(PopularSettings, AStudyHasARowForEachSettingAndProblem) {
  const auto source = [](const std::string& name) {
    return ProblemSource{name, name, [] { return lattice_problem(); }};
  };
  ProblemSource broken{"broken", "broken", [] {
                         TestProblem p = lattice_problem();
                         p.problem.u_free[0] = kNaN;
                         return p;
                       }};
  SettingStudy study =
      study_settings({source("one"), source("two"), broken}, {.time_limit = 5, .overlaps = false});
  EXPECT_TRUE(study.complete);
  EXPECT_EQ(study.rows.size(), 2 * popular_settings().size());
  ASSERT_EQ(study.defects.size(), 1u);
  EXPECT_TRUE(says(study.defects[0], "u_free[0]"));
  for (const SettingStudy::Row& row : study.rows) {
    EXPECT_TRUE(std::isfinite(row.error.guarded())) << row.code;
    EXPECT_TRUE(std::isfinite(row.true_error.velocity)) << row.code;
  }
  EXPECT_TRUE(study.overlaps.empty());
  study.overlaps = {{.code = SettingStudy::Overlap::kExact, .scene = "one", .largest = 0.0123},
                    {.code = "Chrono", .scene = "one", .largest = 0.0456},
                    {.code = SettingStudy::Overlap::kExact, .scene = "two", .largest = 0.0789},
                    {.code = "Chrono", .scene = "two", .end = "bodies left"}};
  const std::string text = to_text(settings_document(study, Provenance{}));
  for (const char* seen : {"two: largest", "4.6e-2", "two, Chrono: bodies left"}) {
    EXPECT_TRUE(says(text, seen)) << seen;
  }
  for (const PopularSetting& setting : popular_settings()) EXPECT_TRUE(says(text, setting.code));
  EXPECT_TRUE(says(text, "natural map (Siconos)"));
}

// A step of a run ends where the setting ends on its problem alone.
TEST(PopularSettings, StepsEndAsTheSettingDoes) {
  const TestProblem p = lattice_problem();
  for (const PopularSetting& setting : popular_settings()) {
    const SettingStudy::Row alone = run_code(setting.code, p);
    const StepSolution step = popular_step_solver(setting, {.time_limit = 20})(p.problem, Vector());
    EXPECT_EQ(step.iterations, alone.iterations) << setting.code;
    EXPECT_EQ(step.error.guarded(), alone.error.guarded()) << setting.code;
    EXPECT_EQ(contact_error(p.problem, step.s).guarded(), alone.error.guarded()) << setting.code;
  }
}

// A lattice at rest need not move: exact steps leave it alone. In the first step, from zero, a sweep
// carries a load one row further up at best, so eight sweeps leave most of 30 rows in free fall, by
// g h² = 2.5e-4 m at least, half a thousandth of the radius 0.5 m.
TEST(PopularSettings, FewSweepsLetAColumnSink) {
  const auto all = popular_overlaps({});
  ASSERT_EQ(all.size(), 3 * (1 + popular_settings().size()));
  std::map<std::string, SettingStudy::Overlap> column;
  for (const SettingStudy::Overlap& o : all) {
    EXPECT_EQ(o.end, "") << o.scene << ", " << o.code;
    EXPECT_LE(o.mean, o.largest);
    if (o.scene == SettingStudy::Overlap::kColumn) column[o.code] = o;
  }
  EXPECT_LT(column.at(SettingStudy::Overlap::kExact).largest, 1e-6);
  EXPECT_GT(column.at("game engine, 8").largest, 5e-4);
  EXPECT_LT(column.at("game engine, 30").largest, column.at("game engine, 8").largest);
  EXPECT_LT(column.at("LMGC90").largest, column.at("game engine, 30").largest);
}

}  // namespace
}  // namespace bipot
