// Writes the shipped problems that no scene file gives: three-dimensional ones, single steps of
// scene families, and steps of runs of moving families. Usage: make_problems DIR

#include <fmt/format.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bench/problems/moving_scene.h"
#include "bench/problems/settled_pile.h"
#include "bench/problems/sphere_problems.h"
#include "core/motion/time_stepping.h"
#include "core/problem_files/fclib_file.h"
#include "core/problem_files/problem_geometry.h"
#include "core/scene/scene_family.h"

namespace {

using namespace bipot;

ContactProblem family_step(const char* family, int side, const FamilyOptions& options) {
  const Scene<2> scene = make_family_scene(family, side, options);
  return step_problem(scene, initial_state(scene));
}

ContactProblem pile_step(int count, double mu) {
  const SettledPile pile = settle_pile({.count = count, .mu = mu});
  return step_problem(pile.scene, pile.state);
}

/// Steps of one run of a moving family.
struct MovingEntries {
  const char* family;
  int side;
  FamilyOptions options;
  std::vector<int> steps;
};

/// One file for each step, with the start of the step as a guess, and its geometry.
void write_steps(const std::filesystem::path& folder, const MovingEntries& entries) {
  const FamilyOptions& o = entries.options;
  const Scene<2> scene = make_moving_scene(entries.family, entries.side, o);
  run_moving_scene<2>(scene, entries.steps, [&](const SceneStep<2>& step) {
    const std::string name =
        fmt::format("2d_{}{}_{}", entries.family, entries.side, step.report.step);
    const std::filesystem::path path = folder / (name + ".hdf5");
    write_fclib(
        path, step.problem,
        {.title = name,
         .description = fmt::format(
             "bipot make_problems: scene {} of {} disks, mu = {:g}, e_n = {:g}, gravity "
             "leans {:g} degrees, seed {}; step {} at t = {:g} s, h = {:g} s, of a run by "
             "apgd to {:g} with at most {} iterations a step",
             entries.family, scene.bodies.size(), o.mu, o.e_n, o.tilt_degrees, o.seed,
             step.report.step, step.report.time, scene.step, kMovingTolerance, kMovingIterations)},
        step.start.size() > 0 ? std::vector<Vector>{step.start} : std::vector<Vector>{});
    write_geometry(path, scene, step.state);
    fmt::print("{}\n", path.string());
  });
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
  const MovingEntries moving[] = {
      {"pour", 12, {.mu = 0.5, .e_n = 0.3, .seed = 21}, {170, 250}},
      {"pour", 14, {.mu = 0.3, .seed = 22}, {200, 230}},
      {"collapse", 14, {.mu = 0.4, .seed = 23}, {260}},
      {"tilt", 12, {.mu = 0.3, .tilt_degrees = 30, .seed = 24}, {180, 320}},
      {"strike", 12, {.mu = 0.3, .e_n = 0.1, .seed = 25}, {450, 600}},
  };
  for (const MovingEntries& m : moving) write_steps(argv[1], m);
  return 0;
}
