#include "core/scene_files/lmgc90_bodies.h"

#include "core/scene_files/scene_file.h"
#include "tests/support/scene_run.h"

namespace bipot {
namespace {

std::string disk_record(const std::string& x, const std::string& contactors) {
  return "$bdyty\n RBDY2      1\n$blmty\n PLAIN      1  behav  plexx  avrd= 0.0000000D+01  gyrd= "
         "0.0000000D+01\n$nodty\n NO3xx      1                coo1= " +
         x + "  coo2=-0.2500000D-01  coo3= 0.0000000D+00\n$tacty\n" + contactors + "$$$$$$\n";
}
const std::string kDiskLine = " DISKx      1  color  BLEUx\tbyrd=\t0.5000000D-01\n";
const std::string kWallLine =
    " JONCx      1  color  DOWNx  axe1= 0.4000000D+01  axe2= 0.1000000D+00\n";

void put_file(const fs::path& path, const std::string& text) { std::ofstream(path) << text; }

struct Lmgc90Bodies : testing::Test {
  const TemporaryFolder folder;
};

TEST_F(Lmgc90Bodies, DisksComeWithDisplacementsAndVelocitiesAndWithoutWalls) {
  put_file(folder / "BODIES.DAT", "! File BODIES\n!\n" + disk_record("0.1000000D+00", kDiskLine) +
                                      disk_record("0.0000000D+00", kWallLine) +
                                      disk_record("-3.0000000D-01", kDiskLine));
  put_file(
      folder / "DOF.INI",
      "! DOF\n\n$steps      0                time= 0.0000000D+00\n!---\n$bdyty\n RBDY2      3\n"
      "$nodty\n NO3xx      1                X(1)= 0.1000000D-01  X(2)= 0.0000000D+00  X(3)= "
      "0.0000000D+00\n                             V(1)= 0.5000000D+00  V(2)=-0.7500000D+00  "
      "V(3)= 0.2000000D+02\n$$$$$$\n");
  const Scene<2> scene = parse_scene(
      "[[disks]]\narrangement = \"file\"\nfile = \"BODIES.DAT\"\ndensity = 100\n[time]\nstep = 1\n"
      "steps = 1\n",
      (folder / "scene.toml").string());
  ASSERT_EQ(scene.bodies.size(), 2u);
  EXPECT_EQ(scene.bodies[0].x, Vec2(0.1, -0.025));
  EXPECT_EQ(scene.bodies[0].radius, 0.05);
  EXPECT_EQ(scene.bodies[0].v, Vec2(0, 0));
  EXPECT_EQ(scene.bodies[1].x, Vec2(-0.3 + 0.01, -0.025));
  EXPECT_EQ(scene.bodies[1].v, Vec2(0.5, -0.75));
  EXPECT_EQ(scene.bodies[1].spin, 20);
}

TEST_F(Lmgc90Bodies, WhatIsLeftOutIsTold) {
  const auto scene = [&](const std::string& bodies) {
    put_file(folder / "BODIES.DAT", bodies);
    return parse_scene(
        "[[disks]]\narrangement = \"file\"\nfile = \"BODIES.DAT\"\ndensity = 100\n"
        "[time]\nstep = 1\nsteps = 1\n",
        (folder / "scene.toml").string());
  };
  const std::string disk = disk_record("0.1D+00", kDiskLine), wall = disk_record("0", kWallLine);
  EXPECT_EQ(scene(disk).caution, "");
  EXPECT_EQ(scene(wall + disk + wall).caution, "BODIES.DAT: 1 read, left out: 2 JONCx");
  const auto refused = [&](const std::string& text, const char* why) {
    EXPECT_TRUE(says(refusal_of<SceneFileError>([&] { scene(text); }), why));
  };
  refused("! none\n", "has no disk");
  refused(wall, "has no disk, left out: 1 JONCx");
}

// The spin of a sphere is that along the axes a, b, c of the body: here a = z, b = x, c = y.
TEST_F(Lmgc90Bodies, ASphereTurnsInItsOwnFrame) {
  put_file(
      folder / "BODIES.DAT",
      "$bdyty\n RBDY3      1\n$nodty\n NO6xx      1  coo1= 0.1D+01  coo2= 0.2D+01  coo3= "
      "0.3D+01\n coo4= 0.0D+00  coo5= 0.0D+00  coo6= 0.0D+00\n$tacty\n SPHER      1  color  BLEUx "
      " byrd= 0.5D+00\n$$$$$$\n");
  put_file(
      folder / "DOF.INI",
      "$bdyty\n RBDY3      1\n$nodty\n NO6xx      1  X(1)= 0.0D+00  X(2)= 0.0D+00  X(3)= "
      "0.0D+00\n X(4)= 0.0D+00  X(5)= 0.0D+00  X(6)= 0.0D+00\n V(1)= 0.1D+01  V(2)= 0.0D+00  V(3)= "
      "0.0D+00\n V(4)= 0.1D+01  V(5)= 0.2D+01  V(6)= 0.3D+01\n a(1)= 0.0D+00  a(2)= 0.0D+00  a(3)= "
      "0.1D+01\n b(1)= 0.1D+01  b(2)= 0.0D+00  b(3)= 0.0D+00\n c(1)= 0.0D+00  c(2)= 0.1D+01  c(3)= "
      "0.0D+00\n$$$$$$\n");
  const auto rows = read_lmgc90_bodies(folder / "BODIES.DAT", 3);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].x, Vec3(1, 2, 3));
  EXPECT_EQ(rows[0].v, Vec3(1, 0, 0));
  EXPECT_EQ(rows[0].spin, Vec3(2, 3, 1));
}

// A body at rest may have velocities of 1e-100 and less.
TEST_F(Lmgc90Bodies, NumbersAreThoseOfFortran) {
  const auto x_of = [&](const std::string& x) {
    put_file(folder / "BODIES.DAT", disk_record(x, kDiskLine));
    return read_lmgc90_bodies(folder / "BODIES.DAT", 2).at(0).x[0];
  };
  EXPECT_EQ(x_of("0.1500000-100"), 0.15e-100);
  EXPECT_EQ(x_of("-0.1500000-309"), -0.15e-309);
  EXPECT_EQ(x_of("0.1500000+100"), 0.15e100);
  EXPECT_EQ(x_of("0.1500000-400"), 0);
  EXPECT_EQ(x_of("0.15d-01"), 0.015);
  EXPECT_EQ(x_of("0.15E-01"), 0.015);
  EXPECT_EQ(x_of("+0.15D+02"), 15);
}

/// A record of DRV_DOF.DAT: one line of each degree, its numbers after the degree.
std::string driven_record(const std::string& body, const std::vector<std::string>& of) {
  std::string text = "$bdyty\n " + body + "\n$nodty\n NO3xx      1\n$dofty  numbr [CT......+...]\n";
  for (std::size_t k = 0; k < of.size(); ++k) {
    text += " vlocy      " + std::to_string(k + 1) + "  " + of[k] + "\n";
  }
  return text + "$$$$$$\n";
}
std::string constant(const std::string& value) {
  return value + "  0.0D+00  0.0D+00  0.0D+00  0.1D+01  0.0D+00";
}

// The lower disk of 0.5 m rises at 0.5 m/s and carries the upper one, straight above it. The lower
// one is a wall. Turning at 20 rad/s, it drives the upper one by friction.
TEST_F(Lmgc90Bodies, ADrivenDiskIsAWallThatCarriesOthers) {
  const std::string line = " DISKx      1  color  BLEUx  byrd= 0.5D+00\n";
  const auto at = [&](const char* y) {
    return "$bdyty\n RBDY2      1\n$nodty\n NO3xx      1                coo1= 0.0D+00  coo2= " +
           std::string(y) + "  coo3= 0.0D+00\n$tacty\n" + line + "$$$$$$\n";
  };
  put_file(folder / "BODIES.DAT", at("0.0D+00") + at("0.1D+01"));
  for (const bool turns : {false, true}) {
    put_file(
        folder / "DRV_DOF.DAT",
        "! DRV_DOF\n" + driven_record("RBDY2      1", {constant("0.0D+00"), constant("0.5D+00"),
                                                       constant(turns ? "2.0D+01" : "0.0D+00")}));
    Scene<2> scene = parse_scene(
        "[[disks]]\narrangement = \"file\"\nfile = \"BODIES.DAT\"\ndensity = 100\n"
        "[contact]\nmu = 0.5\n[time]\nstep = 1e-3\nsteps = 20\n",
        (folder / "scene.toml").string());
    ASSERT_EQ(scene.bodies.size(), 1u);
    ASSERT_EQ(scene.walls.size(), 1u);
    EXPECT_EQ(scene.walls[0].v, Vec2(0, 0.5));
    EXPECT_EQ(scene.walls[0].spin, turns ? 20 : 0);
    const State<2> end = solved_run(scene);
    EXPECT_NEAR(end.bodies[0].v[1], 0.5, 1e-2);
    EXPECT_NEAR(end.walls[0].a[1], 0.01, 1e-12);
    // In its first step it moves for half of it.
    EXPECT_NEAR(end.bodies[0].x[1], 1.01 - 0.5e-3 * 0.5, turns ? 3e-5 : 1e-12);
    // Slipping, it turns the other way by 2 mu/a times the impulse over m: 0.5 and g t.
    EXPECT_NEAR(end.bodies[0].spin, turns ? -2 * 0.5 / 0.5 * (0.5 + 9.81 * 0.02) : 0, 0.05);
  }
}

TEST_F(Lmgc90Bodies, ADrivenSphereCarriesOthers) {
  const auto at = [&](const char* z) {
    return "$bdyty\n RBDY3      1\n$nodty\n NO6xx      1  coo1= 0.0D+00  coo2= 0.0D+00  coo3= " +
           std::string(z) + "\n$tacty\n SPHER      1  color  BLEUx  byrd= 0.5D+00\n$$$$$$\n";
  };
  put_file(folder / "BODIES.DAT", at("0.0D+00") + at("0.1D+01"));
  const std::string zero = constant("0.0D+00");
  put_file(folder / "DRV_DOF.DAT",
           driven_record("RBDY3      1", {zero, zero, constant("0.5D+00"), zero, zero, zero}));
  const AnyScene any = parse_any_scene(
      "[[spheres]]\narrangement = \"file\"\nfile = \"BODIES.DAT\"\ndensity = 100\n[contact]\nmu = "
      "0.5\n[time]\nstep = 1e-3\nsteps = 20\n",
      (folder / "scene.toml").string());
  const Scene<3>& scene = std::get<Scene<3>>(any);
  ASSERT_EQ(scene.bodies.size(), 2u);
  const State<3> end = solved_run(scene);
  EXPECT_NEAR(end.bodies[0].x[2], 0.01, 1e-12);
  EXPECT_NEAR(end.bodies[1].x[2], 1.01 - 0.5e-3 * 0.5, 1e-12);
  EXPECT_NEAR(end.bodies[1].v[2], 0.5, 1e-2);
}

// Walls are left out, and so is whatever drives them.
TEST_F(Lmgc90Bodies, WallsMayBeDrivenInAnyWay) {
  put_file(folder / "BODIES.DAT",
           disk_record("0.1D+00", kDiskLine) + disk_record("0.0D+00", kWallLine));
  put_file(folder / "DRV_DOF.DAT",
           driven_record("RBDY2      2", {"1 0.1 6.28 0 1 0", "evolution vy.dat"}));
  const std::vector<PositionRow> rows = read_lmgc90_bodies(folder / "BODIES.DAT", 2);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_FALSE(rows[0].driven);
}

TEST_F(Lmgc90Bodies, WhatItCannotTakeIsRefusedWithTheLine) {
  const auto refused = [&](const std::string& text, int dim) {
    put_file(folder / "BODIES.DAT", text);
    return refusal_of<SceneFileError>([&] { read_lmgc90_bodies(folder / "BODIES.DAT", dim); });
  };
  const std::string disk = disk_record("0.1D+00", kDiskLine);
  EXPECT_TRUE(says(refused(disk, 3), ":2: expected RBDY3, got RBDY2"));
  EXPECT_TRUE(says(refused(disk_record("0.1D+00", kDiskLine + kWallLine), 2),
                   ":10: body 1 has 2 contactors: give it as a table of [[clusters]]"));
  EXPECT_TRUE(says(refused(disk_record("0.1-", kDiskLine), 2), "is no finite number"));
  EXPECT_TRUE(says(refused(disk_record("0.1D+400", kDiskLine), 2), "is no finite number"));
  EXPECT_TRUE(says(refused(disk_record("0.1X+00", kDiskLine), 2), "is no finite number"));
  EXPECT_TRUE(says(refused(disk.substr(0, disk.size() - 7), 2), "the last body has no end"));
  const auto driven = [&](const std::vector<std::string>& of) {
    put_file(folder / "DRV_DOF.DAT", driven_record("RBDY2      1", of));
    return refused(disk, 2);
  };
  const std::string zero = constant("0.0D+00");
  EXPECT_TRUE(says(driven({zero, zero}), "body 1: 2 degrees of freedom are driven, of 3"));
  EXPECT_TRUE(says(driven({zero, zero, "1 1 6.28 0 1 0"}), "only constant values are possible"));
  EXPECT_TRUE(says(driven({zero, zero, "1 0"}), "a degree of freedom and six numbers"));
  EXPECT_TRUE(says(driven({zero, zero, "evolution my.dat"}), "'evolution' is no finite number"));
  const std::string held = driven_record("RBDY2      1", {zero, zero, zero});
  put_file(folder / "DRV_DOF.DAT", held + held);
  EXPECT_TRUE(says(refused(disk, 2), "body 1 stands there twice"));
}

}  // namespace
}  // namespace bipot
