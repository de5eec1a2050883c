// One body on a floor, compared with rigid-body mechanics.
//
// With inertia c m a² (disk c = 1/2, sphere 2/5) on a slope of angle θ, friction f up the slope:
//   m dv/dt = m g sin θ - f,   c m a dw/dt = f;   rolling, v = a w:  dv/dt = g sin θ / (1 + c),
// f = m g sin θ c/(1 + c) <= mu m g cos θ iff tan θ <= mu (1 + c)/c. Thrown without spin on a flat
// floor, friction conserves m v + c m a w: rolling at v0/(1 + c). The scheme's velocities are exact
// for constant forces, and so are its positions. Only the step in which sliding ends is rounded.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/experiments/experiment_scene.h"
#include "bench/experiments/validation_row.h"

namespace bipot {
namespace {

constexpr double kSlope = 20 * std::numbers::pi / 180;
constexpr double kHuge = 1e9;  // inertia of a block over m a²: it does not turn
const std::string kMechanics = "rigid-body mechanics, derived in slope_experiments.cc";
const ValidationRow::Margin kExactScheme = {
    1e-6, "the scheme is exact here; a hundred times the tightest tolerance", kOneRun};

/// A body of radius 1 m and 1 kg that touches the floor; gravity is tilted by `slope` towards +x.
template <int D>
Scene<D> on_floor(double slope, double mu, double step, const Experiment::Trial& trial) {
  Scene<D> scene = experiment_scene<D>({.mu = mu}, step, trial);
  scene.gravity =
      kGravity * (std::sin(slope) * Vec<D>::Unit(0) - std::cos(slope) * Vec<D>::Unit(D - 1));
  scene.bodies = {round_body<D>(Vec<D>::Unit(D - 1), 1, 1)};
  scene.walls = {flat_floor<D>()};
  return scene;
}

/// Velocity of the point of contact along x: clockwise rotation rolls forwards; in 3D about +y.
double slip(const Disk& d) { return d.v[0] + d.radius * d.spin; }
double slip(const Sphere& s) { return s.v[0] - s.radius * s.spin[1]; }

template <int D>
void rolling(Experiment& e) {
  const double c = kInertia<D>;
  e.rows = {ValidationRow(
                fmt::format("{}_rolls", kBodyName<D>),
                fmt::format("acceleration of a {} that rolls down 20°, over g sin θ", kBodyName<D>),
                kMechanics, D == 2 ? "1/(1 + 1/2) = 2/3" : "1/(1 + 2/5) = 5/7",
                Expectation::equal(1 / (1 + c)), kExactScheme),
            ValidationRow(fmt::format("{}_slips", kBodyName<D>),
                          fmt::format("the same with μ = 0.05, sliding, over g (sin θ − μ cos θ)",
                                      kBodyName<D>),
                          kMechanics, "1", Expectation::equal(1), kExactScheme)};
  e.run = [](Experiment::Trial& trial) {
    for (const double mu : {0.5, 0.05}) {
      Scene<D> scene = on_floor<D>(kSlope, mu, 0.01, trial);
      scene.num_steps = 50;
      const auto end = run_from_start<D>(scene, trial);
      const double free = mu == 0.5 ? std::sin(kSlope) : std::sin(kSlope) - mu * std::cos(kSlope);
      trial.seen.push_back({end.bodies[0].v[0] / (kGravity * free * end.time)});
    }
  };
}

/// The least mu at which a body on the slope does not slide. Below it the contact slides away with
/// g sin θ (1 - mu/mu_c). The criterion "slides by more than 1e-3 of free fall" puts it at (1 -
/// 1e-3) mu_c.
template <int D, bool kBlock>
void threshold(Experiment& e) {
  const double c = kInertia<D>;
  const double critical = std::tan(kSlope) * (kBlock ? 1 : c / (1 + c));
  const std::string name = kBlock ? "block" : kBodyName<D>;
  e.rows = {ValidationRow(
      name + "_threshold",
      kBlock ? "least μ at which a block (a disk that cannot turn) stays on a slope of 20°"
             : fmt::format("least μ at which a {} rolls down 20° without sliding", name),
      kMechanics,
      kBlock ? "tan θ = 0.3640" : (D == 2 ? "tan θ / 3 = 0.1213" : "2/7 tan θ = 0.1040"),
      Expectation::equal(critical),
      {2e-3, "sliding is told from rolling at 1e-3 of free fall; bisection 1e-4",
       "discretisation: bisection to 1e-4"})};
  e.run = [critical](Experiment::Trial& trial) {
    Observation found = find_threshold(0.5 * critical, 1.5 * critical, [&](double mu) {
      Scene<D> scene = on_floor<D>(kSlope, mu, 0.01, trial);
      if (kBlock) scene.bodies[0].inertia = kHuge;
      scene.num_steps = 10;
      const auto end = run_from_start<D>(scene, trial);
      return std::abs(slip(end.bodies[0])) <= 1e-3 * kGravity * std::sin(kSlope) * end.time;
    });
    trial.seen = {found};
  };
}

template <int D>
void thrown(Experiment& e) {
  const double c = kInertia<D>;
  e.rows = {ValidationRow(
      fmt::format("{}_thrown", kBodyName<D>),
      fmt::format("speed at which a {} thrown without spin ends rolling, over v0", kBodyName<D>),
      kMechanics, D == 2 ? "2/3" : "5/7", Expectation::equal(1 / (1 + c)), kExactScheme)};
  e.run = [](Experiment::Trial& trial) {
    Scene<D> scene = on_floor<D>(0, 0.3, 0.01, trial);
    scene.bodies[0].v[0] = 1;
    scene.num_steps = 60;  // rolls from v0 / (mu g (1 + 1/c)) < 0.12 s on
    const auto end = run_from_start<D>(scene, trial);
    trial.seen = {{end.bodies[0].v[0]}};
  };
}

/// Thrown at v0 with the back spin w0: friction μ m g takes both. m v + c m a w is conserved, so that
/// it rolls at (v0 - c a w0)/(1 + c), back if a w0 > v0/c. It turns round at v0²/(2 μ g), which a
/// time step misses by μ g h²/8 at most.
template <int D>
void back_spin(Experiment& e) {
  constexpr double kBackMu = 0.3, kBackSpin = 4, kStep = 2e-3;
  const double c = kInertia<D>;
  const std::string name = kBodyName<D>;
  e.rows = {
      ValidationRow(name + "_back_spin",
                    fmt::format("speed of a {} thrown at v0 with the back spin a ω = 4 v0, once "
                                "it rolls, over v0",
                                name),
                    kMechanics, D == 2 ? "(2 − 4)/3" : "(5 − 2 × 4)/7",
                    Expectation::equal((1 - c * kBackSpin) / (1 + c)), kExactScheme),
      ValidationRow(name + "_turns_round", "its farthest place [m]", kMechanics, "v0²/(2 μ g)",
                    Expectation::equal(1 / (2 * kBackMu * kGravity)),
                    {1e-4, "time step: (μ g h/2 v0)²", kOneRun}),
      ValidationRow(name + "_comes_back",
                    fmt::format("least back spin a ω over v0 at which a {} comes back", name),
                    kMechanics, D == 2 ? "2" : "5/2", Expectation::equal(1 / c),
                    {1e-3, "bisection 1e-4", kOneRun})};
  e.run = [](Experiment::Trial& trial) {
    double farthest = 0;
    const auto rolls_at = [&](double spin) {
      Scene<D> scene = on_floor<D>(0, kBackMu, kStep, trial);
      scene.bodies[0].v[0] = 1;
      if constexpr (D == 2) {
        scene.bodies[0].spin = spin;
      } else {
        scene.bodies[0].spin[1] = -spin;
      }
      farthest = 0;
      // It rolls from (v0 + a w0)/(μ g (1 + 1/c)) on, at most 0.57 s.
      scene.num_steps = 300;
      const auto end = run_from_start<D>(scene, trial, [&](const SceneStep<D>& step) {
        farthest = std::max(farthest, step.state.bodies[0].x[0]);
        return true;
      });
      return end.bodies[0].v[0];
    };
    const double speed = rolls_at(kBackSpin), place = farthest;
    trial.seen = {{speed}, {place}, find_threshold(1.5, 3.5, [&](double spin) {
                    return rolls_at(spin) < 0;
                  })};
  };
}

void belt(Experiment& e) {
  e.rows = {ValidationRow("disk_on_belt",
                          "speed of a disk put down on a belt, once it rolls, over the belt's",
                          kMechanics, "1/3: thrown at −V seen from the belt, where it keeps 2/3",
                          Expectation::equal(1.0 / 3), kExactScheme)};
  e.run = [](Experiment::Trial& trial) {
    Scene<2> scene = on_floor<2>(0, 0.3, 0.01, trial);
    move_at(scene.walls[0], Vec2(1, 0));
    scene.num_steps = 60;
    const auto end = run_from_start<2>(scene, trial);
    trial.seen = {{end.bodies[0].v[0]}};
  };
}

void braking(Experiment& e) {
  constexpr double kBrakeMu = 0.3, kSpeed = 3, kStep = 0.01;
  constexpr double kBrake = kBrakeMu * kGravity;
  // In the step that stops it the speed falls from v <= a h to 0 in h, not in v/a: the distance v
  // h/2 instead of v²/2a, at most a h²/8 more.
  const double allowed = std::pow(kBrake * kStep / kSpeed, 2) / 4 + 1e-6;
  e.rows = {ValidationRow(
      "block_stops", "way of a block thrown at 3 m/s on μ = 0.3 until it stands [m]", kMechanics,
      "v0²/(2 μ g) = 1.529 m", Expectation::equal(kSpeed * kSpeed / (2 * kBrake)),
      {allowed, "the step that stops it: (μ g h/v0)²/4", kOneRun})};
  e.run = [](Experiment::Trial& trial) {
    Scene<2> scene = on_floor<2>(0, kBrakeMu, kStep, trial);
    scene.bodies[0].inertia = kHuge;
    scene.bodies[0].v[0] = kSpeed;
    scene.num_steps = 130;
    const auto end = run_from_start<2>(scene, trial);
    trial.seen = {{end.bodies[0].x[0]}};
  };
}

}  // namespace

std::vector<Experiment> slope_experiments() {
  return made_by({&rolling<2>, &threshold<2, false>, &rolling<3>, &threshold<3, false>, &thrown<2>,
                  &thrown<3>, &belt, &threshold<2, true>, &braking, &back_spin<2>, &back_spin<3>});
}

}  // namespace bipot
