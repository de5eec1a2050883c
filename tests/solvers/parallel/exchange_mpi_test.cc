// The exchange on MPI: what is copied, and what is counted.

#include "tests/solvers/parallel/mpi_group.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

std::span<double> all(std::vector<double>& x) { return x; }

TEST(Exchange, CopiesAreTheOriginals) {
  ProcessGroup& group = mpi_group();
  const int P = group.size(), r = group.rank();
  // Everybody owns 10 + rank items of two values and copies item k of process k and the last item
  // of every process, its own as well.
  const int owned = 10 + r;
  std::vector<ProcessGroup::RemoteItem> copies;
  for (int p = 0; p < P; ++p) {
    copies.push_back({p, p});
    copies.push_back({p, 9 + p});
  }
  const auto exchange = group.make_exchange(owned, copies);
  std::vector<double> mine(to_size(2 * owned)), here(copies.size() * 2, -1);
  for (int k = 0; k < owned; ++k) {
    mine[to_size(2 * k)] = 1000 * r + k;
    mine[to_size(2 * k + 1)] = -1000 * r - k;
  }
  exchange->copy(mine, here, 2);
  for (std::size_t k = 0; k < copies.size(); ++k) {
    const double expected = 1000 * copies[k].owner + copies[k].original;
    EXPECT_EQ(here[2 * k], expected);
    EXPECT_EQ(here[2 * k + 1], -expected);
  }
}

TEST(Exchange, MessagesAndBytesAreCounted) {
  ProcessGroup& group = mpi_group();
  const int P = group.size(), r = group.rank();
  // A chain: everybody copies three items of the next process, so that all but the first send one
  // message of 3 items.
  std::vector<ProcessGroup::RemoteItem> copies;
  if (r + 1 < P) copies = {{r + 1, 0}, {r + 1, 2}, {r + 1, 4}};
  const auto exchange = group.make_exchange(5, copies);
  std::vector<double> mine(5 * 2, 1.0), here(copies.size() * 2);
  ProcessGroup::Traffic before = group.traffic();
  exchange->copy(mine, here, 2);
  EXPECT_EQ(group.traffic().messages - before.messages, r > 0 ? 1 : 0);
  EXPECT_EQ(group.traffic().bytes - before.bytes, r > 0 ? 3 * 2 * 8 : 0);
  before = group.traffic();
  double value = 1;
  group.sum({&value, 1});
  EXPECT_EQ(value, P);
  EXPECT_EQ(group.traffic().reductions - before.reductions, 1);
  EXPECT_EQ(group.traffic().reduced_bytes - before.reduced_bytes, 8);
}

TEST(Exchange, SumsTextsAndListsAreTheSameEverywhere) {
  ProcessGroup& group = mpi_group();
  const int P = group.size(), r = group.rank();
  // 1e16 swallows a 1 that is added to it alone: the order of ranks shows, and it is the same
  // again.
  double values[2] = {r == 0 ? 1e16 : 1.0, 1.0 + r};
  double expected = 0;
  for (int p = 0; p < P; ++p) expected += p == 0 ? 1e16 : 1.0;
  group.sum(values);
  EXPECT_EQ(values[0], expected);
  EXPECT_EQ(values[1], P * (P + 1) / 2.0);
  double largest = -r;
  group.largest({&largest, 1});
  EXPECT_EQ(largest, 0);
  EXPECT_TRUE(group.any(r == P - 1));
  EXPECT_FALSE(group.any(false));
  std::vector<double> mine(to_size(r + 1), r);
  const std::vector<double> list = group.gather(mine);
  ASSERT_EQ(list.size(), to_size(P * (P + 1) / 2));
  EXPECT_EQ(list.front(), 0);
  EXPECT_EQ(list.back(), P - 1);
  EXPECT_EQ(group.first_text(""), "");
  EXPECT_EQ(group.first_text(r == P - 1 ? "last" : ""), "last");
  EXPECT_THROW(group.fail_where_any(r == P - 1 ? "reason" : ""), CommonFailure);
  EXPECT_NO_THROW(group.fail_where_any(""));
}

TEST(Exchange, EveryContactOfAnOwnedContactsBodyIsThereOnce) {
  ProcessGroup& group = mpi_group();
  const ContactProblem whole = triangular_lattice(9);
  const ProblemPiece piece = piece_here(whole);
  // All contacts have one owner: the numbers of all processes are 0, 1, ... without a gap.
  std::vector<double> numbers(piece.number.begin(), piece.number.end());
  numbers = group.gather(numbers);
  std::sort(numbers.begin(), numbers.end());
  ASSERT_EQ(numbers.size(), to_size(whole.num_contacts()));
  for (std::size_t k = 0; k < numbers.size(); ++k) EXPECT_EQ(numbers[k], static_cast<double>(k));
  // Copies of a contact's own number are that number.
  const auto exchange = group.make_exchange(piece.own.num_contacts(), piece.copies);
  std::vector<double> mine(piece.number.begin(), piece.number.end()), halo(piece.copies.size());
  exchange->copy(all(mine), halo, 1);
  // The contacts of the piece in its order are those of the whole that touch a body of its own
  // contacts: found here from the bodies of the whole.
  std::vector<char> body(to_size(whole.num_dofs() / 3), 0);
  const auto for_bodies = [&](int c, auto visit) {
    for (SparseMatrix::InnerIterator it(whole.H, c * 2); it; ++it)
      visit(static_cast<int>(it.row()) / 3);
  };
  for (const int c : piece.number) for_bodies(c, [&](int b) { body[to_size(b)] = 1; });
  std::vector<double> expected;
  for (int c = 0; c < whole.num_contacts(); ++c) {
    bool touches = false;
    for_bodies(c, [&](int b) { touches |= body[to_size(b)] != 0; });
    if (touches) expected.push_back(c);
  }
  std::vector<double> got(expected.size(), -1);
  ASSERT_EQ(piece.owned.size() + piece.halo.size(), expected.size());
  for (std::size_t k = 0; k < mine.size(); ++k) got[to_size(piece.owned[k])] = mine[k];
  for (std::size_t k = 0; k < halo.size(); ++k) got[to_size(piece.halo[k])] = halo[k];
  EXPECT_EQ(got, expected);
}

}  // namespace
}  // namespace bipot
