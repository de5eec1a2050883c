#include "solvers/disks/stress_modes.h"

#include <cstring>

#include "core/problem/delassus.h"
#include "solvers/disks/contact_order.h"
#include "solvers/disks/disk_positions.h"
#include "solvers/kernels/contact_scaling.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

ContactProblem stressed_packing(bool square) {
  LatticeOptions o{.tilt = 0.2, .e_n = 0.2, .e_t = 0.7};
  return square ? square_lattice(40, o) : triangular_lattice(40, o);
}

using StressImpulses = std::vector<ImpulseBatch<2>>;
using StressRows = std::vector<BodyRow>;

/// The modes of a packing, and what their kernels do with given impulses.
struct Stressed {
  ContactProblem problem;
  DelassusOperator delassus{problem};
  ContactScaling scaling = equilibrated_scaling(problem, delassus.diagonal());
  DiskTiles<2> tiles{problem, *delassus.disks(), scaling, symmetric_order(*delassus.disks())};
  StressModes modes{tiles, *delassus.disks()};

  const DiskTiles<2>::Tile& tile() const { return tiles.tile(0); }
  StressRows rows() const { return StressRows(to_size(tiles.num_rows())); }
  StressImpulses impulses() const { return StressImpulses(to_size(tiles.num_batches())); }
  /// All contacts closed and far from their edges but every seventh, which is open.
  StressImpulses pressed() const {
    StressImpulses x = impulses();
    for (std::size_t batch = 0; batch < x.size(); ++batch) {
      for (int lane = 0; lane < kLanes; ++lane) {
        x[batch].x[0][lane] = (batch + static_cast<unsigned>(lane)) % 7 == 0 ? 0 : 1;
      }
    }
    return x;
  }
  /// P nodes, and the momentum of the bodies that it makes.
  StressImpulses carried(const Vector& nodes, StressRows& momentum,
                         SimdPath path = SimdPath::kAuto) const {
    StressRows stress = rows();
    modes.interpolate(nodes, stress);
    const StressImpulses y = impulses();
    StressImpulses z = y;
    momentum = rows();
    StressKernels::LoadSums load;
    stress_kernels(path).impulse({tiles.packed(), tiles.num_batches(), modes.share(), stress.data(),
                                  y.data(), z.data(), momentum.data()},
                                 load);
    return z;
  }
  /// StressRows of Pᵀ(W x + b).
  StressRows rates(const StressImpulses& x, SimdPath path = SimdPath::kAuto) const {
    StressRows velocity = rows(), out = rows();
    tiles.velocities(x, velocity);
    stress_kernels(path).rates(
        {tiles.packed(), tiles.num_batches(), modes.share(), velocity.data(), out.data()});
    return out;
  }
};

Vector unit(int size, int k) { return Vector::Unit(size, k); }

// Loops of contacts close: what was walked along some contacts holds for all others.
TEST(DiskPositions, AllContactsAgreeWithThem) {
  for (const bool square : {false, true}) {
    const DiskStructure disks = *disk_structure(stressed_packing(square));
    const DiskPositions positions = disk_positions(disks, 1);
    for (const DiskStructure::Contact& c : disks.contacts) {
      if (c.j == disks.surroundings()) continue;
      const Vec2 apart = positions.centre[to_size(c.i)] - positions.centre[to_size(c.j)];
      const double distance = disks.bodies[to_size(c.i)].arm + disks.bodies[to_size(c.j)].arm;
      EXPECT_NEAR(apart.x(), distance * c.n[0], 1e-13);
      EXPECT_NEAR(apart.y(), distance * c.n[1], 1e-13);
    }
    EXPECT_EQ(positions.companions.front(), disks.surroundings());
  }
}

// Two chains of three disks of arm 1, one along x and one along y, each on a floor of its own.
TEST(DiskPositions, PackingsThatNothingJoinsStandBesideEachOther) {
  DiskStructure disks;
  disks.bodies.resize(7);
  for (int k = 0; k < 6; ++k) disks.bodies[to_size(k)] = {1, 2, 1};
  disks.contacts = {
      {1, 0, {1, 0}}, {1, 2, {-1, 0}}, {3, 4, {0, -1}}, {5, 4, {0, 1}}, {0, 6, {0, 1}}};
  const DiskPositions positions = disk_positions(disks, 10);
  const Vec2 expected[] = {{0, 0}, {2, 0}, {4, 0}, {14, 0}, {14, 2}, {14, 4}};
  for (int k = 0; k < 6; ++k) {
    EXPECT_LT((positions.centre[to_size(k)] - expected[k]).norm(), 1e-14) << k;
    EXPECT_EQ(positions.companions[to_size(k)], 3);
  }
}

// The same stress σ everywhere: a contact between two disks carries σ n in physical impulses, s_n =
// n·σ n and s_t = t·σ n over the factors that restitution puts on the rows, and one with a wall as
// well.
TEST(StressModes, AUniformStressIsCarriedByAllContactsAlike) {
  Stressed at{stressed_packing(false)};
  ASSERT_TRUE(at.modes.renew(at.pressed()));
  ASSERT_GT(at.modes.num_nodes(), 8);
  const double xx = 2, xy = -0.5, yy = 3;
  Vector nodes(3 * at.modes.num_nodes());
  for (int k = 0; k < at.modes.num_nodes(); ++k) nodes.segment<3>(3 * k) = Vec3(xx, xy, yy);
  StressRows momentum;
  const StressImpulses z = at.carried(nodes, momentum);
  const StressImpulses pressed = at.pressed();
  int open = 0;
  for (int lane = 0; lane < at.tiles.num_batches() * kLanes; ++lane) {
    const int c = at.tiles.contact(lane);
    if (c < 0) continue;
    const DiskStructure::Contact& contact = at.delassus.disks()->contacts[to_size(c)];
    const Vec2 n(contact.n[0], contact.n[1]), t(-n.y(), n.x());
    const Vec2 force(xx * n.x() + xy * n.y(), xy * n.x() + yy * n.y());
    const bool closed = pressed[to_size(lane / kLanes)].x[0][lane % kLanes] > 0;
    open += closed ? 0 : 1;
    const Local<2> s = at.tiles.impulse(z, lane);
    EXPECT_NEAR(s[0], closed ? n.dot(force) / contact.normal : 0, 1e-12);
    EXPECT_NEAR(s[1], closed ? t.dot(force) / contact.tangential : 0, 1e-12);
  }
  EXPECT_GT(open, at.problem.num_contacts() / 10);
}

// Column by column from the momenta of single modes, and the gradient of the energy along each of
// them.
TEST(StressModes, TheMatrixIsTheEnergyOfTheModes) {
  for (const bool square : {false, true}) {
    Stressed at{stressed_packing(square)};
    ASSERT_TRUE(at.modes.renew(at.pressed()));
    const int size = 3 * at.modes.num_nodes();
    std::vector<StressRows> momentum(to_size(size));
    for (int k = 0; k < size; ++k) at.carried(unit(size, k), momentum[to_size(k)]);
    Eigen::MatrixXd energy(size, size);
    for (int a = 0; a < size; ++a) {
      for (int b = 0; b < size; ++b) {
        double sum = 0;
        for (int row = 0; row < at.tiles.num_rows(); ++row) {
          for (int k = 0; k < 4; ++k) {
            sum += at.tiles.inverse()[row].value[k] * momentum[to_size(a)][to_size(row)].value[k] *
                   momentum[to_size(b)][to_size(row)].value[k];
          }
        }
        energy(a, b) = sum;
      }
    }
    ASSERT_GT(energy.norm(), 0);
    const Eigen::MatrixXd matrix = at.modes.matrix();
    EXPECT_LT((matrix - energy).norm(), 1e-8 * energy.norm());
  }
}

// After one correction from any impulse nothing is left to correct: the gradient along all modes is
// 0.
TEST(StressModes, OneCorrectionTakesThemOut) {
  Stressed at{stressed_packing(false)};
  ASSERT_TRUE(at.modes.renew(at.pressed()));
  StressRows rows = at.rates(at.pressed());
  const auto along_modes = [&](const StressRows& rates) {
    Vector sum(3 * at.modes.num_nodes());
    for (int k = 0; k < sum.size(); ++k) {
      StressRows stress = at.rows();
      at.modes.interpolate(unit(static_cast<int>(sum.size()), k), stress);
      sum[k] = 0;
      for (std::size_t row = 0; row < stress.size(); ++row) {
        for (int slot = 0; slot < 4; ++slot) {
          sum[k] += stress[row].value[slot] * rates[row].value[slot];
        }
      }
    }
    return sum;
  };
  const double before = along_modes(rows).norm();
  ASSERT_TRUE(at.modes.relax(rows));
  StressImpulses z = at.pressed();
  StressRows momentum = at.rows();
  StressKernels::LoadSums load;
  const StressImpulses nothing = at.impulses();
  stress_kernels(SimdPath::kAuto)
      .impulse({at.tiles.packed(), at.tiles.num_batches(), at.modes.share(), rows.data(),
                nothing.data(), z.data(), momentum.data()},
               load);
  ASSERT_GT(before, 0);
  EXPECT_LT(along_modes(at.rates(z)).norm(), 1e-6 * before);
}

TEST(StressModes, EveryPathGivesTheSameBits) {
  Stressed at{stressed_packing(false)};
  ASSERT_TRUE(at.modes.renew(at.pressed()));
  Vector nodes(3 * at.modes.num_nodes());
  for (int k = 0; k < nodes.size(); ++k) nodes[k] = std::sin(k);
  StressRows momentum;
  const StressImpulses carried = at.carried(nodes, momentum, SimdPath::kPortable);
  const StressRows rates = at.rates(carried, SimdPath::kPortable);
  const auto same = [](const auto& a, const auto& b) {
    return std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0;
  };
  for (const SimdPath path : {SimdPath::kAvx2, SimdPath::kAvx512}) {
    if (!has_path(path)) continue;
    StressRows pushed;
    EXPECT_TRUE(same(at.carried(nodes, pushed, path), carried)) << to_string(path);
    EXPECT_TRUE(same(pushed, momentum)) << to_string(path);
    EXPECT_TRUE(same(at.rates(carried, path), rates)) << to_string(path);
  }
}

// A factor is kept while one contact in a hundred at most has changed, and no longer.
TEST(StressModes, AreMadeAnewWhereManyContactsChanged) {
  Stressed at{stressed_packing(false)};
  StressImpulses x = at.pressed();
  ASSERT_TRUE(at.modes.renew(x));
  const Eigen::MatrixXd first = at.modes.matrix();
  int lane = 0;  // of a contact that carries
  while (at.modes.share()[lane / kLanes].share[lane % kLanes] == 0) ++lane;
  x[to_size(lane / kLanes)].x[0][lane % kLanes] = 0;
  ASSERT_TRUE(at.modes.renew(x));
  EXPECT_EQ((first - Eigen::MatrixXd(at.modes.matrix())).norm(), 0);
  for (ImpulseBatch<2>& batch : x) batch.x[0][2] = 0;
  ASSERT_TRUE(at.modes.renew(x));
  EXPECT_GT((first - Eigen::MatrixXd(at.modes.matrix())).norm(), 1e-3 * first.norm());
}

// Rates along stresses that move nobody, as nothing carries them: no stress is the answer.
TEST(StressModes, SayWhereTheyWouldGrowWithoutBound) {
  Stressed at{stressed_packing(false)};
  StressImpulses x = at.pressed();
  for (std::size_t batch = x.size() / 2; batch < x.size(); ++batch) x[batch] = {};
  ASSERT_TRUE(at.modes.renew(x));
  StressRows rows = at.rates(at.pressed());
  EXPECT_TRUE(at.modes.relax(rows));
  for (BodyRow& row : rows) row.value[kRowX] = 1;
  EXPECT_FALSE(at.modes.relax(rows));
}

TEST(StressModes, FewDisksHaveNone) {
  LatticeOptions o;
  Stressed at{triangular_lattice(12, o)};
  EXPECT_FALSE(at.modes.renew(at.pressed()));
}

}  // namespace
}  // namespace bipot
