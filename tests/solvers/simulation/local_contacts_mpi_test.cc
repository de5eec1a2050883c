// What each process finds on its bodies and ghosts against detection and assembly on the whole.

#include "core/criterion/rounding_bound.h"
#include "solvers/parallel/distributed_solve.h"
#include "solvers/parallel/distributed_space.h"
#include "solvers/parallel/whole_problem.h"
#include "solvers/simulation/domain_piece.h"
#include "tests/solvers/parallel/mpi_group.h"
#include "tests/solvers/simulation/domain_scenes.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// The first step of a scene, of the whole and of this process.
template <int D>
struct CutStep {
  State<D> whole;
  Midpoint<D> mid;
  DomainState<D> state;
  LocalBodies<D> local;
  Midpoint<D> local_mid;
  LocalContacts<D> contacts;

  CutStep(const Scene<D>& scene, ProcessGroup& group)
      : whole(initial_state(scene)), mid(make_midpoint(scene, whole)) {
    // With the contacts as weights, as in the course of a run.
    State<D> weighed = whole;
    for (const Contact<D>& c : mid.contacts) weighed.contacts.push_back({.contact = c});
    state = cut_state(weighed, cut_cells(weighed, group.size()), group.rank());
    local = with_ghosts(scene, state, group);
    local_mid = free_midpoint(scene, local.state);
    contacts = find_local_contacts(scene, local, local_mid, state.bodies, group);
  }
  Contact<D> numbered(Contact<D> c) const {
    const int here = static_cast<int>(local.numbers.size());
    c.i = local.numbers[to_size(c.i)];
    c.j = c.j < here ? local.numbers[to_size(c.j)] : state.bodies + c.j - here;
    return c;
  }
};

/// The contact problem of that step, of the whole and of this process.
template <int D>
struct CutProblem : CutStep<D> {
  ContactProblem problem;
  ProblemPiece piece;

  CutProblem(const Scene<D>& scene, ProcessGroup& group)
      : CutStep<D>(scene, group),
        problem(assemble_step(scene, this->mid).problem),
        piece(assemble_piece(scene, this->local, this->local_mid, this->contacts,
                             this->state.bodies, group)
                  .piece) {}
  /// The whole of the impulses of which each process has its part.
  Vector gathered(const Vector& s, ProcessGroup& group) const {
    const int dim = problem.dim;
    Buffer mine;
    for (int c = 0; c < piece.own.num_contacts(); ++c) {
      mine.push_back(piece.number[to_size(c)]);
      for (int k = 0; k < dim; ++k) mine.push_back(s[c * dim + k]);
    }
    const Buffer all = group.gather(mine);
    Vector impulse = Vector::Zero(problem.num_rows());
    for (BufferReader reader(all); !reader.at_end();) {
      const int c = reader.integer();
      for (int k = 0; k < dim; ++k) impulse[c * dim + k] = reader.number();
    }
    return impulse;
  }
};

template <int D>
void put_all(const Contact<D>& c, int number, Buffer& out) {
  out.insert(out.end(), {static_cast<double>(c.i), static_cast<double>(c.j), c.gap});
  out.insert(out.end(), c.n.begin(), c.n.end());
  out.push_back(number);
}

template <int D>
void expect_whole_detection(const Scene<D>& scene, ProcessGroup& group) {
  const CutStep<D> cut(scene, group);
  // Every process writes down its own contacts, all read the whole list.
  Buffer mine;
  for (std::size_t k = 0; k < cut.contacts.own.size(); ++k) {
    put_all<D>(cut.numbered(cut.contacts.own[k]), cut.contacts.number[k], mine);
  }
  const std::vector<double> all = group.gather(mine);
  constexpr std::size_t kWidth = D + 4;
  ASSERT_EQ(all.size(), kWidth * cut.mid.contacts.size());
  EXPECT_EQ(cut.contacts.whole, static_cast<int>(cut.mid.contacts.size()));
  std::vector<std::vector<double>> got, expected;
  for (std::size_t k = 0; k < cut.mid.contacts.size(); ++k) {
    got.emplace_back(all.begin() + static_cast<std::ptrdiff_t>(k * kWidth),
                     all.begin() + static_cast<std::ptrdiff_t>((k + 1) * kWidth));
    put_all<D>(cut.mid.contacts[k], static_cast<int>(k), expected.emplace_back());
  }
  std::sort(got.begin(), got.end());
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(got, expected);  // the same bits, the same numbers
  // The halo is all that touches an own body or a body of an own contact: found here on the whole.
  const auto bodies = cut.whole.bodies.size();
  std::vector<char> follow(bodies, 0);
  for (const int k : cut.state.numbers) follow[to_size(k)] = 1;
  for (const Contact<D>& c : cut.contacts.own) {
    const Contact<D> n = cut.numbered(c);
    if (to_size(n.j) < bodies) follow[to_size(n.j)] = 1;
  }
  for (std::size_t k = 0; k < bodies; ++k) {
    if (cut.whole.bodies[k].wall >= 0) follow[k] = 0;
  }
  std::vector<double> needed, here;
  for (std::size_t k = 0; k < cut.mid.contacts.size(); ++k) {
    const Contact<D>& c = cut.mid.contacts[k];
    const bool own = std::binary_search(cut.state.numbers.begin(), cut.state.numbers.end(), c.i);
    if (own || follow[to_size(c.i)] != 0 || (to_size(c.j) < bodies && follow[to_size(c.j)] != 0)) {
      needed.push_back(static_cast<double>(k));
    }
  }
  // Copied from their owners, the numbers of the halo are those of the whole.
  const auto exchange =
      group.make_exchange(static_cast<int>(cut.contacts.own.size()), cut.contacts.copies);
  const std::vector<double> own_numbers(cut.contacts.number.begin(), cut.contacts.number.end());
  std::vector<double> halo(cut.contacts.copies.size());
  exchange->copy(own_numbers, halo, 1);
  here.resize(cut.contacts.all.size(), -1);
  for (std::size_t k = 0; k < own_numbers.size(); ++k) {
    here[to_size(cut.contacts.owned[k])] = own_numbers[k];
  }
  for (std::size_t k = 0; k < halo.size(); ++k) here[to_size(cut.contacts.halo[k])] = halo[k];
  EXPECT_EQ(here, needed);
}

/// Of disks on the processes of this program and on a lone one, of spheres on the former.
template <class Check>
void on_all_scenes(const Check& check) {
  const auto lone = lone_process();
  for (const NamedScene& s : domain_scenes()) {
    SCOPED_TRACE(s.name);
    check(s.scene, mpi_group());
    check(s.scene, *lone);
  }
  check(box_of_spheres(), mpi_group());
}

TEST(Domains, ContactsAreThoseOfDetectionOnTheWhole) {
  on_all_scenes(
      [](const auto& scene, ProcessGroup& group) { expect_whole_detection(scene, group); });
}

TEST(Domains, OneBodyIsPushedByAllProcessesAndOneWallIsCutByAll) {
  ProcessGroup& group = mpi_group();
  for (const NamedScene& s : domain_scenes()) {
    if (s.name != "one touches all" && s.name != "pressed") continue;
    const CutProblem<2> cut(s.scene, group);
    const int most = cut.piece.sharers.empty()
                         ? 0
                         : *std::max_element(cut.piece.sharers.begin(), cut.piece.sharers.end());
    double shared[1] = {static_cast<double>(most)};
    group.largest(shared);
    if (s.name == "one touches all") {
      EXPECT_EQ(shared[0], group.size());
    } else {
      EXPECT_EQ(cut.piece.everywhere_inverse_mass.size(), 1u);
      EXPECT_GE(shared[0], std::min(group.size(), 2));  // the lid
    }
  }
}

TEST(Domains, ProcessesWithoutABodyTakePart) {
  // Two disks: at most two processes have one, and the others have nothing to send or to solve.
  ProcessGroup& group = mpi_group();
  for (const NamedScene& s : domain_scenes()) {
    if (s.name != "two disks") continue;
    const CutStep<2> cut(s.scene, group);
    std::int64_t empty[1] = {cut.state.numbers.empty() ? 1 : 0};
    group.sum(empty);
    EXPECT_GE(empty[0], group.size() - 2);
    if (cut.state.numbers.empty()) {
      EXPECT_TRUE(cut.local.numbers.empty());
    }
  }
}

/// A number for each row of the whole, the same on every process.
double impulse_of(int row) { return 0.1 + std::abs(std::sin(1.0 + 7.3 * row)); }

template <int D>
void expect_whole_products(const Scene<D>& scene, ProcessGroup& group) {
  const CutProblem<D> cut(scene, group);
  if (cut.problem.num_contacts() == 0) return;
  const ContactProblem& own = cut.piece.own;
  Vector s(own.num_rows()), all(cut.problem.num_rows());
  for (int row = 0; row < all.size(); ++row) all[row] = impulse_of(row);
  for (int c = 0; c < own.num_contacts(); ++c) {
    s.segment(c * own.dim, own.dim) = all.segment(cut.piece.number[to_size(c)] * own.dim, own.dim);
  }
  DistributedSpace space(cut.piece, group, false);
  Vector u;
  space.velocity(s, u);
  // One process with the whole, through the same kernel.
  const auto lone = lone_process();
  const BodyNodes nodes = body_nodes(cut.problem);
  const ProblemPiece one =
      cut_piece(cut.problem, nodes, contact_owners(cut.problem, nodes, {}, 1), 0);
  DistributedSpace alone(one, *lone, false);
  Vector expected;
  alone.velocity(all, expected);
  const bool driven = !cut.piece.everywhere_inverse_mass.empty();
  for (int c = 0; c < own.num_contacts(); ++c) {
    for (int k = 0; k < own.dim; ++k) {
      const double here = u[c * own.dim + k];
      const double there = expected[cut.piece.number[to_size(c)] * own.dim + k];
      if (driven) {
        EXPECT_NEAR(here, there, 1e-13 * expected.cwiseAbs().maxCoeff());
      } else {
        EXPECT_EQ(here, there);
      }
    }
  }
  // The gathered problem is the whole, bit for bit.
  const ContactProblem gathered = gather_problem(cut.piece, group);
  if (group.rank() == 0) {
    EXPECT_EQ((gathered.H - cut.problem.H).norm(), 0);
    EXPECT_EQ((gathered.A - cut.problem.A).norm(), 0);
    EXPECT_EQ(gathered.u_free, cut.problem.u_free);
    EXPECT_EQ(gathered.v_free, cut.problem.v_free);
    EXPECT_EQ(gathered.mu, cut.problem.mu);
    EXPECT_EQ(gathered.row_scale, cut.problem.row_scale);
  }
  // The bound of the pieces is that of the whole, but for the order of its sums, and for the
  // longest row, which each has of its own: shorter where a process has contacts with walls alone.
  const RoundingBound bound = distributed_rounding_bound(space, s);
  const RoundingBound of_whole = rounding_bound(cut.problem, all, Precision::kDouble);
  EXPECT_LE(bound.epsilon, of_whole.epsilon * (1 + 1e-10));
  EXPECT_GE(bound.epsilon, of_whole.epsilon * (driven ? 1 - 1e-10 : 0.98));
  EXPECT_LE(bound.eta, of_whole.eta * (1 + 1e-10));
  EXPECT_GE(bound.eta, of_whole.eta * (driven ? 1 - 1e-10 : 0.98));
}

TEST(Domains, ProductsAndBoundsAreThoseOfTheWhole) {
  on_all_scenes(
      [](const auto& scene, ProcessGroup& group) { expect_whole_products(scene, group); });
}

TEST(Domains, EverySolverOfPiecesIsJudgedAsOnTheWhole) {
  ProcessGroup& group = mpi_group();
  for (const NamedScene& s : domain_scenes()) {
    const CutProblem<2> cut(s.scene, group);
    for (const char* solver : {"apgd", "anderson", "auto", "ipm"}) {
      SCOPED_TRACE(s.name + ", " + solver);
      const PieceResult out =
          distributed_solve(solver, cut.piece, {.tol = 1e-7, .max_iterations = 100000}, group);
      EXPECT_TRUE(is_success(out.result.status)) << out.result.message;
      if (cut.problem.num_contacts() == 0) {
        EXPECT_EQ(out.result.status, SolveStatus::kNothingToDo);
        continue;
      }
      const ContactError error = contact_error(cut.problem, cut.gathered(out.result.s, group));
      EXPECT_LE(error.guarded(), 1e-7 * (1 + 1e-6));
      EXPECT_NEAR(error.epsilon, out.result.error.epsilon, 1e-6 * error.epsilon + 1e-16);
      EXPECT_EQ(error.worst_epsilon, out.result.error.worst_epsilon);
    }
  }
}

TEST(Domains, AClaimAtRoundingIsProvedOnTheWholeOrNotMade) {
  // 1e-15 is less than the rounding of a double: what says that it is met has been seen in higher
  // precision, on the gathered whole.
  ProcessGroup& group = mpi_group();
  const Scene<2> scene = domain_scenes().front().scene;
  const CutProblem<2> cut(scene, group);
  for (const double tol : {1e-12, 1e-15, 1e-17}) {
    const PieceResult out =
        distributed_solve("ipm", cut.piece, {.tol = tol, .max_iterations = 200}, group);
    const Vector impulse = cut.gathered(out.result.s, group);
    SolverOptions options{.tol = tol};
    const ContactError error = contact_error(cut.problem, impulse);
    const bool holds =
        error.guarded() <= tol && prove_claim(cut.problem, options, impulse, error).holds;
    EXPECT_EQ(out.result.status == SolveStatus::kConverged, holds) << tol << out.result.message;
  }
}

TEST(Domains, WhatDoubleLeavesOpenIsProvedOnTheGatheredWhole) {
  ProcessGroup& group = mpi_group();
  for (const NamedScene& s : domain_scenes()) {
    if (s.name != "triangular" && s.name != "pressed") continue;
    const CutProblem<2> cut(s.scene, group);
    const PieceResult out =
        distributed_solve("apgd", cut.piece, {.tol = 1e-9, .max_iterations = 100000}, group);
    ASSERT_EQ(out.result.status, SolveStatus::kConverged) << out.result.message;
    const Vector impulse = cut.gathered(out.result.s, group);
    DistributedSpace space(cut.piece, group, false);
    GatheredWhole gathered(space);
    const ContactError error = out.result.error;
    SolverOptions options;
    int open = 0;
    for (const double factor : {1 - 1e-7, 1 + 1e-7, 1 + 1e-6, 1.5, 1e3}) {
      options.tol = error.guarded() * factor;
      const ProvedClaim got = gathered.claim(options, out.result.s, error);
      const ProvedClaim expected = prove_claim(cut.problem, options, impulse, error);
      EXPECT_EQ(got.holds, expected.holds) << s.name << factor;
      EXPECT_EQ(std::isnan(got.error), std::isnan(expected.error)) << s.name << factor;
      if (std::isnan(expected.error)) continue;
      EXPECT_EQ(got.error, expected.error);
      ++open;
    }
    EXPECT_GE(open, 2);  // and some were, at more than the rounding
    EXPECT_LT(open, 5);
  }
}

TEST(Domains, GhostsAreCounted) {
  ProcessGroup& group = mpi_group();
  const Scene<2> scene = domain_scenes().front().scene;
  const State<2> whole = initial_state(scene);
  const DomainState<2> state = cut_state(whole, cut_cells(whole, group.size()), group.rank());
  const ProcessGroup::Traffic before = group.traffic();
  const LocalBodies<2> local = with_ghosts(scene, state, group);
  const std::int64_t meetings = group.traffic().reductions - before.reductions;
  // 12 numbers a disk, and each ghost was sent by somebody.
  std::int64_t counted[3] = {group.traffic().bytes - before.bytes,
                             group.traffic().messages - before.messages,
                             static_cast<std::int64_t>(local.numbers.size() - local.own.size())};
  group.sum(counted);
  EXPECT_EQ(counted[0], counted[2] * 12 * 8);
  EXPECT_LE(counted[1], group.size() * (group.size() - 1));
  if (group.size() == 1) {
    EXPECT_EQ(counted[2], 0);
  } else {
    EXPECT_GT(counted[2], 0);
    EXPECT_LT(counted[2], static_cast<std::int64_t>(whole.bodies.size()) * (group.size() - 1));
  }
  // The box of the bodies and the sizes of the buffers: two meetings.
  EXPECT_EQ(meetings, 2);
}

TEST(Domains, WhatOneProcessCannotDetectAllRefuse) {
  ProcessGroup& group = mpi_group();
  Scene<2> scene = domain_scenes().front().scene;
  scene.bodies[1].x = scene.bodies[0].x;
  EXPECT_THROW(CutStep<2>(scene, group), std::exception);  // the whole refuses
  const State<2> whole = initial_state(scene);
  const DomainState<2> state = cut_state(whole, cut_cells(whole, group.size()), group.rank());
  const LocalBodies<2> local = with_ghosts(scene, state, group);
  const Midpoint<2> mid = free_midpoint(scene, local.state);
  EXPECT_THROW(find_local_contacts(scene, local, mid, state.bodies, group), CommonFailure);
}

}  // namespace
}  // namespace bipot
