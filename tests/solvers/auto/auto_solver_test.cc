#include "solvers/auto/auto_solver.h"

#include "core/criterion/rounding_bound.h"
#include "core/motion/time_stepping.h"
#include "core/scene/scene_family.h"
#include "solvers/auto/auto_plan.h"
#include "solvers/solve_run.h"
#include "tests/support/converged.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/manufactured.h"
#include "tests/support/scene_text.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

std::vector<AutoStage> planned(const ContactProblem& p, bool warm = false, double tol = 1e-8) {
  SolverOptions options{.tol = tol, .parameters = {{"forces", "spread"}}};
  if (warm) options.s0 = Vector::Ones(p.num_rows());
  return plan_stages(shipped_plan(), traits_of(p, DelassusOperator(p), options));
}

/// Those that have their turn after an error a little above the tolerance.
std::vector<AutoStage> serving(const ContactProblem& p, bool warm, double tol) {
  std::vector<AutoStage> stages = planned(p, warm, tol);
  std::erase_if(stages, [&](const AutoStage& stage) { return 2 * tol > stage.largest_error; });
  return stages;
}

/// The first stage of a solver.
auto stage_of(const std::vector<AutoStage>& stages, std::string_view solver) {
  return std::find_if(stages.begin(), stages.end(),
                      [&](const AutoStage& stage) { return stage.solver->name == solver; });
}

void expect_stage(const AutoStage& stage, std::string_view solver, AutoStage::Start start) {
  EXPECT_EQ(stage.solver->name, solver);
  EXPECT_EQ(stage.start, start);
}

bool takes(const AutoStage& stage, std::string_view parameter) {
  return stage.parameters.find(parameter) != std::string_view::npos;
}

/// `auto` on a shipped problem, which it must solve.
SolveResult auto_solves(const char* file, double tol) {
  return converged(solve("auto", shipped_file(file), {.tol = tol}), file);
}

ContactProblem first_step(const char* family, int side) {
  const Scene<2> scene = make_family_scene(family, side);
  return step_problem(scene, initial_state(scene));
}

TEST(AutoSolver, ExplainsEveryStageInALine) {
  const ContactProblem p = shipped_file("2d_pyramid_10.hdf5");
  const std::string text = explain_auto(p, {.parameters = {{"forces", "spread"}}});
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'),
            static_cast<std::ptrdiff_t>(planned(p).size()) + 2);
  EXPECT_TRUE(says(text, "145 contacts"));
  EXPECT_TRUE(says(explain_auto(p, {.tol = 1.5e-3}), "tolerance 1.5e-3"));
}

TEST(AutoSolver, UnequalMassesBeginWithFactorisations) {
  EXPECT_EQ(planned(shipped_file("2d_triangular_12_mass1e6.hdf5")).front().solver->name, "ipm");
  EXPECT_NE(planned(shipped_file("2d_triangular_lattice.hdf5")).front().solver->name, "ipm");
}

TEST(AutoSolver, GivesUpWhatDoesNotPromiseAndSolvesAllTheSame) {
  // Neither Anderson nor apgd get this pyramid to 1e-8 within 30 000 and 170 000 iterations.
  const SolveResult result = auto_solves("2d_pyramid_10.hdf5", 1e-8);
  EXPECT_LE(result.error.guarded(), 1e-8);
  EXPECT_TRUE(says(result.message, "assor 64: given up"));
  EXPECT_LT(result.iterations, 20000);
}

/// Within a decade of the tolerance Anderson is let go on for a while, not to the end of its
/// budget.
TEST(AutoSolver, AndersonHasPatienceNearTheToleranceAndNoMore) {
  // Given by W alone: no disks, which begin with other sweeps.
  SolverEntry by_w = *find_solver("auto");
  by_w.run = [](SolveRun& run) { plan_solver(shipped_plan()).run(run, Vector()); };
  const SolveResult slow =
      converged(solve(by_w, local_form(shipped_file("2d_pyramid_20_mu05.hdf5")), {.tol = 0.3}));
  EXPECT_TRUE(says(slow.message, "anderson 64: given up"));
  const SolveResult quick = solve("auto", shipped_file("2d_pour300_392.hdf5"), {.tol = 0.03});
  EXPECT_FALSE(says(quick.message, "given up")) << quick.message;
}

/// Small packings: sweeps within a decade of a loose tolerance go on for 120 iterations, then they
/// must promise to arrive.
TEST(AutoSolver, SweepsNearALooseToleranceHavePatienceAndNoMore) {
  EXPECT_TRUE(says(auto_solves("2d_pyramid_20_mu05.hdf5", 0.3).message, "assor 126: given up"));
}

/// Above 2500 contacts splitting makes the start of paths, below momentum. Where these do not
/// arrive, the next begins a little off where the last one ended, then one from what a multiple of
/// the caller's impulse leads to.
TEST(AutoSolver, PathsThatDoNotArriveAreFollowedByOthersFromElsewhere) {
  for (const int side : {28, 36}) {  // 2268 and 3780 contacts or so
    const ContactProblem p = first_step("triangular", side);
    ASSERT_EQ(p.num_contacts() > 2500, side == 36);
    const std::vector<AutoStage> stages = planned(p, true);
    // After the one of few pivots that follows the first sweeps.
    const auto first = std::find_if(stages.begin(), stages.end(), [&](const AutoStage& stage) {
      return stage.solver->name == "homotopy" && stage.max_iterations > p.num_contacts();
    });
    ASSERT_GE(stages.end() - first, 5);
    EXPECT_EQ(first[-1].solver->name, side == 36 ? "admm" : "apgd");
    EXPECT_EQ(first->start, AutoStage::Start::kBest);
    EXPECT_EQ(first->of_start, 1);
    expect_stage(first[1], "homotopy", AutoStage::Start::kLast);
    EXPECT_NEAR(first[1].of_start, 1, 0.2);
    EXPECT_NE(first[1].of_start, 1);
    // Up to 2500 contacts paths have four pivots a contact, then two.
    const int n = p.num_contacts();
    EXPECT_EQ(first->max_iterations, side == 36 ? 2 * n : 4 * n);
    EXPECT_EQ(first[1].max_iterations, first->max_iterations);
    expect_stage(first[2], side == 36 ? "admm" : "apgd", AutoStage::Start::kCaller);
    EXPECT_LT(first[2].of_start, 0.9);
    expect_stage(first[3], "homotopy", AutoStage::Start::kLast);
    EXPECT_EQ(first[3].of_start, 1);
    if (side == 28) continue;
    // Splitting with more patience, from the caller's impulse, and paths from where that ended.
    const auto patient = std::find_if(first, stages.end(), [&](const AutoStage& stage) {
      return stage.solver->name == "admm" && stage.start == AutoStage::Start::kCaller &&
             stage.of_start == 1 && stage.max_iterations > first[-1].max_iterations;
    });
    ASSERT_GE(stages.end() - patient, 2);
    expect_stage(patient[1], "homotopy", AutoStage::Start::kLast);
  }
}

/// The second stage of apgd starts from half the caller's impulse, as apgd alone does from there.
TEST(AutoSolver, AStageStartsFromAMultipleOfTheCallersImpulse) {
  const ContactProblem p = shipped_file("2d_pour300_392.hdf5");
  SolverOptions options{.tol = 1e-15, .max_iterations = 10};  // out of reach: all stages come
  const Vector start = solve("pgs", p, options).s;
  options.s0 = start;
  options.max_iterations = 12000;
  SolverOptions race_alone = options;
  race_alone.islands = false;
  const std::string stages = run_solver(*find_solver("auto"), p, race_alone).message;
  options.max_iterations = 2000;
  const auto ends = [&](double multiple) {
    options.s0 = multiple * start;
    return fmt::format("apgd 2000: iteration limit ({:.1e})",
                       solve("apgd", p, options).error.guarded());
  };
  EXPECT_TRUE(says(stages, ends(0.5))) << ends(0.5) << '\n' << stages;
  EXPECT_FALSE(says(stages, ends(1))) << stages;
}

int stages_of(const ContactProblem& p, std::string_view solver) {
  const std::vector<AutoStage> stages = planned(p);
  return static_cast<int>(std::count_if(stages.begin(), stages.end(), [&](const AutoStage& stage) {
    return stage.solver->name == solver;
  }));
}

/// Above 4000 contacts, at tolerances such as 1e-3: splitting from several starts, each with a
/// short path from where it ends, comes before long paths, long splitting after them. From 0 there
/// are no multiples to start from.
TEST(AutoSolver, LargePackingsGoFromSomeSplittingToPathsWhereTheToleranceIsFair) {
  const ContactProblem p = lattice_step(Lattice::kTriangular, 40, 0.3, 10);
  ASSERT_GT(p.num_contacts(), 4000);
  for (const bool warm : {false, true}) {
    constexpr int kShort = 1000;
    int before = 0, after = 0, paths = 0;  // iterations of admm, pivots of long paths between them
    int short_paths = 0;
    std::set<double> multiples, kicks;
    bool after_splitting = false;
    for (const AutoStage& stage : serving(p, warm, 1e-3)) {
      const bool path = stage.solver->name == "homotopy", is_short = stage.max_iterations < kShort;
      if (path && is_short) {
        EXPECT_TRUE(after_splitting && stage.start == AutoStage::Start::kLast);
        ++short_paths;
      }
      if (path && !is_short && after == 0) paths += stage.max_iterations;
      after_splitting = stage.solver->name == "admm" && stage.start == AutoStage::Start::kCaller;
      if (stage.solver->name != "admm") continue;
      (paths == 0 ? before : after) += stage.max_iterations;
      if (paths != 0) continue;
      (stage.start == AutoStage::Start::kCaller ? multiples : kicks).insert(stage.of_start);
    }
    EXPECT_GE(before, 3 * 1500) << warm;
    EXPECT_LE(before, warm ? 20000 : 5000);
    EXPECT_EQ(multiples.size(), warm ? 4U : 1U);
    EXPECT_GE(kicks.size(), 2U);
    EXPECT_EQ(kicks.count(1), 0U);
    EXPECT_GE(paths, 20000) << warm;
    EXPECT_GE(after, 6000) << warm;
    EXPECT_EQ(to_size(short_paths), multiples.size());
  }
}

/// At such tolerances short paths come before the long ones, up to 12 000 contacts.
TEST(AutoSolver, ShortPathsComeBeforeLongOnesAtFairTolerances) {
  for (const int rows : {40, 50, 70}) {
    const ContactProblem p = lattice_step(Lattice::kTriangular, rows, 0.3, 10);
    SCOPED_TRACE(p.num_contacts());
    int short_paths = 0, long_paths = 0;
    for (const AutoStage& stage : serving(p, true, 1e-3)) {
      if (stage.solver->name == "admm" && stage.max_iterations > 6000)
        break;  // all that comes after
      if (stage.solver->name != "homotopy") continue;
      (stage.max_iterations < 1000 ? short_paths : long_paths) += 1;
    }
    EXPECT_EQ(short_paths, p.num_contacts() <= 12000 ? 4 : 0);
    EXPECT_EQ(long_paths, 2);
  }
}

/// To tight tolerances: a path from the best impulse follows splitting, beyond 8000 contacts only
/// from a small error, and else factorisations. Then some from a little off where the last came
/// nearest.
TEST(AutoSolver, LargePackingsFollowKickedPathsWhereTheToleranceIsTight) {
  for (const int side : {40, 60}) {
    const ContactProblem p = lattice_step(Lattice::kTriangular, side, 0.3, 10);
    ASSERT_EQ(p.num_contacts() <= 8000, side == 40);
    const std::vector<AutoStage> stages = serving(p, false, 1e-6);
    auto first = stage_of(stages, "homotopy");
    ASSERT_NE(first, stages.begin());
    EXPECT_EQ(first[-1].solver->name, "admm");
    if (side == 60) {
      EXPECT_EQ(first->start, AutoStage::Start::kBest);
      EXPECT_EQ(first->largest_error, 0.002);
      EXPECT_EQ(first[1].solver->name, "ipm");
      first += 2;
    }
    EXPECT_EQ(first->largest_error, 0.5);
    EXPECT_EQ(first->start, AutoStage::Start::kBest);
    EXPECT_EQ(first->of_start, 1);
    const int count = side == 40 ? 1 : 3;
    std::set<double> kicks;
    for (int k = 1; k <= count; ++k) {
      expect_stage(first[k], "homotopy", AutoStage::Start::kLast);
      EXPECT_NEAR(first[k].of_start, 1, 0.2);
      kicks.insert(first[k].of_start);
    }
    EXPECT_EQ(kicks.size(), to_size(count));
    EXPECT_EQ(kicks.count(1), 0U);
  }
}

/// Given W alone: in the plane a path follows the first sweeps, up to 1000 contacts; in space few
/// contacts have a dozen factorisations next. PETSc, whose start takes longer than most solves, comes
/// late.
TEST(AutoSolver, GivenWAloneExactAnswersComeSecond) {
  const auto second = [](const ContactProblem& p) {
    return std::string(serving(p, false, 1e-6).at(1).solver->name);
  };
  for (const char* name : {"2d_tilt12_320.hdf5", "2d_triangular_20_tilt10.hdf5"}) {
    const ContactProblem p = local_form(shipped_file(name));
    ASSERT_GT(p.num_contacts(), 100);
    EXPECT_EQ(second(p) == "homotopy", p.num_contacts() <= 1000) << name;
  }
  const ContactProblem few = manufactured_problem(3, 20, 40, 1).problem;
  EXPECT_EQ(second(local_form(few)), "ipm");
  EXPECT_NE(second(few), "ipm");
  EXPECT_NE(second(local_form(manufactured_problem(3, 5, 10, 1).problem)), "ipm");
  for (const char* name : {"3d_sphere_pyramid_4.hdf5", "2d_tilt12_320.hdf5"}) {
    const std::vector<AutoStage> stages = planned(local_form(shipped_file(name)));
    EXPECT_LT(stage_of(stages, "ipm"), stage_of(stages, "newton")) << name;
  }
}

/// Where these do not arrive, starts around the best impulse have their turn, then the central path
/// through its folds.
TEST(AutoSolver, MovingPackingsThatResistHaveOtherStartsAndPatience) {
  const std::vector<AutoStage> stages = planned(shipped_file("2d_pour300_392.hdf5"), true);
  const auto shaken = std::find_if(stages.begin(), stages.end(), [](const AutoStage& stage) {
    return takes(stage, "shake=first");
  });
  ASSERT_GE(stages.end() - shaken, 2);
  expect_stage(*shaken, "homotopy", AutoStage::Start::kBest);
  EXPECT_EQ(shaken[1].solver->name, "ipm");
  EXPECT_EQ(shaken[1].max_iterations, 1000);
}

TEST(AutoSolver, MovingPackingsAreSolvedByPathFollowing) {
  for (const char* name :
       {"2d_pour300_273.hdf5", "2d_pour300_392.hdf5", "2d_compaction_flow.hdf5"}) {
    SolverOptions options{.tol = 1e-10, .time_limit = 2 * BIPOT_TEST_SLOWNESS};
    const SolveResult result = converged(solve("auto", shipped_file(name), options), name);
    EXPECT_LE(result.error.guarded(), 1e-10) << name;
    // First order was given up, and nothing was needed after the first paths.
    EXPECT_TRUE(says(result.message, "given up")) << name;
    const std::size_t path = result.message.find("homotopy");
    ASSERT_NE(path, std::string::npos) << name << ": " << result.message;
    EXPECT_EQ(result.message.find(';', path), std::string::npos) << name << result.message;
    EXPECT_LT(result.iterations, 3000) << name;
  }
}

TEST(AutoSolver, NothingExactForALooseTolerance) {
  const SolveResult result = auto_solves("2d_tilt1000hi_182.hdf5", 1e-2);
  EXPECT_FALSE(says(result.message, "homotopy")) << result.message;
}

TEST(AutoSolver, NoPathsInSpace) {
  EXPECT_EQ(stages_of(shipped_file("3d_sphere_pyramid_4.hdf5"), "homotopy"), 0);
  EXPECT_GT(stages_of(shipped_file("2d_pyramid_10.hdf5"), "homotopy"), 0);
  EXPECT_GT(stages_of(shipped_file("1d_square_20.hdf5"), "homotopy"), 0);
}

// 250 spheres under a plate (h = 5e-4 s, 50 N on 1 kg; steps 327 and 336): ipm meets 1e-3 in 66
// iterations from either start, or in 304 and 333 after 16 folds, admm in 8242; in 2e5 sweeps or
// steps of momentum nothing else does. So neither may be cut off earlier, nor come after what never
// ends.
TEST(AutoSolver, InSpaceFactorisationsHaveTheirTime) {
  for (const bool warm : {false, true}) {
    const std::vector<AutoStage> stages = planned(shipped_file("3d_sphere_box_4.hdf5"), warm);
    const auto endless = std::find_if(stages.begin(), stages.end(), [](const AutoStage& stage) {
      return stage.max_iterations >= 1000000;
    });
    int first = 0, most = 0, splitting = 0;
    for (auto stage = stages.begin(); stage != endless; ++stage) {
      if (stage->solver->name == "ipm" && first == 0) first = stage->min_iterations;
      if (stage->solver->name == "ipm") most = std::max(most, stage->min_iterations);
      if (stage->solver->name == "admm") splitting = std::max(splitting, stage->min_iterations);
    }
    EXPECT_GE(first, 66);
    EXPECT_GE(most, 333);
    EXPECT_GE(splitting, 9610);
  }
}

// Steps of pours of 500 spheres at which all else stands still: the cold central path met 1e-2 in
// all 29, within 330 factorisations, and 1e-8 in 18 of 19, within 569.
TEST(AutoSolver, InSpaceTheCentralPathHasItsTime) {
  for (const double tol : {1e-2, 1e-8}) {
    for (const bool warm : {false, true}) {
      const std::vector<AutoStage> stages =
          planned(shipped_file("3d_sphere_pyramid_4.hdf5"), warm, tol);
      const auto path = std::ranges::find(stages, "direct=off", &AutoStage::parameters);
      ASSERT_NE(path, stages.end());
      EXPECT_EQ(path->solver->name, "ipm");
      EXPECT_GE(path->min_iterations, 580);
      for (auto stage = stages.begin(); stage != path; ++stage) {
        if (stage->solver->name == "load_path") continue;  // one pass
        // Gradient steps cost a tenth of a sweep there and back or less, plain sweeps a quarter.
        const std::string_view name = stage->solver->name;
        const int most = name == "apgd" ? 30000 : name == "pgs" ? 15000 : 3000;
        EXPECT_LE(stage->max_iterations, most) << stage->solver->name;
      }
    }
  }
}

TEST(AutoSolver, AWarmStartSavesIterations) {
  const ContactProblem p = shipped_file("2d_pour300_392.hdf5");
  const SolveResult rough = converged(solve("auto", p, {.tol = 1e-4}));
  const SolveResult cold = solve("auto", p, {.tol = 1e-10});
  const SolveResult warm = converged(solve("auto", p, {.tol = 1e-10, .s0 = rough.s}));
  EXPECT_LT(warm.iterations, cold.iterations) << warm.message;
}

TEST(AutoSolver, LargePackingsAtRestAreSolvedBySweepsForthAndBack) {
  const ContactProblem p = lattice_step(Lattice::kTriangular, 40, 0.3, 10);
  ASSERT_GT(p.num_contacts(), 4000);
  const SolveResult cold =
      converged(solve("auto", p, {.tol = 1e-6, .parameters = {{"forces", "spread"}}}));
  EXPECT_EQ(cold.message.find("stages: assor"), 0u) << cold.message;
  EXPECT_LT(4 * cold.iterations, solve("apgd", p, {.tol = 1e-6}).iterations);
  // Without bodies there is nothing to put in vectors: W alone goes the old way.
  const ContactProblem local = local_form(p);
  for (const AutoStage& stage : planned(local)) EXPECT_NE(stage.solver->name, "assor");
}

// The normals of square lattices are along or across one direction; those of triangular ones, of
// pyramids, settled piles and steps of pours are not.
TEST(AutoSolver, SmallSquareLatticesBeginWithAndersonOthersWithSweepsForthAndBack) {
  for (const int side : {5, 12}) {  // few contacts and more
    LatticeOptions tilted{.tilt = 0.2};
    EXPECT_EQ(planned(square_lattice(side, tilted)).front().solver->name, "anderson") << side;
    EXPECT_EQ(planned(triangular_lattice(side, tilted)).front().solver->name, "assor") << side;
  }
  EXPECT_EQ(planned(triangular_lattice(2)).front().solver->name,
            "anderson");  // too few to fill vectors
  for (const char* name : {"2d_pile_300_mu03.hdf5", "2d_pour300_392.hdf5", "2d_tilt12_320.hdf5",
                           "2d_triangular_lattice.hdf5", "2d_pyramid_10.hdf5"}) {
    ASSERT_GT(shipped_file(name).num_contacts(), 100) << name;
    EXPECT_EQ(planned(shipped_file(name)).front().solver->name, "assor") << name;
    // From a warm start too, at any tolerance.
    for (const double tol : {1e-1, 1e-8}) {
      EXPECT_EQ(serving(shipped_file(name), true, tol)[0].solver->name, "assor") << name;
    }
    // A path comes next, and no Anderson.
    EXPECT_EQ(serving(shipped_file(name), true, 1e-4)[1].solver->name, "homotopy") << name;
    for (const AutoStage& stage : planned(shipped_file(name), true)) {
      EXPECT_NE(stage.solver->name, "anderson") << name;
    }
  }
  LatticeOptions options{.tilt = 0.2};
  const ContactProblem larger = triangular_lattice(30, options);
  ASSERT_GT(larger.num_contacts(), 2500);
  for (const double tol : {1e-1, 1e-8}) {
    for (const bool warm : {false, true}) {
      EXPECT_EQ(planned(larger, warm, tol)[0].solver->name, "assor");
    }
  }
  options.dim = 1;  // without friction
  EXPECT_EQ(planned(triangular_lattice(30, options)).front().solver->name, "anderson");
}

/// Up to 2500 contacts of disks a path begins where the first sweeps end, if that is near.
TEST(AutoSolver, SmallPackingsOfDisksGoFromSweepsToAPath) {
  for (const char* name : {"2d_tilt12_320.hdf5", "2d_pile_300_mu03.hdf5"}) {
    const ContactProblem p = shipped_file(name);
    const bool few = p.num_contacts() <= 400;
    ASSERT_EQ(few, std::string_view(name) == "2d_tilt12_320.hdf5");
    for (const bool warm : {false, true}) {
      for (const double tol : {3e-2, 1e-4}) {
        const std::vector<AutoStage> stages = serving(p, warm, tol);
        EXPECT_EQ(stages[0].solver->name, "assor");
        expect_stage(stages[1], "homotopy", AutoStage::Start::kBest);
        EXPECT_LE(stages[1].largest_error, 0.1) << "from far away paths are long";
        EXPECT_EQ(stages[2].solver->name, few ? "pgs" : "apgd");
      }
    }
  }
  for (const int side : {28, 36}) {  // 2268 and 3780 contacts or so
    const ContactProblem p = first_step("triangular", side);
    for (const bool warm : {false, true}) {
      EXPECT_EQ(serving(p, warm, 1e-4)[0].solver->name, "assor");
      EXPECT_EQ(serving(p, warm, 1e-4)[1].solver->name, side == 28 ? "homotopy" : "apgd");
    }
  }
  EXPECT_TRUE(says(auto_solves("2d_tilt12_320.hdf5", 1e-8).message, "homotopy"));
  // Sweeps leave this one at 0.6: momentum and factorisations come next, and no path from there.
  EXPECT_TRUE(says(auto_solves("2d_pyramid_20_mu05.hdf5", 1e-8).message, "(6.3e-01); apgd"));
  const std::vector<AutoStage> warm = serving(shipped_file("2d_tilt12_320.hdf5"), true, 1e-4);
  EXPECT_EQ(warm[2].solver->name, "pgs");
}

/// Spheres that land: a few sweeps there and back, then momentum for packings at rest. Then many
/// plain sweeps and splitting, at last the central path; Newton steps end to a tight tolerance what
/// these began. A close packing, here of 112 contacts of 30 spheres, begins with momentum, and to a
/// tight tolerance with factors next.
TEST(AutoSolver, SpheresBeginWithSweepsAndSplitting) {
  const auto names = [](double tol, const char* file = "3d_sphere_box_4.hdf5") {
    std::vector<std::string_view> order;
    for (const AutoStage& stage : serving(shipped_file(file), false, tol)) {
      if (order.empty() || order.back() != stage.solver->name) order.push_back(stage.solver->name);
      if (stage.parameters == "direct=off") break;
    }
    return order;
  };
  using Names = std::vector<std::string_view>;
  EXPECT_EQ(names(1e-2), (Names{"assor", "pgs", "apgd", "admm", "ipm"}));
  EXPECT_EQ(names(1e-3), (Names{"assor", "apgd", "pgs", "admm", "ipm"}));
  EXPECT_EQ(names(1e-6), (Names{"assor", "apgd", "ptc", "pgs", "admm", "ptc", "pgs", "ipm"}));
  const char* close = "3d_sphere_pyramid_4.hdf5";
  EXPECT_EQ(names(0.5, close)[0], "pgs");
  EXPECT_EQ(names(0.5, close)[1], "assor");
  EXPECT_EQ(names(1e-2, close), (Names{"apgd", "assor", "pgs", "apgd", "admm", "ipm"}));
  EXPECT_EQ(names(1e-6, close),
            (Names{"apgd", "ipm", "assor", "apgd", "ptc", "pgs", "admm", "ptc", "pgs", "ipm"}));
}

TEST(AutoSolver, PathsSeeTheCallersCancel) {
  // The caller stops the solve in the middle of the paths.
  // Sweeps, factorisations and apgd are given up by 1900 iterations: what follows are paths.
  SolverOptions options{.tol = 1e-12};
  bool on_path = false;
  options.on_iteration = [&](const IterationRecord& r) { on_path = r.iteration > 1900; };
  options.cancelled = [&on_path] { return on_path; };
  const SolveResult result = ended(SolveStatus::kInterrupted,
                                   solve("auto", shipped_file("2d_pyramid_20_mu05.hdf5"), options));
  const std::size_t path = result.message.rfind("homotopy");
  ASSERT_NE(path, std::string::npos) << result.message;
  EXPECT_EQ(result.message.find(';', path), std::string::npos) << result.message;
}

TEST(AutoSolver, TheCallersCancelIsNoGivingUp) {
  int asked = 0;
  SolverOptions options{.tol = 1e-8};
  options.cancelled = [&asked] { return ++asked > 5; };
  ended(SolveStatus::kInterrupted, solve("auto", shipped_file("2d_pyramid_10.hdf5"), options));
  EXPECT_LT(asked, 20);  // no further stage was begun
}

TEST(AutoSolver, TheIterationLimitHoldsForAllStagesTogether) {
  const SolveResult result =
      ended(SolveStatus::kIterationLimit,
            solve("auto", shipped_file("2d_pyramid_10.hdf5"), {.tol = 1e-8, .max_iterations = 30}));
  EXPECT_LE(result.iterations, 30);
}

TEST(AutoSolver, HistoryCountsOnOverTheStages) {
  std::vector<int> iterations;
  SolverOptions options{.tol = 1e-8};
  options.on_iteration = [&](const IterationRecord& r) { iterations.push_back(r.iteration); };
  const SolveResult result = solve("auto", shipped_file("2d_pyramid_10.hdf5"), options);
  ASSERT_FALSE(iterations.empty());
  EXPECT_TRUE(std::is_sorted(iterations.begin(), iterations.end()));
  EXPECT_EQ(iterations.back(), result.iterations);
}

// A cylinder of 1e9 kg rests on two of 1 kg between walls. Rounding of the impulses alone leaves 4e-6
// of the energy that they move: 1e-8 cannot be had, which is known after the first stage.
TEST(AutoSolver, SaysWhatDoublesAllow) {
  const auto part = [](const char* x, const char* y, const char* mass) {
    return fmt::format("[[disks]]\nposition = [{}, {}]\nradius = 0.1\nmass = {}\n", x, y, mass);
  };
  const Scene<2> scene = scene_of(
      "[contact]\nmu = 0.5\n" + part("0.1", "0.1", "1") + part("0.3", "0.1", "1") +
      part("0.2", "0.27320508075688773", "1e9") +
      "[[walls]]\npoint = [0, 0]\nnormal = [0, 1]\n[[walls]]\npoint = [0, 0]\nnormal = [1, 0]\n"
      "[[walls]]\npoint = [0.4, 0]\nnormal = [-1, 0]\n[time]\nstep = 0.0166\nsteps = 1\n");
  const ContactProblem p = step_problem(scene, initial_state(scene));
  SolverOptions options;
  const SolveResult result = ended(SolveStatus::kStalled, solve("auto", p, options));
  EXPECT_EQ(result.message.rfind("as exact as doubles allow: ", 0), 0u) << result.message;
  EXPECT_LT(result.error.guarded(), 1e-5);
  EXPECT_LT(result.iterations, 10000);
  const double floor = rounding_floor(p, result.s, result.error);
  EXPECT_GT(floor, 1e-6);
  EXPECT_LT(floor, 2e-5);
  options.tol = 1e-4;
  EXPECT_EQ(solve("auto", p, options).status, SolveStatus::kConverged);
}

}  // namespace
}  // namespace bipot
