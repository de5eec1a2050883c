#include "core/problem/sphere_structure.h"

#include "core/problem/delassus.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/manufactured.h"
#include "tests/support/random_vector.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(SphereStructure, IsFoundInPackings) {
  for (const ContactProblem& p :
       {cubic_lattice(3), shipped_file("3d_sphere_pyramid_4.hdf5"), cubic_lattice(1)}) {
    const auto spheres = sphere_structure(p);
    ASSERT_TRUE(spheres.has_value());
    EXPECT_EQ(spheres->contacts.size(), p.mu.size());
    EXPECT_EQ(spheres->bodies.size() - 1, static_cast<std::size_t>(p.num_dofs()) / 6);
    EXPECT_EQ(spheres->bodies.back().inverse_mass, 0);
  }
}

/// Products by bodies are those by H, whatever the number of threads.
void expect_products_of(const ContactProblem& p, int walls) {
  const Vector s = random_vector(p.num_rows(), 1);
  const Vector expected = p.H.transpose() * Vector((p.H * s).cwiseQuotient(p.A.diagonal()));
  Vector first;
  for (const int threads : {1, 3}) {
    const DelassusOperator packed(p, DelassusOperator::Form::kAuto, threads);
    ASSERT_TRUE(packed.bodies<3>().has_value());
    EXPECT_EQ(packed.bodies<3>()->walls, walls);
    Vector u;
    packed.apply(s, u);
    EXPECT_LT((u - expected).norm(), 1e-14 * expected.norm());
    if (threads == 1) first = u;
    EXPECT_EQ(u, first);
  }
}

TEST(SphereStructure, GivesTheSameProductsAsH) {
  expect_products_of(cubic_lattice(4, {.e_n = 0.1, .e_t = 1}), 0);
  expect_products_of(shipped_file("3d_sphere_pyramid_4.hdf5"), 0);
}

// Normal forces alone move the walls, whatever the tangential impulses.
TEST(SphereStructure, DrivenWallsAreBodies) {
  ContactProblem p = cubic_lattice(4, {.e_n = 0.1, .e_t = 1});
  for (const Vec3& normal : {Vec3(0, 0, 1), Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0)}) {
    p = with_driven_wall(p, normal, 2, 0.1);
  }
  expect_products_of(p, 4);
  int c = 0;
  while (p.H.coeff(p.num_dofs() - 1, 3 * c) == 0) ++c;
  ContactProblem dragged = p;
  dragged.H.coeffRef(p.num_dofs() - 1, 3 * c + 2) = 1e-6;
  EXPECT_FALSE(sphere_structure(dragged).has_value());
  while (p.H.coeff(p.num_dofs() - 4, 3 * c) == 0) ++c;
  ContactProblem two_normals = p;
  two_normals.H.coeffRef(p.num_dofs() - 1, 3 * c) = -1;
  two_normals.H.coeffRef(p.num_dofs() - 4, 3 * c) = 0;
  EXPECT_FALSE(sphere_structure(two_normals).has_value());
}

TEST(SphereStructure, RefusesWhatIsNotASphere) {
  const ContactProblem lattice = cubic_lattice(2);
  EXPECT_FALSE(sphere_structure(manufactured_problem(3, 4, 5, 1).problem).has_value());
  EXPECT_FALSE(sphere_structure(triangular_lattice(3)).has_value());
  for (const int dof : {6, 9}) {  // one direction of a mass, of a moment of inertia
    ContactProblem changed = lattice;
    changed.A.coeffRef(dof, dof) *= 1 + 1e-12;
    EXPECT_FALSE(sphere_structure(changed).has_value()) << dof;
  }
  // Every entry of a contact of two spheres matters, and so does a moment of the normal force.
  int c = 0;
  while (lattice.H.col(3 * c).nonZeros() != 2) ++c;
  for (int k = 0; k < 3; ++k) {
    for (SparseMatrix::InnerIterator it(lattice.H, 3 * c + k); it; ++it) {
      ContactProblem changed = lattice;
      changed.H.coeffRef(static_cast<int>(it.row()), 3 * c + k) *= 1 + 1e-12;
      EXPECT_FALSE(sphere_structure(changed).has_value()) << it.row() << " " << k;
    }
  }
  ContactProblem turning = lattice;
  turning.H.coeffRef(3, 3 * c) = 1e-6;
  EXPECT_FALSE(sphere_structure(turning).has_value());
}

}  // namespace
}  // namespace bipot
