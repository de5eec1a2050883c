// A ball that bounces and a disk that swings in a hollow circle.

#include <cmath>

#include "bench/experiments/experiment_scene.h"
#include "bench/experiments/validation_row.h"

namespace bipot {
namespace {

/// Falls from 1 m above the floor, e_n = 0.6. In the step that detects the floor the ball is within
/// v h of it. The heights before and after are then those of a floor as much higher or lower: H1/H0
/// = e² (1 ± v h/H0 (1 + 1/e²)), its root half of that.
void bouncing(Experiment& e) {
  constexpr double kRestitution = 0.6, kStep = 1e-4;
  const double speed = std::sqrt(2 * kGravity);
  e.rows = {ValidationRow(
      "ball_bounces", "root of the ratio of heights of a ball before and after a bounce",
      "Newton's restitution, energy in free flight", "e_n = 0.6", Expectation::equal(kRestitution),
      {0.5 * speed * kStep * (1 + 1 / (kRestitution * kRestitution)),
       "the place of the impact is known to v h", kOneRun})};
  e.run = [](Experiment::Trial& trial) {
    Scene<2> scene = experiment_scene<2>({.mu = 0.3, .e_n = kRestitution}, kStep, trial);
    scene.gravity = Vec2(0, -kGravity);
    scene.bodies = {round_body<2>(Vec2(0, 2), 1, 1)};
    scene.walls = {flat_floor<2>()};
    scene.num_steps = 8000;
    bool bounced = false;
    double height = 0;
    run_from_start<2>(scene, trial, [&](const SceneStep<2>& step) {
      const Disk& d = step.state.bodies[0];
      bounced = bounced || d.v[1] > 0;
      if (bounced) height = std::max(height, d.x[1] - d.radius);
      return !bounced || d.v[1] > 0;
    });
    trial.seen = {{std::sqrt(height)}};
  };
}

/// A disk of radius a rolls without sliding in a hollow circle of radius R. With the angle φ of its
/// position, kinetic energy is 3/4 m ((R - a) φ')², potential m g (R - a)(1 - cos φ). It is a
/// pendulum of length 3/2 (R - a), whose period from rest at φ0 is 4 √(l/g) K(sin φ0/2). The normal
/// turns by φ' h in a step, whose shock dissipates the share (φ' h)² of the energy: φ'² <= φ0² g/l.
/// Over a period that is at most 2π h φ0² √(g/l) = 5e-3 of the energy, which changes the period by
/// φ0²/16 of that.
void swinging(Experiment& e) {
  constexpr double kDrum = 1, kRadius = 0.2, kStart = 0.5, kStep = 1e-3;
  constexpr double kLength = 1.5 * (kDrum - kRadius);
  e.rows = {ValidationRow(
      "disk_swings", "period of a disk that rolls to and fro in a hollow circle, from 0.5 rad [s]",
      "energy of rolling, a pendulum of length 3/2 (R − a); complete elliptic integral",
      "4 √(3 (R − a)/2g) K(sin φ0/2)",
      Expectation::equal(4 * std::sqrt(kLength / kGravity) *
                         std::comp_ellint_1(std::sin(kStart / 2))),
      {1e-3, "time step: h/T = 5e-4, and shocks as the normal turns", kOneRun})};
  e.quick_tols = {1, 1e-1, 1e-2, 1e-4, 1e-7};
  e.run = [](Experiment::Trial& trial) {
    Scene<2> scene = experiment_scene<2>({.mu = 1}, kStep, trial);
    scene.gravity = Vec2(0, -kGravity);
    const double way = kDrum - kRadius;
    scene.bodies = {round_body<2>(way * Vec2(std::sin(kStart), -std::cos(kStart)), kRadius, 1)};
    Wall<2> drum{.name = "circle", .shape = Wall<2>::Shape::kHollowCircle, .radius = kDrum};
    scene.walls = {drum};
    scene.num_steps = 5000;
    std::vector<double> crossings;  // upwards in x
    double before = kStart, time = 0;
    run_from_start<2>(scene, trial, [&](const SceneStep<2>& step) {
      const Vec2& x = step.state.bodies[0].x;
      const double angle = std::atan2(x[0], -x[1]);
      if (before < 0 && angle >= 0) crossings.push_back(time + kStep * before / (before - angle));
      before = angle;
      time = step.state.time;
      return crossings.size() < 2;
    });
    const bool swings = crossings.size() == 2;
    trial.seen = {{swings ? crossings[1] - crossings[0] : kNaN, 0,
                   swings ? "" : "it does not swing through twice within 5 s"}};
  };
}

}  // namespace

std::vector<Experiment> impact_experiments() { return made_by({&bouncing, &swinging}); }

}  // namespace bipot
