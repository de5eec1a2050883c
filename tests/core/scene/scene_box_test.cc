#include "core/scene/scene_box.h"

#include "tests/support/test.h"

namespace bipot {
namespace {

/// Three disks of radius 1 cm above each other, y from 0 to 6 cm.
std::vector<Disk> column() {
  std::vector<Disk> disks(3);
  for (int k = 0; k < 3; ++k) {
    disks[k].x = Vec2(0, 0.01 + 0.02 * k);
    disks[k].radius = 0.01;
  }
  return disks;
}

bool spans(const std::pair<Vec2, Vec2>& line, const Vec2& a, const Vec2& b) {
  return (line.first - a).norm() + (line.second - b).norm() < 1e-12 ||
         (line.first - b).norm() + (line.second - a).norm() < 1e-12;
}

TEST(ViewBox, HasTheDisksAndTheWallsNearThem) {
  std::vector<Wall<2>> walls(1);  // the half-plane y < 0
  const Box<2> box = view_box(column(), walls);
  EXPECT_LT(box.lower[1], 0);
  EXPECT_GT(box.upper[1], 0.06);
  EXPECT_LT(box.upper[1], 0.1);
  walls[0].a = Vec2(0, -0.05);  // as far as the disks are wide: still in sight
  EXPECT_LT(view_box(column(), walls).lower[1], -0.05);
  walls[0].a = Vec2(0, -100);
  EXPECT_GT(view_box(column(), walls).lower[1], -0.1);
}

TEST(ViewBox, LeavesOutWhatAnotherHalfPlaneCovers) {
  std::vector<Wall<2>> trough(2);  // its lowest point is the origin
  trough[0].normal = Vec2(1, 1).normalized();
  trough[1].normal = Vec2(-1, 1).normalized();
  std::vector<Disk> disks(3);
  for (const int k : {0, 1, 2}) {
    disks[k].x = Vec2(0.2 * (k - 1), k == 1 ? 0.02 : 0.22);
    disks[k].radius = 0.01;
  }
  EXPECT_GT(view_box(disks, trough).lower[1], -0.02);
}

TEST(ViewBox, IsNeverEmpty) {
  EXPECT_FALSE(view_box({}, {}).empty());
  EXPECT_GT(view_box({}, {}).size().minCoeff(), 0);
  const std::vector<Wall<2>> walls(1);
  EXPECT_GT(view_box({}, walls).size().minCoeff(), 0);
}

TEST(WallLines, EndWhereAnotherHalfPlaneBegins) {
  Box<2> box;
  box.include(Vec2(-1, -1));
  box.include(Vec2(3, 2));
  Wall<2> floor, side, post;  // floor y < 0, side x < 0
  side.normal = Vec2(1, 0);
  post.shape = Wall<2>::Shape::kSegment;
  post.a = Vec2(1, 0);
  post.b = Vec2(1, 1);
  const auto lines = wall_lines(std::vector<Wall<2>>{floor, side, post}, box);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_TRUE(spans(lines[0], Vec2(0, 0), Vec2(3, 0)));
  EXPECT_TRUE(spans(lines[1], Vec2(0, 0), Vec2(0, 2)));
  EXPECT_TRUE(spans(lines[2], post.a, post.b));
}

TEST(WallLines, ABuriedLineIsShownWhole) {
  Box<2> box;
  box.include(Vec2(-1, -1));
  box.include(Vec2(1, 1));
  Wall<2> left, right, deep;  // x < 0.2 and x > -0.2 are solid: nothing of y = -0.5 is free
  left.a = Vec2(0.2, 0);
  left.normal = Vec2(1, 0);
  right.a = Vec2(-0.2, 0);
  right.normal = Vec2(-1, 0);
  deep.a = Vec2(0, -0.5);
  const auto lines = wall_lines(std::vector<Wall<2>>{left, right, deep}, box);
  EXPECT_TRUE(spans(lines[2], Vec2(-1, -0.5), Vec2(1, -0.5)));
}

}  // namespace
}  // namespace bipot
