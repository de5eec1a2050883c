#include "solvers/disks/symmetric_sweep.h"

#include "core/problem/delassus.h"
#include "solvers/disks/contact_order.h"
#include "solvers/kernels/contact_sweep.h"
#include "tests/support/bit_hash.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

ContactProblem leaning(int dim, int rows) {
  return triangular_lattice(rows, {.dim = dim, .tilt = 0.2, .e_n = 0.2, .e_t = dim == 1 ? 0 : 0.7});
}

struct Prepared {
  ContactProblem problem;
  DelassusOperator delassus{problem};
  ContactScaling scaling = equilibrated_scaling(problem, delassus.diagonal());
};

template <int D>
Vector iterated(const Prepared& at, const Execution& execution, double& turn, int sweeps = 1) {
  SymmetricSweep<D> sweep(at.problem, *at.delassus.bodies<D>(), at.scaling, 1.3, sweeps, execution);
  sweep.reset(Vector::Zero(at.problem.num_rows()));
  for (int k = 0; k < 20; ++k) turn = sweep.iterate(0.1 * (k % 5));
  return sweep.impulse();
}

/// Rows of a packing whose order is cut into strips: with R rows it has 3 R² contacts in 7 R
/// levels, and 4 strips of 40 contacts a level need R > 373.
constexpr int kWide = 380;

void check_order(int rows_of_packing) {
  const ContactProblem p = leaning(2, rows_of_packing);
  const DiskStructure disks = *DelassusOperator(p).disks();
  const ContactTiles order = order_contacts(disks);
  // Tiles are pieces of the order, each with the bodies that it is the first to come to.
  ASSERT_GT(order.tiles.size(), 2u);
  int batches = 0, rows = 0;
  for (const ContactTiles::Tile& tile : order.tiles) {
    EXPECT_EQ(tile.first_batch, batches);
    EXPECT_EQ(tile.first_row, rows);
    for (int lane = tile.first_batch * kLanes; lane < tile.last_batch * kLanes; ++lane) {
      const int c = order.contact[to_size(lane)];
      if (c < 0) continue;
      EXPECT_LT(order.row[to_size(disks.contacts[to_size(c)].i)], tile.last_row - 1);
    }
    batches = tile.last_batch;
    rows = tile.last_row;
  }
  EXPECT_EQ(batches, order.num_batches());
  EXPECT_EQ(rows, order.num_rows);
  std::vector<int> batch(disks.contacts.size(), -1), tile(batch);
  for (int t = 0; t < static_cast<int>(order.tiles.size()); ++t) {
    const ContactTiles::Tile& of = order.tiles[to_size(t)];
    for (int lane = of.first_batch * kLanes; lane < of.last_batch * kLanes; ++lane) {
      const int c = order.contact[to_size(lane)];
      if (c < 0) continue;
      ASSERT_EQ(batch[to_size(c)], -1) << "twice";
      batch[to_size(c)] = lane / kLanes;
      tile[to_size(c)] = t;
    }
  }
  ASSERT_EQ(std::count(batch.begin(), batch.end(), -1), 0);
  EXPECT_GT(8.0 * order.num_batches(), disks.contacts.size());
  EXPECT_LT(order.num_batches(), 0.25 * static_cast<double>(disks.contacts.size()));

  const std::vector<int> row = body_rows(disks);
  const auto place = [&](const DiskStructure::Contact& c) {
    const int i = row[to_size(c.i)];
    if (c.j == disks.surroundings()) return std::pair(i, -1);
    const int j = row[to_size(c.j)];
    return std::pair(std::min(i, j), std::max(i, j));
  };
  std::vector<std::vector<int>> of_body(disks.bodies.size() - 1);
  for (int c = 0; c < p.num_contacts(); ++c) {
    const DiskStructure::Contact& contact = disks.contacts[to_size(c)];
    of_body[to_size(contact.i)].push_back(c);
    if (contact.j != disks.surroundings()) of_body[to_size(contact.j)].push_back(c);
  }
  for (std::vector<int>& contacts : of_body) {
    std::stable_sort(contacts.begin(), contacts.end(), [&](int a, int b) {
      return place(disks.contacts[to_size(a)]) < place(disks.contacts[to_size(b)]);
    });
    for (std::size_t k = 1; k < contacts.size(); ++k) {
      const std::size_t now = to_size(contacts[k]), before = to_size(contacts[k - 1]);
      EXPECT_GE(batch[now], batch[before] + (tile[now] == tile[before] ? 2 : 1));
    }
  }
}

TEST(SymmetricSweep, BatchesKeepTheOrderOfTheRows) {
  check_order(30);
  check_order(kWide);
}

TEST(SymmetricSweep, StripsInSpaceKeepTheGivenOrder) {
  const ContactProblem p = cubic_lattice(24, {.dim = 3, .tilt = 0.2});
  const SphereStructure spheres = *DelassusOperator(p).bodies<3>();
  const ContactTiles order = symmetric_order(spheres);
  EXPECT_NE(order.contact, given_order(spheres).contact);
  std::vector<int> batch(spheres.contacts.size(), -1), last(spheres.bodies.size(), -1);
  for (std::size_t lane = 0; lane < order.contact.size(); ++lane) {
    const int c = order.contact[lane];
    if (c >= 0) batch[to_size(c)] = static_cast<int>(lane) / kLanes;
  }
  for (std::size_t c = 0; c < batch.size(); ++c) {
    ASSERT_GE(batch[c], 0);
    const auto& contact = spheres.contacts[c];
    for (const int body : {contact.i, contact.j}) {
      if (body == spheres.surroundings()) continue;
      EXPECT_GT(batch[c], last[to_size(body)]);
      last[to_size(body)] = batch[c];
    }
  }
}

TEST(SymmetricSweep, StripsOfAWidePackingOccupyManyThreads) {
  const auto gain = [](int rows) {
    const Prepared at{leaning(2, rows)};
    const SymmetricSweep<2> sweep(at.problem, *at.delassus.disks(), at.scaling, 1.3, 2,
                                  {8, SimdPath::kAuto});
    return sweep.schedule({2, 2}).gain();
  };
  // Two sweeps each way that follow each other occupy two threads. Four strips occupy four times
  // as many, but for the beginning and the end of the sweeps up and down.
  EXPECT_LT(gain(100), 2);
  EXPECT_GT(gain(kWide), 4);
}

TEST(SymmetricSweep, GoesAlongTheRowsWhereThatFillsTheLanes) {
  const auto disks_of = [](int rows) {
    const ContactProblem p = leaning(2, rows);
    return *DelassusOperator(p).disks();
  };
  const DiskStructure large = disks_of(40), middle = disks_of(30), small = disks_of(12);
  EXPECT_EQ(symmetric_order(large).contact, order_contacts(large).contact);
  EXPECT_EQ(symmetric_order(middle).contact, tile_contacts(middle).contact);
  // A batch for two contacts, and one for six or more.
  EXPECT_GT(3 * order_contacts(small).num_batches(), static_cast<int>(small.contacts.size()));
  EXPECT_LT(6 * symmetric_order(small).num_batches(), static_cast<int>(small.contacts.size()));
}

/// The scalar sweeps of DiskSweep forth and back in the order of the batches, from y.
template <int D>
void check_against_scalar(int rows, int sweeps) {
  const Prepared at{leaning(D, rows)};
  const ContactProblem& p = at.problem;
  const ContactTiles order = symmetric_order(*at.delassus.disks());
  const Vector diagonal = at.delassus.diagonal();
  DiskSweep<D> scalar(p, *at.delassus.disks());
  for (int c = 0; c < p.num_contacts(); ++c) {
    scalar.set_steps(c, 1.3 * diagonal.segment<D>(c * D).cwiseInverse(), p.mu[c]);
  }
  Vector now = Vector::Zero(p.num_rows()), before = now;
  double expected = 0;
  for (int k = 0; k < 20; ++k) {
    const Vector y = now + 0.1 * (k % 5) * (now - before);
    scalar.reset(y);
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      for (const int c : order.contact) {
        if (c >= 0) scalar.relax(c);
      }
    }
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      for (auto c = order.contact.rbegin(); c != order.contact.rend(); ++c) {
        if (*c >= 0) scalar.relax(*c);
      }
    }
    before = now;
    now = scalar.impulse();
    expected = diagonal.dot((y - now).cwiseProduct(now - before));
  }
  double turn = 0;
  EXPECT_LT((iterated<D>(at, {}, turn, sweeps) - now).norm(), 1e-12 * now.norm());
  EXPECT_NEAR(turn, expected, 1e-9 * std::abs(expected));
}

TEST(SymmetricSweep, IsTheScalarSweepForthAndBackFromY) {
  for (const int sweeps : {1, 2, 3}) {
    SCOPED_TRACE(sweeps);
    for (const int rows : {12, 40}) {  // as they fill the lanes, and along the rows
      check_against_scalar<1>(rows, sweeps);
      check_against_scalar<2>(rows, sweeps);
    }
  }
}

const std::vector<Execution> kEveryPath = {
    {1, SimdPath::kPortable}, {1, SimdPath::kAvx2}, {1, SimdPath::kAvx512}};
const std::vector<Execution> kEveryTeam = {{2}, {3}, {4}};

template <int D>
void check_bits(const ContactProblem& p, const std::vector<Execution>& others,
                const std::vector<int>& all_sweeps) {
  const Prepared at{p};
  for (const int sweeps : all_sweeps) {
    double turn = 0;
    const Vector alone = iterated<D>(at, {}, turn, sweeps);
    ASSERT_GT(alone.norm(), 0);
    for (const Execution& execution : others) {
      if (!has_path(execution.path)) continue;
      SCOPED_TRACE(fmt::format("{} contacts, {} sweeps, {}, threads {}", p.num_contacts(), sweeps,
                               to_string(execution.path), execution.threads));
      double other = 0;
      EXPECT_TRUE(same_bits(iterated<D>(at, execution, other, sweeps), alone));
      EXPECT_EQ(std::memcmp(&other, &turn, sizeof(double)), 0);
    }
  }
}

TEST(SymmetricSweep, HasTheSameBitsFromEveryPath) {
  for (const int rows : {12, 40}) {
    check_bits<1>(leaning(1, rows), kEveryPath, {2});
    check_bits<2>(leaning(2, rows), kEveryPath, {2});
  }
}

TEST(SymmetricSweep, HasTheSameBitsForAnyNumberOfThreads) {
  check_bits<2>(leaning(2, 30), kEveryTeam, {1, 2, 5});  // as they fill the lanes
  check_bits<2>(leaning(2, 40), kEveryTeam, {1, 2, 5});  // along the rows
  check_bits<2>(leaning(2, kWide), kEveryTeam, {2});     // in strips
  check_bits<3>(cubic_lattice(24, {.dim = 3, .tilt = 0.2}), kEveryTeam, {2});
}

TEST(SymmetricSweep, RefreshKeepsTheImpulse) {
  const Prepared at{leaning(2, 12)};
  SymmetricSweep<2> sweep(at.problem, *at.delassus.disks(), at.scaling, 1.3, 2, {});
  sweep.reset(Vector::Zero(at.problem.num_rows()));
  for (int k = 0; k < 5; ++k) sweep.iterate(0.3);
  const Vector before = sweep.impulse();
  sweep.refresh();
  EXPECT_EQ(sweep.impulse(), before);
  // What a sweep does is a question of the impulse alone.
  sweep.iterate(0);
  SymmetricSweep<2> other(at.problem, *at.delassus.disks(), at.scaling, 1.3, 2, {});
  other.reset(before);
  other.iterate(0);
  EXPECT_LT((sweep.impulse() - other.impulse()).norm(), 1e-13 * before.norm());
  // Of spheres, in strips.
  const Prepared space{cubic_lattice(24, {.dim = 3, .tilt = 0.2})};
  SymmetricSweep<3> strips(space.problem, *space.delassus.bodies<3>(), space.scaling, 1.3, 2, {2});
  strips.reset(Vector::Zero(space.problem.num_rows()));
  for (int k = 0; k < 2; ++k) strips.iterate(0.1);
  const Vector kept = strips.impulse();
  strips.refresh();
  EXPECT_EQ(strips.impulse(), kept);
}

}  // namespace
}  // namespace bipot
