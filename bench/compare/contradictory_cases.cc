#include <cmath>

#include "bench/compare/case_parts.h"
#include "core/scene/scene_family.h"

namespace bipot {
namespace {

using Expect = ExtremeCase::Expect;

Scene<2> row_between_walls() {
  Scene<2> scene = empty_scene(0.3);
  scene.gravity.setZero();
  scene.bodies = touching_rows(5, 1);
  scene.walls = {half_space<2>(Vec2::Zero(), Vec2(1, 0), "left"),
                 half_space<2>(Vec2(5, 0), Vec2(-1, 0), "right")};
  return scene;
}

void move_in(Wall<2>& wall, double speed) { move_at(wall, speed * wall.normal); }

}  // namespace

void add_contradictory_cases(std::vector<ExtremeCase>& cases) {
  Scene<2> forced = row_between_walls();
  for (Wall<2>& wall : forced.walls) drive(wall, wall.normal, 2, 300);
  cases.push_back({.name = "walls_forced_together",
                   .what = "a row of 5 disks between two walls that press with 300 N each",
                   .known = "equal and opposite: rest, and each of the 6 contacts carries h F",
                   .problem = step_of(forced),
                   .true_error = [forced](const Vector& s, const Vector&) {
                     double worst = 0;
                     for (Eigen::Index row = 0; row < s.size(); row += 2) {
                       worst = std::max(worst, std::abs(s[row] / (300 * forced.step) - 1));
                     }
                     return worst;
                   }});
  Scene<2> moved = row_between_walls();
  move_in(moved.walls[1], 0.1);
  cases.push_back(
      {.name = "wall_into_row",
       .what = "a row of 5 disks between a fixed wall and one that moves in at 0.1 m/s",
       .known = "equal normal impulses are a self-stress that works against the wall: none",
       .expect = Expect::kNone,
       .problem = step_of(moved)});
  Scene<2> lattice = make_family_scene("square", 6);
  move_in(lattice.walls[2], 1e-6);
  cases.push_back(
      {.name = "wall_into_lattice",
       .what = "a square lattice of 36 disks in a box, one wall moves in at 1e-6 m/s, gravity acts",
       .known = "each row is such a self-stress: none, however slow the wall",
       .expect = Expect::kNone,
       .problem = step_of(lattice)});
  Scene<2> out = make_family_scene("square", 6);
  move_in(out.walls[2], -1);
  cases.push_back({.name = "wall_out_of_lattice",
                   .what = "the same wall moves out at 1 m/s",
                   .known = "the motion that follows the wall leaves every contact: one exists",
                   .problem = step_of(out)});
  Scene<2> wedge = empty_scene(0.3);
  wedge.bodies = {round_body<2>(Vec2(0, 3), 0.5, 1)};
  add_wedge(wedge, 0.2);
  for (Wall<2>& wall : wedge.walls) move_in(wall, 0.1);
  cases.push_back(
      {.name = "wedge_closes",
       .what = "a disk in a wedge of 23 degrees with mu = 0.3 whose walls close at 0.1 m/s",
       .known = "friction jams it (mu > tan 11.5°): impulses of slipping outwards point into the "
                "wedge; no case of its two contacts is possible: none",
       .expect = Expect::kNone,
       .problem = step_of(wedge)});
  cases.push_back({.name = "data_of_no_motion",
                   .what = "W alone of one mass between two walls, w = (-1, -2)",
                   .known = "u_1 + u_2 = -3 whatever s: none",
                   .expect = Expect::kNone,
                   .problem = [] {
                     ContactProblem p{.dim = 1};
                     p.W.resize(2, 2);
                     p.W.insert(0, 0) = 1;
                     p.W.insert(0, 1) = -1;
                     p.W.insert(1, 0) = -1;
                     p.W.insert(1, 1) = 1;
                     p.W.makeCompressed();
                     p.mu = Vector::Zero(2);
                     p.u_free = -Vector::LinSpaced(2, 1, 2);
                     return p;
                   }});
}

}  // namespace bipot
