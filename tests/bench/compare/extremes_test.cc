#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "bench/compare/extreme_matrix.h"
#include "bench/compare/extreme_report.h"
#include "bench/compare/isolated_jobs.h"
#include "bench/compare/random_problem.h"
#include "bench/compare/random_sets.h"
#include "bench/measure/independent_check.h"
#include "bench/report/labels.h"
#include "core/criterion/extended_error.h"
#include "tests/support/converged.h"
#include "tests/support/manufactured.h"
#include "tests/support/markup_defect.h"
#include "tests/support/naive_error.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

TEST(IndependentCheck, AgreesWithTheNaiveImplementation) {
  for (int dim = 1; dim <= 3; ++dim) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      Manufactured m = manufactured_problem(dim, 6, 9, seed, 0.6);
      m.problem.W = SparseRows();
      EXPECT_LT(independent_check(m.problem, m.s).guarded, 1e-12) << "d = " << dim;
      // Off the law by about a tenth, also outside of the cones.
      Vector s = m.s;
      for (Eigen::Index i = 0; i < s.size(); ++i) s[i] += 0.1 * std::sin(7.0 * double(i) + seed);
      const IndependentCheck check = independent_check(m.problem, s);
      const NaiveError naive = naive_error(m.problem, s);
      EXPECT_NEAR(check.epsilon, naive.epsilon, 1e-10 * naive.epsilon) << "d = " << dim;
      EXPECT_NEAR(check.eta, naive.eta, 1e-10 * naive.eta) << "d = " << dim;
      EXPECT_GT(check.guarded, 1e-3);
    }
  }
}

TEST(IndependentCheck, JudgesRollingAsTheCriterionDoes) {
  for (const int rows : {3, 6}) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      for (const bool restitution : {false, true}) {
        Manufactured m = manufactured_rolling(rows, 6, 9, seed);
        ContactProblem& p = m.problem;
        if (restitution) {
          p.row_scale = Vector::Constant(p.num_rows(), 1.2);
          for (int c = 0; c < p.num_contacts(); ++c) p.row_scale[c * rows] = 1.3;
        }
        if (seed % 2 == 0) p.W = SparseRows();
        // Off the law by about a tenth, also outside of the cones.
        Vector s = m.s;
        for (Eigen::Index i = 0; i < s.size(); ++i) s[i] += 0.1 * std::sin(7.0 * double(i) + seed);
        const IndependentCheck check = independent_check(p, s);
        const ContactError error = contact_error(p, s);
        EXPECT_NEAR(check.epsilon, error.epsilon, 1e-10 * error.epsilon) << rows << " rows";
        EXPECT_NEAR(check.eta, error.eta, 1e-10 * error.eta) << rows << " rows";
        EXPECT_GT(check.guarded, 1e-3);
        // Other scales are another problem, which m.s does not solve.
        if (restitution) continue;
        EXPECT_LT(independent_check(p, m.s).guarded, 1e-12) << rows << " rows";
      }
    }
  }
}

// Contacts that slide apart at u_n = 0: s = 0 is exact, though ρ û lies on the edge of the polar
// cone.
TEST(IndependentCheck, NoImpulseIsExactWhereContactsOnlySlide) {
  for (int k = 1; k <= 50; ++k) {
    ContactProblem p{
        .dim = 3,
        .W = SparseMatrix(Eigen::MatrixXd((Eigen::Matrix3d::Identity() / 0.7)).sparseView()),
        .u_free = Vec3(0, 0.37 * k, 1.0 / k),
        .mu = Vector::Constant(1, 0.1 + 0.013 * k)};
    EXPECT_EQ(independent_check(p, Vector::Zero(3)).guarded, 0) << k;
  }
}

// A contact of 1 kg and 1 kg m² with s_n = 1, mu_r = 0.2 and the moment m = 0.3. The lever is
// sqrt(W_nn / W_mm) = 1. The nearest point of the cone has s_n = (1 + 0.2 0.3) / (1 + 0.2²).
TEST(IndependentCheck, MovesAMomentBeyondItsBoundToTheNearestPointOfTheCone) {
  const ContactProblem p{.dim = 3,
                         .W = SparseRows(Eigen::MatrixXd::Identity(3, 3).sparseView()),
                         .u_free = Eigen::Vector3d(-1, 0, 0),
                         .mu = Vector::Constant(1, 0.5),
                         .mu_r = Vector::Constant(1, 0.2)};
  const IndependentCheck check = independent_check(p, Eigen::Vector3d(1, 0, 0.3));
  EXPECT_NEAR(check.s[0], 1.06 / 1.04, 1e-15);
  EXPECT_EQ(check.s[1], 0);
  EXPECT_NEAR(check.s[2], 0.2 * 1.06 / 1.04, 1e-15);
  EXPECT_GT(check.guarded, 0.1);
}

TEST(IndependentCheck, TheExtendedErrorThatJudgesLargeFrictionAgrees) {
  for (int dim = 1; dim <= 3; ++dim) {
    for (const double mu : {0.4, 1e6}) {
      const Manufactured m = manufactured_problem(dim, 6, 9, 7, mu);
      Vector s = m.s;
      for (Eigen::Index i = 0; i < s.size(); ++i) s[i] *= 1 + 1e-5 * std::sin(3.0 * double(i));
      const IndependentCheck global = independent_check(m.problem, s);
      const double extended = extended_guarded_error(m.problem, global.s);
      EXPECT_NEAR(extended, independent_check(m.problem, global.s).guarded, 1e-9 * extended)
          << "d = " << dim << ", mu = " << mu;
    }
  }
}

TEST(IndependentCheck, ImpulsesThatPullAreNotOnTheCone) {
  // s_n = -1 at a frictionless contact is put at 0, where u_n = -1 violates the law.
  ContactProblem p = manufactured_problem(1, 2, 2, 1, 0).problem;
  p.u_free.setConstant(-1);
  EXPECT_GT(independent_check(p, Vector::Constant(2, -1.0)).guarded, 0.1);
  EXPECT_TRUE(std::isnan(independent_check(p, Vector::Constant(2, kNaN)).guarded));
}

// One contact of 1 kg, b = -1, s = 1 - δ: ε = 20 δ - 10 δ², see tests/solvers/proved_claim_test.cc.
TEST(IndependentCheck, ConfirmsNoClaimBeyondTheTolerance) {
  const ContactProblem p = delassus_problem(1, Eigen::MatrixXd::Identity(1, 1),
                                            Vector::Constant(1, -1), Vector::Zero(1));
  const double delta = std::ldexp(1.0, -30), epsilon = 20 * delta - 10 * delta * delta;
  const IndependentCheck check = independent_check(p, Vector::Constant(1, 1 - delta));
  EXPECT_NEAR(check.guarded, epsilon, 1e-15 * epsilon);
  EXPECT_TRUE(check.confirms(epsilon * (1 + 1e-12)));
  EXPECT_FALSE(check.confirms(epsilon * (1 - 1e-12)));
  EXPECT_FALSE(IndependentCheck().confirms(1));
}

// 2^-20 - 2^60 + 2^60: 81 digits, which quadruple precision has and extended precision has not.
TEST(IndependentCheck, SeesWhatExtendedPrecisionRoundsAway) {
  const ContactProblem p =
      unit_masses(1, Eigen::RowVector3d(1, -1, 1), Vector::Zero(1), Vector::Zero(3));
  const double large = std::ldexp(1.0, 60), small = std::ldexp(1.0, -20);
  const IndependentCheck check = independent_check(p, Eigen::Vector3d(small, large, large));
  EXPECT_EQ(check.u[0], small);
  EXPECT_EQ(check.u[1], -small);
}

TEST(IsolatedJobs, ACrashAHangAndAnExceptionAreCountedAndTheOthersRun) {
  std::vector<IsolatedJobs::End> ends;
  IsolatedJobs jobs{.count = 6, .seconds = 1};
  jobs.job = [](int k) -> nlohmann::json {
    if (k == 1) std::raise(SIGKILL);
    if (k == 3) std::this_thread::sleep_for(std::chrono::seconds(60));
    if (k == 4) throw std::runtime_error("on purpose");
    return "job " + std::to_string(k);
  };
  jobs.on_end = [&](int, const IsolatedJobs::End& end) { ends.push_back(end); };
  run_isolated(jobs);
  ASSERT_EQ(ends.size(), 6u);
  for (const int k : {0, 2, 5}) {
    EXPECT_EQ(ends[to_size(k)].kind, IsolatedJobs::End::Kind::kDone);
    EXPECT_EQ(ends[to_size(k)].result, "job " + std::to_string(k));
  }
  EXPECT_EQ(ends[1].kind, IsolatedJobs::End::Kind::kCrashed);
  EXPECT_TRUE(says(ends[1].cause, "signal 9"));
  EXPECT_EQ(ends[3].kind, IsolatedJobs::End::Kind::kHung);
  EXPECT_EQ(ends[4].kind, IsolatedJobs::End::Kind::kCrashed);
}

TEST(IsolatedJobs, AnInterruptionEndsThem) {
  int done = 0;
  IsolatedJobs jobs{.count = 100};
  jobs.job = [](int) { return nlohmann::json(); };
  jobs.on_end = [&](int, const IsolatedJobs::End&) { ++done; };
  jobs.interrupted = [&] { return done >= 3; };
  run_isolated(jobs);
  EXPECT_EQ(done, 3);
}

TEST(RandomProblem, IsTheSameEveryTimeAndHoldsWhatItPlants) {
  std::set<std::string> descriptions;
  for (int k = 0; k < 100; ++k) {
    const RandomProblem a = random_problem(5, k), b = random_problem(5, k);
    EXPECT_EQ(a.problem.u_free, b.problem.u_free);
    EXPECT_EQ(validate(a.problem), "") << a.description;
    descriptions.insert(a.description);
    EXPECT_EQ(a.planted.size() > 0, k % 2 == 0);
    if (k % 2 == 0) {
      EXPECT_LT(independent_check(a.problem, a.planted).guarded, 1e-9)
          << k << ": " << a.description;
    }
  }
  EXPECT_GT(descriptions.size(), 90u);
}

/// Next to what double precision can judge, a stage that multiplies by W claims what A and H do not
/// confirm. The race goes on, and a later stage solves the problem.
TEST(RandomProblem, AClaimThatTheRaceDoesNotConfirmIsNotItsEnd) {
  const RandomProblem random = random_problem(1, 601);
  const SolveResult result =
      converged(solve("auto", random.problem, {.tol = 1e-8, .time_limit = 10}));
  EXPECT_LE(independent_check(random.problem, result.s).guarded, 1e-8) << result.message;
}

RandomSets::Options short_set(int count) {
  RandomSets::Options options{
      .count = count, .seed = 20, .time_limit = 0.3, .solvers = solver_names()};
  return options;
}

TEST(RandomSets, NothingIsWrongInAShortOne) {
  const RandomSets result = run_random_problems(short_set(66));
  for (const RandomSets::Finding& f : result.findings) {
    if (f.kind.find("not solved") == std::string::npos) {
      ADD_FAILURE() << f.kind << ' ' << f.index << ' ' << f.solver << ": " << f.message;
    }
  }
  EXPECT_TRUE(result.sound());
  EXPECT_EQ(result.done, 66);
  EXPECT_EQ(result.tallies.front().tried, 66);
  EXPECT_GT(result.tallies.front().planted_solved, 26);  // of 33
  EXPECT_GT(result.certificates, 10);
}

// 44 contacts of 10 bodies without friction, W alone: impulses so large beside the energy that ε in
// double precision was 9.8e-9 where it is 1.6e-8, and auto took it. One of 10 000.
TEST(RandomSets, RoundingOfLargeSelfStressIsNoClaim) {
  RandomSets::Options options = short_set(1);
  options.seed = 1;
  options.first = 4989;
  options.solvers = {"auto", "homotopy"};
  const RandomSets result = run_random_problems(options);
  EXPECT_TRUE(result.sound());
  EXPECT_EQ(result.tallies[0].tried, 1);
  EXPECT_EQ(result.tallies[1].tried, 1);
}

TEST(RandomSets, NothingIsWrongInAFewScenes) {
  const RandomSets result = run_random_scenes(short_set(12));
  for (const RandomSets::Finding& f : result.findings) {
    if (f.kind.find("not solved") == std::string::npos && f.kind != "run ended early") {
      ADD_FAILURE() << f.kind << ' ' << f.index << ": " << f.message;
    }
  }
  EXPECT_TRUE(result.sound());
  EXPECT_EQ(result.energy_grew, 0);
  EXPECT_GT(result.tallies.front().tried, 100);
}

TEST(ExtremeCases, EachSaysWhatItIsAndWhatIsKnown) {
  std::set<std::string> names;
  for (const ExtremeCase& c : extreme_cases()) {
    EXPECT_TRUE(names.insert(c.name).second) << c.name;
    EXPECT_FALSE(c.what.empty()) << c.name;
    EXPECT_FALSE(c.known.empty()) << c.name;
    EXPECT_NE(bool(c.problem), bool(c.scene)) << c.name;
    EXPECT_EQ(bool(c.scene), c.steps > 0) << c.name;
  }
  EXPECT_GT(names.size(), 60u);
}

ExtremeMatrix::Options of(const std::string& name) {
  return ExtremeMatrix::Options{.solvers = {"auto", "pgs"}, .only = name, .time_limit = 0.3};
}

TEST(ExtremeMatrix, KnowsWhatItsCasesAre) {
  const ExtremeMatrix walls = measure_extremes(of("wall_into_row"));
  EXPECT_EQ(walls.cases.front().verdict, Existence::kNone);
  EXPECT_EQ(walls.find("wall_into_row", "auto")->end, ExtremeCell::kNone);
  // By cases: friction jams the wedge, normals alone do not.
  const ExtremeMatrix wedge = measure_extremes(of("wedge_closes"));
  EXPECT_EQ(wedge.cases.front().verdict, Existence::kNone);
  EXPECT_EQ(wedge.find("wedge_closes", "auto")->end, ExtremeCell::kNone);
  const ExtremeMatrix tower = measure_extremes(of("light_on_heavy_1e2"));
  EXPECT_EQ(tower.find("light_on_heavy_1e2", "auto")->end, ExtremeCell::kSolved);
  EXPECT_LT(tower.find("light_on_heavy_1e2", "auto")->true_error, 1e-6);
  // Weights of 1e12 kg in 53 digits: what is lost moves the light disks by more than the tolerance.
  const ExtremeMatrix beyond = measure_extremes(of("heavy_on_light_1e12"));
  EXPECT_GT(beyond.cases.front().floor, 1e-8);
  EXPECT_EQ(beyond.find("heavy_on_light_1e12", "auto")->end, ExtremeCell::kBeyond);
  EXPECT_EQ(measure_extremes(of("coincident_centres")).cells.front().end, ExtremeCell::kRefused);
  EXPECT_THROW(measure_extremes(of("no_such_case")), std::invalid_argument);
}

TEST(ExtremeMatrix, NewtonsLawCreatesEnergyOnlyWhereTheCoefficientsDiffer) {
  const ExtremeMatrix corners = measure_extremes(of("corner_e"));
  for (const ExtremeCell& c : corners.cells) EXPECT_NE(c.end, ExtremeCell::kWrong) << c.name;
  EXPECT_LT(corners.find("corner_e_1_1", "auto")->energy_error, 1e-7);
  EXPECT_LT(corners.find("corner_e_0.5_0.5", "auto")->energy_error, 1e-7);
  EXPECT_GT(corners.find("corner_e_1_0", "auto")->energy_error, 0.01);
}

TEST(ExtremeReport, SaysWhatAutoMissesAndOthersSolve) {
  ExtremeMatrix m = measure_extremes(of("units_usual"));
  EXPECT_TRUE(solved_by_others(m, "units_usual").empty());
  EXPECT_FALSE(says(to_text(m), "missed by auto"));
  for (ExtremeCell& c : m.cells)
    c.end = c.solver == "auto" ? ExtremeCell::kUnsolved : ExtremeCell::kSolved;
  EXPECT_EQ(solved_by_others(m, "units_usual"), std::vector<std::string>{"pgs"});
  EXPECT_TRUE(says(to_text(m), "missed by auto: units_usual: solved by pgs"));
  EXPECT_TRUE(says(to_html(extremes_page(m, {})), "solves: 1."));
  EXPECT_TRUE(says(to_csv(cells_table(m)), ",true,"));
  for (ExtremeCell& c : m.cells) c.end = ExtremeCell::kUnsolved;
  EXPECT_TRUE(solved_by_others(m, "units_usual").empty());
}

TEST(ExtremeReport, EveryCellStandsInTheTableAndThePage) {
  ExtremeMatrix::Options options = of("units_usual");
  options.tol = 1e-6;
  ExtremeMatrix m = measure_extremes(options);
  m.cells.back().end = ExtremeCell::kWrong;
  m.cells.back().message = "a <planted> fault";
  const std::string csv = to_csv(cells_table(m)), text = to_text(m);
  const Document document = extremes_page(m, provenance("extremes", "bipot extremes"));
  const std::string page = to_html(document);
  EXPECT_EQ(markup_defect(page), "");
  const Json json = to_json(document);
  EXPECT_EQ(json["command_line"], "bipot extremes");
  EXPECT_EQ(json["cells"][1]["end"], "wrong");
  EXPECT_EQ(json["cases"][0]["name"], "units_usual");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3);
  EXPECT_TRUE(says(csv, "bipot extremes --only units_usual --solver pgs --tol 1e-6"));
  EXPECT_TRUE(says(page, "a guarded error of " + tolerance_label(1e-6)));
  EXPECT_TRUE(says(text, "wrong: bipot extremes --only units_usual --solver pgs"));
  EXPECT_TRUE(says(page, "a &lt;planted&gt; fault"));
  EXPECT_FALSE(says(page, "a <planted>"));
  EXPECT_TRUE(says(to_markdown(m), "| units | 1/1 | 0/1, 1 wrong |"));
}

}  // namespace
}  // namespace bipot
