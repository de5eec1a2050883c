// The vector kernels for disks on pieces of a problem against those on the whole.

#include "solvers/parallel/disk_frontier.h"
#include "tests/solvers/parallel/mpi_group.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

struct Iterated {
  Vector s;
  std::vector<double> lambda;
};

/// So many iterations from a lambda that is far too small, which the energies of the steps raise.
Iterated iterate(GradientKernel& kernel, const Vector& s0, GradientMap map) {
  constexpr int kIterations = 40;
  Iterated out;
  kernel.reset(s0);
  GradientKernel::Control control{.lambda = 1e-3, .map = map};
  for (int k = 0; k < kIterations; ++k) {
    kernel.advance(1, control);
    if (k % 8 == 7 && map == GradientMap::kFollowed) kernel.follow(0.7);
    out.lambda.push_back(control.lambda);
  }
  out.s = kernel.impulse();
  return out;
}

template <int D>
void expect_iterates_of_the_whole(const ContactProblem& p, GradientMap map) {
  const DelassusOperator delassus(p);
  ASSERT_TRUE(delassus.disks());
  const ContactScaling scaling = equilibrated_scaling(p, delassus.diagonal());
  Vector s0 = Vector::Zero(p.num_rows());
  for (int c = 0; c < p.num_contacts(); ++c) s0[c * D] = 0.1 * (1 + c % 5);
  TiledGradient<D> whole(p, *delassus.disks(), scaling, {});
  const Iterated one = iterate(whole, s0, map);
  EXPECT_GT(one.lambda.back(), 0.1);  // raised, by the energies alone

  const ProblemPiece piece = piece_here(p);
  DistributedSpace space(piece, mpi_group(), false);
  const auto disks = DiskFrontier<D>::structure(space);
  ASSERT_TRUE(disks);
  DiskFrontier<D> frontier(space);
  const ContactScaling scaling_here = equilibrated_scaling(piece.own, space.diagonal());
  Vector start(piece.own.num_rows());
  for (std::size_t k = 0; k < piece.number.size(); ++k) {
    start.segment<D>(static_cast<int>(k) * D) = s0.segment<D>(piece.number[k] * D);
  }
  TiledGradient<D> kernel(piece.own, *disks, scaling_here, {}, &frontier);
  const Iterated many = iterate(kernel, start, map);
  for (std::size_t k = 0; k < one.lambda.size(); ++k) {
    EXPECT_NEAR(many.lambda[k], one.lambda[k], 1e-9 * one.lambda[k]) << "iteration " << k;
  }
  for (std::size_t k = 0; k < piece.number.size(); ++k) {
    EXPECT_LE(
        (many.s.segment<D>(static_cast<int>(k) * D) - one.s.segment<D>(piece.number[k] * D)).norm(),
        1e-9 * one.s.norm())
        << "contact " << piece.number[k];
  }
}

TEST(DiskFrontier, IteratesAndSumsAreThoseOfTheWhole) {
  expect_iterates_of_the_whole<2>(square_lattice(8, {.tilt = 0.05}), GradientMap::kSplit);
  expect_iterates_of_the_whole<2>(triangular_lattice(8), GradientMap::kFollowed);
  expect_iterates_of_the_whole<1>(triangular_lattice(8, {.dim = 1}), GradientMap::kSplit);
  expect_iterates_of_the_whole<2>(square_lattice(6, {.e_n = 0.5, .e_t = 0.2}), GradientMap::kSplit);
  expect_iterates_of_the_whole<2>(shipped_file("2d_strike12_450.hdf5"), GradientMap::kSplit);
}

TEST(DiskFrontier, AProcessWithoutContactsTakesPart) {
  // Two contacts of one disk: two processes at most have any.
  const ContactProblem p = square_lattice(1);
  ASSERT_LE(p.num_contacts(), 3);
  expect_iterates_of_the_whole<2>(p, GradientMap::kSplit);
}

TEST(DiskFrontier, OtherBodiesAndWallsThatAllPushHaveNoStructure) {
  const ProblemPiece spheres = piece_here(cubic_lattice(3));
  DistributedSpace space(spheres, mpi_group(), false);
  EXPECT_FALSE(space.disks());
  EXPECT_FALSE(DiskFrontier<2>::structure(space));

  ProblemPiece pushed = piece_here(square_lattice(4));
  pushed.everywhere_inverse_mass.push_back(1);
  pushed.everywhere_own_dof.push_back(-1);
  DistributedSpace with_wall(pushed, mpi_group(), false);
  EXPECT_TRUE(with_wall.disks());
  EXPECT_FALSE(DiskFrontier<2>::structure(with_wall));
}

}  // namespace
}  // namespace bipot
