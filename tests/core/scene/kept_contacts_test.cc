#include "core/base/portable_random.h"
#include "core/scene/contact_detection.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// Bodies of radii 0.5 to 1 in a box of that many radii, drawn; they overlap here and there.
template <int D>
std::vector<Body<D>> crowd(int count, double width, unsigned seed) {
  PortableRandom draw(seed);
  std::vector<Body<D>> bodies(to_size(count));
  for (Body<D>& b : bodies) {
    for (int k = 0; k < D; ++k) b.x[k] = draw.between(0, width);
    b.radius = draw.between(0.5, 1);
  }
  return bodies;
}

template <int D>
void expect_same(const std::vector<Contact<D>>& kept, const std::vector<Contact<D>>& found) {
  ASSERT_EQ(kept.size(), found.size());
  for (std::size_t k = 0; k < kept.size(); ++k) {
    EXPECT_EQ(kept[k].i, found[k].i);
    EXPECT_EQ(kept[k].j, found[k].j);
    EXPECT_EQ(kept[k].n, found[k].n);
    EXPECT_EQ(kept[k].gap, found[k].gap);
  }
}

/// A floor, and in the plane a segment, which move as well.
template <int D>
std::vector<Wall<D>> two_walls() {
  std::vector<Wall<D>> walls(D == 2 ? 2 : 1);
  if constexpr (D == 2) {
    walls[1].shape = Wall<2>::Shape::kSegment;
    walls[1].a = Vec2(2, 2);
    walls[1].b = Vec2(12, 7);
  }
  return walls;
}

/// Moves all at random by at most `step` along each axis, 150 times; returns the searches.
template <int D>
int searches_of_a_walk(double step, int threads) {
  std::vector<Body<D>> bodies = crowd<D>(D == 2 ? 300 : 500, D == 2 ? 24 : 12, 7);
  std::vector<Wall<D>> walls = two_walls<D>();
  KeptContacts<D> kept;
  PortableRandom draw(5);
  for (int k = 0; k < 150; ++k) {
    const double eta = 0.05;
    expect_same<D>(kept(bodies, walls, eta, threads),
                   detect_contacts<D>(bodies, walls, eta, threads));
    if (::testing::Test::HasFailure()) return -1;
    for (Body<D>& b : bodies) {
      for (int axis = 0; axis < D; ++axis) b.x[axis] += step * draw.symmetric();
    }
    for (Wall<D>& w : walls) {
      for (int axis = 0; axis < D; ++axis) {
        const double move = step * draw.symmetric();
        w.a[axis] += move;
        w.b[axis] += move;
      }
    }
  }
  return kept.searches();
}

TEST(KeptContacts, AreThoseOfASearchAtEveryStep) {
  // The skin is 0.2 of the smallest radius, 0.1: lists hold while nothing has moved by 0.05.
  EXPECT_LE(searches_of_a_walk<2>(0.002, 1), 15);
  EXPECT_LE(searches_of_a_walk<3>(0.002, 1), 15);
  EXPECT_LE(searches_of_a_walk<2>(0.002, 3), 15);
  EXPECT_GT(searches_of_a_walk<2>(0.01, 1), 5);
}

TEST(KeptContacts, FastBodiesAreSearchedEveryTime) {
  EXPECT_EQ(searches_of_a_walk<2>(0.2, 1), 150);
  EXPECT_EQ(searches_of_a_walk<3>(0.2, 2), 150);
}

TEST(KeptContacts, ChangesOfTheBodiesEndTheList) {
  std::vector<Disk> disks = crowd<2>(200, 20, 3);
  std::vector<Wall<2>> walls = two_walls<2>();
  KeptContacts<2> kept;
  // A new list is made once, and then serves.
  const auto expect_searches = [&](int searches, double eta = 0.5) {
    for (int k = 0; k < 5; ++k) {
      expect_same<2>(kept(disks, walls, eta), detect_contacts(disks, walls, eta));
      EXPECT_EQ(kept.searches(), searches);
    }
  };
  expect_searches(1, 0.05);
  expect_searches(2);  // another distance
  disks[17].radius = 2;
  expect_searches(3);
  disks.pop_back();
  expect_searches(4);
  walls[0].normal = Vec2(0.6, 0.8);
  expect_searches(5);
  walls.push_back({});
  walls.back().shape = Wall<2>::Shape::kHollowCircle;
  walls.back().a = Vec2(10, 10);
  walls.back().radius = 11;
  expect_searches(6);
  walls.back().radius = 8;
  expect_searches(7);
  walls.back().present = false;
  expect_searches(8);
  disks[3].x += Vec2(9, 9);  // a single one that jumps
  expect_searches(9);
  disks.clear();
  expect_same<2>(kept(disks, walls, 0.5), detect_contacts(disks, walls, 0.5));
}

TEST(KeptContacts, CoincidentCentresAreRefusedAsByASearch) {
  std::vector<Disk> disks = crowd<2>(20, 20, 3);
  const std::vector<Wall<2>> walls = two_walls<2>();
  KeptContacts<2> kept;
  kept(disks, walls, 0.05);
  const Vec2 place = disks[4].x;
  disks[4].x = disks[5].x;
  EXPECT_THROW(kept(disks, walls, 0.05), std::invalid_argument);
  disks[4].x = place;
  expect_same<2>(kept(disks, walls, 0.05), detect_contacts(disks, walls, 0.05));
}

}  // namespace
}  // namespace bipot
