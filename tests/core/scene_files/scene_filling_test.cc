// Fillings that know where to stop, and groups whose positions stand in a file.

#include "core/scene_files/scene_filling.h"

#include "tests/support/refused_scene.h"
#include "tests/support/scene_text.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

const std::string kShortTime = "[time]\nstep = 1e-3\nsteps = 2\n";
const std::string kRandom = "[[disks]]\narrangement = 'random'\nmass = 1\nradii = [0.5]\n";

Scene<2> parse_filling(const std::string& text) { return scene_of(text + kShortTime); }
void expect_filling_refused(const std::string& text, std::initializer_list<std::string> parts) {
  expect_scene_refused(text + kShortTime, parts);
}

// Cells of 1.1 m (spacing 0.1): 8 columns and 3 rows fit 8.9 x 3.4 m.
TEST(SceneFilling, StopsAtItsHeight) {
  const std::string place = kRandom + "width = 8.9\nheight = 3.4\ncount = ";
  const Scene<2> full = parse_filling(place + "24\n");
  ASSERT_EQ(full.bodies.size(), 24u);
  for (const Disk& d : full.bodies) EXPECT_LE(d.x[1] + d.radius, 3.4);
  expect_filling_refused(place + "25\n", {"fits 24 of 25", "larger", "height = 4.4 holds all"});
  const Scene<2> higher = parse_filling(kRandom + "width = 8.9\nheight = 4.4\ncount = 25\n");
  EXPECT_EQ(higher.bodies.size(), 25u);
  // Without a height it has the same places, and no end.
  const Scene<2> open = parse_filling(kRandom + "width = 8.9\ncount = 24\n");
  EXPECT_EQ(open.bodies[23].x, full.bodies[23].x);
}

TEST(SceneFilling, StaysInsideADrum) {
  const std::string drum =
      "[[walls]]\nname = 'drum'\ncenter = [3, 4]\nradius = 6\nhollow = true\n" + kRandom +
      "inside = 'drum'\ncount = ";
  const Scene<2> scene = parse_filling(drum + "40\n");
  ASSERT_EQ(scene.bodies.size(), 40u);
  double lowest = 10;
  for (const Disk& d : scene.bodies) {
    EXPECT_LE((d.x - Vec2(3, 4)).norm() + d.radius, 6 + 1e-11);
    lowest = std::min(lowest, d.x[1] - d.radius);
  }
  EXPECT_LT(lowest, -1);  // from the bottom, at -2, up
  // 144 disks have the area of the drum.
  expect_filling_refused(drum + "144\n", {"fits ", " of 144"});
  std::string solid = drum;
  solid.replace(solid.find("true"), 4, "false");
  expect_filling_refused(solid + "4\n", {"'drum' is solid", "hollow"});
}

// The number that a refusal names fits, whatever sizes are drawn.
TEST(SceneFilling, NamesANumberThatFits) {
  const std::string drum =
      "[[walls]]\nname = 'drum'\ncenter = [0, 0]\nradius = 5\nhollow = true\n"
      "[[disks]]\narrangement = 'random'\nmass = 1\nradii = [0.3, 0.4, 0.7]\ninside = 'drum'\n";
  for (const int seed : {1, 2, 3, 4, 5}) {
    const auto filling = [&](int count) {
      return fmt::format("{}seed = {}\ncount = {}\n", drum, seed, count);
    };
    const std::string text = refusal_of([&] { parse_filling(filling(200)); });
    const int fits = std::stoi(text.substr(text.find("fits ") + 5));
    ASSERT_GT(fits, 10);
    EXPECT_EQ(parse_filling(filling(fits)).bodies.size(), to_size(fits));
  }
}

TEST(SceneFilling, StaysInsideABoxAndAPolygon) {
  const std::string box =
      "[[walls]]\nname = 'a'\npoint = [0, 0]\nnormal = [1, 0]\n"
      "[[walls]]\nname = 'b'\npoint = [5.6, 0]\nnormal = [-1, 0]\n"
      "[[walls]]\nname = 'c'\npoint = [0, -1]\nnormal = [0, 1]\n";
  const Scene<2> scene = parse_filling(box + kRandom + "inside = ['a', 'b', 'c']\ncount = 30\n");
  for (const Disk& d : scene.bodies) {
    EXPECT_GE(d.x[0], 0.5);
    EXPECT_LE(d.x[0], 5.1);
    EXPECT_GE(d.x[1], -0.5);
  }
  const std::string three = box + kRandom + "count = 3\ninside = ";
  expect_filling_refused(three + "['a', 'b']\n", {"'corner'", "missing"});
  expect_filling_refused(three + "['a', 'c']\n", {"'width'", "missing"});
  expect_filling_refused(three + "'d'\n", {"unknown wall 'd'"});

  // A triangle of segments of one name, corners (0, 0), (12, 0), (0, 12): x + y + r √2 <= 12.
  const std::string triangle =
      "[[walls]]\nname = 't'\nfrom = [0, 0]\nto = [12, 0]\n"
      "[[walls]]\nname = 't'\nfrom = [12, 0]\nto = [0, 12]\n";
  const std::string side = "[[walls]]\nname = 't'\nfrom = [0, 12]\nto = [0, 0]\n";
  const std::string filling = kRandom + "inside = 't'\ncount = 30\n";
  for (const Disk& d : parse_filling(triangle + side + filling).bodies) {
    EXPECT_LE(d.x[0] + d.x[1] + 0.5 * std::sqrt(2.0), 12 + 1e-11);
    EXPECT_GE(std::min(d.x[0], d.x[1]), 0.5 - 1e-11);
  }
  expect_filling_refused(triangle + filling, {"'inside'", "closed line", "1 walls meet at"});
}

TEST(SceneFilling, StaysInsideATube) {
  const auto scene = scene_of<3>(
      "[[walls]]\nname = 'floor'\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n"
      "[[walls]]\nname = 'tube'\ncenter = [1, 2, 0]\naxis = [0, 0, 1]\nradius = 4\nhollow = true\n"
      "[[spheres]]\narrangement = 'random'\nmass = 1\nradii = [0.5, 0.4]\ncount = 60\n"
      "inside = ['floor', 'tube']\n" +
      kShortTime);
  ASSERT_EQ(scene.bodies.size(), 60u);
  for (const Sphere& s : scene.bodies) {
    EXPECT_LE((s.x.head<2>() - Vec2(1, 2)).norm() + s.radius, 4 + 1e-11);
    EXPECT_GE(s.x[2] - s.radius, -1e-11);
  }
}

TEST(SceneFilling, PositionsComeFromAFileBesideTheScene) {
  const TemporaryFolder folder;
  const auto positions = [&](const std::string& text) { std::ofstream(folder / "p.csv") << text; };
  const std::string source = (folder / "scene.toml").string();
  const std::string group = "arrangement = 'file'\nfile = 'p.csv'\ndensity = 1000\n" + kShortTime;
  positions("id, Y; x,z\tRadius\r\n1,0.2,0.1,0.3,0.01\n\n2,0.5,0.4,-6e-1,0.02\n");
  const Scene<3> space = std::get<Scene<3>>(parse_any_scene("[[spheres]]\n" + group, source));
  ASSERT_EQ(space.bodies.size(), 2u);
  EXPECT_EQ(space.bodies[0].x, Vec3(0.1, 0.2, 0.3));
  EXPECT_EQ(space.bodies[1].x, Vec3(0.4, 0.5, -0.6));
  EXPECT_EQ(space.bodies[1].radius, 0.02);
  EXPECT_NEAR(space.bodies[0].mass, 4.18879020e-3, 1e-10);  // 4/3 π 0.01³ 1000

  const auto refused = [&](const std::string& table, const std::string& because) {
    EXPECT_TRUE(says(
        refusal_of<std::runtime_error>([&] { parse_any_scene(table + group, source); }), because));
  };
  refused("[[disks]]\n", "p.csv:1: has a column z");
  positions("x,y,radius\n1,2,0.1\n1,x,0.1\n");
  refused("[[disks]]\n", "p.csv:3: y: 'x' is no finite number");
  refused("[[spheres]]\n", "p.csv:1: no column 'z'");
  positions("x,y,radius,v_x\n1,2,0.1,3\n");
  refused("[[disks]]\n", "unknown column 'v_x'; did you mean 'vx'?");
  positions("x,y,radius,vx\n1,2,0.1,3\n");
  const std::string glued =
      "[[walls]]\npoint = [0, 0]\nnormal = [0, 1]\nname = 'floor'\n[[disks]]\n"
      "wall = 'floor'\narrangement = 'file'\nfile = 'p.csv'\n" +
      std::string(kShortTime);
  EXPECT_TRUE(says(refusal_of([&] { parse_any_scene(glued, source); }),
                   "glued disks move with their wall"));
  positions("x,y,radius\n1,2\n");
  refused("[[disks]]\n", "p.csv:2: 2 columns");
  positions("x,y,radius\n1,2,0\n");
  refused("[[disks]]\n", "radius: 0 is not positive");
  positions("x,y,z,radius,spin\n1,2,3,0.1,5\n");
  refused("[[spheres]]\n", "p.csv:1: has a column spin: spheres have spin_x");
  for (const std::string column : {"vz", "spin_x", "spin_y", "spin_z"}) {
    positions("x,y,radius," + column + "\n1,2,0.1,3\n");
    refused("[[disks]]\n", "p.csv:1: has a column " + column);
  }
  positions("x,y,radius\n");
  refused("[[disks]]\n", "p.csv has no disk");
  positions("x,y,radius,X\n1,2,0.1,3\n");
  refused("[[disks]]\n", "p.csv:1: has two columns 'x'");
  fs::remove(folder / "p.csv");
  refused("[[disks]]\n", "p.csv: ");
  positions("x,y,radius\n1,2,0.25\n");
  EXPECT_EQ(parse_scene("[[disks]]\n" + group, source).bodies[0].radius, 0.25);
  positions("# x  y radius\n1 2 0.1\n\n 3  -4 0.2 \n");
  const Scene<2> plane = parse_scene("[[disks]]\n" + group, source);
  ASSERT_EQ(plane.bodies.size(), 2u);
  EXPECT_EQ(plane.bodies[1].x, Vec2(3, -4));
  EXPECT_EQ(plane.bodies[1].radius, 0.2);
}

}  // namespace
}  // namespace bipot
