#include "core/problem/disk_structure.h"

#include "core/problem/delassus.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/manufactured.h"
#include "tests/support/random_vector.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(DiskStructure, IsFoundInLatticesWithAndWithoutFriction) {
  for (const int dim : {1, 2}) {
    const ContactProblem p = triangular_lattice(5, {.dim = dim, .turn = 0.3});
    const auto disks = disk_structure(p);
    ASSERT_TRUE(disks.has_value()) << dim;
    EXPECT_EQ(disks->contacts.size(), p.mu.size());
    EXPECT_EQ(disks->bodies.size() - 1,
              static_cast<std::size_t>(p.num_dofs()) / (dim == 1 ? 2 : 3));
    EXPECT_EQ(disks->bodies.back().inverse_mass, 0);
  }
}

// Driven walls are bodies: normal forces alone move them, whatever the tangential impulses.
TEST(DiskStructure, GivesTheSameProductsAsH) {
  for (const int dim : {1, 2}) {
    const LatticeOptions o{.dim = dim, .turn = 0.3, .e_n = 0.1, .e_t = dim == 2 ? 1.0 : 0.0};
    const Vec2 up(-std::sin(0.3), std::cos(0.3)), right(std::cos(0.3), std::sin(0.3));
    const Vec2 normals[] = {up, right, -right};
    ContactProblem p = triangular_lattice(5, o);
    // Three walls are as many rows as a disk has.
    for (int walls = 0; walls <= 3; ++walls) {
      if (walls > 0) p = with_driven_wall(p, normals[walls - 1], 3 * walls, 0.1);
      const DelassusOperator packed(p);
      ASSERT_TRUE(packed.disks().has_value()) << dim << " " << walls;
      EXPECT_EQ(packed.disks()->walls, walls);
      EXPECT_EQ(packed.disks()->surroundings() - packed.disks()->first_wall(), walls);
      const Vector s = random_vector(p.num_rows(), 1);
      Vector u;
      packed.apply(s, u);
      const Vector expected = p.H.transpose() * Vector((p.H * s).cwiseQuotient(p.A.diagonal()));
      EXPECT_LT((u - expected).norm(), 1e-14 * expected.norm()) << dim << " " << walls;
    }
  }
}

TEST(DiskStructure, RefusesOtherWalls) {
  const Vec2 up(0, 1);
  const ContactProblem p = with_driven_wall(triangular_lattice(4), up, 2, 0);
  ASSERT_TRUE(disk_structure(p));
  const int wall = p.num_dofs() - 1;
  int of_wall = -1, other = -1;  // contacts with the wall, with a fixed one
  for (int c = 0; c < p.num_contacts(); ++c) {
    if (p.H.coeff(wall, 2 * c) != 0) {
      of_wall = c;
    } else if (disk_structure(p)->contacts[to_size(c)].j == disk_structure(p)->surroundings()) {
      other = c;
    }
  }
  ASSERT_GE(of_wall, 0);
  ASSERT_GE(other, 0);
  ContactProblem dragged = p;  // by friction
  dragged.H.coeffRef(wall, 2 * of_wall + 1) = 1e-6;
  EXPECT_FALSE(disk_structure(dragged));
  ContactProblem lever = p;
  lever.H.coeffRef(wall, 2 * of_wall) *= 1 + 1e-12;
  EXPECT_FALSE(disk_structure(lever));
  ContactProblem two_normals = p;
  two_normals.H.coeffRef(wall, 2 * other) = -1;
  EXPECT_FALSE(disk_structure(two_normals));
}

TEST(DiskStructure, RefusesWhatIsNotADisk) {
  const ContactProblem lattice = triangular_lattice(4);
  EXPECT_FALSE(disk_structure(manufactured_problem(2, 4, 5, 1).problem).has_value());
  EXPECT_FALSE(disk_structure(cubic_lattice(2)).has_value());

  ContactProblem heavier_in_x = lattice;
  heavier_in_x.A.coeffRef(3, 3) *= 1 + 1e-12;
  EXPECT_FALSE(disk_structure(heavier_in_x).has_value());

  // Each entry of H of the contact between disks 1 and 2 matters.
  int column = -1;
  for (int c = 0; c < lattice.num_contacts() && column < 0; ++c) {
    if (lattice.H.col(2 * c).nonZeros() == 2 && lattice.H.coeff(3, 2 * c) != 0 &&
        lattice.H.coeff(6, 2 * c) != 0) {
      column = 2 * c;
    }
  }
  ASSERT_GE(column, 0);
  for (int k = 0; k < 2; ++k) {
    for (SparseMatrix::InnerIterator it(lattice.H, column + k); it; ++it) {
      ContactProblem changed = lattice;
      changed.H.coeffRef(static_cast<int>(it.row()), column + k) *= 1 + 1e-12;
      EXPECT_FALSE(disk_structure(changed).has_value()) << it.row() << " " << k;
    }
  }

  ContactProblem spin_in_normal = lattice;
  spin_in_normal.H.coeffRef(5, column) = 1e-6;
  EXPECT_FALSE(disk_structure(spin_in_normal).has_value());

  ContactProblem local = lattice;
  local.W = assemble_delassus(lattice.A, lattice.H, 2);
  local.A.resize(0, 0);
  local.H.resize(0, 0);
  EXPECT_FALSE(disk_structure(local).has_value());
}

}  // namespace
}  // namespace bipot
