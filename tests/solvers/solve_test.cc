#include "solvers/solve.h"

#include <Eigen/Geometry>

#include "core/criterion/rounding_bound.h"
#include "solvers/solve_run.h"
#include "tests/support/converged.h"
#include "tests/support/manufactured.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

#define EXPECT_MESSAGE(result, part) EXPECT_TRUE(says((result).message, part))

ContactProblem some_problem(int dim = 2) { return manufactured_problem(dim, 12, 14, 3).problem; }

TEST(Solve, EnergiesBeyondTheRangeOfSquaresAreSolved) {
  // s = -u_free / W. The energy u²/W is 1e-620, 1e450, 1e-500: no doubles, s and u are. Two more
  // have energies that doubles hold, but not their squares.
  struct Data {
    double w, b;
  };
  for (const Data& d : {Data{1, -1e-310}, Data{1e-150, -1e150}, Data{1e100, -1e-200},
                        Data{1, -1e130}, Data{1, -1e-130}}) {
    const ContactProblem p = one_contact_problem(1, d.w, 1, 0, d.b, Vector());
    for (const SolverEntry& entry : solver_table()) {
      const SolveResult r = converged(solve(entry, p), entry.name);
      EXPECT_NEAR(r.s[0] * d.w / d.b, -1, 1e-7) << entry.name;
      if (d.w == 1 && std::isnormal(d.b * d.b)) {
        EXPECT_NEAR(r.error.energy / (0.5 * d.b * d.b), 1, 1e-6) << entry.name;
      }
    }
  }
}

TEST(Solve, ExactStartCostsNoIteration) {
  for (int dim = 1; dim <= 3; ++dim) {
    const Manufactured m = manufactured_problem(dim, 12, 14, 3);
    for (const SolverEntry& entry : solver_table()) {
      if (dim > entry.max_dim) continue;
      const SolveResult r =
          converged(solve(entry, m.problem, {.tol = 1e-12, .s0 = m.s}), entry.name);
      EXPECT_EQ(r.iterations, 0) << entry.name;
      EXPECT_LT((r.u - m.u).norm(), 1e-12 * m.u.norm());
      EXPECT_LE(r.error.guarded(), 1e-12);
    }
  }
}

TEST(Solve, NothingToDoWithoutContacts) {
  for (const StopTest stop : {StopTest::kGuarded, StopTest::kRaw42, StopTest::kImpulse}) {
    for (const SolverEntry& entry : solver_table()) {
      const SolveResult r = ended(SolveStatus::kNothingToDo,
                                  solve(entry, ContactProblem{}, {.stop = stop}), entry.name);
      EXPECT_EQ(r.iterations, 0);
      EXPECT_EQ(r.s.size(), 0);
      EXPECT_EQ(r.error.guarded(), 0);
    }
  }
}

TEST(Solve, NothingToDoWhereEveryContactOpens) {
  ContactProblem p = some_problem();
  for (int c = 0; c < p.num_contacts(); ++c) p.u_free[2 * c] = c % 2 == 0 ? 0.0 : 1.0;
  for (const StopTest stop : {StopTest::kGuarded, StopTest::kRaw42, StopTest::kImpulse}) {
    for (const SolverEntry& entry : solver_table()) {
      // A poor start is no reason to work.
      const SolverOptions options{.stop = stop, .s0 = Vector::Ones(p.num_rows())};
      const SolveResult r = ended(SolveStatus::kNothingToDo, solve(entry, p, options), entry.name);
      EXPECT_EQ(r.s, Vector(Vector::Zero(p.num_rows())));
      EXPECT_EQ(r.u, p.u_free);
    }
  }
}

TEST(Solve, StatusIterationLimit) {
  for (const int limit : {0, 1, 3}) {
    SolverOptions options{.tol = 1e-14, .max_iterations = limit};
    const SolveResult r =
        ended(SolveStatus::kIterationLimit, solve("uzawa", some_problem(), options));
    EXPECT_EQ(r.iterations, limit);
    EXPECT_TRUE(r.s.allFinite());
    EXPECT_GT(r.error.guarded(), options.tol);
    EXPECT_MESSAGE(r, "iteration limit");
  }
}

TEST(Solve, StatusTimeLimit) {
  const SolveResult r = ended(SolveStatus::kTimeLimit,
                              solve("uzawa", some_problem(), {.tol = 1e-14, .time_limit = 1e-9}));
  EXPECT_MESSAGE(r, "time limit");
  EXPECT_LE(r.iterations, 1);
}

TEST(Solve, StatusStalledAtRoundOff) {
  const SolveResult r = ended(SolveStatus::kStalled, solve("pgs", some_problem(), {.tol = 1e-300}));
  EXPECT_MESSAGE(r, "round-off");
  EXPECT_LT(r.error.guarded(), 1e-12);  // it says where it stopped, and returns the best
}

TEST(Solve, StatusDivergedWhenTheIterateGrowsWithoutBound) {
  const auto grow = [](SolveRun& run) {
    Vector s = Vector::Constant(run.problem().num_rows(), 0.01);
    for (int k = 0; !run.stop(k, s); ++k) s *= 10;
  };
  for (int dim = 1; dim <= 3; ++dim) {
    const SolveResult r =
        ended(SolveStatus::kDiverged, solve({.name = "growing", .run = grow}, some_problem(dim)));
    EXPECT_LT(r.iterations, 30);
    EXPECT_TRUE(r.s.allFinite());
    EXPECT_LT(r.error.guarded(), 1e3);  // the best iterate, not the last
  }
}

TEST(Solve, WaitingAtZeroIsNeitherStalledNorConverged) {
  // Splitting methods may keep s = 0 for a while, with multipliers on the move.
  const auto wait = [](SolveRun& run) {
    const Vector solution = solve("pgs", run.problem(), {.tol = 1e-12}).s;
    Vector s = Vector::Zero(solution.size());
    for (int k = 0; !run.stop(k, s); ++k) {
      if (k >= 3) s = solution;
    }
  };
  const SolverEntry entry{.name = "late starter", .run = wait};
  for (const StopTest stop : {StopTest::kGuarded, StopTest::kImpulse}) {
    const SolveResult r = converged(solve(entry, some_problem(), {.stop = stop}));
    EXPECT_GE(r.iterations, 4);
    EXPECT_LE(r.error.guarded(), 1e-8);
  }
}

TEST(Solve, StatusDivergedWhenTheIterateIsNotANumber) {
  const auto run_wild = [](SolveRun& run) {
    Vector s = Vector::Zero(run.problem().num_rows());
    for (int k = 0; !run.stop(k, s); ++k) s[0] = kNaN;
  };
  for (int dim = 1; dim <= 3; ++dim) {
    const SolveResult r =
        ended(SolveStatus::kDiverged, solve({.name = "wild", .run = run_wild}, some_problem(dim)));
    EXPECT_EQ(r.iterations, 1);
    EXPECT_TRUE(r.s.allFinite());
  }
}

TEST(Solve, StatusNumericalFailureForAnIndefiniteMassMatrix) {
  ContactProblem p = some_problem();
  p.W = SparseRows();
  p.A.coeffRef(0, 1) = p.A.coeffRef(1, 0) = 100;
  for (const SolverEntry& entry : solver_table()) {
    const SolveResult r = ended(SolveStatus::kNumericalFailure, solve(entry, p), entry.name);
    EXPECT_MESSAGE(r, "not positive definite");
    EXPECT_TRUE(r.s.allFinite());
  }
}

TEST(Solve, StatusInvalidInputNamesTheDefect) {
  const auto expect_refused = [](const ContactProblem& p, const SolverOptions& options,
                                 const std::string& part) {
    for (const SolverEntry& entry : solver_table()) {
      EXPECT_MESSAGE(ended(SolveStatus::kInvalidInput, solve(entry, p, options), entry.name), part);
    }
  };
  ContactProblem bad = some_problem();
  bad.u_free[5] = kNaN;
  expect_refused(bad, {}, "u_free[5]");
  const ContactProblem p = some_problem();
  for (const double tol : {0.0, -1.0, kNaN, kInfinity}) expect_refused(p, {.tol = tol}, "tol");
  expect_refused(p, {.max_iterations = -1}, "max_iterations");
  for (const double limit : {0.0, -1.0, kNaN}) {
    expect_refused(p, {.time_limit = limit}, "time_limit");
  }
  expect_refused(p, {.s0 = Vector::Zero(3)}, "s0 has size 3, expected 28");
  expect_refused(p, {.s0 = Vector::Constant(28, kNaN)}, "non-finite");
}

TEST(Solve, UnknownSolverListsTheValidOnes) {
  const SolveResult r = ended(SolveStatus::kInvalidInput, solve("uzava", some_problem()));
  EXPECT_MESSAGE(r, "unknown solver 'uzava'; did you mean 'uzawa'?");
  for (const std::string& name : solver_names()) EXPECT_MESSAGE(r, name);
}

TEST(Solve, UnknownParameterNamesTheNearest) {
  const SolveResult r =
      ended(SolveStatus::kInvalidInput,
            solve("uzawa", some_problem(), {.parameters = {{"refesh", "jacobi"}}}));
  EXPECT_MESSAGE(r, "uzawa");
  EXPECT_MESSAGE(r, "unknown parameter 'refesh'; did you mean 'refresh'?");
}

TEST(Solve, ParameterValuesAreCheckedAgainstTheirRange) {
  const auto message = [](const char* solver, const char* name, const char* value) {
    const SolveResult r =
        ended(SolveStatus::kInvalidInput,
              solve(solver, some_problem(), {.parameters = {{name, value}}}), value);
    return r.message;
  };
  for (const char* value : {"2.5", "2", "0", "-1", "nan", "inf", "1.2x", "", " 1", "1e"}) {
    EXPECT_TRUE(says(message("pgs", "omega", value), "omega = '" + std::string(value) + "'"));
  }
  for (const char* value : {"0", "1.5"}) {
    EXPECT_TRUE(says(message("pgs", "local_iterations", value), "an integer in [1, 1000]"));
  }
  EXPECT_TRUE(says(message("uzawa", "rho", "papers"), "stable|paper"));
  EXPECT_TRUE(says(message("uzawa", "rho", ""), "stable|paper"));
  EXPECT_TRUE(says(message("uzawa", "rho", "stable|paper"), "expected one of"));
}

TEST(Solve, ParametersThatDoNotFitTheProblemAreInvalidInput) {
  const ContactProblem local = local_form(some_problem());
  const SolveResult r = ended(SolveStatus::kInvalidInput,
                              solve("ipm", local, {.parameters = {{"linear_system", "body"}}}));
  EXPECT_MESSAGE(r, "ipm: the body form needs H");
  const SolveResult cut =
      ended(SolveStatus::kInvalidInput,
            solve("pgs", some_problem(), {.stop = StopTest::kRaw42, .islands = true}));
  EXPECT_MESSAGE(cut, "guarded stop test alone");
}

TEST(Solve, LimitsOfAnEntryAreInvalidInput) {
  SolverEntry entry = *find_solver("pgs");
  entry.max_dim = 2;
  EXPECT_EQ(solve(entry, some_problem(3)).status, SolveStatus::kInvalidInput);
  EXPECT_EQ(solve(entry, some_problem(2)).status, SolveStatus::kConverged);
  entry.max_contacts = 13;
  const SolveResult r = ended(SolveStatus::kInvalidInput, solve(entry, some_problem(2)));
  EXPECT_MESSAGE(r, "at most 13 contacts, the problem has 14");
}

TEST(Solve, AssemblesTheOperatorForSolversThatNeedIt) {
  SolverEntry entry{.name = "needs W", .needs_delassus = true};
  entry.run = run_of([](const ContactProblem& p, const SolverOptions& options) {
    EXPECT_TRUE(p.has_delassus());
    return solve("pgs", p, options);
  });
  ContactProblem p = some_problem();
  p.W = SparseRows();
  EXPECT_EQ(solve(entry, p).status, SolveStatus::kConverged);
}

// Solvers that do not keep the contract.

SolverEntry saboteur(SolveResult (*run)(const ContactProblem&, const SolverOptions&)) {
  return SolverEntry{.name = "saboteur", .run = run_of(run)};
}

SolveResult claim(Vector s) {
  return SolveResult{.status = SolveStatus::kConverged, .message = "trust me", .s = std::move(s)};
}
/// One that claims so many rows more than there are, all of this value.
SolverEntry claiming(double value, int more_rows = 0) {
  return {.name = "saboteur", .run = run_of([=](const ContactProblem& p, const SolverOptions&) {
                                return claim(Vector::Constant(p.num_rows() + more_rows, value));
                              })};
}

void expect_caught(const SolverEntry& entry, const std::string& part,
                   const std::vector<StopTest>& stops = {StopTest::kGuarded, StopTest::kRaw42}) {
  for (int dim = 1; dim <= 3; ++dim) {
    const ContactProblem p = some_problem(dim);
    for (const StopTest stop : stops) {
      SolverOptions options{.stop = stop};
      const SolveResult r = ended(SolveStatus::kNumericalFailure, solve(entry, p, options), dim);
      EXPECT_MESSAGE(r, part);
      EXPECT_EQ(r.s.size(), p.num_rows());
      EXPECT_EQ(r.u.size(), p.num_rows());
      EXPECT_TRUE(r.s.allFinite());
      EXPECT_TRUE(r.u.allFinite());
      EXPECT_GT(r.error.guarded(), options.tol);
    }
  }
}

TEST(Sabotage, ZerosAndAClaimOfConvergence) {
  expect_caught(claiming(0), "withdrawn");
  EXPECT_MESSAGE(solve(claiming(0), some_problem(), {.tol = 1.25e-3}),
                 "tolerance 1.25e-3 (it said: trust me");
}

TEST(Sabotage, NothingToDoIsAClaimToo) {
  expect_caught(saboteur([](const ContactProblem& p, const SolverOptions&) {
                  SolveResult r = claim(Vector::Zero(p.num_rows()));
                  r.status = SolveStatus::kNothingToDo;
                  return r;
                }),
                "withdrawn");
}

TEST(Sabotage, NotANumber) {
  expect_caught(claiming(kNaN), "non-finite");
  expect_caught(saboteur([](const ContactProblem& p, const SolverOptions&) {
                  Vector s = Vector::Zero(p.num_rows());
                  s[0] = kInfinity;
                  return claim(s);
                }),
                "non-finite");
}

TEST(Sabotage, OnlyTheTangentialPartMoves) {
  const SolverEntry tangential =
      saboteur([](const ContactProblem& p, const SolverOptions& options) {
        SolverOptions guarded = options;
        guarded.stop = StopTest::kGuarded;
        SolveResult r = solve("pgs", p, guarded);
        for (int c = 0; c < p.num_contacts(); ++c) r.s[c * p.dim] = 0;
        return r;
      });
  expect_caught(tangential, "withdrawn", {StopTest::kGuarded});
  // Who asks for the raw (42) gets it: the projected impulses slide as they should and penetrate,
  // which it does not see. The guarded error beside it does.
  EXPECT_GT(solve(tangential, some_problem(), {.stop = StopTest::kRaw42}).error.guarded(), 0.1);
}

TEST(Sabotage, OnlyTheNormalPartMoves) {
  for (int dim = 2; dim <= 3; ++dim) {
    const SolveResult r = solve(saboteur([](const ContactProblem& p, const SolverOptions& options) {
                                  SolveResult inner = solve("pgs", p, options);
                                  for (int i = 0; i < p.num_rows(); ++i) {
                                    if (i % p.dim != 0) inner.s[i] = 0;
                                  }
                                  return inner;
                                }),
                                some_problem(dim));
    EXPECT_EQ(r.status, SolveStatus::kNumericalFailure) << r.message;
  }
}

TEST(Sabotage, WrongSize) {
  expect_caught(claiming(0, -1), "rows, expected");
  expect_caught(
      saboteur([](const ContactProblem&, const SolverOptions&) { return claim(Vector()); }),
      "returned 0 rows");
}

TEST(Sabotage, Exceptions) {
  expect_caught(saboteur([](const ContactProblem&, const SolverOptions&) -> SolveResult {
                  throw std::runtime_error("the pivot broke");
                }),
                "the pivot broke");
  expect_caught(saboteur([](const ContactProblem&, const SolverOptions&) -> SolveResult {
                  throw 42;  // not even an exception
                }),
                "saboteur failed");
}

TEST(Sabotage, NoStatus) {
  expect_caught(saboteur([](const ContactProblem& p, const SolverOptions&) {
                  return SolveResult{.s = Vector::Zero(p.num_rows())};
                }),
                "without a status");
}

TEST(Sabotage, AFlatteringErrorIsOverwritten) {
  const SolveResult r = solve(saboteur([](const ContactProblem& p, const SolverOptions&) {
                                SolveResult mine = claim(Vector::Zero(p.num_rows()));
                                mine.error.epsilon = mine.error.eta = 0;
                                return mine;
                              }),
                              some_problem());
  EXPECT_GT(r.error.guarded(), 1e-3);
}

TEST(Sabotage, AnHonestFailureKeepsItsStatus) {
  const SolveResult r = solve(saboteur([](const ContactProblem& p, const SolverOptions&) {
                                SolveResult mine = claim(Vector::Zero(p.num_rows()));
                                mine.status = SolveStatus::kStalled;
                                return mine;
                              }),
                              some_problem());
  EXPECT_EQ(r.status, SolveStatus::kStalled);
  EXPECT_EQ(r.message, "trust me");
}

// Stop tests and history.

TEST(StopTests, Raw42IsMetInThePapersSense) {
  for (int dim = 2; dim <= 3; ++dim) {
    const SolveResult r =
        converged(solve("pgs", some_problem(dim), {.tol = 1e-6, .stop = StopTest::kRaw42}));
    EXPECT_LE(r.error.raw42, 1e-6);
    EXPECT_MESSAGE(r, "raw42");
  }
}

TEST(StopTests, Raw42IsNeverMetWithoutFriction) {
  const SolveResult r = solve("uzawa", some_problem(1),
                              {.tol = 1e-6, .stop = StopTest::kRaw42, .max_iterations = 50});
  EXPECT_FALSE(is_success(r.status)) << r.message;
  EXPECT_TRUE(std::isnan(r.error.raw42));
}

TEST(StopTests, ImpulseComparesConsecutiveIterates) {
  SolverOptions options{.tol = 1e-3, .stop = StopTest::kImpulse};
  std::vector<int> judged;
  options.on_iteration = [&](const IterationRecord& record) { judged.push_back(record.iteration); };
  const SolveResult r = converged(solve("pgs", some_problem(), options));
  EXPECT_MESSAGE(r, "impulse");
  for (int k = 0; k < static_cast<int>(judged.size()); ++k) EXPECT_EQ(judged[k], k);  // every one
  ASSERT_GE(r.iterations, 1);
}

TEST(Solve, AStartBeyondAllNumbersIsReplacedByZero) {
  const ContactProblem p = some_problem();
  const SolveResult from_zero = converged(solve("pgs", p));
  for (const double size : {1e120, 1e160, 1e200}) {
    const SolveResult r = converged(solve("pgs", p, {.s0 = Vector::Constant(p.num_rows(), size)}));
    EXPECT_EQ(r.iterations, from_zero.iterations) << size;
  }
}

TEST(StopTests, AnExactStartDoesNotMeetTheImpulseTestByItself) {
  // One impulse says nothing about successive ones: at least one iteration.
  const Manufactured m = manufactured_problem(2, 12, 14, 3);
  const SolveResult r =
      converged(solve("pgs", m.problem, {.tol = 1e-6, .stop = StopTest::kImpulse, .s0 = m.s}));
  EXPECT_EQ(r.iterations, 1);
}

TEST(History, IsCalledAtTheStatedCadence) {
  // Whenever the count has grown by its root or by 1/32 (from 1024 on); the last one always.
  SolverOptions options{.tol = 1e-300, .max_iterations = 1500, .parameters = {{"rho", "stable"}}};
  std::vector<IterationRecord> records;
  options.on_iteration = [&](const IterationRecord& record) {
    records.push_back(record);
    const ContactCount count = record.count();
    EXPECT_EQ(count.take_off + count.stick + count.slip, 60);
  };
  const ContactProblem p = manufactured_problem(2, 30, 60, 5).problem;
  const SolveResult r = ended(SolveStatus::kIterationLimit, solve("uzawa", p, options));
  std::vector<int> judged;
  for (const IterationRecord& record : records) judged.push_back(record.iteration);
  const std::vector<int> first = {0, 1, 2, 3, 4, 6, 8, 10, 13, 16, 20, 24, 28, 33, 38, 44, 50, 57};
  ASSERT_GT(judged.size(), first.size());
  EXPECT_EQ(std::vector<int>(judged.begin(), judged.begin() + std::ssize(first)), first);
  for (std::size_t i = 2; i + 1 < judged.size(); ++i) {
    const int k = judged[i - 1], grown = judged[i] - k;
    EXPECT_TRUE(k >= 1024 ? grown == k / 32 : grown * grown <= k && (grown + 1) * (grown + 1) > k)
        << k << " to " << judged[i];
  }
  EXPECT_EQ(judged.back(), 1500);
  double time = 0, best = kInfinity;
  for (const IterationRecord& record : records) {
    EXPECT_GE(record.seconds, time);
    time = record.seconds;
    best = std::min(best, record.error.guarded());
    EXPECT_GT(record.step, 0);
  }
  EXPECT_NEAR(best, r.error.guarded(), 1e-9 * best);  // the best iterate is returned
}

TEST(History, DoesNotChangeTheIterates) {
  const ContactProblem p = some_problem();
  for (const SolverEntry& entry : solver_table()) {
    SolverOptions options;
    const SolveResult quiet = solve(entry, p, options);
    int calls = 0;
    options.on_iteration = [&](const IterationRecord&) { ++calls; };
    const SolveResult watched = solve(entry, p, options);
    EXPECT_EQ(quiet.s, watched.s) << entry.name;
    EXPECT_EQ(quiet.iterations, watched.iterations) << entry.name;
    EXPECT_GT(calls, 0) << entry.name;
  }
}

TEST(Solve, IsDeterministic) {
  for (int dim = 1; dim <= 3; ++dim) {
    for (const SolverEntry& entry : solver_table()) {
      if (dim > entry.max_dim) continue;
      const SolveResult a = solve(entry, some_problem(dim)), b = solve(entry, some_problem(dim));
      EXPECT_EQ(a.s, b.s) << entry.name;
      EXPECT_EQ(a.iterations, b.iterations) << entry.name;
      EXPECT_EQ(a.status, b.status) << entry.name;
    }
  }
}

TEST(Solve, EveryStatusAndStopTestHasAName) {
  for (int k = 0; k <= static_cast<int>(SolveStatus::kInvalidInput); ++k) {
    EXPECT_NE(to_string(static_cast<SolveStatus>(k)), "unknown status") << k;
  }
  EXPECT_TRUE(is_success(SolveStatus::kConverged));
  EXPECT_TRUE(is_success(SolveStatus::kNothingToDo));
  EXPECT_FALSE(is_success(SolveStatus::kStalled));
  EXPECT_EQ(to_string(StopTest::kGuarded), "guarded");
  EXPECT_EQ(to_string(StopTest::kRaw42), "raw42");
  EXPECT_EQ(to_string(StopTest::kImpulse), "impulse");
}

TEST(Registry, EntriesAreCompleteAndTheirNamesDiffer) {
  std::vector<std::string> names = solver_names();
  for (const SolverEntry& entry : solver_table()) {
    EXPECT_EQ(find_solver(entry.name), &entry);
    EXPECT_FALSE(entry.summary.empty());
    EXPECT_NE(entry.run, nullptr);
    for (const ParameterSpec& spec : entry.parameters) {
      EXPECT_FALSE(spec.help.empty()) << entry.name << ' ' << spec.name;
      // The default is a valid value.
      SolverOptions options{
          .parameters = {{std::string(spec.name), std::string(spec.default_value)}}};
      EXPECT_NE(solve(entry, ContactProblem{}, options).status, SolveStatus::kInvalidInput)
          << entry.name << ' ' << spec.name;
    }
  }
  EXPECT_EQ(find_solver("no such solver"), nullptr);
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end());
}

/// A cube of m₂ kg on one of m₁ kg on a floor, edges of 1 m, a contact at each corner of their lower
/// faces; one step of 1 ms from rest.
ContactProblem two_cubes(double m1, double m2) {
  ContactProblem p{.dim = 3};
  Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(12, 12), wrench = Eigen::MatrixXd::Zero(12, 24);
  for (int body = 0; body < 2; ++body) {
    const double m = body == 0 ? m1 : m2;
    mass.diagonal().segment<3>(6 * body).setConstant(m);
    mass.diagonal().segment<3>(6 * body + 3).setConstant(m / 6);
  }
  const Vec3 axes[] = {Vec3::UnitZ(), Vec3::UnitX(), Vec3::UnitY()};
  for (int c = 0; c < 8; ++c) {
    const Vec3 corner(c & 1 ? 0.5 : -0.5, c & 2 ? 0.5 : -0.5, 0);
    for (int k = 0; k < 3; ++k) {
      const auto push = [&](int body, double sign, double z) {
        wrench.col(3 * c + k).segment<3>(6 * body) = sign * axes[k];
        wrench.col(3 * c + k).segment<3>(6 * body + 3) =
            sign * (corner + Vec3(0, 0, z)).cross(axes[k]);
      };
      push(c / 4, 1, -0.5);
      if (c >= 4) push(0, -1, 0.5);
    }
  }
  p.A = mass.sparseView();
  p.H = wrench.sparseView();
  p.v_free = Vector::Zero(12);
  p.v_free[2] = p.v_free[8] = -9.81e-3;
  p.u_free = wrench.transpose() * p.v_free;
  p.mu = Vector::Constant(8, 0.5);
  return p;
}

// Rounding of impulses of 1e5 kg leaves more than 1e-8 of the energy of 1e-3 kg: a solver that gets
// there says so, whichever it is. The lower corners bear both weights, the upper ones one.
TEST(Solve, EachSolverSaysWhatDoublesAllow) {
  const ContactProblem p = two_cubes(1e-3, 1e5);
  int said = 0;
  for (const SolverEntry& entry : solver_table()) {
    const SolveResult result = solve(entry, p, {.max_iterations = 200000, .time_limit = 2});
    if (result.status == SolveStatus::kInvalidInput) continue;  // for the plane alone
    if (result.status == SolveStatus::kTimeLimit) continue;     // that keeps its name
    if (!(result.error.guarded() <= rounding_floor(p, result.s, result.error))) continue;
    ++said;
    EXPECT_EQ(result.status, SolveStatus::kStalled) << entry.name << ": " << result.message;
    EXPECT_EQ(result.message.rfind("as exact as doubles allow: ", 0), 0u)
        << entry.name << ": " << result.message;
    double lower = 0, upper = 0;
    for (int c = 0; c < 8; ++c) (c < 4 ? lower : upper) += result.s[3 * c];
    EXPECT_NEAR(lower, 981.00000981, 1e-3) << entry.name;
    EXPECT_NEAR(upper, 981, 1e-3) << entry.name;
  }
  EXPECT_GE(said, 2);  // a busy machine cuts others off by time
}

}  // namespace
}  // namespace bipot
