// Starts of scenes that cannot be, by the word of a scene file: bodies in each other, in walls,
// behind them, and where they would leave at once.

#include "core/scene/start_check.h"

#include "core/scene/scene_parts.h"
#include "core/scene_files/scene_file.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

const std::string kTime = "time = { step = 1e-3, steps = 1 }\n";

Scene<2> flat(const std::string& text) { return parse_scene(kTime + text, "test.toml"); }

Scene<3> in_space(const std::string& text) {
  return std::get<Scene<3>>(parse_any_scene(kTime + text, "test.toml"));
}

template <int D>
std::string said(const Scene<D>& scene) {
  return start_sentence(scene, start_overlaps(scene));
}

std::string disk(const std::string& x, const std::string& y) {
  return "[[disks]]\nposition = [" + x + ", " + y + "]\nradius = 0.004\nmass = 1\n";
}

TEST(StartCheck, AWallThatCutsThroughThePackingNamesItsRows) {
  // Rows at heights 4, 12, … 76 mm; the wall at 50.1 mm. Those from 52 mm on are behind it, the
  // highest by 76 + 4 - 50.1 = 29.9 mm, 7.475 radii; the row at 44 mm is clear by 2.1 mm.
  const Scene<2> scene = flat(
      "[[disks]]\narrangement = 'rectangular'\ncolumns = 5\nrows = 10\nradius = 0.004\nmass = 1\n"
      "[[walls]]\npoint = [0, 0]\nnormal = [0, 1]\n"
      "[[walls]]\nname = 'top'\npoint = [0, 0.0501]\nnormal = [0, -1]\n");
  EXPECT_EQ(said(scene),
            "20 disks overlap at the start, worst disk 45 and wall 'top': 29.9 mm, 7.5 radii");
}

TEST(StartCheck, ADiskFarBehindAHalfPlane) {
  // Its centre lies 0.2 m behind the line: depth 0.204 m, 51 radii.
  const Scene<2> scene = flat(disk("0", "-0.2") + "[[walls]]\npoint = [0, 0]\nnormal = [0, 1]\n");
  EXPECT_EQ(
      said(scene),
      "1 disk overlaps at the start, worst disk 0 and wall 'wall0': 204 mm, 51 radii; all lie "
      "behind wall 'wall0': turn its normal, which points to the bodies");
}

TEST(StartCheck, ADrumFilledBeyondItsRim) {
  // Centres at 0, 90 and 120 mm in a drum of 100: 90 + 4 < 100, 120 + 4 - 100 = 24 mm.
  const Scene<2> scene = flat(disk("0", "0") + disk("0.09", "0") + disk("0", "0.12") +
                              "[[walls]]\nname = 'drum'\ncenter = [0, 0]\nradius = 0.1\n"
                              "hollow = true\n");
  EXPECT_EQ(said(scene),
            "1 disk overlaps at the start, worst disk 2 and wall 'drum': 24 mm, 6 radii");
}

TEST(StartCheck, ASphereOutsideAHollowCylinder) {
  const Scene<3> scene = in_space(
      "[[spheres]]\nposition = [0, 0.3, 0.5]\nradius = 0.1\nmass = 1\n"
      "[[walls]]\nname = 'pipe'\ncenter = [0, 0, 0]\naxis = [0, 0, 1]\nradius = 0.2\nhollow = true\n");
  EXPECT_EQ(said(scene),
            "1 sphere overlaps at the start, worst sphere 0 and wall 'pipe': 200 mm, 2 radii");
}

TEST(StartCheck, APlateACylinderAndADisk) {
  // 1 mm from the plate: 3 mm deep. 5 mm between disks: 3 mm. Within the cylinder of 1 mm by
  // 1 + 4 - 4 = 1 mm, which is its whole radius, the smaller one.
  EXPECT_EQ(
      said(flat(disk("0", "0.001") + "[[walls]]\nname = 'plate'\nfrom = [-1, 0]\nto = [1, 0]\n")),
      "1 disk overlaps at the start, worst disk 0 and wall 'plate': 3 mm, 0.75 radii");
  EXPECT_EQ(said(flat(disk("0", "0") + disk("0.005", "0"))),
            "2 disks overlap at the start, worst disk 0 and disk 1: 3 mm, 0.75 radii");
  EXPECT_EQ(
      said(flat(disk("0", "0.004") + "[[walls]]\nname = 'rod'\ncenter = [0, 0]\nradius = 0.001\n")),
      "1 disk overlaps at the start, worst disk 0 and wall 'rod': 1 mm, 1 radii");
}

TEST(StartCheck, DisksThatMeetAcrossTheBorderOfACell) {
  // 2 mm left of the border and 3 mm right of it: 5 mm between the centres.
  EXPECT_EQ(said(flat(disk("0.003", "0") + disk("0.098", "0") + "[cell]\nwidth = 0.1\n")),
            "2 disks overlap at the start, worst disk 0 and disk 1 across the border of the cell: "
            "3 mm, 0.75 radii");
}

TEST(StartCheck, BodiesInOutletsWouldLeaveAtOnce) {
  // 6 mm below its edge; a disk glued to a wall stays.
  EXPECT_EQ(said(flat(disk("0", "-0.006") +
                      "[[disks]]\nposition = [1, -1]\nradius = 0.004\nwall = 'floor'\n"
                      "[[walls]]\nname = 'floor'\nfrom = [1, -2]\nto = [2, -2]\n"
                      "[[outlets]]\nname = 'hole'\npoint = [0, 0]\nnormal = [0, 1]\n")),
            "1 disk overlaps at the start, worst disk 0 and outlet 'hole': 6 mm, 1.5 radii");
  // A box, 8 mm below its upper edge; in a cell the image 10 mm from both sides of a box beyond it.
  EXPECT_EQ(said(flat(disk("0", "0.002") +
                      "[[outlets]]\nname = 'box'\nlower = [-1, -1]\nupper = [1, 0.01]\n")),
            "1 disk overlaps at the start, worst disk 0 and outlet 'box': 8 mm, 2 radii");
  EXPECT_EQ(said(flat(disk("0.06", "0") + "[cell]\nwidth = 0.1\n"
                                          "[[outlets]]\nname = 'box'\nlower = [0.15, -1]\n"
                                          "upper = [0.17, 1]\n")),
            "1 disk overlaps at the start, worst disk 0 and outlet 'box': 10 mm, 2.5 radii");
  EXPECT_TRUE(start_overlaps(flat(disk("0", "0.003") + "[[outlets]]\nname = 'box'\n"
                                                       "lower = [1, -1]\nupper = [2, 0.01]\n"))
                  .empty());
}

TEST(StartCheck, AWallThatHasPassedABody) {
  // A lid pressed down that starts below the disk which it is to press.
  EXPECT_EQ(said(flat(disk("0", "0.004") + "[[walls]]\npoint = [0, 0]\nnormal = [0, 1]\n"
                                           "[[walls]]\nname = 'lid'\npoint = [0, 0.006]\n"
                                           "normal = [0, -1]\nforce = 1\nmass = 1\n")),
            "1 disk overlaps at the start, worst disk 0 and wall 'lid': 2 mm, 0.5 radii");
}

TEST(StartCheck, TouchingToRoundingAndJoinedBodiesAreNoOverlaps) {
  EXPECT_EQ(said(flat("[[disks]]\narrangement = 'triangular'\ncolumns = 20\nrows = 20\n"
                      "radius = 0.0031\nmass = 1\n[[walls]]\npoint = [0, 0]\nnormal = [0, 1]\n")),
            "");
  EXPECT_EQ(said(flat("[[clusters]]\nparts = [[0, 0, 0.1], [0.1, 0, 0.1]]\nposition = [0, 0.2]\n"
                      "mass = 1\n")),
            "");
  EXPECT_EQ(said(flat("[[walls]]\nname = 'floor'\npoint = [0, 0]\nnormal = [0, 1]\n"
                      "[[disks]]\nposition = [0, 0]\nradius = 0.1\nwall = 'floor'\n"
                      "[[disks]]\nposition = [0.1, 0]\nradius = 0.1\nwall = 'floor'\n")),
            "");
}

TEST(StartCheck, SpringsHoldOverlapsUpToATenth) {
  Scene<2> scene = flat("model = 'dem'\n" + disk("0", "0") + disk("0.0077", "0"));
  EXPECT_EQ(said(scene), "");  // 0.3 mm, 0.075 radii
  scene.bodies[1].x[0] = 0.0075;
  EXPECT_NE(said(scene), "");
  scene.model = Model::kNonsmooth;
  scene.bodies[1].x[0] = 0.0077;
  EXPECT_NE(said(scene), "");
}

TEST(StartCheck, AFloorWhoseNormalPointsAwayIsNamed) {
  Scene<2> scene = one_law<2>({});
  scene.bodies = {round_body<2>(Vec2(0, 1), 0.1, 1), round_body<2>(Vec2(1, 2), 0.1, 1)};
  scene.walls = {half_space<2>(Vec2(0, 0), Vec2(0, -1), "floor")};
  const std::string text = start_sentence(scene, start_overlaps(scene));
  EXPECT_TRUE(says(text, "all lie behind wall 'floor': turn its normal"));
  scene.bodies[1].x[1] = -2;
  EXPECT_FALSE(says(start_sentence(scene, start_overlaps(scene)), "turn"));
}

}  // namespace
}  // namespace bipot
