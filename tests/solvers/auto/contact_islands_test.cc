#include "solvers/auto/contact_islands.h"

#include "core/base/portable_random.h"
#include "core/motion/time_stepping.h"
#include "core/problem/delassus.h"
#include "core/scene/scene_parts.h"
#include "solvers/auto/island_problem.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/manufactured.h"
#include "tests/support/side_by_side.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

std::vector<std::vector<int>> lists(const ContactProblem& p) {
  const ContactIslands islands = contact_islands(p);
  std::vector<std::vector<int>> all;
  for (int k = 0; k < islands.count(); ++k) {
    all.emplace_back(islands.of(k).begin(), islands.of(k).end());
  }
  return all;
}
using Lists = std::vector<std::vector<int>>;

/// Two disks of radius 1 on a floor, far from each other.
Scene<2> two_disks(Wall<2> floor) {
  Scene<2> scene = one_law<2>({.mu = 0.3});
  scene.bodies = {round_body<2>(Vec2(0, 1), 1, 2), round_body<2>(Vec2(5, 1), 1, 2)};
  scene.walls = {std::move(floor)};
  scene.step = 0.01;
  scene.contact_distance = 0.1;
  return scene;
}

TEST(ContactIslands, AFixedFloorConnectsNothingAndADrivenOneDoes) {
  Wall<2> floor = half_space<2>(Vec2(0, 0), Vec2(0, 1));
  const Scene<2> fixed = two_disks(floor);
  EXPECT_EQ(lists(step_problem(fixed, initial_state(fixed))), (Lists{{0}, {1}}));
  move_at(floor, Vec2(0, 1));  // no degree of freedom either
  const Scene<2> moving = two_disks(floor);
  EXPECT_EQ(lists(step_problem(moving, initial_state(moving))), (Lists{{0}, {1}}));
  drive(floor, Vec2(0, 1), 1);
  const Scene<2> driven = two_disks(floor);
  EXPECT_EQ(lists(step_problem(driven, initial_state(driven))), (Lists{{0, 1}}));
}

/// A disk in a corner: contact 0 with the floor, 1 with the wall, normals (0, 1) and (1, 0).
ContactProblem corner(double mu_floor, double mu_wall) {
  ContactProblem p{.dim = 2};
  p.A.resize(3, 3);
  for (int k = 0; k < 3; ++k) p.A.insert(k, k) = 1;
  p.H.resize(3, 4);
  p.H.insert(1, 0) = 1;   // floor, normal: y
  p.H.insert(0, 1) = -1;  // tangent: -x and the spin
  p.H.insert(2, 1) = -1;
  p.H.insert(0, 2) = 1;  // wall, normal: x
  p.H.insert(1, 3) = 1;  // tangent: y and the spin
  p.H.insert(2, 3) = -1;
  p.A.makeCompressed();
  p.H.makeCompressed();
  p.v_free = Vector::Constant(3, -1);
  p.u_free = p.H.transpose() * p.v_free;
  p.mu = Vector(2);
  p.mu << mu_floor, mu_wall;
  return p;
}

TEST(ContactIslands, WithoutFrictionOnlyNormalsConnect) {
  // The normals share nothing. A tangent of the floor moves x, which the wall's normal pushes.
  EXPECT_EQ(lists(corner(0, 0)), (Lists{{0}, {1}}));
  EXPECT_EQ(lists(corner(0.3, 0)), (Lists{{0, 1}}));
  EXPECT_EQ(lists(corner(0.3, 0.3)), (Lists{{0, 1}}));
  EXPECT_EQ(lists(local_form(corner(0, 0))), (Lists{{0}, {1}}));
  EXPECT_EQ(lists(local_form(corner(0, 0.3))), (Lists{{0, 1}}));
}

TEST(ContactIslands, AMassMatrixConnects) {
  ContactProblem p = corner(0, 0);
  p.A.coeffRef(0, 1) = p.A.coeffRef(1, 0) = 0.1;
  p.A.makeCompressed();
  EXPECT_EQ(lists(p), (Lists{{0, 1}}));
  EXPECT_EQ(lists(local_form(p)), (Lists{{0, 1}}));
}

TEST(ContactIslands, SmallOnesComeFirstAndBothFormsAgree) {
  for (const int dim : {1, 2, 3}) {
    std::vector<ContactProblem> parts;
    for (const int contacts : {7, 1, 30, 3, 1}) {
      parts.push_back(manufactured_problem(dim, std::max(1, contacts - 1), contacts, 5).problem);
    }
    const SideBySide whole = side_by_side(parts);
    Lists expected;
    for (const std::size_t k : {1, 4, 3, 0, 2}) expected.push_back(whole.place[k]);
    EXPECT_EQ(lists(whole.problem), expected) << dim;
    EXPECT_EQ(lists(local_form(whole.problem)), expected) << dim;
  }
}

TEST(ContactIslands, NoContactsAreNoIslands) {
  EXPECT_EQ(contact_islands(ContactProblem{}).count(), 0);
}

/// u of the part and of the whole at the same impulse, drawn for all, but for tangents without
/// friction.
void expect_same_velocities(const ContactProblem& whole, int expected_islands) {
  const ContactIslands islands = contact_islands(whole);
  ASSERT_EQ(islands.count(), expected_islands);
  PortableRandom draw(3);
  Vector s(whole.num_rows());
  for (int i = 0; i < whole.num_rows(); ++i) {
    const bool idle = i % whole.dim > 0 && whole.mu[i / whole.dim] == 0;
    s[i] = idle ? 0 : draw.symmetric();
  }
  Vector u(whole.num_rows());
  const DelassusOperator operator_of_whole(whole);
  operator_of_whole.velocity(s, u);
  IslandCutter cut(whole);
  for (int k = 0; k < islands.count(); ++k) {
    const IslandProblem part = cut(islands.of(k));
    EXPECT_EQ(validate(part.problem), "");
    Vector of_part(part.problem.num_rows());
    const DelassusOperator delassus(part.problem);
    delassus.velocity(part.gather(s), of_part);
    EXPECT_LE((of_part - part.gather(u)).lpNorm<Eigen::Infinity>(), 1e-13 * u.norm());
  }
}

std::vector<ContactProblem> clusters(int dim) {
  std::vector<ContactProblem> parts;
  for (const int contacts : {4, 1, 12}) {
    parts.push_back(manufactured_problem(dim, std::max(1, contacts - 1), contacts, 11).problem);
  }
  return parts;
}

TEST(IslandProblem, HasTheVelocitiesOfTheWhole) {
  for (const int dim : {1, 2, 3}) {
    ContactProblem whole = side_by_side(clusters(dim)).problem;
    whole.W = SparseRows();
    expect_same_velocities(whole, 3);
    expect_same_velocities(local_form(whole), 3);
    // A general mass matrix within each cluster: neighbours in the list of degrees of freedom.
    std::vector<ContactProblem> coupled = clusters(dim);
    for (ContactProblem& part : coupled) {
      for (int k = 0; k + 1 < part.num_dofs(); ++k) {
        part.A.coeffRef(k, k + 1) = part.A.coeffRef(k + 1, k) = 0.1;
      }
      part.A.makeCompressed();
      part.W = assemble_delassus(part.A, part.H, dim);
    }
    expect_same_velocities(side_by_side(coupled).problem, 3);
  }
}

TEST(IslandProblem, KeepsTheScaleOfRestitution) {
  const LatticeOptions options{.mu = 0.3, .e_n = 0.4, .e_t = 0.2};
  const SideBySide whole =
      side_by_side({square_lattice(3, options), triangular_lattice(3, options)});
  ASSERT_GT(whole.problem.row_scale.size(), 0);
  expect_same_velocities(whole.problem, 2);
  IslandCutter cut(whole.problem);
  const IslandProblem part = cut(contact_islands(whole.problem).of(0));
  EXPECT_EQ(part.problem.row_scale, part.gather(whole.problem.row_scale));
}

TEST(IslandProblem, DisksStayDisks) {
  // The kernels for disks need their rows together.
  const LatticeOptions options{.mu = 0.3};
  const SideBySide whole =
      side_by_side({square_lattice(4, options), triangular_lattice(3, options)});
  IslandCutter cut(whole.problem);
  const ContactIslands islands = contact_islands(whole.problem);
  for (int k = 0; k < islands.count(); ++k) {
    const IslandProblem part = cut(islands.of(k));
    EXPECT_TRUE(DelassusOperator(part.problem).disks().has_value());
  }
}

TEST(IslandProblem, APartWithoutFrictionHasOneDimension) {
  ContactProblem slippery = manufactured_problem(2, 5, 6, 1).problem;
  slippery.mu.setZero();
  slippery.W = SparseRows();
  ContactProblem rough = manufactured_problem(2, 5, 7, 2).problem;
  rough.W = SparseRows();
  const SideBySide whole = side_by_side({slippery, rough});
  expect_same_velocities(whole.problem, 2);
  IslandCutter cut(whole.problem);
  const ContactIslands islands = contact_islands(whole.problem);
  const IslandProblem part = cut(islands.of(0));
  EXPECT_EQ(part.problem.dim, 1);
  EXPECT_EQ(cut(islands.of(1)).problem.dim, 2);
  Vector s = Vector::Ones(whole.problem.num_rows());
  part.scatter(Vector::Constant(6, 2.0), 2, s);
  for (const int c : whole.place[0]) {
    EXPECT_EQ(s[2 * c], 2);
    EXPECT_EQ(s[2 * c + 1], 0);
  }
  for (const int c : whole.place[1]) EXPECT_EQ(s[2 * c + 1], 1);
}

}  // namespace
}  // namespace bipot
