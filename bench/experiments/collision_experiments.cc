// Collisions of round bodies without gravity: one body with a wall, two bodies, rows and racks.
//
// Inertia c m a² (disk c = 1/2, sphere 2/5), k = 1 + 1/c. A contact of a body with a wall has
// W_nn = 1/m, W_tt = k/m, W_nt = 0; of two bodies 1/m* = 1/m_1 + 1/m_2 in place of 1/m. Hence
//   u_n⁺ = -e_n u_n⁻,   it sticks: u_t⁺ = -e_t u_t⁻,   it slips: u_t⁺ = u_t⁻ - k μ (1 + e_n) |u_n⁻|.
// It sticks up to the incidence u_t⁻/|u_n⁻| = k μ (1 + e_n)/(1 + e_t). That is the model of three
// coefficients of Walton (in Particulate Two-Phase Flow, 1993) and of Foerster, Louge, Chang and
// Allia (Phys. Fluids 6, 1994, 1108): their β_0 is e_t, and k is 7/2 for spheres.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/experiments/experiment_scene.h"
#include "bench/experiments/validation_row.h"
#include "core/motion/state.h"

namespace bipot {
namespace {

constexpr double kObliqueMu = 0.2, kObliqueNormal = 0.8, kObliqueTangential = 0.4;
constexpr double kImpactStep = 1e-3;
const std::string kThreeCoefficients =
    "model of three coefficients, Walton 1993, Foerster et al. 1994";
const std::string kMomenta = "momentum and angular momentum, derived in collision_experiments.cc";
const ValidationRow::Margin kImpact = {
    1e-6, "an impact is exact; a hundred times the tightest tolerance", kOneRun};

template <int D>
constexpr double kTangentialShare = 1 + 1 / kInertia<D>;  // k

/// The state after the step in whose middle the bodies are where the scene has them.
template <int D>
State<D> after_impact(Scene<D> scene, Experiment::Trial& trial) {
  for (Body<D>& b : scene.bodies) b.x -= 0.5 * scene.step * b.v;
  scene.num_steps = 1;
  return run_from_start<D>(scene, trial);
}

/// Direction along the floor in which bodies fly.
template <int D>
Vec<D> along_floor() {
  if constexpr (D == 2) {
    return Vec2(1, 0);
  } else {
    return Vec3(0.6, 0.8, 0);
  }
}

/// Velocity of the lowest point of the body along the floor.
double speed_below(const Disk& d) { return d.v[0] + d.radius * d.spin; }
double speed_below(const Sphere& s) {
  return (s.v - s.radius * s.spin.cross(Vec3::UnitZ())).dot(along_floor<3>());
}

/// A body of radius 1 after an impact on the floor at the normal speed 1.
template <int D>
Body<D> after_oblique_impact(double incidence, Experiment::Trial& trial) {
  Scene<D> scene = experiment_scene<D>(
      {.mu = kObliqueMu, .e_n = kObliqueNormal, .e_t = kObliqueTangential}, kImpactStep, trial);
  scene.bodies = {round_body<D>(Vec<D>::Unit(D - 1), 1, 1)};
  scene.bodies[0].v = incidence * along_floor<D>() - Vec<D>::Unit(D - 1);
  scene.walls = {flat_floor<D>()};
  return after_impact<D>(scene, trial).bodies[0];
}

/// Sliding takes μ (1 + e_n)/c of the spin a ω over the normal speed.
template <int D>
void oblique(Experiment& e) {
  constexpr double kSlips = 2, kSticks = 0.5, k = kTangentialShare<D>;
  constexpr double kLoss = kObliqueMu * (1 + kObliqueNormal);
  const std::string body = kBodyName<D>, factor = D == 2 ? "3" : "7/2";
  e.rows = {
      ValidationRow(body + "_oblique_slips",
                    fmt::format("speed of the point of contact of a {} after an impact at the "
                                "incidence 2, over the normal speed",
                                body),
                    kThreeCoefficients, fmt::format("2 − {} μ (1 + e_n)", factor),
                    Expectation::equal(kSlips - k * kLoss), kImpact),
      ValidationRow(body + "_oblique_spin", "its spin a ω after this impact, over the normal speed",
                    kThreeCoefficients, fmt::format("{} μ (1 + e_n)", D == 2 ? "2" : "5/2"),
                    Expectation::equal(kLoss / kInertia<D>), kImpact),
      ValidationRow(body + "_oblique_sticks",
                    "that speed after an impact at the incidence 0.5, over that before",
                    kThreeCoefficients, "−e_t = −0.4", Expectation::equal(-kObliqueTangential),
                    kImpact),
      ValidationRow(body + "_oblique_incidence",
                    fmt::format("least incidence at which a {} slips", body), kThreeCoefficients,
                    fmt::format("{} μ (1 + e_n)/(1 + e_t)", factor),
                    Expectation::equal(k * kLoss / (1 + kObliqueTangential)),
                    {2e-3, "slip is told at 1e-3 of the normal speed; bisection 1e-4", kOneRun})};
  e.run = [](Experiment::Trial& trial) {
    const Body<D> slips = after_oblique_impact<D>(kSlips, trial);
    const double turned = slips.v.dot(along_floor<D>()) - speed_below(slips);
    const double sticks = speed_below(after_oblique_impact<D>(kSticks, trial));
    trial.seen = {{speed_below(slips)},
                  {turned},
                  {sticks / kSticks},
                  find_threshold(0.4, 1.6, [&](double incidence) {
                    const double after = speed_below(after_oblique_impact<D>(incidence, trial));
                    return after > -kObliqueTangential * incidence + 1e-3;
                  })};
  };
}

/// Two equal bodies of radius 1 and mass m meet head-on with the same spin 1. Their points of
/// contact pass each other at 2. Sticking takes the impulse 2 m/2k = m/k from each. Each keeps the
/// spin 1 - 1/(c k) = c/(1 + c) and leaves sideways at 1/k = c/(1 + c).
template <int D>
void spinning_pair(Experiment& e) {
  const std::string bodies = D == 2 ? "disks" : "spheres", share = D == 2 ? "1/3" : "2/7";
  e.rows = {ValidationRow(bodies + "_meet_spin",
                          fmt::format("spin that two equal {} with the same spin keep when they "
                                      "meet head-on",
                                      bodies),
                          kMomenta, share, Expectation::equal(1 / kTangentialShare<D>), kImpact),
            ValidationRow(bodies + "_meet_sideways", "their speed sideways after that, over a ω",
                          kMomenta, share, Expectation::equal(1 / kTangentialShare<D>), kImpact)};
  e.run = [](Experiment::Trial& trial) {
    Scene<D> scene = experiment_scene<D>({.mu = 1, .e_n = 0.5}, kImpactStep, trial);
    for (const double side : {-1.0, 1.0}) {
      Body<D> body = round_body<D>(side * Vec<D>::Unit(0), 1, 1, -side * Vec<D>::Unit(0));
      if constexpr (D == 2) {
        body.spin = 1;
      } else {
        body.spin = Vec3::UnitZ();
      }
      scene.bodies.push_back(body);
    }
    const Body<D> left = after_impact<D>(scene, trial).bodies[0];
    double spin = 0;
    if constexpr (D == 2) {
      spin = left.spin;
    } else {
      spin = left.spin[2];
    }
    trial.seen = {{spin}, {std::abs(left.v[1])}};
  };
}

/// Two different spheres that stick, off-centre and spinning. By the formulas at the top they lose
///   ½ m* (1 - e_n²) u_n² + ½ (m*/k) (1 - e_t²) |u_t|².
void unequal_pair(Experiment& e) {
  e.rows = {
      ValidationRow("pair_energy",
                    "energy that two unequal spinning spheres lose, over the expected one",
                    kThreeCoefficients, "½ m* (1 − e_n²) u_n² + ½ (2/7) m* (1 − e_t²) u_t²",
                    Expectation::equal(1), kImpact),
      ValidationRow("pair_angular_momentum", "change of their angular momentum, over what they had",
                    kMomenta, "0", Expectation::equal(0), kImpact)};
  e.run = [](Experiment::Trial& trial) {
    Scene<3> scene = experiment_scene<3>({.mu = 5, .e_n = 0.6, .e_t = 0.3}, kImpactStep, trial);
    const Vec3 n = Vec3(2, 1, 2) / 3;
    scene.bodies = {round_body<3>(Vec3::Zero(), 1, 1, Vec3(1, 0.2, 0.1), Vec3(0.5, -1, 0.2)),
                    round_body<3>(1.5 * n, 0.5, 0.3, Vec3(-0.7, 0.1, -0.4), Vec3(-1, 2, 1))};
    const Sphere &a = scene.bodies[0], &b = scene.bodies[1];
    const Vec3 u =
        a.v - b.v + a.radius * a.spin.cross(n) + b.radius * b.spin.cross(n);  // n: from a to b
    const double reduced = a.mass * b.mass / (a.mass + b.mass), u_n = u.dot(n);
    const double expected =
        0.5 * reduced *
        ((1 - 0.36) * u_n * u_n + 2.0 / 7 * (1 - 0.09) * (u.squaredNorm() - u_n * u_n));
    State<3> before = initial_state(scene);
    for (Sphere& s : before.bodies) s.x -= 0.5 * scene.step * s.v;
    const State<3> after = after_impact<3>(scene, trial);
    const Vec3 momentum = angular_momentum(before);
    trial.seen = {{(kinetic_energy(before) - kinetic_energy(after)) / expected},
                  {(angular_momentum(after) - momentum).norm() / momentum.norm()}};
  };
}

/// The state after the first of a row of disks, one for each mass, struck the others at speed 1.
State<2> struck_row(const std::vector<double>& masses, double gap, Experiment::Trial& trial) {
  Scene<2> scene = experiment_scene<2>({.e_n = 1}, kImpactStep, trial);
  scene.contact_distance = 1e-9;
  for (const double mass : masses) {
    const double x = (1 + gap) * static_cast<double>(scene.bodies.size());
    scene.bodies.push_back(round_body<2>(Vec2(x, 0), 0.5, mass));
  }
  scene.bodies[0].v = Vec2(1, 0);
  if (gap == 0) return after_impact<2>(scene, trial);
  scene.num_steps = static_cast<int>(4 * static_cast<double>(masses.size()) * gap / kImpactStep);
  return run_from_start<2>(scene, trial);
}

/// Three equal disks that touch, e_n = 0 at the first contact and 1 at the second, by Poisson's law.
/// Compression gives 1/3 to all, with impulses 2/3 and 1/3. The second is returned: 1/3, 0, 2/3. The
/// first two would close, and go on with 1/6.
State<2> squeezed_row(Experiment::Trial& trial) {
  Scene<2> scene = experiment_scene<2>({}, kImpactStep, trial);
  scene.impact = ContactLaw::Impact::kPoisson;
  scene.contact_distance = 1e-9;
  scene.materials = {"dull", "elastic"};
  scene.laws = {{}, {}, {}, {.e_n = 1}};
  for (int k = 0; k < 3; ++k) {
    scene.bodies.push_back(round_body<2>(Vec2(k, 0), 0.5, 1));
    scene.bodies.back().material = k > 0 ? 1 : 0;
  }
  scene.bodies[0].v = Vec2(1, 0);
  return after_impact<2>(scene, trial);
}

/// Touching: all contacts but the first stay closed, v_1 = … = V, V - v_0 = 1 and v_0 + 4 V = 1.
/// With gaps: one impact after the other, the first of 2 m_i/(m_i + m_j) of the speed.
void cradle(Experiment& e) {
  e.rows = {
      ValidationRow("cradle_touching",
                    "speed of the striking disk after a row of five that touch, e = 1",
                    "momentum, and Newton's law for all contacts at once", "2/5 − 1 = −0.6",
                    Expectation::equal(-0.6), kImpact),
      ValidationRow("cradle_with_gaps", "speed of the last of five disks with gaps, e = 1",
                    "equal masses change velocities", "1", Expectation::equal(1), kImpact),
      ValidationRow("row_with_gaps", "speed of the last of three disks, masses 1, 2 and 4",
                    "momentum and energy of each impact", "2/(1 + 2) × 4/(2 + 4) = 4/9",
                    Expectation::equal(4.0 / 9), kImpact),
      ValidationRow("row_squeezed",
                    "speed of the last of three disks that touch, e_n = 0 and 1, by Poisson's "
                    "law",
                    "Glocker, Multibody Syst. Dyn. 32 (2014); collision_experiments.cc",
                    "1/3 + 1/3", Expectation::equal(2.0 / 3), kImpact)};
  e.run = [](Experiment::Trial& trial) {
    const std::vector<double> equal(5, 1.0);
    constexpr double kGap = 0.02;  // twenty steps
    trial.seen = {{struck_row(equal, 0, trial).bodies[0].v[0]},
                  {struck_row(equal, kGap, trial).bodies[4].v[0]},
                  {struck_row({1, 2, 4}, kGap, trial).bodies[2].v[0]},
                  {squeezed_row(trial).bodies[2].v[0]}};
  };
}

/// A rack of fifteen disks that touch is struck along its axis. The mirror image of ball j of row r
/// is ball r - j.
void billiard(Experiment& e) {
  e.rows = {ValidationRow("break_symmetry",
                          "largest distance of a ball from its mirror image after a billiard "
                          "break, over the radius",
                          "symmetry of the rack", "0", Expectation::equal(0),
                          {1e-9, "rounding, enlarged by the impacts that follow", kOneRun}),
            ValidationRow("break_energy", "energy after this break with e = 1, over that before",
                          "e = 1 without friction", "1", Expectation::equal(1), kImpact)};
  e.run = [](Experiment::Trial& trial) {
    constexpr int kRows = 5;
    Scene<2> scene = experiment_scene<2>({.e_n = 1}, kImpactStep, trial);
    for (int r = 0; r < kRows; ++r) {
      for (int j = 0; j <= r; ++j) {
        scene.bodies.push_back(round_body<2>(Vec2(std::sqrt(3.0) * r, 2 * j - r), 1, 1));
      }
    }
    scene.bodies.push_back(round_body<2>(Vec2(-3, 0), 1, 1, Vec2(10, 0)));
    scene.num_steps = 1000;
    const State<2> end = run_from_start<2>(scene, trial);
    double apart = 0;
    for (int r = 0, first = 0; r < kRows; first += ++r) {
      for (int j = 0; j <= r; ++j) {
        const Vec2 &x = end.bodies[to_size(first + j)].x, &y = end.bodies[to_size(first + r - j)].x;
        apart = std::max(apart, (x - Vec2(y[0], -y[1])).norm());
      }
    }
    trial.seen = {{apart}, {kinetic_energy(end) / 50}};
  };
}

}  // namespace

std::vector<Experiment> collision_experiments() {
  return made_by({&oblique<2>, &oblique<3>, &spinning_pair<2>, &spinning_pair<3>, &unequal_pair,
                  &cradle, &billiard});
}

}  // namespace bipot
