#include "core/scene_files/scene_file.h"

#include <regex>

#include "core/base/file_error.h"
#include "core/scene_files/scene_keys.h"
#include "tests/support/refused_scene.h"
#include "tests/support/scene_text.h"
#include "tests/support/source_folder.h"

namespace bipot {
namespace {

// The least that a scene needs: everything else has a default.
const std::string kTime = "[time]\nstep = 1e-3\nsteps = 10\n";
const std::string kDisk = "[[disks]]\nposition = [1, 2]\nradius = 0.5\nmass = 3\n";
const std::string kFloor = "[[walls]]\npoint = [0, 0]\nnormal = [0, 1]\n";

/// The text, with the table above at its end where it has none of the kind.
std::string timed(const std::string& text) {
  return text.find("[time]") == std::string::npos ? text + kTime : text;
}

Scene<2> parse(const std::string& text) { return parse_scene(timed(text), "test.toml"); }

void expect_refused(const std::string& text, std::initializer_list<std::string> parts) {
  expect_scene_refused(text, parts, parse);
}

TEST(SceneFile, DefaultsOfTheLeastScene) {
  const Scene<2> s = parse("");
  EXPECT_EQ(s.title, "");
  EXPECT_EQ(s.source, "test.toml");
  EXPECT_EQ(s.gravity, Vec2(0, -9.81));
  EXPECT_TRUE(s.bodies.empty());
  EXPECT_TRUE(s.walls.empty());
  EXPECT_EQ(s.materials, std::vector<std::string>{"default"});
  ASSERT_EQ(s.laws.size(), 1u);
  EXPECT_EQ(s.laws[0].mu, 0);
  EXPECT_EQ(s.laws[0].e_n, 0);
  EXPECT_EQ(s.laws[0].e_t, 0);
  EXPECT_FALSE(s.has_friction());
  EXPECT_EQ(s.contact_distance, 0);
  EXPECT_EQ(s.solver.name, "auto");
  EXPECT_EQ(s.solver.tol, 1e-8);
  EXPECT_EQ(s.solver.stop, "guarded");
  EXPECT_EQ(s.solver.max_iterations, 1000000);
  EXPECT_TRUE(s.solver.warm_start);
  EXPECT_TRUE(s.solver.parameters.empty());
  EXPECT_EQ(s.output.every, 100);
  EXPECT_EQ(s.output.ledger_every, 1);
  EXPECT_TRUE(s.output.picture);
  EXPECT_FALSE(s.output.stress_picture);
  EXPECT_TRUE(s.output.track.empty());
}

TEST(SceneFile, PinsAndRopesAreHeldByTheirBodies) {
  // The second disk stands at (4, 2); points are kept relative to the bodies.
  const std::string two = kTime + kDisk + "[[disks]]\nposition = [4, 2]\nradius = 0.5\nmass = 3\n";
  const Scene<2> s =
      parse(two +
            "[[ropes]]\nbodies = [0, 1]\n[[ropes]]\nbodies = [1]\nfrom = [4, 3]\n"
            "to = [4, 5]\nlength = 2.5\n[[pins]]\nbodies = [0, 1]\npoint = [2, 2]\n");
  ASSERT_EQ(s.joints.size(), 3u);
  EXPECT_FALSE(s.joints[0].is_rope());
  EXPECT_EQ(s.joints[0].at_i, Vec2(1, 0));
  EXPECT_EQ(s.joints[0].at_j, Vec2(-2, 0));
  EXPECT_EQ(s.joints[1].length, 3);
  EXPECT_EQ(s.joints[2].j, -1);
  EXPECT_EQ(s.joints[2].at_i, Vec2(0, 1));
  EXPECT_EQ(s.joints[2].at_j, Vec2(4, 5));
  EXPECT_EQ(s.joints[2].length, 2.5);

  expect_refused(two + "[[pins]]\nbodies = [0, 2]\npoint = [2, 2]\n",
                 {"'bodies'", "one or two numbers of disks, from 0 to 1"});
  expect_refused(two + "[[pins]]\nbodies = [0, 1]\n", {"'point': is missing"});
  expect_refused(two + "[[pins]]\nbodies = [0, 0]\npoint = [2, 2]\n",
                 {"pins[0]: disk 0 and 0 are one body"});
  expect_refused(two + "[[ropes]]\nbodies = [0]\n", {"'to': is missing: the point of the ground"});
  expect_refused(two + "[[ropes]]\nbodies = [0, 1]\nlength = 2\n",
                 {"ropes[0]: its length is 2 m, its ends are 3 m apart"});
  expect_refused(two + "[[ropes]]\nbodies = [0]\nto = [1, 2]\n", {"its ends are at one place"});
  expect_refused("model = 'dem'\n" + two + "[[ropes]]\nbodies = [0, 1]\n",
                 {"pins and ropes do not go with the model \"dem\""});
  expect_refused("cell = {width = 20}\n" + two + "[[ropes]]\nbodies = [0, 1]\n",
                 {"do not go with a periodic cell"});
  expect_refused("joints = []\n" + two, {"did you mean 'pins'"});
}

TEST(SceneFile, TopLevelKeys) {
  const Scene<2> s = parse("title = 'A title'\ngravity = [1.5, -2]\n");
  EXPECT_EQ(s.title, "A title");
  EXPECT_EQ(s.gravity, Vec2(1.5, -2));
}

TEST(SceneFile, TimeBySteps) {
  const Scene<2> s = parse("");
  EXPECT_EQ(s.step, 1e-3);
  EXPECT_EQ(s.num_steps, 10);
}

TEST(SceneFile, TimeByDuration) {
  const Scene<2> s = parse("[time]\nstep = 1e-3\nduration = 0.7\n");
  EXPECT_EQ(s.num_steps, 700);
}

TEST(SceneFile, ContactTable) {
  const Scene<2> s = parse("[contact]\nmu = 0.3\ne_n = 0.5\ne_t = 0.25\ndistance = 1e-4\n");
  EXPECT_EQ(s.laws[0].mu, 0.3);
  EXPECT_EQ(s.laws[0].e_n, 0.5);
  EXPECT_EQ(s.laws[0].e_t, 0.25);
  EXPECT_EQ(s.contact_distance, 1e-4);
  EXPECT_TRUE(s.has_friction());
}

TEST(SceneFile, ContactDistanceDefaultsToAMillionthOfTheSmallestRadius) {
  EXPECT_DOUBLE_EQ(
      parse(kDisk + "[[disks]]\nposition = [5, 5]\nradius = 0.25\nmass = 1\n").contact_distance,
      0.25e-6);
  EXPECT_EQ(parse("[contact]\ndistance = 0\n" + kDisk).contact_distance, 0);
}

TEST(SceneFile, MaterialsAndPairs) {
  const Scene<2> s = parse(
      "materials = ['steel', 'wood']\n[contact]\nmu = 0.2\ne_n = 0.5\n"
      "[[pairs]]\nbetween = ['wood', 'steel']\nmu = 0.4\ne_t = 1\n"
      "[[pairs]]\nbetween = ['wood', 'wood']\ne_n = 0\n" +
      kDisk + "material = 'wood'\n" + kFloor + "material = 'wood'\n" + kFloor);
  EXPECT_EQ(s.law(0, 0).mu, 0.2);
  EXPECT_EQ(s.law(0, 1).mu, 0.4);
  EXPECT_EQ(s.law(1, 0).mu, 0.4);
  EXPECT_EQ(s.law(0, 1).e_n, 0.5);  // from [contact]
  EXPECT_EQ(s.law(0, 1).e_t, 1);
  EXPECT_EQ(s.law(1, 1).mu, 0.2);
  EXPECT_EQ(s.law(1, 1).e_n, 0);
  EXPECT_EQ(s.bodies[0].material, 1);
  EXPECT_EQ(s.walls[0].material, 1);
  EXPECT_EQ(s.walls[1].material, 0);  // the first one named
}

TEST(SceneFile, SingleDisk) {
  const Scene<2> s = parse(kDisk + "velocity = [4, 5]\nspin = 6\ninertia = 7\n");
  ASSERT_EQ(s.bodies.size(), 1u);
  EXPECT_EQ(s.bodies[0].x, Vec2(1, 2));
  EXPECT_EQ(s.bodies[0].radius, 0.5);
  EXPECT_EQ(s.bodies[0].mass, 3);
  EXPECT_EQ(s.bodies[0].v, Vec2(4, 5));
  EXPECT_EQ(s.bodies[0].spin, 6);
  EXPECT_EQ(s.bodies[0].inertia, 7);
  EXPECT_DOUBLE_EQ(parse(kDisk).bodies[0].inertia, 0.5 * 3 * 0.25);
}

TEST(SceneFile, DensityGivesTheMassOfACylinderOfUnitLength) {
  const Scene<2> s = parse("[[disks]]\nposition = [0, 0]\nradius = 0.5\ndensity = 8\n");
  EXPECT_DOUBLE_EQ(s.bodies[0].mass, 8 * std::numbers::pi * 0.25);
}

TEST(SceneFile, Arrangements) {
  const auto group = [](const std::string& keys) {
    return parse("[[disks]]\ndensity = 1\ncorner = [3, 4]\n" + keys).bodies;
  };
  const auto rectangular =
      group("arrangement = 'rectangular'\ncolumns = 3\nrows = 2\nradius = 0.5\n");
  ASSERT_EQ(rectangular.size(), 6u);
  EXPECT_EQ(rectangular[0].x, Vec2(3.5, 4.5));
  EXPECT_EQ(group("arrangement = 'triangular'\ncolumns = 3\nrows = 2\nradius = 0.5\n").size(), 5u);
  EXPECT_EQ(group("arrangement = 'pyramid'\nrows = 4\nradius = 0.5\n").size(), 10u);
  const std::string random =
      "arrangement = 'random'\ncount = 20\nradii = [1, 2]\nfractions = [3, 1]\nwidth = 50\n";
  const auto filled = group(random + "seed = 4\nspacing = 0.5\n");
  ASSERT_EQ(filled.size(), 20u);
  EXPECT_EQ(
      std::count_if(filled.begin(), filled.end(), [](const Disk& d) { return d.radius == 1; }), 15);
  EXPECT_NE(filled[0].x, group(random + "seed = 5\nspacing = 0.5\n")[0].x);
  EXPECT_NE(filled[0].x, group(random + "seed = 4\n")[0].x);
  EXPECT_EQ(group(random)[7].x, group(random + "seed = 1\nspacing = 0.1\n")[7].x);  // the defaults
  const auto even = group("arrangement = 'random'\ncount = 20\nradii = [1, 2]\nwidth = 50\n");
  EXPECT_EQ(std::count_if(even.begin(), even.end(), [](const Disk& d) { return d.radius == 1; }),
            10);
}

TEST(SceneFile, GroupsFollowEachOther) {
  const Scene<2> s =
      parse(kDisk + "[[disks]]\narrangement = 'pyramid'\nrows = 2\nradius = 1\nmass = 9\n");
  ASSERT_EQ(s.bodies.size(), 4u);
  EXPECT_EQ(s.bodies[0].mass, 3);
  EXPECT_EQ(s.bodies[3].mass, 9);
}

TEST(SceneFile, FixedAndMovingWalls) {
  const Scene<2> s = parse(
      "[[walls]]\nname = 'slope'\npoint = [1, 2]\nnormal = [3, 4]\n"
      "[[walls]]\nfrom = [1, 2]\nto = [3, 4]\nvelocity = [5, 6]\n");
  ASSERT_EQ(s.walls.size(), 2u);
  EXPECT_EQ(s.walls[0].name, "slope");
  EXPECT_EQ(s.walls[0].shape, Wall<2>::Shape::kHalfPlane);
  EXPECT_EQ(s.walls[0].motion, Wall<2>::Motion::kFixed);
  EXPECT_EQ(s.walls[0].a, Vec2(1, 2));
  EXPECT_TRUE(s.walls[0].normal.isApprox(Vec2(0.6, 0.8)));
  EXPECT_EQ(s.walls[1].name, "wall1");
  EXPECT_EQ(s.walls[1].shape, Wall<2>::Shape::kSegment);
  EXPECT_EQ(s.walls[1].a, Vec2(1, 2));
  EXPECT_EQ(s.walls[1].b, Vec2(3, 4));
  EXPECT_EQ(s.walls[1].motion, Wall<2>::Motion::kMoving);
  EXPECT_EQ(s.walls[1].v, Vec2(5, 6));
}

TEST(SceneFile, DrivenWalls) {
  const Scene<2> s = parse(kFloor + "force = -7\nmass = 8\n" +
                           "[[walls]]\nfrom = [1, 2]\nto = [3, 4]\n"
                           "direction = [0, -2]\nforce = 1\nmass = 2\nspeed = 3\n");
  EXPECT_EQ(s.walls[0].motion, Wall<2>::Motion::kDriven);
  EXPECT_EQ(s.walls[0].force, -7);
  EXPECT_EQ(s.walls[0].mass, 8);
  EXPECT_EQ(s.walls[0].direction, Vec2(0, 1));  // a half-plane's is its normal
  EXPECT_EQ(s.walls[0].v, Vec2(0, 0));
  EXPECT_EQ(s.walls[1].direction, Vec2(0, -1));
  EXPECT_EQ(s.walls[1].v, Vec2(0, -3));
}

TEST(SceneFile, AWallMovedAcrossAForce) {
  const Scene<2> s = parse(kFloor + "force = -7\nmass = 8\nspeed = 2\nvelocity = [3, 0]\n");
  EXPECT_EQ(s.walls[0].motion, Wall<2>::Motion::kDriven);
  EXPECT_EQ(s.walls[0].across, Vec2(3, 0));
  EXPECT_EQ(s.walls[0].v, Vec2(3, 2));
  const Scene<2> turned = parse("rotate_degrees = 90\n" + kFloor +
                                "force = -7\nmass = 8\nspeed = 2\nvelocity = [3, 0]\n");
  EXPECT_TRUE(turned.walls[0].across.isApprox(Vec2(0, 3)));
  EXPECT_TRUE(turned.walls[0].v.isApprox(Vec2(-2, 3)));
}

TEST(SceneFile, ForcesAndDragTurnWithTheScene) {
  const Scene<2> s = parse(
      "rotate_degrees = 90\n[[forces]]\nbodies = [0, 0]\nforce = [2, 1]\n"
      "[drag]\ncoefficient = 1\nvelocity = [3, 0]\n" +
      kDisk);
  EXPECT_TRUE(s.forces[0].force.isApprox(Vec2(-1, 2)));
  EXPECT_TRUE(s.drag.velocity.isApprox(Vec2(0, 3)));
}

TEST(SceneFile, LinesOfFluxTurnWithTheSceneAndProfilesRefuseTo) {
  const Scene<2> s = parse(
      "rotate_degrees = 90\n[observables]\nlines = [{from = [0, -1], to = [2, 1]}]\n" + kDisk);
  EXPECT_TRUE(s.observables->crossings[0].a.isApprox(Vec2(1, 0)));
  EXPECT_TRUE(s.observables->crossings[0].b.isApprox(Vec2(-1, 2)));
  expect_refused(
      "rotate_degrees = 90\n[observables]\nprofile = \"y\"\nprofile_range = [0, 1]\n" + kDisk,
      {"'rotate_degrees'", "profile"});
}

TEST(SceneFile, Circles) {
  const std::string circle = "[[walls]]\ncenter = [1, 2]\nradius = 3\n";
  const Scene<2> s = parse(circle + "hollow = true\nspin = -4\n" + circle);
  EXPECT_EQ(s.walls[0].shape, Wall<2>::Shape::kHollowCircle);
  EXPECT_EQ(s.walls[0].a, Vec2(1, 2));
  EXPECT_EQ(s.walls[0].radius, 3);
  EXPECT_EQ(s.walls[0].spin, -4);
  EXPECT_EQ(s.walls[1].shape, Wall<2>::Shape::kSolidCircle);
  EXPECT_EQ(s.walls[1].spin, 0);
  expect_refused("[[walls]]\ncenter = [0, 0]\n", {"[walls[0]]", "'radius'", "missing"});
  expect_refused("[[walls]]\ncenter = [0, 0]\nradius = 0\n",
                 {"test.toml:3", "'radius'", "positive"});
  expect_refused(kFloor + "center = [0, 0]\nradius = 1\n", {"half-plane", "circle"});
  expect_refused(kFloor + "spin = 1\n", {"test.toml:4", "unknown key 'spin'"});
  expect_refused(circle + "force = 1\nmass = 1\n", {"'direction'", "missing"});
}

TEST(SceneFile, BeltsMoveAlongTheirWall) {
  const std::string belt = "[[walls]]\nfrom = [0, 0]\nto = [2, 0]\nsurface_velocity = ";
  const Scene<2> s = parse(belt + "[3, 0]\nstarts = 1\n" + kFloor + "surface_velocity = [-1, 0]\n");
  EXPECT_EQ(s.walls[0].belt, Vec2(3, 0));
  EXPECT_EQ(s.walls[0].v, Vec2(0, 0));
  EXPECT_EQ(s.walls[1].belt, Vec2(-1, 0));
  EXPECT_TRUE(
      parse("rotate_degrees = 90\n" + belt + "[3, 0]\n").walls[0].belt.isApprox(Vec2(0, 3)));
  expect_refused(belt + "[3, 1]\n", {"test.toml:4", "along the wall"});
  expect_refused("[[walls]]\ncenter = [0, 0]\nradius = 1\nsurface_velocity = [1, 0]\n",
                 {"unknown key 'surface_velocity'"});
}

TEST(SceneFile, WallsThatStartStopAndGo) {
  const Scene<2> s = parse(kFloor + "velocity = [1, 0]\nstarts = 2\nstops = 3\nremoved = 4\n" +
                           kFloor + "removed = 5\n");
  EXPECT_EQ(s.walls[0].starts, 2);
  EXPECT_EQ(s.walls[0].stops, 3);
  EXPECT_EQ(s.walls[0].removed, 4);
  EXPECT_EQ(s.walls[1].starts, 0);
  EXPECT_EQ(s.walls[1].stops, kInfinity);
  EXPECT_EQ(s.walls[1].removed, 5);
  expect_refused(kFloor + "starts = 1\n", {"test.toml:4", "'starts'", "a wall that moves"});
  expect_refused(kFloor + "velocity = [1, 0]\nstarts = 2\nstops = 1\n",
                 {"test.toml:6", "'stops'", "later than starts"});
  expect_refused(kFloor + "velocity = [1, 0]\nstarts = -2\n", {"'starts'", ">= 0"});
  expect_refused(kFloor + "removed = 0\n", {"'removed'", "positive"});
}

TEST(SceneFile, GravityThatTurns) {
  const Scene<2> s = parse("[tilt]\ndegrees_per_second = 90\nstarts = 1\nstops = 2\n");
  EXPECT_DOUBLE_EQ(s.tilt.rate, std::numbers::pi / 2);
  EXPECT_EQ(s.tilt.starts, 1);
  EXPECT_EQ(s.tilt.stops, 2);
  EXPECT_EQ(parse("").tilt.rate, 0);
  expect_refused("[tilt]\nstarts = 1\n", {"'degrees_per_second'", "missing"});
  expect_refused("[tilt]\ndegrees_per_second = 1\nstarts = 2\nstops = 1\n",
                 {"test.toml:4", "'stops'", "later"});
}

TEST(SceneFile, PeriodicCells) {
  const Scene<2> s = parse("gravity = [0, 0]\n[cell]\nwidth = 5\n" + kDisk + kFloor);
  EXPECT_TRUE(s.cell.in_x);
  EXPECT_FALSE(s.cell.in_y);
  EXPECT_EQ(s.cell.width.length, 5);
  EXPECT_FALSE(s.cell.deforms());
  const std::string both = "gravity = [0, 0]\n[cell]\nwidth = 5\nheight = 6\noffset = 1\n";
  const Scene<2> d =
      parse(both + "width_speed = -2\npressure_y = 7\nshear_stress = 8\nmass = 9\n" + kDisk);
  EXPECT_TRUE(d.cell.in_y);
  EXPECT_EQ(d.cell.height.length, 6);
  EXPECT_EQ(d.cell.offset.length, 1);
  EXPECT_EQ(d.cell.width.motion, CellSide::Motion::kMoving);
  EXPECT_EQ(d.cell.width.speed, -2);
  EXPECT_EQ(d.cell.height.motion, CellSide::Motion::kDriven);
  EXPECT_EQ(d.cell.height.stress, 7);
  EXPECT_EQ(d.cell.height.mass, 9);
  EXPECT_EQ(d.cell.offset.stress, 8);
  EXPECT_FALSE(parse("").cell.periodic());

  expect_refused("[cell]\nheight = 1\n", {"[cell]", "'width'", "missing"});
  expect_refused("[cell]\nwidth = 5\noffset = 1\n", {"test.toml:3", "give its height"});
  expect_refused("[cell]\nwidth = 5\nheight_speed = 1\n", {"test.toml:3", "height"});
  expect_refused(both + "width_speed = 1\npressure_x = 1\nmass = 1\n",
                 {"test.toml:7", "'pressure_x'", "not both"});
  expect_refused(both + "pressure_x = 1\n", {"'mass'", "missing"});
  expect_refused(both + "mass = 1\n", {"test.toml:6", "'mass'", "stress drives"});
  expect_refused("rotate_degrees = 3\n[cell]\nwidth = 5\n", {"'rotate_degrees'"});
  // kDisk has a radius of 0.5: two of its diameters.
  expect_refused("[cell]\nwidth = 2\n" + kDisk,
                 {"test.toml:1: the cell repeats itself after 2 m", "two of the largest"});
  expect_refused("[cell]\nwidth = 5\nheight = 5\n" + kDisk, {"test.toml:1: gravity has no place"});
  expect_refused(both + kDisk + kFloor, {"wall 0", "half-plane"});
  expect_refused("[cell]\nwidth = 5\n[[walls]]\npoint = [0, 0]\nnormal = [1, 9]\n",
                 {"wall 0", "lies along x"});
  expect_refused("[cell]\nwidth = 5\n[[walls]]\nfrom = [0, 0]\nto = [5.1, 1]\n",
                 {"wall 0", "m wide, the cell 5 m"});
  expect_refused(both + "[[walls]]\nfrom = [0, 0]\nto = [1, 6.1]\n",
                 {"wall 0", "m high, the cell 6 m"});
}

TEST(SceneFile, DisksGluedToAWall) {
  const std::string glued = "[[disks]]\nposition = [0, 0]\nradius = 1\nwall = 'lid'\n";
  const std::string lid = "[[walls]]\nname = 'lid'\npoint = [0, 0]\nnormal = [0, -1]\n";
  const Scene<2> s = parse(kDisk + glued + kFloor + lid + "velocity = [3, 0]\n");
  EXPECT_EQ(s.bodies[0].wall, -1);
  EXPECT_EQ(s.bodies[1].wall, 1);
  EXPECT_EQ(s.bodies[1].mass, 0);
  EXPECT_EQ(s.bodies[1].v, Vec2(3, 0));
  expect_refused(glued + kFloor, {"test.toml:4", "'wall'", "'lid'"});
  expect_refused(glued + "mass = 1\n" + lid, {"test.toml:5", "'mass'", "not glued"});
  expect_refused(glued + lid + "removed = 1\n",
                 {"test.toml:5: wall 0: 'lid'", "removed", "disk 0"});
}

TEST(SceneFile, RotationTurnsTheBodiesAndNotGravity) {
  const Scene<2> s =
      parse("rotate_degrees = 90\n" + kDisk + "velocity = [4, 5]\n" +
            "[[walls]]\npoint = [7, 0]\nnormal = [0, 1]\nforce = 1\nmass = 1\nspeed = 2\n");
  EXPECT_TRUE(s.bodies[0].x.isApprox(Vec2(-2, 1)));
  EXPECT_TRUE(s.bodies[0].v.isApprox(Vec2(-5, 4)));
  EXPECT_TRUE(s.walls[0].a.isApprox(Vec2(0, 7)));
  EXPECT_TRUE(s.walls[0].normal.isApprox(Vec2(-1, 0)));
  EXPECT_TRUE(s.walls[0].direction.isApprox(Vec2(-1, 0)));
  EXPECT_TRUE(s.walls[0].v.isApprox(Vec2(-2, 0)));
  EXPECT_EQ(s.gravity, Vec2(0, -9.81));
}

TEST(SceneFile, RotationTurnsClusters) {
  const std::string cluster =
      "[[clusters]]\nposition = [1, 2]\nvelocity = [4, 5]\nspin = 3\ndensity = 100\n"
      "parts = [[-0.1, 0, 0.1], [0.1, 0, 0.1]]\n";
  const Scene<2> s = parse("rotate_degrees = 90\n" + cluster);
  EXPECT_TRUE(s.clusters.bodies[0].x.isApprox(Vec2(-2, 1)));
  EXPECT_TRUE(s.clusters.bodies[0].v.isApprox(Vec2(-5, 4)));
  EXPECT_EQ(s.clusters.bodies[0].spin, 3);
  EXPECT_TRUE(s.bodies[0].x.isApprox(Vec2(-2, 0.9)));
  // v + w × r with r = (0, -0.1): (0.3, 0) more.
  EXPECT_TRUE(s.bodies[0].v.isApprox(Vec2(-4.7, 4)));
}

TEST(SceneFile, SpringsAndDashpots) {
  const Scene<2> s = parse("model = 'dem'\n" + kDisk +
                           "[dem]\nstiffness = 1e5\noverlap = 0.02\ntangential_ratio = 0.5\n"
                           "substep = 1e-5\nsafety = 0.2\n");
  EXPECT_EQ(s.model, Model::kSpringDashpot);
  EXPECT_EQ(s.dem.stiffness, 1e5);
  EXPECT_EQ(s.dem.overlap, 0.02);
  EXPECT_EQ(s.dem.tangential_ratio, 0.5);
  EXPECT_EQ(s.dem.substep, 1e-5);
  EXPECT_EQ(s.dem.safety, 0.2);
  EXPECT_EQ(parse(kDisk).model, Model::kNonsmooth);
  expect_refused("model = 'dem'\n" + kDisk + "[dem]\noverlap = 0.1\n",
                 {"overlap = 0.1, expected a number in (0, 0.1)"});
  const std::string stiff = kDisk + "[dem]\ntangential_ratio = 0\n";
  expect_refused("model = 'dem'\n" + stiff + "[contact]\nmu = 0.5\n", {"give mu = 0"});
  EXPECT_EQ(parse("model = 'dem'\n" + stiff).dem.tangential_ratio, 0);
  expect_refused("model = 'dem'\n" + kDisk + kTime + "[contact]\ndistance = 1e-3\n",
                 {"'distance'", "rigid contacts"});
}

TEST(SceneFile, SolverAndOutput) {
  const Scene<2> s =
      parse(kDisk + kDisk +
            "[solver]\nname = 'uzawa'\ntol = 1e-5\nstop = 'impulse'\nmax_iterations = 7\n"
            "warm_start = false\nparameters = { rho = 'paper', omega = 1.5, count = 3 }\n"
            "[output]\nevery = 2\nledger_every = 3\npicture = false\ntrack = [0, 1]\n");
  EXPECT_EQ(s.solver.name, "uzawa");
  EXPECT_EQ(s.solver.tol, 1e-5);
  EXPECT_EQ(s.solver.stop, "impulse");
  EXPECT_EQ(s.solver.max_iterations, 7);
  const Scene<2> own = parse_scene("[solver]\nplan = 'own.toml'\n" + kTime, "/a/b/scene.toml");
  EXPECT_EQ(own.solver.parameters.at("plan"), "/a/b/own.toml");
  EXPECT_FALSE(s.solver.warm_start);
  EXPECT_EQ(s.solver.parameters, (std::map<std::string, std::string>{
                                     {"rho", "paper"}, {"omega", "1.5"}, {"count", "3"}}));
  EXPECT_EQ(s.output.every, 2);
  EXPECT_EQ(s.output.ledger_every, 3);
  EXPECT_FALSE(s.output.picture);
  EXPECT_EQ(s.output.track, (std::vector<int>{0, 1}));
}

TEST(SceneFile, UnknownKeysAreRefusedWithTheNearestNameAndTheLine) {
  expect_refused("titel = 'x'\n", {"test.toml:1", "unknown key 'titel'", "did you mean 'title'"});
  expect_refused(kTime + "durration = 3\n", {"test.toml:4", "[time]", "did you mean 'duration'"});
  expect_refused("[contact]\nmy = 3\n", {"test.toml:2", "[contact]", "did you mean 'mu'"});
  expect_refused(kDisk + "velocty = [0, 1]\n", {"test.toml:5", "[disks[0]]", "'velocity'"});
  expect_refused(kFloor + kFloor + "forse = 1\n", {"test.toml:7", "[walls[1]]", "'force'"});
  expect_refused("[solver]\nmaxiterations = 1\n", {"test.toml:2", "'max_iterations'"});
  expect_refused("[output]\nevry = 1\n", {"test.toml:2", "'every'"});
  expect_refused("materials = ['a']\n[[pairs]]\nbetween = ['a', 'a']\nnu = 1\n",
                 {"test.toml:4", "[pairs[0]]", "'mu'"});
  // Keys of another kind of group are as unknown as any.
  expect_refused(kDisk + "rows = 3\n", {"unknown key 'rows'"});
  expect_refused(kFloor + "speed = 3\n", {"unknown key 'speed'"});
}

TEST(SceneFile, WrongTypesAreRefused) {
  expect_refused("title = 3\n", {"test.toml:1", "'title'", "string"});
  expect_refused("gravity = 3\n", {"test.toml:1", "'gravity'", "array"});
  expect_refused("gravity = [1, 2, 3]\n", {"'gravity'", "2 numbers, got 3"});
  expect_refused("gravity = [1, 'x']\n", {"'gravity'", "number"});
  expect_refused("gravity = [1, nan]\n", {"'gravity'", "finite"});
  expect_refused("[contact]\nmu = 'x'\n", {"test.toml:2", "'mu'", "number"});
  expect_refused("[contact]\nmu = true\n", {"'mu'", "number"});
  expect_refused("[contact]\nmu = inf\n", {"'mu'", "finite"});
  expect_refused("contact = 3\n", {"'contact'", "table"});
  expect_refused("[disks]\nradius = 1\n", {"'disks'", "[[disks]]"});
  expect_refused("disks = [1]\n", {"'disks'", "tables"});
  expect_refused("materials = [1]\n", {"'materials'", "strings"});
  expect_refused("materials = 'x'\n", {"'materials'", "strings"});
  expect_refused("[solver]\nmax_iterations = 1.5\n", {"'max_iterations'", "integer"});
  expect_refused("[solver]\nmax_iterations = 99999999999\n", {"'max_iterations'", "range"});
  expect_refused("[solver]\nwarm_start = 1\n", {"'warm_start'", "true or false"});
  expect_refused("[solver]\nparameters = { x = true }\n", {"string or a number"});
  expect_refused(kDisk + "[output]\ntrack = [0.5]\n", {"'track'"});
  expect_refused(kDisk + "[output]\ntrack = [1e300]\n", {"'track'"});
}

TEST(SceneFile, MissingKeysAreNamed) {
  expect_scene_refused("", {"[top level]", "[time]", "missing"});
  expect_refused("[time]\nsteps = 3\n", {"[time]", "'step'", "missing"});
  expect_refused("[time]\nstep = 3\n", {"[time]", "either steps or duration"});
  expect_refused("[[disks]]\nradius = 1\nmass = 1\n", {"[disks[0]]", "'position'"});
  expect_refused("[[disks]]\nposition = [0, 0]\nmass = 1\n", {"'radius'", "missing"});
  expect_refused("[[disks]]\nposition = [0, 0]\nradius = 1\n", {"'mass'", "density"});
  const std::string group = "[[disks]]\nmass = 1\narrangement = ";
  expect_refused(group + "'rectangular'\nradius = 1\nrows = 2\n", {"'columns'", "missing"});
  expect_refused(group + "'triangular'\nradius = 1\ncolumns = 2\n", {"'rows'", "missing"});
  expect_refused(group + "'pyramid'\nrows = 2\n", {"'radius'", "missing"});
  expect_refused(group + "'random'\nwidth = 10\nradii = [1]\n", {"'count'", "missing"});
  expect_refused(group + "'random'\ncount = 10\nradii = [1]\n", {"'width'", "missing"});
  expect_refused(group + "'random'\ncount = 10\nwidth = 10\n", {"'radii'", "missing"});
  expect_refused("[[walls]]\npoint = [0, 0]\n", {"[walls[0]]", "point and normal"});
  expect_refused(kFloor + "force = 1\n", {"force [N] and mass [kg]"});
  expect_refused(kFloor + "mass = 1\n", {"force [N] and mass [kg]"});
  expect_refused("[[walls]]\nfrom = [0, 0]\nto = [1, 0]\nforce = 1\nmass = 1\n",
                 {"'direction'", "missing"});
  expect_refused("materials = ['a']\n[[pairs]]\nmu = 1\n", {"'between'"});
  expect_refused(
      "materials = ['a', 'b']\n[[pairs]]\nbetween = ['a', 'b']\n[[pairs]]\nbetween = ['b', 'a']\n",
      {"test.toml:5", "[pairs[1]]", "an earlier entry"});
}

TEST(SceneFile, ContradictionsAreRefused) {
  expect_refused("[time]\nstep = 1\nsteps = 3\nduration = 3\n", {"either steps or duration"});
  expect_refused(kDisk + "density = 1\n", {"either mass [kg] or density"});
  expect_refused(kFloor + "from = [0, 0]\nto = [1, 1]\n", {"half-plane", "segment"});
  expect_refused(kFloor + "force = 1\nmass = 1\nvelocity = [1, 0.1]\n",
                 {"test.toml:6", "'velocity'", "across its direction only"});
  expect_refused("materials = ['a', 'a']\n", {"'materials'", "differ"});
}

TEST(SceneFile, ValuesOutOfRangeAreRefused) {
  expect_refused("[time]\nstep = 0\nsteps = 3\n", {"'step'", "positive"});
  expect_refused("[time]\nstep = 1\nsteps = -3\n", {"'steps'", "non-negative"});
  expect_refused("[time]\nstep = 1e-9\nduration = 1e9\n", {"'duration'", "too many"});
  expect_refused("[contact]\ndistance = -1\n", {"'distance'", ">= 0"});
  expect_refused("[contact]\nmu = -0.1\n", {"mu = -0.1"});
  expect_refused("[contact]\ne_n = 1.5\n", {"e_n = 1.5"});
  expect_refused("[contact]\ne_t = -0.5\n", {"e_t = -0.5"});
  expect_refused("[[disks]]\nposition = [0, 0]\nradius = -1\nmass = 1\n", {"'radius'", "positive"});
  expect_refused("[[disks]]\nposition = [0, 0]\nradius = 1\nmass = 0\n", {"'mass'", "positive"});
  expect_refused("[[disks]]\nposition = [0, 0]\nradius = 1\ndensity = 0\n", {"'density'"});
  expect_refused(kDisk + "inertia = 0\n", {"test.toml:5: [disks[0]] 'inertia'", "positive"});
  expect_refused(kDisk +
                     "[[inlets]]\nlower = [0, 0]\nupper = [1, 1]\nradii = [0.1]\nmass = 1\n"
                     "rate = 1e9\n",
                 {"test.toml:5: inlets[0]", "bodies a step"});
  expect_refused("[cell]\nwidth = 5\n[start]\noverlaps = 'push apart'\n",
                 {"test.toml:3: [start] overlaps"});
  expect_refused(kFloor + "force = 1\nmass = -1\n", {"test.toml:1: wall 0", "mass = -1"});
  expect_refused("[[walls]]\npoint = [0, 0]\nnormal = [0, 0]\n", {"'normal'", "zero"});
  expect_refused("[[walls]]\nfrom = [1, 1]\nto = [1, 1]\n", {"test.toml:1: wall 0", "coincide"});
  expect_refused(kFloor + "direction = [0, 0]\nforce = 1\nmass = 1\n", {"'direction'", "zero"});
  expect_refused("[output]\nevery = -1\n", {"'every'", "non-negative"});
  expect_refused("[output]\nledger_every = -1\n", {"'ledger_every'", "non-negative"});
  expect_refused("[output]\ntrack = [0]\n", {"test.toml:2: output.track", "no disk 0"});
  expect_refused("[solver]\ntol = 0\n", {"'tol'", "positive"});
  expect_refused("[solver]\nmax_iterations = -1\n", {"'max_iterations'", "non-negative"});
  const std::string random = "[[disks]]\nmass = 1\narrangement = 'random'\nradii = [1]\n";
  expect_refused(random + "count = -1\nwidth = 10\n", {"'count'", "non-negative"});
  expect_refused(random + "count = 3\nwidth = 1\n", {"does not hold"});
  expect_refused(random + "count = 3\nwidth = 10\nseed = -1\n", {"'seed'"});
  expect_refused(random + "count = 3\nwidth = 10\nspacing = -1\n", {"spacing = -1"});
  expect_refused(random + "count = 3\nwidth = 10\nfractions = [1, 2]\n", {"2 entries for 1"});
}

const std::string kSphere = "[[spheres]]\nposition = [0, 0, 1]\nradius = 0.5\nmass = 2\n";

Scene<3> in_space(const std::string& text) { return scene_of<3>(timed(text)); }

// 4/3 π 0.5³ of 1000 kg/m³, and 2/5 m a² of it.
TEST(SceneFile, SpheresMakeASceneInSpace) {
  const Scene<3> scene = in_space(
      "[[spheres]]\nposition = [1, 2, 3]\nradius = 0.5\ndensity = 1000\nspin = [0, 1, 2]\n"
      "velocity = [3, 0, -1]\n[[walls]]\npoint = [0, 0, 0]\nnormal = [0, 0, 2]\nforce = 3\n"
      "mass = 4\n[[walls]]\ncenter = [1, 1, 0]\naxis = [0, 3, 0]\nradius = 5\nhollow = true\n"
      "spin = 0.5\n");
  ASSERT_EQ(scene.bodies.size(), 1u);
  const Sphere& s = scene.bodies[0];
  EXPECT_EQ(s.x, Vec3(1, 2, 3));
  EXPECT_EQ(s.v, Vec3(3, 0, -1));
  EXPECT_EQ(s.spin, Vec3(0, 1, 2));
  EXPECT_NEAR(s.mass, 523.598775598, 1e-8);
  EXPECT_NEAR(s.inertia, 0.1 * s.mass, 1e-12);
  EXPECT_EQ(scene.gravity, Vec3(0, 0, -9.81));
  ASSERT_EQ(scene.walls.size(), 2u);
  EXPECT_EQ(scene.walls[0].direction, Vec3::UnitZ());
  EXPECT_EQ(scene.walls[1].shape, Wall<3>::Shape::kHollowCircle);
  EXPECT_EQ(scene.walls[1].normal, Vec3::UnitY());
  EXPECT_EQ(scene.walls[1].spin, 0.5);
  EXPECT_TRUE(in_space("dim = 3\n").bodies.empty());
}

TEST(SceneFile, ArrangementsOfSpheresHaveTheirNumbers) {
  const auto count = [](const std::string& keys) {
    return in_space("[[spheres]]\nmass = 1\n" + keys + "\n").bodies.size();
  };
  EXPECT_EQ(count("arrangement = 'cubic'\ncolumns = 2\nrows = 3\nlayers = 4\nradius = 1"), 24u);
  EXPECT_EQ(count("arrangement = 'pyramid'\nrows = 4\nradius = 1"), 30u);  // 16 + 9 + 4 + 1
  EXPECT_EQ(count("arrangement = 'random'\ncount = 37\nradii = [1, 2]\nwidth = 20\ndepth = 9"),
            37u);
}

TEST(SceneFile, AGrainBelongsToFlatWallsInSpace) {
  const auto refused = refused_scenes(kTime);
  const std::string plate = "[[walls]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n";
  const Scene<3> grained = in_space("dim = 3\n" + plate + "grain = [0, 3, 1]\ngrain_ratio = 0.4\n");
  EXPECT_EQ(grained.walls[0].grain, Vec3(0, 1, 0));
  EXPECT_EQ(grained.walls[0].grain_ratio, 0.4);
  EXPECT_FALSE(in_space("dim = 3\n" + plate).walls[0].has_grain());
  refused("dim = 3\n" + plate + "grain = [0, 1, 0]\n", "'grain_ratio'");
  refused("dim = 3\n" + plate + "grain_ratio = 1\n", "'grain'");
  refused("dim = 3\n" + plate + "grain = [0, 0, 2]\ngrain_ratio = 1\n", "normal");
  refused(
      "dim = 3\n[[walls]]\ncenter = [0, 0, 0]\naxis = [0, 0, 1]\nradius = 1\n"
      "grain = [0, 0, 2]\ngrain_ratio = 1\n",
      "flat walls");
  expect_refused(kFloor + "grain = [1, 0]\ngrain_ratio = 1\n", {"'grain'", "3D"});
}

TEST(SceneFile, WhatDoesNotBelongInSpaceIsRefused) {
  const auto refused = refused_scenes(kTime);
  expect_refused(kSphere, {"only 'bipot run'"});  // who reads disks only
  refused("dim = 4\n", "expected 2 or 3, got 4");
  refused("dim = 2\n" + kSphere, "dim = 3");
  refused("dim = 3\n" + kDisk, "'disks'");
  refused("rotate_degrees = 3\n" + kSphere, "turns scenes in the plane alone");
  refused(kSphere + "[[walls]]\npoint = [0, 0]\nnormal = [0, 1]\n", "expected 3 numbers, got 2");
  refused(kSphere + "[[walls]]\ncenter = [0, 0, 0]\nradius = 1\n", "cylinder");
  refused(kSphere + "[[walls]]\nfrom = [0, 0, 0]\nto = [0, 0, 1]\n", "half-space");
  refused("[[spheres]]\narrangement = 'random'\nmass = 1\ncount = 3\nradii = [1]\nwidth = 1\n",
          "width");
}

TEST(SceneFile, UnknownWordsNameTheNearest) {
  expect_refused(kDisk + "material = 'steal'\n", {"'material'", "Valid: default"});
  expect_refused("materials = ['steel', 'wood']\n" + kDisk + "material = 'steal'\n",
                 {"did you mean 'steel'"});
  expect_refused("materials = ['steel', 'wood']\n[[pairs]]\nbetween = ['steel', 'wod']\n",
                 {"did you mean 'wood'"});
  expect_refused("[[disks]]\narrangement = 'piramid'\n", {"did you mean 'pyramid'"});
  expect_refused("[solver]\nstop = 'garded'\n", {"did you mean 'guarded'"});
}

TEST(SceneFile, SyntaxErrorsNameTheLine) {
  expect_refused("title = 'x'\ngravity = [1,\n[time]\n", {"test.toml:3"});
  expect_refused(kTime + kTime, {"test.toml:4"});
}

TEST(SceneFile, AMissingFileIsNamed) {
  EXPECT_TRUE(
      says(refusal_of<FileError>([&] { read_scene("no/such/scene.toml"); }), "no/such/scene.toml"));
}

const fs::path kScenes = source_folder() / "data" / "scenes";

TEST(SceneFile, EveryShippedSceneIsSound) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(kScenes)) {
    if (entry.path().extension() != ".toml") continue;
    ++count;
    std::visit(
        [&](const auto& scene) {
          EXPECT_EQ(validate(scene), "") << entry.path();
          EXPECT_FALSE(scene.title.empty()) << entry.path();
          EXPECT_FALSE(scene.bodies.empty()) << entry.path();
          EXPECT_GT(scene.num_steps, 0) << entry.path();
        },
        read_any_scene(entry.path()));
  }
  EXPECT_GE(count, 7);
}

/// Every key that the reader asks a table for.
std::set<std::string> keys_in_the_source() {
  std::string source;
  for (const auto& entry : fs::directory_iterator(source_folder() / "core" / "scene_files")) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("scene_")) source += file_text(entry.path());
  }
  const std::regex access(
      R"((?:has|maybe_number|number|positive|integer|natural|boolean|word|one_of|vec(?:_or_zero)?<[23D]>|numbers|words|table|tables)\(\"([a-z_]+)\")");
  std::set<std::string> keys;
  for (std::sregex_iterator it(source.begin(), source.end(), access), end; it != end; ++it) {
    keys.insert((*it)[1]);
  }
  const std::regex material(R"((?:material_index\([a-z]+, |at_least_one\()[*a-z]+, \"([a-z_]+)\")");
  for (std::sregex_iterator it(source.begin(), source.end(), material), end; it != end; ++it) {
    keys.insert((*it)[1]);
  }
  return keys;
}

std::string page_of_scenes() {
  return file_text(source_folder() / "data" / "manual" / "reference" / "scenes.md");
}

TEST(SceneFile, EveryKeyIsDocumentedAndNoOther) {
  const std::string page = page_of_scenes();
  // A documented key stands in the first cell of a table row: |`key`|... or |`key`, `key`|...
  const std::regex row(R"(\n\|([^|\n]+)\|)"), key("`([a-z_]+)`");
  std::set<std::string> documented;
  const std::sregex_iterator end;
  for (std::sregex_iterator it(page.begin(), page.end(), row); it != end; ++it) {
    const std::string cell = (*it)[1];
    for (std::sregex_iterator k(cell.begin(), cell.end(), key); k != end; ++k) {
      documented.insert((*k)[1]);
    }
  }
  const std::set<std::string> known = keys_in_the_source();
  EXPECT_GT(known.size(), 45u);
  EXPECT_EQ(documented, known);
  // And the reader expects no key that nothing reads.
  for (const char* table : {"", "contact", "pairs", "time", "disks", "spheres", "clusters", "walls",
                            "solver", "output", "start", "tilt", "dem", "cell", "outlets", "inlets",
                            "observables", "observables.lines", "observables.faces"}) {
    for (const std::string& expected : keys_of_table(table)) {
      EXPECT_TRUE(known.contains(expected)) << table << ": " << expected;
    }
  }
}

TEST(SceneFile, TheExampleOfTheManualIsSound) {
  const std::string page = page_of_scenes(), fence = "```toml\n";
  const std::size_t begin = page.find(fence) + fence.size();
  ASSERT_GE(begin, fence.size());
  const Scene scene = parse_scene(page.substr(begin, page.find("```", begin) - begin), "scenes.md");
  EXPECT_EQ(validate(scene), "");
  EXPECT_EQ(scene.bodies.size(), 60u);
  EXPECT_EQ(scene.walls.size(), 4u);
}

// Of 2000 rows, 2000 · 2001 · 4001 / 6 = 2.7e9 spheres, 4e7 in ten layers of a lattice of 2000 x
// 2000.
TEST(SceneFile, MoreSpheresThanMemoryHoldsAreRefused) {
  const auto refused = refused_scenes(kTime);
  const std::string rows = "[[spheres]]\nmass = 1\nradius = 0.1\nrows = 2000\n";
  refused(rows + "arrangement = 'pyramid'\n", "2.67e+09 spheres, at most 1e+07");
  refused(rows + "arrangement = 'cubic'\ncolumns = 2000\nlayers = 10\n",
          "4e+07 spheres, at most 1e+07");
  refused(
      "[[spheres]]\nmass = 1\narrangement = 'random'\ncount = 20000000\nradii = [1]\nwidth = 9\n",
      "2e+07 spheres, at most 1e+07");
}

// Of 20 000 rows, 2e8 disks: found by tests/fuzz/scene_fuzz.cc.
TEST(SceneFile, MoreDisksThanMemoryHoldsAreRefused) {
  const std::string rows = "[[disks]]\nradius = 0.1\nrows = 20000\n";
  expect_refused(rows + "arrangement = \"pyramid\"\n",
                 {"test.toml:3", "'rows'", "2e+08", "at most 1e+07"});
  expect_refused(rows + "arrangement = \"triangular\"\ncolumns = 20000\n", {"4e+08"});
  expect_refused("[[disks]]\narrangement = \"random\"\ncount = 20000000\nradii = [1]\nwidth = 9\n",
                 {"'count'", "2e+07"});
}

TEST(SceneFile, OverlapsAreKeptOrProjected) {
  EXPECT_FALSE(parse("[contact]\nmu = 0\n").project_overlaps);
  EXPECT_TRUE(parse("[contact]\noverlaps = \"project\"\n").project_overlaps);
  expect_refused("[contact]\noverlaps = \"ignore\"\n", {"'overlaps'", "project"});
  EXPECT_TRUE(parse("[contact]\noverlaps = \"predict\"\n").predict_gaps);
  expect_refused("[contact]\ne_n = 0.5\noverlaps = \"predict\"\n",
                 {"test.toml:3: overlaps", "predict", "e_n = 0.5"});
  const std::string wide = kDisk + "[contact]\ndistance = 0.1\n";
  EXPECT_TRUE(says(parse(wide).caution, "lets bodies rest 0.2 of the smallest radius apart"));
  EXPECT_EQ(parse(wide + "overlaps = \"predict\"\n").caution, "");
  EXPECT_TRUE(says(parse(wide).caution, "predict"));
  EXPECT_FALSE(says(parse(wide + "e_n = 0.5\n").caution, "predict")) << "it is refused there";
  EXPECT_EQ(parse(kDisk + "[contact]\ndistance = 0.02\n").caution, "");
  EXPECT_EQ(parse(kTime + "travel = 0.1\n").travel, 0.1);
  const std::string accurate = kTime + "accuracy = 1e-3\n";
  EXPECT_EQ(parse(accurate).accuracy, 1e-3);
  EXPECT_EQ(parse(accurate).solver.tol, 1e-5);
  EXPECT_EQ(parse(accurate + "[solver]\ntol = 1e-3\n").solver.tol, 1e-3);
  EXPECT_EQ(parse(kTime + "accuracy = 0.3\n").solver.tol, 1e-4);
  expect_refused(kTime + "accuracy = 1\n", {"test.toml:4: accuracy = 1"});
  expect_refused(accurate + "travel = 0.1\n", {"accuracy", "travel"});
  // That of the command line has no line.
  expect_scene_refused(accurate, {"test.toml: accuracy = 1"},
                       [](const std::string& text) { parse_any_scene(text, "test.toml", 1.0); });
  expect_refused("model = \"dem\"\n" + accurate, {"accuracy", "dem"});
  expect_refused("[contact]\noverlaps = \"project\"\n" + accurate, {"accuracy", "project"});
  expect_refused("[contact]\noverlaps = \"predict\"\n" + accurate, {"accuracy", "predict"});
  expect_refused(kTime + "travel = -1\n", {"travel = -1"});
  expect_refused("model = \"dem\"\n" + kTime + "travel = 0.1\n", {"travel", "dem"});
  expect_refused("model = \"dem\"\n[contact]\noverlaps = \"project\"\n", {"overlaps", "dem"});
}

}  // namespace
}  // namespace bipot
