// Cohesive contacts: a hanging chain, and what the time step does to a contact that is struck.
//
// A plate carries a stuck disk, and another disk strikes the plate away from it; all have the mass
// m. Without a range the contact holds an impulse of c h. Plate, disks and speeds V, v of both after
// the step: striker and plate at v, disk at v as well if it holds, with the impulse s = m v:
//   m V = 3 m v,  s = m V/3 <= c h,  V <= 3 c h/m,
// in proportion to the step (Abramian and Staron, Time steps v.s. cohesion in non-smooth contact
// dynamics algorithm, hal-02570097, 2020, for other rows of bodies). Over a range r the striker and
// the plate leave at V/2, and the disk follows if ½ (2 m/3)(V/2)² <= c r, V <= √(12 c r/m). The
// impulse c h of the first step is left out: 1.5 c h of √(12 c r m), 1.5 % for the longer step.

#include <cmath>

#include "bench/experiments/experiment_scene.h"
#include "bench/experiments/validation_row.h"

namespace bipot {
namespace {

/// Smallest cohesion that holds 5 disks under a ceiling, over the weight of one.
void hanging(Experiment& e) {
  e.rows = {ValidationRow("chain_hangs",
                          "smallest cohesion that holds a chain of 5 disks, over m g",
                          "statics: the top contact carries all", "5", Expectation::equal(5),
                          {2e-3, "bisection", kOneRun})};
  e.run = [](Experiment::Trial& trial) {
    trial.seen = {find_threshold(4, 6, [&](double cohesion) {
      Scene<2> scene =
          experiment_scene<2>({.mu = 0.3, .cohesion = cohesion * kGravity}, 0.01, trial);
      scene.gravity = Vec2(0, -kGravity);
      scene.walls = {half_space<2>(Vec2::Zero(), Vec2(0, -1))};
      for (int k = 0; k < 5; ++k) scene.bodies.push_back(round_body<2>(Vec2(0, -0.5 - k), 0.5, 1));
      scene.num_steps = 100;
      return run_from_start<2>(scene, trial).bodies[0].v.norm() < 0.1;
    })};
  };
}

/// Whether the stuck disk follows the plate, struck with this speed.
bool follows(double speed, double step, double range, Experiment::Trial& trial) {
  Scene<2> scene = experiment_scene<2>({.cohesion = 1}, step, trial);
  scene.contact_distance = 1e-9;
  scene.cohesion_range = range;
  scene.materials = {"sticky", "smooth"};
  scene.laws = {scene.laws[0], {}, {}, {}};
  Wall<2> plate{.name = "plate", .shape = Wall<2>::Shape::kSegment};
  drive(plate, Vec2(0, -1), 1);
  plate.a = Vec2(-3, 0);
  plate.b = Vec2(3, 0);
  scene.walls = {plate};
  scene.bodies = {round_body<2>(Vec2(-2, 0.5), 0.5, 1),
                  round_body<2>(Vec2(2, 0.5), 0.5, 1, Vec2(0, -speed))};
  scene.bodies[1].material = 1;
  const double back = range > 0 ? 4 * speed / 3 : 0;  // twice the time to come back
  scene.num_steps = 5 + static_cast<int>(back / step);
  const State<2> end = run_from_start<2>(scene, trial);
  return end.bodies[0].x[1] - 0.5 - end.walls[0].a[1] < std::max(range, 0.1 * speed * step);
}

void struck(Experiment& e) {
  constexpr double kStep = 1e-3, kRange = 1e-3;
  const std::string source =
      "momentum and energy, derived in cohesion_experiments.cc; Abramian and Staron 2020";
  e.rows = {
      ValidationRow("struck_grows_with_step",
                    "speed of a blow that opens a contact without range: at h over that at h/2",
                    source, "3 c h/m: 2", Expectation::equal(2), {5e-3, "bisection", kOneRun}),
      ValidationRow(
          "struck_with_range", "the same with cohesion_range = 1 mm", source, "√(12 c r/m): 1",
          Expectation::equal(1),
          {3e-2, "the first step's impulse, 1.5 % at h, and the step in which it turns back",
           kOneRun})};
  e.tols = e.quick_tols = decades(1, 8);
  e.run = [](Experiment::Trial& trial) {
    for (const double range : {0.0, kRange}) {
      double opens[2];
      for (int k = 0; k < 2; ++k) {
        const double step = kStep / (1 << k);
        const double expected = range > 0 ? std::sqrt(12 * range) : 3 * step;
        opens[k] = expected * find_threshold(0.5, 1.5, [&](double x) {
                                return !follows(x * expected, step, range, trial);
                              }).value;
      }
      trial.seen.push_back({opens[0] / opens[1]});
    }
  };
}

}  // namespace

std::vector<Experiment> cohesion_experiments() { return made_by({&hanging, &struck}); }

}  // namespace bipot
