#include <fmt/format.h>

#include "bench/compare/case_parts.h"

namespace bipot {

void add_unit_cases(std::vector<ExtremeCase>& cases) {
  struct Units {
    const char* name;
    double length, gravity, step;
  };
  for (const Units& u :
       {Units{"units_usual", 0.5, 9.81, 0.01}, Units{"length_1e-6", 1e-6, 9.81, 0.01},
        Units{"length_1e3", 1e3, 9.81, 0.01}, Units{"gravity_1e-6", 0.5, 1e-6, 0.01},
        Units{"gravity_1e6", 0.5, 1e6, 0.01}, Units{"step_1e-9", 0.5, 9.81, 1e-9},
        Units{"step_10", 0.5, 9.81, 10}}) {
    Scene<2> scene = tower({1, 3, 2, 5, 1, 2}, {u.length});
    scene.gravity = Vec2(0, -u.gravity);
    scene.step = u.step;
    scene.contact_distance = 1e-9 * u.length;
    cases.push_back(
        {.name = u.name,
         .what = fmt::format("a tower of 6 disks of radius {:g} m, g = {:g} m/s², h = {:g} s",
                             u.length, u.gravity, u.step),
         .known =
             "the weights above, h g Σ m; the criterion has no units, so that every solver takes "
             "as many iterations as in usual ones, but for rounding",
         .problem = step_of(scene),
         .true_error = against(tower_impulses(scene))});
  }
}

}  // namespace bipot
