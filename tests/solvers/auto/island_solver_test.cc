#include "core/motion/time_stepping.h"
#include "core/scene/generators.h"
#include "core/scene/scene_family.h"
#include "solvers/auto/auto_solver.h"
#include "solvers/auto/contact_islands.h"
#include "solvers/auto/islands.h"
#include "solvers/solve_run.h"
#include "tests/support/converged.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/manufactured.h"
#include "tests/support/naive_error.h"
#include "tests/support/side_by_side.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

/// Parts of 1, 3, 5, 9, 14 and 40 contacts, each with a solution, velocities 10^k times as large.
ContactProblem archipelago(int dim, unsigned seed, bool given_by_delassus, int copies = 1) {
  std::vector<ContactProblem> parts;
  for (int copy = 0; copy < copies; ++copy) {
    double scale = 1e-3;
    for (const int contacts : {14, 1, 40, 3, 9, 5}) {
      ContactProblem part =
          manufactured_problem(dim, std::max(1, contacts - 1), contacts, seed + 7).problem;
      part.u_free *= scale;
      scale *= 10;
      if (!given_by_delassus) part.W = SparseRows();
      parts.push_back(given_by_delassus ? local_form(part) : part);
    }
  }
  return side_by_side(parts).problem;
}

/// The race of `auto` alone.
void run_race(SolveRun& run, const Vector& best) { plan_solver(shipped_plan()).run(run, best); }

/// `auto` that cuts at once, without an attempt on the whole.
SolverEntry cutting_auto(const IslandSolver& solver = {.run = &run_race}) {
  SolverEntry entry = *find_solver("auto");
  entry.run = [solver](SolveRun& run) { solve_islands(run, solver); };
  return entry;
}

TEST(Islands, TheWholeMeetsTheTolerance) {
  for (const int dim : {1, 2, 3}) {
    for (const unsigned seed : {1u, 2u, 3u}) {
      for (const bool local : {false, true}) {
        const ContactProblem p = archipelago(dim, seed, local);
        for (const double tol : {1e-2, 1e-5, 1e-9}) {
          const SolveResult result = converged(solve(cutting_auto(), p, {.tol = tol}));
          EXPECT_TRUE(says(result.message, "6 islands"));
          EXPECT_LE(naive_error(p, result.s).guarded(), tol * (1 + 1e-6))
              << dim << ' ' << seed << ' ' << local;
        }
      }
    }
  }
}

/// A solver that stops as early as the stop test lets it: on the line from an exact impulse to 0.
SolverEntry lazy_solver(std::vector<double>* errors) {
  const auto run_lazily = [errors](SolveRun& run) {
    const ContactProblem& p = run.problem();
    const SolveResult exact = run_solver(*find_solver("auto"), p, {.tol = 1e-13, .islands = false});
    ContactErrorEvaluator evaluate(p, 1, run.whole().share());
    // Within the tolerance by more than rounding, or no claim is proved.
    SolverOptions proved = run.options();
    proved.tol *= 1 - 1e-9;
    double low = 0, high = 1;
    for (int k = 0; k < 60; ++k) {
      const double middle = 0.5 * (low + high);
      (meets(proved, evaluate(middle * exact.s)) ? high : low) = middle;
    }
    errors->push_back(contact_error(p, high * exact.s).guarded());
    run.take({.status = SolveStatus::kConverged, .s = high * exact.s, .iterations = 1});
  };
  return {.name = "lazy", .run = run_lazily};
}

/// 20 contacts that approach at 1 and slide at 10, W = 1 but for tangents that are neighbours: 0.2.
ContactProblem sliding_part() {
  constexpr int kContacts = 20;
  ContactProblem p{.dim = 2};
  p.W.resize(2 * kContacts, 2 * kContacts);
  p.W.setIdentity();
  p.u_free = Vector::Zero(2 * kContacts);
  p.mu = Vector::Constant(kContacts, 0.5);
  for (int c = 0; c < kContacts; ++c) {
    if (c > 0) p.W.coeffRef(2 * c + 1, 2 * c - 1) = p.W.coeffRef(2 * c - 1, 2 * c + 1) = 0.2;
    p.u_free[2 * c] = -1;
    p.u_free[2 * c + 1] = 10;
  }
  p.W.makeCompressed();
  return p;
}

TEST(Islands, PartsThatJustMeetTheirSharesMeetTheWhole) {
  // The errors that the lazy solver leaves are as large as it may leave them.
  for (const double tol : {1e-1, 1e-2, 1e-4}) {
    std::vector<double> errors;
    const SolverEntry lazy = lazy_solver(&errors);
    std::vector<ContactProblem> parts;
    for (const unsigned seed : {3u, 4u, 5u, 6u, 7u, 8u}) {
      parts.push_back(manufactured_problem(2, 15, 20, seed).problem);
      parts.back().u_free *= std::pow(3.0, seed);
    }
    const ContactProblem p = side_by_side(parts).problem;
    const SolveResult result = converged(solve(lazy, p, {.tol = tol, .islands = true}));
    EXPECT_FALSE(says(result.message, "then the whole"));
    EXPECT_LE(result.error.guarded(), tol);
    EXPECT_GE(result.error.guarded(), 0.5 * tol);  // what was left to the last part is used
    ASSERT_EQ(errors.size(), 6u);
  }
}

TEST(Islands, MaximaOfDifferentTermsDoNotUseUpTheTolerance) {
  // On one part D is the largest term of the denominator, on the other θK: both with the error tol
  // by themselves would be more than tol on the whole, as the maxima of the sums are less than the
  // sum of the maxima.
  //   sliding: s_n = 1, |s_t| = mu, D = 20 mu |u_t| > 90 and θK < 2;
  //   resting: D = 0.
  // With the same maximum in both the sum of them is nearly twice the maximum of the sums.
  const ContactProblem sliding = sliding_part();
  const ContactProblem resting = lattice_step(Lattice::kTriangular, 6, 0.3, 0);
  const SolveResult one = solve("auto", sliding, {.tol = 1e-12});
  const SolveResult two = solve("auto", resting, {.tol = 1e-12});
  ASSERT_GT(one.error.friction_power, kTheta * one.error.energy);
  ASSERT_LT(two.error.friction_power, kTheta * two.error.energy);
  ContactProblem scaled = local_form(resting);
  // The same energy in both maxima.
  scaled.u_free *= std::sqrt(one.error.friction_power / (kTheta * two.error.energy));
  const ContactProblem p = side_by_side({sliding, scaled}).problem;
  const double sum_of_maxima = 2 * one.error.friction_power;
  const SolveResult exact = solve("auto", p, {.tol = 1e-12});
  const double maximum_of_sums = std::max(exact.error.friction_power, kTheta * exact.error.energy);
  EXPECT_GT(sum_of_maxima, 1.5 * maximum_of_sums);
  std::vector<double> errors;
  const SolverEntry lazy = lazy_solver(&errors);
  const SolveResult result = converged(solve(lazy, p, {.tol = 1e-3, .islands = true}));
  EXPECT_FALSE(says(result.message, "then the whole"));
  EXPECT_LE(naive_error(p, result.s).guarded(), 1e-3 * (1 + 1e-9));
}

void expect_near(const ContactError& error, const ContactError& expected) {
  EXPECT_NEAR(error.epsilon, expected.epsilon, 1e-12 * expected.epsilon);
  EXPECT_NEAR(error.eta, expected.eta, 1e-12 * expected.eta);
  EXPECT_NEAR(error.natural_map, expected.natural_map, 1e-12 * expected.natural_map);
}

TEST(Islands, APartIsJudgedAsAPieceOfTheWhole) {
  // With the sums of the rest as `others` the error of a part is that of the whole.
  for (const int dim : {1, 2, 3}) {
    const ContactProblem p = archipelago(dim, 4, false);
    Vector s = solve("auto", p, {.tol = 1e-3}).s;
    s *= 0.9;
    ContactErrorEvaluator evaluate(p);
    const ContactError whole = evaluate(s);
    ErrorSums sums;
    for (int c = 0; c < p.num_contacts(); ++c) sums += evaluate.part(c);
    const ContactError added = error_of(sums);
    expect_near(added, whole);
    EXPECT_NEAR(added.energy, whole.energy, 1e-12 * whole.energy);
    const SideBySide two = side_by_side({p, p});
    Vector both(2 * s.size());
    ErrorShare share;
    for (int c = 0; c < p.num_contacts(); ++c) {
      both.segment(two.place[0][to_size(c)] * dim, dim) = s.segment(c * dim, dim);
      both.segment(two.place[1][to_size(c)] * dim, dim) = 0.5 * s.segment(c * dim, dim);
    }
    ContactErrorEvaluator other(p);
    other(0.5 * s);
    share.others = other.sums();
    ContactErrorEvaluator part(p, 1, share);
    const ContactError as_piece = part(s);
    const ContactError expected = contact_error(two.problem, both);
    expect_near(as_piece, expected);
    // Half the tolerance: twice the figure. By itself it is better here and counts threefold.
    share.share = 0.5;
    EXPECT_NEAR(ContactErrorEvaluator(p, 1, share)(s).epsilon, 2 * expected.epsilon,
                1e-12 * expected.epsilon);
    share.alone = 3;
    EXPECT_NEAR(ContactErrorEvaluator(p, 1, share)(s).epsilon,
                std::min(2 * expected.epsilon, 3 * whole.epsilon), 1e-12 * expected.epsilon);
  }
}

TEST(Islands, SingleContactsAreSolvedInClosedForm) {
  // Take-off; stick: s_n = 1/2, s_t = -0.1, inside the cone; slip: s_n = 1/2, |s_t| = mu s_n =
  // 0.15.
  for (const int dim : {2, 3}) {
    std::vector<ContactProblem> parts;
    Vector b_t = Vector::Zero(2);
    for (const auto& [b_n, slide] : {std::pair{1.0, 0.3}, {-1.0, 0.3}, {-1.0, 3.0}}) {
      b_t[0] = slide;
      parts.push_back(one_contact_problem(dim, 2, 3, 0.3, b_n, b_t));
    }
    const ContactProblem p = side_by_side(parts).problem;
    const SolveResult result = converged(solve("auto", p, {.tol = 1e-14}));
    EXPECT_TRUE(says(result.message, "3 islands: 1 open, 0 kept, 2 of few contacts, 0 by auto"));
    Vector expected = Vector::Zero(3 * dim);
    expected[dim] = expected[2 * dim] = 0.5;
    expected[dim + 1] = -0.1;
    expected[2 * dim + 1] = -0.15;
    EXPECT_LE((result.s - expected).norm(), 1e-15);
    EXPECT_EQ(result.iterations, 1);
  }
}

TEST(Islands, WhatRestsKeepsItsImpulsesAndIsCheckedAllTheSame) {
  std::vector<ContactProblem> parts;
  for (const int contacts : {1, 60, 200, 300}) {
    parts.push_back(manufactured_problem(2, std::max(1, contacts - 1), contacts, 9).problem);
  }
  const SideBySide before = side_by_side(parts);
  const SolveResult first = converged(solve("auto", before.problem, {.tol = 1e-8}));
  for (std::size_t moved = 0; moved < parts.size(); ++moved) {
    std::vector<ContactProblem> changed = parts;
    changed[moved].u_free *= 1.5;  // its impulses are 1.5 times the ones before
    const ContactProblem p = side_by_side(changed).problem;
    const SolveResult result = converged(solve("auto", p, {.tol = 1e-7, .s0 = first.s}));
    EXPECT_TRUE(says(result.message, "3 kept"));
    for (std::size_t k = 0; k < parts.size(); ++k) {
      for (const int c : before.place[k]) {
        if (k != moved) {
          EXPECT_EQ(result.s.segment(2 * c, 2), first.s.segment(2 * c, 2));
        } else {
          EXPECT_LE((result.s - 1.5 * first.s).segment(2 * c, 2).norm(), 1e-3);
        }
      }
    }
  }
}

TEST(Islands, OtherSolversCutOnlyWhereAsked) {
  const ContactProblem p = archipelago(2, 1, false);
  const SolveResult whole = solve("pgs", p, {.tol = 1e-6});
  EXPECT_FALSE(says(whole.message, "islands"));
  const SolveResult cut = converged(solve("pgs", p, {.tol = 1e-6, .islands = true}));
  EXPECT_TRUE(says(cut.message, "6 islands"));
  EXPECT_LE(cut.iterations, whole.iterations);
  const SolveResult off = converged(solve("auto", p, {.tol = 1e-6, .islands = false}));
  EXPECT_FALSE(says(off.message, "islands"));
}

TEST(Islands, TheyAreAParameterOfEverySolver) {
  const ContactProblem p = archipelago(2, 1, false);
  const SolveResult on = solve("pgs", p, {.tol = 1e-6, .parameters = {{"islands", "on"}}});
  EXPECT_EQ(on.s, solve("pgs", p, {.tol = 1e-6, .islands = true}).s);
  const SolveResult off = solve("auto", p, {.tol = 1e-6, .parameters = {{"islands", "off"}}});
  EXPECT_EQ(off.s, solve("auto", p, {.tol = 1e-6, .islands = false}).s);
  const SolveResult other =
      ended(SolveStatus::kInvalidInput, solve("pgs", p, {.parameters = {{"islands", "some"}}}));
  EXPECT_TRUE(says(other.message, "on|off"));
  // A solver's own parameters are read all the same.
  const SolveResult own = converged(
      solve("pgs", p, {.tol = 1e-6, .parameters = {{"islands", "on"}, {"omega", "1.3"}}}));
  EXPECT_NE(own.s, on.s);
}

TEST(Islands, ExplainSaysHowManyThereAre) {
  const std::string text = explain_islands(archipelago(2, 1, false));
  EXPECT_TRUE(says(text, "islands: 6;"));
  EXPECT_TRUE(says(text, "the largest has 40"));
  EXPECT_EQ(explain_islands(ContactProblem{}), "islands: 0\n");
}

TEST(Islands, OnePartIsSolvedAsItIs) {
  const ContactProblem p = lattice_step(Lattice::kTriangular, 8, 0.3, 5);
  const SolveResult on = solve("auto", p, {.tol = 1e-8, .islands = true});
  const SolveResult off = solve("auto", p, {.tol = 1e-8, .islands = false});
  EXPECT_EQ(on.s, off.s);
  EXPECT_EQ(on.message, off.message);
  EXPECT_EQ(on.iterations, off.iterations);
}

TEST(Islands, SameBitsForAnyNumberOfThreads) {
  const ContactProblem p = archipelago(2, 2, false);
  const SolveResult one = solve(cutting_auto(), p, {.tol = 1e-8});
  for (const int threads : {2, 3, 4}) {
    const SolveResult more =
        solve(cutting_auto(), p, {.tol = 1e-8, .execution = {.threads = threads}});
    EXPECT_EQ(more.s, one.s) << threads;
    EXPECT_EQ(more.iterations, one.iterations);
  }
}

/// `auto` with another attempt, and with another solver for the parts.
SolverEntry attempting(const std::function<void(SolveRun&)>& attempt,
                       const decltype(IslandSolver::run)& parts = &run_race) {
  return cutting_auto({.run = parts, .attempt = attempt});
}

/// Five sweeps, with a history of six records.
SolveResult half_done(const ContactProblem& p, const SolverOptions& options) {
  SolveResult result = solve("pgs", p, {.tol = options.tol, .max_iterations = 5});
  if (options.on_iteration) {
    for (int k = 0; k <= 5; ++k) {
      options.on_iteration({.iteration = k, .error = contact_error(p, result.s), .count = [&] {
                              return count_contacts(p, result.s);
                            }});
    }
  }
  result.message = "half done";
  return result;
}

TEST(Islands, HistoryEndsWithTheErrorOfTheWhole) {
  const ContactProblem p = archipelago(2, 3, false);
  for (const SolverEntry& entry :
       {cutting_auto(), *find_solver("auto"), attempting(run_of(&half_done))}) {
    std::vector<IterationRecord> records;
    SolverOptions options{.tol = 1e-8};
    options.on_iteration = [&](const IterationRecord& r) {
      records.push_back(r);
      const ContactCount count = r.count();
      EXPECT_EQ(count.take_off + count.stick + count.slip, p.num_contacts());
    };
    const SolveResult result = converged(solve(entry, p, options));
    ASSERT_GT(records.size(), 1u);
    EXPECT_EQ(records.front().iteration, 0);
    EXPECT_TRUE(std::is_sorted(records.begin(), records.end(), [](const auto& a, const auto& b) {
      return a.iteration < b.iteration;
    }));
    EXPECT_EQ(records.back().iteration, result.iterations);
    EXPECT_NEAR(records.back().error.guarded(), result.error.guarded(),
                1e-9 * result.error.guarded());
  }
}

TEST(Islands, AnAttemptOnTheWholeThatArrivesIsAll) {
  const ContactProblem p = archipelago(2, 1, false);
  const auto attempt = run_of([](const ContactProblem& q, const SolverOptions& options) {
    EXPECT_EQ(contact_islands(q).count(), 6);
    return solve("pgs", q, {.tol = options.tol});
  });
  const SolverEntry entry = attempting(
      attempt, [](SolveRun&, const Vector&) { throw std::logic_error("nothing was left to do"); });
  EXPECT_EQ(converged(solve(entry, p, {.tol = 1e-6})).s, solve("pgs", p, {.tol = 1e-6}).s);
}

TEST(Islands, AnAttemptThatDoesNotArriveLeavesItsBestToTheParts) {
  const ContactProblem p = archipelago(2, 1, false);
  const Vector left = half_done(p, {.tol = 1e-9}).s;
  int parts = 0;
  SolverEntry entry = attempting(run_of(&half_done), [&](SolveRun& run, const Vector& best) {
    ++parts;
    EXPECT_EQ(best.size(), run.problem().num_rows());
    // Parts come out of the whole: what stands there are its numbers.
    for (const double x : best) EXPECT_NE(std::find(left.begin(), left.end(), x), left.end());
    EXPECT_EQ(run.options().max_iterations, 995);
    run_race(run, best);
  });
  const SolveResult result = converged(solve(entry, p, {.tol = 1e-9, .max_iterations = 1000}));
  EXPECT_GT(parts, 0);
  EXPECT_TRUE(says(result.message, "the whole: half done; then 6 islands")) << result.message;
  EXPECT_GT(result.iterations, 5);
  entry = attempting(run_of(&half_done));
  // From a warm start too, where that settles little.
  const SolveResult again = converged(solve(entry, p, {.tol = 1e-9, .s0 = 0.5 * result.s}));
  EXPECT_TRUE(says(again.message, "half done"));
}

TEST(Islands, AStartThatSettlesMuchOfManyContactsSavesTheAttempt) {
  for (const int copies : {1, 6}) {
    const ContactProblem p = archipelago(2, 1, false, copies);
    Vector mostly = solve("auto", p, {.tol = 1e-9}).s;
    const ContactIslands islands = contact_islands(p);
    for (const int c : islands.of(islands.count() - 2)) mostly.segment<2>(2 * c) *= 0.5;
    const SolveResult rest =
        converged(solve(attempting(run_of(&half_done)), p, {.tol = 1e-8, .s0 = mostly}));
    EXPECT_EQ(says(rest.message, "half done"), copies == 1) << rest.message;
  }
}

TEST(Islands, AnAttemptThatIsNotMadeLeavesAllToTheParts) {
  // As where no stage of a plan serves the whole, from a start that settles all but the largest.
  const ContactProblem p = shipped_file("2d_pour300_392.hdf5");
  int attempts = 0;
  const SolverEntry entry = attempting([&](SolveRun& run) {
    ++attempts;
    run.take(SolveResult());
  });
  Vector start = solve("auto", p, {.tol = 1e-9}).s;
  const ContactIslands islands = contact_islands(p);
  for (const int c : islands.of(islands.count() - 1)) start.segment<2>(2 * c) *= 0.99;
  converged(solve(entry, p, {.tol = 1e-5, .s0 = start}));
  EXPECT_EQ(attempts, 1);
}

/// Sweeps that leave the problem of 14 contacts undone.
SolveResult all_but_one(const ContactProblem& p, const SolverOptions& options) {
  SolveResult result = solve("pgs", p, {.tol = 1e-3 * options.tol});
  const ContactIslands islands = contact_islands(p);
  for (int k = 0; k < islands.count(); ++k) {
    if (islands.of(k).size() != 14) continue;
    for (const int c : islands.of(k)) result.s.segment(c * p.dim, p.dim) *= 0.5;
    result.status = SolveStatus::kIterationLimit;
  }
  return result;
}

TEST(Islands, WhatAnAttemptSolvedIsNotSolvedAgain) {
  const ContactProblem p = archipelago(2, 1, false);
  std::vector<int> sizes;
  const SolverEntry entry =
      attempting(run_of(&all_but_one), [&](SolveRun& run, const Vector& best) {
        sizes.push_back(run.problem().num_contacts());
        run_race(run, best);
      });
  const SolveResult result = converged(solve(entry, p, {.tol = 1e-8}));
  EXPECT_EQ(sizes, std::vector<int>{14});
  EXPECT_LE(naive_error(p, result.s).guarded(), 1e-8);
}

/// Pyramids of 22 contacts side by side on the ground, each second one without friction, and one of
/// 117.
ContactProblem pyramids(int small) {
  Scene<2> scene = make_family_scene("pyramid", 9);
  scene.materials = {"rough", "slippery"};
  scene.laws = {{.mu = 0.3}, {.mu = 0}, {.mu = 0}, {.mu = 0}};
  double left = 12;
  for (int k = 0; k < small; ++k, left += 6) {
    for (Disk d : pyramid(4, 0.5, Vec2(left, 0))) {
      d.mass = scene.bodies[0].mass;
      d.inertia = scene.bodies[0].inertia;
      d.material = k % 2;
      scene.bodies.push_back(d);
    }
  }
  for (Disk& d : scene.bodies) d.v = Vec2(0, -1);
  return step_problem(scene, initial_state(scene));
}

using Sizes = std::vector<std::pair<int, int>>;  // dimensions and contacts
Sizes* attempts = nullptr;                       // of the two functions below

void arrives(SolveRun& run) {
  attempts->push_back({run.problem().dim, run.problem().num_contacts()});
  run.take(run.nested(require_solver("pgs"), run.options(), run.whole().share()));
}
void leaves_half_of_them(SolveRun& run) {
  const ContactProblem& p = run.problem();
  attempts->push_back({p.dim, p.num_contacts()});
  SolveResult result = solve("pgs", p, {.tol = 1e-3 * run.options().tol});
  const ContactIslands islands = contact_islands(p);
  for (int k = 0; k < islands.count(); k += 2) {
    for (const int c : islands.of(k)) result.s.segment(c * p.dim, p.dim) *= 0.5;
  }
  result.status = SolveStatus::kIterationLimit;
  run.take(std::move(result));
}

/// Above 4000 contacts there is no attempt on the whole: islands of about one size are tried at
/// once, and each of a group that does not arrive is looked at.
TEST(Islands, ThoseOfOneSizeAreTriedTogether) {
  const ContactProblem p = pyramids(200);
  ASSERT_EQ(p.num_contacts(), 200 * 22 + 117);
  for (const bool done : {true, false}) {
    Sizes tried, solved;
    attempts = &tried;
    const SolverEntry entry =
        attempting(done ? &arrives : &leaves_half_of_them, [&](SolveRun& run, const Vector& best) {
          solved.push_back({run.problem().dim, run.problem().num_contacts()});
          EXPECT_EQ(best.size() != 0, run.problem().num_contacts() == 22);
          run_race(run, best);
        });
    const SolveResult result = converged(solve(entry, p, {.tol = 1e-6}));
    EXPECT_LE(naive_error(p, result.s).guarded(), 1e-6);
    EXPECT_EQ(tried, (Sizes{{1, 2200}, {2, 2200}}));
    EXPECT_EQ(solved.size(), done ? 1u : 101u);
    EXPECT_EQ(solved.back(), std::pair(2, 117));
    EXPECT_TRUE(
        says(result.message, done ? "200 together, 1 by auto" : "100 together, 101 by auto"));
  }
}

/// Of a large problem a part that is nearly all of it is not copied: the entry goes on with the
/// whole, from where the small parts are settled, also after an attempt; and what it throws loses
/// nothing.
TEST(Islands, APartThatIsNearlyAllIsSolvedWithinTheWhole) {
  const ContactProblem large = triangular_lattice(40, {.tilt = 0.1});
  ASSERT_GT(large.num_contacts(), 4000);
  const ContactProblem small = pyramid(1);
  const SideBySide sides = side_by_side({large, small});
  const ContactProblem& p = sides.problem;
  std::vector<int> contacts;
  SolverEntry entry = cutting_auto({.run = [&](SolveRun& run, const Vector& best) {
    contacts.push_back(run.problem().num_contacts());
    EXPECT_EQ(run.options().s0.size(), run.problem().num_rows());
    EXPECT_GT(run.options().s0[2 * sides.place[1][0]], 0) << "the small part is settled";
    run_race(run, best);
  }});
  const SolveResult result = converged(solve(entry, p, {.tol = 1e-6}));
  EXPECT_EQ(contacts, std::vector<int>{p.num_contacts()});
  EXPECT_TRUE(says(result.message, "1 of few contacts, 0 by auto; then the whole"))
      << result.message;
  EXPECT_LE(naive_error(p, result.s).guarded(), 1e-6 * (1 + 1e-9));

  entry = cutting_auto(
      {.run = [](SolveRun&, const Vector&) { throw std::runtime_error("no memory is left"); }});
  const SolveResult failed = ended(SolveStatus::kNumericalFailure, solve(entry, p, {.tol = 1e-6}));
  EXPECT_TRUE(says(failed.message, "no memory is left"));
  EXPECT_GT(failed.s[2 * sides.place[1][0]], 0);

  // Half of the contacts are not nearly all.
  contacts.clear();
  entry = cutting_auto({.run = [&](SolveRun& run, const Vector& best) {
    contacts.push_back(run.problem().num_contacts());
    run_race(run, best);
  }});
  converged(solve(entry, side_by_side({large, large}).problem, {.tol = 1e-3}));
  EXPECT_EQ(contacts, std::vector<int>(2, large.num_contacts()));
}

TEST(Islands, AnAttemptThatUsesUpTheIterationsIsTheEnd) {
  const ContactProblem p = archipelago(2, 1, false);
  const SolveResult result =
      ended(SolveStatus::kIterationLimit,
            solve(attempting(run_of(&half_done)), p, {.tol = 1e-9, .max_iterations = 5}));
  EXPECT_EQ(result.iterations, 5);
  EXPECT_EQ(result.s, half_done(p, {.tol = 1e-9}).s);
}

TEST(Islands, APartThatFailsIsNamedAndTheOthersAreSolved) {
  const auto fail = [](SolveRun& run) {
    if (run.problem().num_contacts() != 14) return run_race(run, Vector());
    run.end(SolveStatus::kStalled, "not today");
  };
  const SolverEntry failing{.name = "failing", .run = fail};
  const ContactProblem p = archipelago(2, 1, false);
  const SolveResult result =
      ended(SolveStatus::kStalled, solve(failing, p, {.tol = 1e-12, .islands = true}));
  EXPECT_TRUE(says(result.message, "14 contacts: not today"));
  // What it left undone is all that is wrong.
  ContactErrorEvaluator evaluate(p);
  const ContactError whole = evaluate(result.s);
  const double energy = std::max(whole.friction_power, kTheta * whole.energy);
  const ContactIslands islands = contact_islands(p);
  for (int k = 0; k < islands.count(); ++k) {
    ErrorSums sums;
    for (const int c : islands.of(k)) sums += evaluate.part(c);
    if (islands.of(k).size() == 14) {
      EXPECT_GT(error_of(sums).guarded(), 0.1);
    } else {
      EXPECT_LE(sums.gap + sums.penetration, 1e-11 * energy);
    }
  }
}

TEST(Islands, TheTimeLimitHoldsForAllPartsTogether) {
  const auto wait = [](SolveRun& run) {
    EXPECT_LE(run.options().time_limit, 3600);
    run.end(SolveStatus::kTimeLimit, "out of time");
  };
  const SolverEntry slow{.name = "slow", .run = wait};
  const SolveResult result = ended(
      SolveStatus::kTimeLimit,
      solve(slow, archipelago(2, 1, false), {.tol = 1e-8, .time_limit = 3600, .islands = true}));
  EXPECT_TRUE(says(result.message, "1 by slow"));  // nothing was begun after that
}

TEST(Islands, ShippedMovingProblemsAreSolvedBothWays) {
  for (const char* name : {"2d_pour300_392.hdf5", "2d_tilt1000hi_182.hdf5"}) {
    const ContactProblem p = shipped_file(name);
    EXPECT_GT(contact_islands(p).count(), 1) << name;
    for (const double tol : {1e-3, 1e-8}) {
      EXPECT_LE(converged(solve("auto", p, {.tol = tol}), name).error.guarded(), tol);
    }
  }
}

}  // namespace
}  // namespace bipot
