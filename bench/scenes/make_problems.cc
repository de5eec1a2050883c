// Writes the shipped problems that no scene can dump: three-dimensional ones, and single steps of
// scene families. Usage: make_problems DIR

#include <fmt/format.h>

#include <filesystem>
#include <functional>

#include "bench/scenes/settled_pile.h"
#include "bench/scenes/sphere_problems.h"
#include "core/files/fclib_file.h"
#include "core/motion/time_stepping.h"
#include "core/scene/scene_family.h"

namespace {

using namespace bipot;

ContactProblem family_step(const char* family, int side, const FamilyOptions& options) {
  const Scene scene = make_family_scene(family, side, options);
  return step_problem(scene, initial_state(scene), false);
}

ContactProblem pile_step(int count, double mu) {
  const SettledPile pile = settle_pile({.count = count, .mu = mu});
  return step_problem(pile.scene, pile.state, false);
}

struct Entry {
  const char* name;
  const char* description;
  std::function<ContactProblem()> make;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: make_problems DIR\n");
    return 2;
  }
  const Entry entries[] = {
      {"3d_sphere_pyramid_2", "5 spheres: 4 below, 1 above, mu = 0.5, from rest",
       [] { return sphere_pyramid(2, 0.5, 0); }},
      {"3d_sphere_pyramid_4", "30 spheres in 4 square layers, mu = 0.5, gravity leans 5 degrees",
       [] { return sphere_pyramid(4, 0.5, 5); }},
      {"3d_sphere_box_4", "64 spheres, cubic lattice in a box, mu = 0.3, gravity leans 10 degrees",
       [] { return sphere_box(4, 0.3, 10); }},
      {"2d_triangular_20_tilt10",
       "triangular lattice of 20 rows, mu = 0.3, gravity leans 10 degrees",
       [] { return family_step("triangular", 20, {.mu = 0.3, .tilt_degrees = 10}); }},
      {"2d_triangular_12_mass1e6",
       "triangular lattice, masses log-uniform over 6 decades, mu = 0.3",
       [] { return family_step("triangular", 12, {.mu = 0.3, .mass_ratio = 1e6}); }},
      {"2d_pyramid_20_mu05", "free pyramid of 20 rows, mu = 0.5",
       [] { return family_step("pyramid", 20, {.mu = 0.5}); }},
      {"2d_pile_300_mu03", "random pile of 300 disks at rest, mu = 0.3",
       [] { return pile_step(300, 0.3); }},
      {"1d_square_20", "square lattice of 20 x 20, frictionless",
       [] { return family_step("square", 20, {.mu = 0}); }},
  };
  std::filesystem::create_directories(argv[1]);
  for (const Entry& e : entries) {
    const auto path = std::filesystem::path(argv[1]) / (std::string(e.name) + ".hdf5");
    write_fclib(
        path, e.make(),
        {.title = e.name,
         .description = fmt::format("bipot make_problems: {}; radius 0.5 m, mass 1 kg, 9.81 "
                                    "m/s2, h = 0.01 s, e = 0",
                                    e.description)});
    fmt::print("{}\n", path.string());
  }
  return 0;
}
