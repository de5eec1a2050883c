#include "core/motion/passage.h"

#include "core/scene/scene_parts.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

constexpr double kFreeStep = 1e-3;

struct Seen {
  StepTravel travel;
  std::vector<Passage> passages;
};

/// One free step of the scene: nothing acts on the bodies. They turn back where `bounced` says so.
template <int D>
Seen free_step(Scene<D> scene, bool bounced = false) {
  scene.step = kFreeStep;
  const State<D> before = initial_state(scene);
  State<D> after = before;
  for (Body<D>& body : after.bodies) {
    drift(body, 0.5 * kFreeStep);
    if (bounced) body.v = -body.v;
    drift(body, 0.5 * kFreeStep);
  }
  move_cell(after.cell, kFreeStep);
  for (Wall<D>& wall : after.walls) {
    wall.a += kFreeStep * wall.v;
    wall.b += kFreeStep * wall.v;
  }
  Seen seen{step_travel(before, after, kFreeStep), {}};
  const auto paths = paths_of<D>(before, after, kFreeStep, seen.travel, [](int k) { return k; });
  seen.passages = find_passages(before, after, kFreeStep, paths);
  return seen;
}

Wall<2> plate(const Vec2& a, const Vec2& b) {
  return Wall<2>{.name = "plate", .shape = Wall<2>::Shape::kSegment, .a = a, .b = b};
}

Body<2> disk(const Vec2& x, const Vec2& v = Vec2::Zero()) { return round_body<2>(x, 0.01, 1, v); }

TEST(Passage, ADiskShotThroughAPlateIsSeen) {
  // 300 m/s for 1 ms: from x = -0.1 to 0.2, 30 radii, through a plate at x = 0.
  Scene<2> scene = one_law<2>({});
  scene.walls = {plate(Vec2(0, -1), Vec2(0, 1))};
  scene.bodies = {disk(Vec2(-0.1, 0), Vec2(300, 0))};
  const Seen seen = free_step(scene);
  EXPECT_NEAR(seen.travel.radii, 30, 1e-9);
  EXPECT_TRUE(seen.travel.may_pass());
  ASSERT_EQ(seen.passages.size(), 1u);
  EXPECT_EQ(passage_text(scene, seen.passages[0]), "disk 0 went through wall 'plate' at 300 m/s");
}

TEST(Passage, ADiskBesideAPlateOrThrownBackByItDoesNotGoThrough) {
  Scene<2> scene = one_law<2>({});
  scene.walls = {plate(Vec2(0, 0.1), Vec2(0, 1))};
  scene.bodies = {disk(Vec2(-0.1, 0), Vec2(300, 0))};
  EXPECT_TRUE(free_step(scene).passages.empty());
  // The middle of the step is at x = 0.05, where the plate now stands 1 mm farther.
  scene.walls = {plate(Vec2(0.051, -1), Vec2(0.051, 1))};
  EXPECT_TRUE(free_step(scene, true).passages.empty());
  // It went through one at 0.04 and came back through it: once.
  scene.walls = {plate(Vec2(0.04, -1), Vec2(0.04, 1))};
  EXPECT_EQ(free_step(scene, true).passages.size(), 1u);
}

// Both rest in their cells. The upper cells move at 60 m/s, 6 radii a step: the image above of disk 1
// comes from 20 mm before disk 0 and is 10 mm beyond it in the middle of the step.
TEST(Passage, ADiskGoesThroughAnImageThatMovesWithItsCell) {
  Scene<2> scene = one_law<2>({});
  scene.cell.in_x = scene.cell.in_y = true;
  scene.cell.width.length = scene.cell.height.length = 0.1;
  scene.cell.offset = {.motion = CellSide::Motion::kMoving, .speed = 60};
  scene.bodies = {disk(Vec2(0.05, 0.099)), disk(Vec2(0.03, 0.001))};
  const Seen seen = free_step(scene);
  EXPECT_EQ(seen.travel.radii, 0);
  EXPECT_EQ(seen.passages.size(), 1u);
  scene.cell.offset.speed = 5;  // 0.3 mm a step
  EXPECT_FALSE(free_step(scene).travel.may_pass());
}

TEST(Passage, TwoDisksThatExchangePlacesPassEachOther) {
  // From 250 mm apart to 350 mm beyond; in the middle 50 mm beyond. 12 mm from centre to centre at
  // the closest, less than (2 - 1/2) radii = 15 mm; with 16 mm they graze.
  for (const double beside : {0.012, 0.016}) {
    Scene<2> scene = one_law<2>({});
    scene.bodies = {disk(Vec2(-0.15, 0), Vec2(300, 0)), disk(Vec2(0.1, beside), Vec2(-300, 0))};
    const Seen seen = free_step(scene);
    ASSERT_EQ(seen.passages.size(), beside < 0.015 ? 1u : 0u);
    if (beside < 0.015) {
      EXPECT_EQ(seen.passages[0].j, 1);
      EXPECT_NEAR(seen.passages[0].speed, 600, 1e-9);
    }
  }
}

TEST(Passage, APairThatMeetsInTheMiddleOfTheStepHasContactThere) {
  // The centres are 18 mm apart at mid-step, where the contact law turns both back.
  Scene<2> scene = one_law<2>({});
  scene.bodies = {disk(Vec2(-0.159, 0), Vec2(300, 0)), disk(Vec2(0.159, 0), Vec2(-300, 0))};
  EXPECT_TRUE(free_step(scene, true).passages.empty());
  EXPECT_EQ(free_step(scene, false).passages.size(), 1u);
}

TEST(Passage, BodiesSlowerThanARadiusAStepAreNotLookedAt) {
  Scene<2> scene = one_law<2>({});
  scene.bodies = {disk(Vec2(0, 0), Vec2(9, 0)), disk(Vec2(0.5, 0))};
  EXPECT_NEAR(free_step(scene).travel.radii, 0.9, 1e-12);
  EXPECT_FALSE(free_step(scene).travel.may_pass());
}

TEST(Passage, APlateThatSweepsOverADiskAtRest) {
  Scene<2> scene = one_law<2>({});
  scene.walls = {plate(Vec2(0.05, -1), Vec2(0.05, 1))};
  move_at(scene.walls[0], Vec2(-200, 0));
  scene.bodies = {disk(Vec2(0, 0))};
  EXPECT_EQ(free_step(scene).passages.size(), 1u);
}

TEST(Passage, JoinedDisksPassNobodyOfTheirOwn) {
  Scene<2> scene = one_law<2>({});
  scene.walls = {plate(Vec2(5, -1), Vec2(5, 1))};
  scene.bodies = {disk(Vec2(-0.15, 0), Vec2(300, 0)), disk(Vec2(0.1, 0), Vec2(-300, 0))};
  EXPECT_EQ(free_step(scene).passages.size(), 1u);
  scene.bodies[0].wall = scene.bodies[1].wall = 0;
  EXPECT_TRUE(free_step(scene).passages.empty());
}

TEST(Passage, AcrossTheBorderOfACell) {
  // The cell is 1 m wide: from 0.95 to 1.25 m, through the image at 1.1 m of the disk at 0.1 m; the
  // middle of the step is at 1.1 m less 0 mm beside it by 5 mm.
  Scene<2> scene = one_law<2>({});
  scene.cell.in_x = true;
  scene.cell.width.length = 1;
  scene.bodies = {disk(Vec2(0.92, 0), Vec2(300, 0)), disk(Vec2(0.1, 0.005))};
  EXPECT_EQ(free_step(scene).passages.size(), 1u);
}

TEST(Passage, WallsOfACellAreItsImagesToo) {
  // The same flight a period on or back, through a plate, a circle and a plate across the seam.
  for (const double period : {-1.0, 0.0, 1.0, 2.0}) {
    Scene<2> scene = one_law<2>({});
    scene.cell.in_x = scene.cell.in_y = true;
    scene.cell.width.length = scene.cell.height.length = 1;
    scene.bodies = {disk(Vec2(0.37, 0.5 + period), Vec2(300, 0))};
    scene.walls = {plate(Vec2(0.5, 0.4), Vec2(0.5, 0.6))};
    EXPECT_EQ(free_step(scene).passages.size(), 1u) << period;
    scene.walls = {{.shape = Wall<2>::Shape::kSolidCircle, .a = Vec2(0.5, 0.5), .radius = 0.05}};
    EXPECT_EQ(free_step(scene).passages.size(), 1u) << period;
    scene.walls = {plate(Vec2(0.95, 0.5), Vec2(1.05, 0.5))};
    scene.bodies = {disk(Vec2(1 + period, 0.37), Vec2(0, 300))};
    EXPECT_EQ(free_step(scene).passages.size(), 1u) << period;
    scene.bodies = {disk(Vec2(1.06 + period, 0.37), Vec2(0, 300))};
    EXPECT_TRUE(free_step(scene).passages.empty()) << period;
  }
}

TEST(Passage, ASphereThroughASphereAndThroughARod) {
  Scene<3> scene = one_law<3>({});
  scene.bodies = {round_body<3>(Vec3(-0.15, 0, 0), 0.01, 1, Vec3(400, 0, 0)),
                  round_body<3>(Vec3(0, 0, 0), 0.01, 1)};
  EXPECT_EQ(free_step(scene).passages.size(), 1u);
  scene.walls = {{.name = "rod", .shape = Wall<3>::Shape::kSolidCircle, .radius = 0.02}};
  scene.bodies.pop_back();
  const Seen seen = free_step(scene);
  ASSERT_EQ(seen.passages.size(), 1u);
  EXPECT_EQ(passage_text(scene, seen.passages[0]), "sphere 0 went through wall 'rod' at 400 m/s");
  scene.walls[0].a = Vec3(0, 0.04, 0);
  EXPECT_TRUE(free_step(scene).passages.empty());
}

TEST(Passage, PathsKeepTheirNumbersOnTheWay) {
  BodyPath<2> path{.number = 7,
                   .from = Vec2(1, 2),
                   .mid = Vec2(3, 4),
                   .to = Vec2(5, 6),
                   .radius = 0.5,
                   .cluster = 2};
  const std::vector<BodyPath<2>> there = unpacked<2>(packed<2>({path, path}));
  ASSERT_EQ(there.size(), 2u);
  EXPECT_EQ(there[1].number, 7);
  EXPECT_EQ(there[1].mid, Vec2(3, 4));
  EXPECT_EQ(there[1].to, Vec2(5, 6));
  EXPECT_EQ(there[1].radius, 0.5);
  EXPECT_EQ(there[1].wall, -1);
  EXPECT_EQ(there[1].cluster, 2);
  EXPECT_TRUE(there[1].elsewhere);
}

/// Steps of a free flight from x, each 0.3 m long, until something was passed or ten are over.
template <int D>
int passages_in_flight(Scene<D> scene, double x) {
  scene.bodies[0].x[0] = x;
  int count = 0;
  for (int step = 0; step < 10; ++step) {
    count += static_cast<int>(free_step(scene).passages.size());
    drift(scene.bodies[0], kFreeStep);
  }
  return count;
}

TEST(Passage, AStepThatEndsOnTheObstacleHidesNothing) {
  // From x = 0.1 the places are 0.4, 0.7, 1.0: the last lies exactly on the obstacle at 1.
  for (const double x : {0.1, 0.1 + 1e-12, 0.1 - 1e-12, 0.235}) {
    Scene<2> scene = one_law<2>({});
    scene.bodies = {disk(Vec2(0, 0), Vec2(300, 0))};
    scene.walls = {plate(Vec2(1, -1), Vec2(1, 1))};
    EXPECT_EQ(passages_in_flight(scene, x), 1) << x;
    // Beside the centre of another disk, at one twentieth of the radius, as well.
    for (const double beside : {0.0, 0.0005}) {
      scene.walls.clear();
      scene.bodies.resize(1);
      scene.bodies.push_back(disk(Vec2(1, beside)));
      EXPECT_EQ(passages_in_flight(scene, x), 1) << x << ", " << beside;
    }
  }
}

TEST(Passage, ACentreThatLeavesItsRoomIsSeen) {
  Scene<2> scene = one_law<2>({});
  scene.bodies = {disk(Vec2(0, 0), Vec2(300, 0))};
  scene.walls = {half_space<2>(Vec2(1, 0), Vec2(-1, 0), "wall")};
  EXPECT_EQ(passages_in_flight(scene, 0.235), 1);
  scene.walls = {{.name = "drum", .shape = Wall<2>::Shape::kHollowCircle, .radius = 1}};
  EXPECT_EQ(passages_in_flight(scene, 0.235), 1);
}

TEST(Passage, AChordThroughALargeDiskIsOneUpToGrazing) {
  // From (-0.075, h) to (0.075, h), which the centre at 0 sees under less than 90°. They touch at a
  // distance of 0.11, and graze down to 0.105; both ends lie beyond that.
  for (const double height : {0.085, 0.1049, 0.1051}) {
    Scene<2> scene = one_law<2>({});
    scene.bodies = {disk(Vec2(-0.075, height), Vec2(300, 0)), round_body<2>(Vec2(0, 0), 0.1, 1)};
    const int passages = height < 0.105 ? 1 : 0;
    EXPECT_EQ(static_cast<int>(free_step(scene).passages.size()), passages) << height;
    // The same from mid-step to mid-step: at 0 a step ends.
    scene.bodies[0].v[0] = 150;
    EXPECT_EQ(passages_in_flight(scene, -0.15), passages) << height;
  }
}

TEST(Passage, PinnedDisksThatOverlapMayTurn) {
  Scene<2> scene = one_law<2>({});
  const double apart = 0.015;
  scene.bodies = {disk(Vec2(0, 0)), disk(Vec2(apart, 0), Vec2(0, 100))};
  const State<2> before = initial_state(scene);
  State<2> after = before;
  after.bodies[1].x = apart * Vec2(std::cos(1.0), std::sin(1.0));
  std::vector<BodyPath<2>> paths = paths_of<2>(
      before, after, kFreeStep, step_travel(before, after, kFreeStep), [](int k) { return k; });
  ASSERT_TRUE(paths[1].fast);
  paths[1].mid = apart * Vec2(std::cos(0.5), std::sin(0.5));
  EXPECT_TRUE(find_passages(before, after, kFreeStep, paths).empty());
}

}  // namespace
}  // namespace bipot
