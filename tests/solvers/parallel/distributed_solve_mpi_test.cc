// Solvers on several processes against those of one.

#include "core/base/triplets.h"
#include "solvers/parallel/distributed_solve.h"
#include "solvers/solve_run.h"
#include "tests/solvers/parallel/mpi_group.h"
#include "tests/support/converged.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/manufactured.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

struct NamedProblem {
  std::string name;
  ContactProblem problem;
};

std::vector<NamedProblem> problems() {
  std::vector<NamedProblem> list;
  list.push_back({"square lattice", square_lattice(8, {.tilt = 0.05})});
  list.push_back({"triangular lattice", triangular_lattice(8)});
  list.push_back({"triangular lattice, d = 1", triangular_lattice(8, {.dim = 1})});
  list.push_back({"restitution", square_lattice(6, {.e_n = 0.5, .e_t = 0.2})});
  list.push_back({"spheres", cubic_lattice(4)});
  list.push_back({"pile", shipped_file("2d_pour12_170.hdf5")});
  list.push_back({"moving", shipped_file("2d_strike12_450.hdf5")});
  return list;
}

bool same_everywhere(const Vector& x) {
  double signs[2] = {0, 0};
  for (int i = 0; i < x.size(); ++i) {
    signs[0] += x[i] * (1 + i % 7);
    signs[1] -= x[i] * (1 + i % 7);
  }
  const double mine = signs[0];
  mpi_group().largest(signs);
  return signs[0] == mine && -signs[1] == mine;
}

/// What all processes together find of it, to the tolerance of the options.
DistributedResult solved_by_all(const std::string& solver, const NamedProblem& p,
                                const SolverOptions& options, const DistributedOptions& how = {}) {
  const DistributedResult out = distributed_solve(solver, p.problem, options, mpi_group(), how);
  SCOPED_TRACE(p.name + ", " + solver + ": " + out.result.message);
  EXPECT_EQ(out.result.status, SolveStatus::kConverged);
  // The whole impulse, judged on one process: the same figures.
  const ContactError error = contact_error(p.problem, out.result.s);
  EXPECT_LE(error.guarded(), options.tol * (1 + 1e-6));
  EXPECT_NEAR(error.epsilon, out.result.error.epsilon, 1e-6 * error.epsilon + 1e-16);
  EXPECT_NEAR(error.eta, out.result.error.eta, 1e-6 * error.eta + 1e-16);
  EXPECT_EQ(error.worst_epsilon, out.result.error.worst_epsilon);
  EXPECT_EQ(error.worst_eta, out.result.error.worst_eta);
  EXPECT_TRUE(same_everywhere(out.result.s));
  EXPECT_TRUE(same_everywhere(out.result.u));
  return out;
}

/// Those that run on the parts of a problem, and some that run on the first process.
std::vector<std::string> several_solvers() {
  std::vector<std::string> names{"admm", "ipm"};
  if (find_solver("newton") != nullptr) names.push_back("newton");
  for (const SolverEntry& entry : solver_table()) {
    if (runs_on_parts(entry, {}) != Parallel::kNo) names.emplace_back(entry.name);
  }
  return names;
}
bool gets_near(const std::string& solver) {
  return solver != "uzawa" && solver != "classical" && solver != "pgs";
}

TEST(DistributedSolve, EverySolverMeetsTheToleranceOfTheWhole) {
  EXPECT_GE(several_solvers().size(), 9u);
  for (const NamedProblem& p : problems()) {
    for (const std::string& solver : several_solvers()) {
      solved_by_all(solver, p, {.tol = gets_near(solver) ? 1e-6 : 1e-3, .max_iterations = 200000});
    }
  }
}

TEST(DistributedSolve, RollingFrictionIsJudgedAndSolvedAsOnOneProcess) {
  for (const int rows : {3, 6}) {
    ContactProblem problem = manufactured_rolling(rows, 12, 18, 1).problem;
    problem.W = SparseRows();
    for (const std::string& solver : several_solvers()) {
      if (!require_solver(solver).rolls) continue;
      solved_by_all(solver, {"rows " + std::to_string(rows), problem},
                    {.tol = 1e-4, .max_iterations = 200000});
    }
  }
}

TEST(DistributedSolve, AProcessWithoutAContactLearnsThatThoseOfTheOthersRoll) {
  for (const int rows : {3, 6}) {
    ContactProblem problem;
    for (unsigned seed = 1; problem.num_contacts() == 0 || problem.u_free[0] >= 0; ++seed) {
      problem = manufactured_rolling(rows, 4, 1, seed).problem;  // until the contact closes
    }
    problem.W = SparseRows();
    solved_by_all("auto", {"one contact, rows " + std::to_string(rows), problem}, {.tol = 1e-4});
  }
}

TEST(DistributedSolve, VelocitiesAreThoseOfOneProcessWhereTheyAreUnique) {
  // Without friction the energy is a convex quadratic, strictly convex in the velocities of the
  // bodies: these are unique. Its excess over the least one is at most of the size of the guarded
  // error squared times E, so that velocities agree to about the root of 1e-10.
  const ContactProblem p = triangular_lattice(8, {.dim = 1, .tilt = 0.1});
  const Vector v = body_velocities(p, converged(solve("ipm", p, {.tol = 1e-12})).s);
  for (const char* solver : {"apgd", "anderson", "pgs"}) {
    const DistributedResult out = distributed_solve(solver, p, {.tol = 1e-10}, mpi_group());
    ASSERT_EQ(out.result.status, SolveStatus::kConverged) << solver << out.result.message;
    EXPECT_LE((body_velocities(p, out.result.s) - v).norm(), 1e-4 * p.v_free.norm()) << solver;
  }
}

TEST(DistributedSolve, AStartFarBeyondTheFreeMotionIsNoGrowth) {
  // The energy is quadratic in s: a start of 1e14 times what carries the weights has some 1e28
  // times the energy of the free violation, 1e20 of which is divergence.
  const ContactProblem p = square_lattice(6, {.tilt = 0.05});
  Vector s0 = Vector::Zero(p.num_rows());
  for (int n = 0; n < p.num_rows(); n += p.dim) s0[n] = 1e14 * p.u_free.cwiseAbs().maxCoeff();
  ASSERT_GT(contact_error(p, s0).energy,
            1e20 * contact_error(p, Vector::Zero(p.num_rows())).energy);
  for (const char* solver : {"apgd", "uzawa", "pgs"}) {
    SolverOptions options{.tol = 1e-6, .max_iterations = 40, .s0 = s0};
    const DistributedResult out = distributed_solve(solver, p, options, mpi_group());
    EXPECT_NE(out.result.status, SolveStatus::kDiverged) << solver << ": " << out.result.message;
    EXPECT_GT(out.result.iterations, 0) << solver;
  }
}

/// The best of so many iterations, all of them judged.
SolverOptions first_iterations(int count) {
  return SolverOptions{.tol = 1e-300, .max_iterations = count};
}

TEST(DistributedSolve, GradientIteratesAreThoseOfOneProcess) {
  for (const NamedProblem& p : problems()) {
    SCOPED_TRACE(p.name);
    const SolverOptions options = first_iterations(25);
    const SolveResult one = solve("apgd", p.problem, options);
    const DistributedResult out = distributed_solve("apgd", p.problem, options, mpi_group());
    ASSERT_EQ(out.result.iterations, one.iterations);
    EXPECT_LE((out.result.s - one.s).norm(), 1e-9 * one.s.norm());
  }
}

TEST(DistributedSolve, UzawaHasTheBitsOfOneProcess) {
  // Its iterates hold no sum over contacts, and velocities are added up in the order of the whole.
  for (const NamedProblem& p : problems()) {
    SCOPED_TRACE(p.name);
    if (!body_nodes(p.problem).everywhere.empty()) continue;
    const SolverOptions options = first_iterations(30);
    const SolveResult one = solve("uzawa", p.problem, options);
    const DistributedResult out = distributed_solve("uzawa", p.problem, options, mpi_group());
    EXPECT_EQ(out.result.iterations, one.iterations);
    EXPECT_TRUE(out.result.s == one.s) << (out.result.s - one.s).norm();
    EXPECT_TRUE(out.result.u == one.u);
  }
}

TEST(DistributedSolve, ReproducibleGradientHasTheSameBitsForAnyNumberOfProcesses) {
  for (const NamedProblem& p : problems()) {
    SCOPED_TRACE(p.name);
    SolverOptions options{.tol = 1e-6};
    const auto lone = lone_process();
    const DistributedOptions exact{.reproducible = true};
    const DistributedResult one = distributed_solve("apgd", p.problem, options, *lone, exact);
    const DistributedResult out = distributed_solve("apgd", p.problem, options, mpi_group(), exact);
    ASSERT_EQ(out.result.status, SolveStatus::kConverged);
    EXPECT_EQ(out.result.iterations, one.result.iterations);
    EXPECT_EQ(out.result.error.epsilon, one.result.error.epsilon);
    EXPECT_EQ(out.result.error.eta, one.result.error.eta);
    EXPECT_TRUE(out.result.s == one.result.s);
    EXPECT_TRUE(out.result.u == one.result.u);
  }
}

TEST(DistributedSolve, TheSameProcessesGetTheSameBitsAgain) {
  const ContactProblem p = shipped_file("2d_pour12_170.hdf5");
  for (const std::string& solver : several_solvers()) {
    const SolverOptions options = first_iterations(300);
    const DistributedResult a = distributed_solve(solver, p, options, mpi_group());
    const DistributedResult b = distributed_solve(solver, p, options, mpi_group());
    EXPECT_TRUE(a.result.s == b.result.s) << solver;
    EXPECT_TRUE(a.result.error.epsilon == b.result.error.epsilon) << solver;
  }
}

TEST(DistributedSolve, AProcessWithoutABodyTakesPart) {
  // One disk on a floor: of P processes P - 1 have nothing, and each of them is in every sum.
  const NamedProblem p{"one contact",
                       one_contact_problem(2, 1, 3, 0.5, -1, Vector::Constant(1, 0.3))};
  for (const std::string& solver : several_solvers()) {
    const DistributedResult out = solved_by_all(solver, p, {.tol = 1e-10});
    // Sticks: s_n = 1 / 1, s_t = -0.3 / 3.
    EXPECT_NEAR(out.result.s[0], 1, 1e-4);
    EXPECT_NEAR(out.result.s[1], -0.1, 1e-4);
    EXPECT_EQ(out.counts.imbalance, mpi_group().size());
  }
}

/// A disk of radius 3 in the middle of a ring of 24 disks of radius 0.45 that it pushes outwards,
/// each held by a fixed wall outside: 24 contacts of the middle, 24 with the wall.
ContactProblem wheel(std::vector<Vec3>& places) {
  constexpr int kRing = 24;
  ContactProblem p{.dim = 2};
  const int dofs = 3 * (kRing + 1), contacts = 2 * kRing;
  Triplets H, A;
  // The ring first, so that contacts belong to its disks and the middle is everybody's ghost.
  const int middle = 3 * kRing;
  p.v_free = Vector::Zero(dofs);
  for (int k = 0; k < dofs; ++k) A.emplace_back(k, k, k < middle ? 1.0 : 20.0);
  for (int k = 0; k < kRing; ++k) {
    const double angle = 2 * M_PI * (k + 0.5) / kRing, nx = std::cos(angle), ny = std::sin(angle);
    const auto side = [&](int contact, int dof, double sign, double arm, double n_sign) {
      H.emplace_back(dof, 2 * contact, sign * n_sign * nx);
      H.emplace_back(dof + 1, 2 * contact, sign * n_sign * ny);
      H.emplace_back(dof, 2 * contact + 1, -sign * n_sign * ny);
      H.emplace_back(dof + 1, 2 * contact + 1, sign * n_sign * nx);
      H.emplace_back(dof + 2, 2 * contact + 1, -arm);
    };
    side(2 * k, 3 * k, 1, 0.45, 1);  // n from the middle to the ring's disk
    side(2 * k, middle, -1, 3, 1);
    side(2 * k + 1, 3 * k, 1, 0.45, -1);  // n from the wall inwards
    p.v_free[3 * k + 1] = -0.3;
    places.push_back(Vec3(3 * nx, 3 * ny, 0));
    places.push_back(Vec3(3.9 * nx, 3.9 * ny, 0));
  }
  p.v_free[middle] = 1;
  p.v_free[middle + 1] = -2;
  p.v_free[middle + 2] = 0.5;
  p.H = from_triplets(dofs, 2 * contacts, H);
  p.A = from_triplets(dofs, dofs, A);
  p.mu = Vector::Constant(contacts, 0.4);
  p.u_free = p.H.transpose() * p.v_free;
  return p;
}

TEST(DistributedSolve, ABodyMayTouchAllProcesses) {
  std::vector<Vec3> places;
  const NamedProblem p{"wheel", wheel(places)};
  ASSERT_EQ(validate(p.problem), "");
  const int P = mpi_group().size();
  const BodyNodes nodes = body_nodes(p.problem);
  ASSERT_EQ(nodes.nodes, 25);
  ASSERT_TRUE(nodes.everywhere.empty());
  const ContactOwners owners = contact_owners(p.problem, nodes, places, P);
  const ProblemPiece piece = cut_piece(p.problem, nodes, owners, mpi_group().rank());
  EXPECT_EQ(piece.sharers.back(), P);  // the middle is the last body
  EXPECT_EQ(piece.sharers.front(), 1);
  for (const std::string& solver : several_solvers()) {
    const DistributedResult out =
        solved_by_all(solver, p, {.tol = 1e-8}, {.contact_places = places});
    EXPECT_LE(out.counts.imbalance, 1.2);  // an even part of the ring each
  }
  const SolverOptions few = first_iterations(20);
  const SolveResult one = solve("apgd", p.problem, few);
  const DistributedResult out =
      distributed_solve("apgd", p.problem, few, mpi_group(), {.contact_places = places});
  EXPECT_LE((out.result.s - one.s).norm(), 1e-9 * one.s.norm());
}

TEST(DistributedSolve, ADrivenWallMayBeCutByAllProcesses) {
  const NamedProblem p{"compression", shipped_file("2d_isotropic_compression.hdf5")};
  ASSERT_FALSE(body_nodes(p.problem).everywhere.empty());
  const ProblemPiece piece = piece_here(p.problem);
  EXPECT_FALSE(piece.everywhere.empty()) << "no contact of a driven wall is here";
  const SolverOptions few = first_iterations(20);
  const SolveResult one = solve("apgd", p.problem, few);
  const DistributedResult same = distributed_solve("apgd", p.problem, few, mpi_group());
  EXPECT_LE((same.result.s - one.s).norm(), 1e-9 * one.s.norm());
  EXPECT_LE((same.result.u - one.u).norm(), 1e-9 * one.u.norm());
  for (const std::string& solver : several_solvers()) solved_by_all(solver, p, {.tol = 1e-3});
  SolverOptions options{.tol = 1e-5};
  const auto lone = lone_process();
  const DistributedOptions exact{.reproducible = true};
  const DistributedResult a = distributed_solve("apgd", p.problem, options, *lone, exact);
  const DistributedResult b = distributed_solve("apgd", p.problem, options, mpi_group(), exact);
  EXPECT_EQ(a.result.iterations, b.result.iterations);
  EXPECT_TRUE(a.result.s == b.result.s);
}

TEST(DistributedSolve, AnIterationIsOneExchangeAndOneReduction) {
  const ContactProblem p = triangular_lattice(16);
  const ProblemPiece piece = piece_here(p);
  // What a process sends in one exchange: its contacts in the halos of others, d = 2 doubles each.
  std::vector<double> owner_of_copies;
  for (const ProcessGroup::RemoteItem& item : piece.copies) owner_of_copies.push_back(item.owner);
  const std::vector<double> partners = mpi_group().gather(owner_of_copies);
  double bytes = 16.0 * static_cast<double>(std::count(partners.begin(), partners.end(),
                                                       static_cast<double>(mpi_group().rank())));
  mpi_group().largest({&bytes, 1});
  const auto traffic = [&](int iterations, const char* solver) {
    return distributed_solve(solver, p, first_iterations(iterations), mpi_group()).counts.traffic;
  };
  const ProcessGroup::Traffic a = traffic(20, "apgd"), b = traffic(30, "apgd");
  // Ten iterations, each an exchange and the reduction of 3 numbers; iterates 24, 28 and 30 are
  // judged, each an exchange and the criterion's reduction (10 sums, 2 norms, 2 wishes to stop).
  EXPECT_EQ(b.reductions - a.reductions, 13);
  EXPECT_EQ(b.reduced_bytes - a.reduced_bytes, (10 * 3 + 3 * 14) * 8);
  EXPECT_EQ(b.bytes - a.bytes, static_cast<std::int64_t>(13 * bytes));
  if (mpi_group().size() == 1) {
    EXPECT_EQ(b.messages, 0);
  } else {
    EXPECT_GT(bytes, 0);
    EXPECT_GE(b.messages - a.messages, 13);
  }
  // A sweep and an Uzawa step have no reduction of their own.
  for (const char* solver : {"pgs", "uzawa"}) {
    const ProcessGroup::Traffic c = traffic(20, solver), d = traffic(30, solver);
    EXPECT_EQ(d.reductions - c.reductions, 3) << solver;
    EXPECT_EQ(d.bytes - c.bytes, static_cast<std::int64_t>(13 * bytes)) << solver;
  }
}

TEST(DistributedSolve, SplitMassesBoundTheOperator) {
  // s·W s <= s·W~ s for every s, which is what makes sweeps side by side converge; with the bodies'
  // whole masses on every process it does not hold: two processes that push a body the same way.
  const ContactProblem p = triangular_lattice(6);
  const ProblemPiece piece = piece_here(p);
  const DelassusOperator whole(p);
  Vector u;
  int violated = 0;
  for (int draw = 0; draw < 50; ++draw) {
    Vector s(p.num_rows());
    for (int i = 0; i < s.size(); ++i) s[i] = std::sin(1.0 + 37.0 * draw + 1.7 * i * (draw + 1));
    whole.apply(s, u);
    double forms[2] = {0, 0};  // with split and with whole masses
    Vector mine(piece.own.num_rows());
    for (std::size_t c = 0; c < piece.number.size(); ++c) {
      mine.segment<2>(2 * static_cast<int>(c)) = s.segment<2>(2 * piece.number[c]);
    }
    const Vector momentum = piece.own.H * mine;
    for (int k = 0; k < momentum.size(); ++k) {
      const double form = momentum[k] * momentum[k] / piece.own.A.coeff(k, k);
      forms[0] += form * piece.sharers[to_size(k)];
      forms[1] += form;
    }
    mpi_group().sum(forms);
    EXPECT_LE(s.dot(u), forms[0] * (1 + 1e-12));
    if (mpi_group().size() == 1) {
      EXPECT_NEAR(s.dot(u), forms[0], 1e-12 * forms[0]);
    }
    if (s.dot(u) > forms[1] * (1 + 1e-12)) ++violated;
  }
  EXPECT_EQ(violated > 0, mpi_group().size() > 1);
}

TEST(DistributedSolve, AllStopWhereOneIsInterruptedOrOutOfTime) {
  const ContactProblem p = shipped_file("2d_pour300_392.hdf5");
  const bool last = mpi_group().rank() == mpi_group().size() - 1;
  SolverOptions options{.tol = 1e-14};
  int polls = 0;
  options.cancelled = [&] { return last && ++polls > 40; };
  for (const char* solver : {"apgd", "anderson", "pgs", "auto"}) {
    polls = 0;
    const DistributedResult out = distributed_solve(solver, p, options, mpi_group());
    EXPECT_EQ(out.result.status, SolveStatus::kInterrupted) << solver << ": " << out.result.message;
    EXPECT_TRUE(out.result.s.allFinite());
  }
  options.cancelled = {};
  options.time_limit = last ? 0.05 : 1e9;
  const DistributedResult out = distributed_solve("apgd", p, options, mpi_group());
  EXPECT_EQ(out.result.status, SolveStatus::kTimeLimit) << out.result.message;
}

TEST(DistributedSolve, RefusalsSayWhy) {
  const ContactProblem p = triangular_lattice(4);
  const auto refusal = [&](const char* solver, const ContactProblem& problem,
                           const SolverOptions& options) {
    const DistributedResult out = distributed_solve(solver, problem, options, mpi_group());
    EXPECT_EQ(out.result.status, SolveStatus::kInvalidInput);
    return out.result.message;
  };
  const SolverOptions plain;
  EXPECT_TRUE(says(refusal("apdg", p, plain), "apgd"));
  EXPECT_TRUE(says(refusal("apgd", local_form(p), plain), "W alone"));
  ContactProblem coupled = p;
  coupled.A.coeffRef(0, 3) = coupled.A.coeffRef(3, 0) = 1e-3 * p.A.coeff(0, 0);
  coupled.A.makeCompressed();
  EXPECT_TRUE(says(refusal("apgd", coupled, plain), "not diagonal"));
  SolverOptions options{.parameters = {{"nonsense", "1"}}};
  EXPECT_TRUE(says(refusal("apgd", p, options), "nonsense"));
  options.parameters = {{"islands", "on"}};
  EXPECT_TRUE(says(refusal("apgd", p, options), "islands"));
  SolverOptions start;
  // One process alone has a start of the wrong size: all refuse.
  if (mpi_group().rank() == mpi_group().size() - 1) start.s0 = Vector::Zero(1);
  EXPECT_TRUE(says(refusal("apgd", p, start), "s0"));
}

// With the bits of one process.
TEST(DistributedSolve, OtherSolversAndParametersRunOnTheFirstProcess) {
  const ContactProblem p = triangular_lattice(4, {.tilt = 0.1});
  const std::pair<const char*, std::map<std::string, std::string>> ways[] = {
      {"lemke", {}},
      {"assor", {}},
      {"pgs", {{"order", "shuffled"}}},
      {"uzawa", {{"refresh", "gauss-seidel"}}}};
  for (const auto& [solver, parameters] : ways) {
    SolverOptions options{.tol = 1e-6, .parameters = parameters};
    const SolveResult one = solve(solver, p, options);
    const SolveResult out = distributed_solve(solver, p, options, mpi_group()).result;
    EXPECT_EQ(out.status, SolveStatus::kConverged) << solver << ": " << out.message;
    EXPECT_TRUE(says(out.message, "on the root process"));
    EXPECT_EQ(out.iterations, one.iterations) << solver;
    EXPECT_TRUE(out.s == one.s) << solver;
  }
  SolverOptions exact{.parameters = {{"order", "shuffled"}}};
  EXPECT_EQ(distributed_solve("pgs", p, exact, mpi_group(), {.reproducible = true}).result.status,
            SolveStatus::kInvalidInput);
}

TEST(DistributedSolve, NothingToDoAndGoodStartsAreSeen) {
  const ContactProblem p = triangular_lattice(5);
  EXPECT_EQ(distributed_solve("apgd", ContactProblem{}, {}, mpi_group()).result.status,
            SolveStatus::kNothingToDo);
  ContactProblem apart = p;
  apart.u_free.setConstant(1);
  EXPECT_EQ(distributed_solve("apgd", apart, {}, mpi_group()).result.status,
            SolveStatus::kNothingToDo);
  SolverOptions options{.tol = 1e-8,
                        .s0 = distributed_solve("apgd", p, {.tol = 1e-9}, mpi_group()).result.s};
  const DistributedResult out = distributed_solve("apgd", p, options, mpi_group());
  EXPECT_EQ(out.result.status, SolveStatus::kConverged);
  EXPECT_EQ(out.result.iterations, 0);
}

}  // namespace
}  // namespace bipot
