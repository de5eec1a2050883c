#include "core/problem/contact_wrenches.h"

#include "tests/support/lattice_problem.h"
#include "tests/support/random_vector.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(ContactWrenches, HaveTheBitsOfProductsByColumnsOfH) {
  for (const ContactProblem& p : {shipped_file("1d_square_20.hdf5"), cubic_lattice(3),
                                  shipped_file("2d_isotropic_compression.hdf5")}) {
    const ContactWrenches wrenches(p.H, p.dim);
    const Vector s = random_vector(p.num_rows(), 1), v = random_vector(p.num_dofs(), 2);
    Vector g(p.num_dofs()), u;
    wrenches.momentum(s, g);
    wrenches.velocity(v, u);
    EXPECT_EQ(g, Vector(p.H * s));
    EXPECT_EQ(u, Vector(p.H.transpose() * v));
  }
}

/// Two rows on the degrees of freedom 0, 3 and 4. Row 1 holds a zero for 2.
SparseMatrix two_rows() {
  SparseMatrix H(5, 2);
  H.insert(3, 0) = 2;
  H.insert(4, 0) = -1;
  H.insert(0, 1) = 5;
  H.insert(2, 1) = 0;
  H.insert(3, 1) = 7;
  H.makeCompressed();
  return H;
}

TEST(ContactWrenches, ListEachDegreeOfFreedomOnceAndNoZeros) {
  const ContactWrenches wrenches(two_rows(), 2, Vector::Constant(2, 10.0));
  ASSERT_EQ(wrenches.num_contacts(), 1);
  const std::vector<int> dofs{0, 3, 4};
  const double rows[3][2] = {{0, 50}, {20, 70}, {-10, 0}};
  ASSERT_EQ(wrenches.end(0), 3);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(wrenches.dof(k), dofs[to_size(k)]);
    for (int a = 0; a < 2; ++a) EXPECT_EQ(wrenches.row(k)[a], rows[k][a]);
  }
}

TEST(ContactWrenches, TakeOtherNumbers) {
  ContactWrenches wrenches(two_rows(), 2);
  wrenches.renumber({0, -1, -1, 1, 2});
  Vector g(3);
  wrenches.momentum((Vector(2) << 1, 2).finished(), g);
  EXPECT_EQ(g, Vector((Vector(3) << 10, 16, -1).finished()));
}

}  // namespace
}  // namespace bipot
