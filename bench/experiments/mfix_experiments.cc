// The verification cases DEM-01 to DEM-05 of MFiX in the limit of rigid bodies: Garg, Galvin, Li and
// Pannala, Powder Technology 220 (2012) 122, and the manual of MFiX for verification. Sizes and
// coefficients are theirs where they matter.
//
// DEM-01, DEM-02: dropped from the height h_0 of its centre a ball of radius r reaches the floor
// with v = √(2 g (h_0 - r)) after t_1 = v/g. After impact k it has the speed eᵏ v, rises to
// (h_0 - r) e²ᵏ + r and comes back after 2 eᵏ t_1.
// DEM-03: two balls between a floor and a plate; pressed with the force F as no rigid ball yields.
// DEM-04: a ball slides at v_0 - μ g t and turns by 5 μ g t/2a until both agree at 2 v_0/(7 μ g).
// Its way until then is 12 v_0²/(49 μ g); then it rolls at 5/7 v_0.
// DEM-05: an oblique impact that slips takes μ (1 + e) v_n of the speed along the wall, and turns the
// ball by 5/2 of that over a (collision_experiments.cc).

#include <cmath>
#include <numbers>

#include "bench/experiments/experiment_scene.h"
#include "bench/experiments/validation_row.h"

namespace bipot {
namespace {

const std::string kGarg = "Garg et al., Powder Technol. 220 (2012) 122; mfix_experiments.cc";

constexpr double kDropRadius = 0.1, kDropHeight = 0.5;  // of DEM-01 and DEM-02 [m]

/// The ball of DEM-01 after `seconds`. `accuracy` places parts of steps on the impacts.
Sphere dropped(double e_n, double accuracy, double seconds, Experiment::Trial& trial) {
  constexpr double kStep = 1e-2;
  Scene<3> scene = experiment_scene<3>({.e_n = e_n}, kStep, trial);
  scene.accuracy = accuracy;
  scene.contact_distance = 1e-3 * accuracy * kDropRadius;
  scene.gravity = Vec3(0, 0, -kGravity);
  scene.bodies = {round_body<3>(Vec3(0, 0, kDropHeight), kDropRadius, 1)};
  scene.walls = {flat_floor<3>()};
  scene.num_steps = static_cast<int>(std::lround(seconds / kStep));
  return run_from_start<3>(scene, trial).bodies[0];
}

/// Three impacts, each misplaced by up to x a of the way 2 (h_0 - r) e², x a/(h_0 - r)/1.6.
void falling_ball(Experiment& e) {
  constexpr double kRestitution = 0.9, kEnd = 1.5, kAccuracy = 1e-4;
  const double speed = std::sqrt(2 * kGravity * (kDropHeight - kDropRadius));
  const double third = speed / kGravity * (1 + 2 * kRestitution * (1 + kRestitution));
  const double leaves = std::pow(kRestitution, 3) * speed, t = kEnd - third;
  const std::string why = "accuracy: each impact is misplaced by 1e-4 radii at most";
  e.rows = {ValidationRow("dem01_place", "height of the ball after 1.5 s and three bounces [m]",
                          kGarg, "r + e³ v t − g t²/2, t since the third impact",
                          Expectation::equal(kDropRadius + leaves * t - 0.5 * kGravity * t * t),
                          {1e-3, why, kOneRun}),
            ValidationRow("dem01_third_impact", "time of the third impact, from the speed then [s]",
                          kGarg, "(1 + 2 e + 2 e²) √(2 (h_0 − r)/g)", Expectation::equal(third),
                          {1e-3, why, kOneRun})};
  e.run = [=](Experiment::Trial& trial) {
    const Sphere ball = dropped(kRestitution, kAccuracy, kEnd, trial);
    trial.seen = {{ball.x[2]}, {kEnd - (leaves - ball.v[2]) / kGravity}};
  };
}

/// The energy after three bounces tells the height that the ball reaches.
void bouncing_ball(Experiment& e) {
  constexpr double kRestitution = 0.8, kEnd = 1.2;
  e.rows = {ValidationRow(
      "dem02_third_height", "height of the third bounce over that of the drop, both less r", kGarg,
      "e⁶", Expectation::equal(std::pow(kRestitution, 6)),
      {1e-3, "accuracy: each impact is misplaced by 1e-4 radii at most", kOneRun})};
  e.run = [](Experiment::Trial& trial) {
    const Sphere ball = dropped(kRestitution, 1e-4, kEnd, trial);
    const double energy = 0.5 * ball.v[2] * ball.v[2] + kGravity * (ball.x[2] - kDropRadius);
    trial.seen = {{energy / (kGravity * (kDropHeight - kDropRadius))}};
  };
}

void stacked(Experiment& e) {
  constexpr double kPush = 50, kLower = 2, kUpper = 1;
  constexpr double kOnUpper = kPush + kUpper * kGravity;
  const std::string why = "statics; a hundred times the tightest tolerance";
  e.rows = {ValidationRow("dem03_floor", "force on the floor, over what lies and pushes on it",
                          kGarg, "F + (m_1 + m_2) g", Expectation::equal(1), {1e-6, why, kOneRun}),
            ValidationRow("dem03_between", "force between the two balls, likewise", kGarg,
                          "F + m_2 g", Expectation::equal(1), {1e-6, why, kOneRun}),
            ValidationRow("dem03_place", "height of the upper ball over its radius", kGarg, "3",
                          Expectation::equal(3), {1e-6, why, kOneRun})};
  e.run = [](Experiment::Trial& trial) {
    Scene<3> scene = experiment_scene<3>({.e_n = 0.5}, 1e-3, trial);
    scene.gravity = Vec3(0, 0, -kGravity);
    scene.bodies = {round_body<3>(Vec3(0, 0, 1), 1, kLower),
                    round_body<3>(Vec3(0, 0, 3), 1, kUpper)};
    Wall<3> plate = half_space<3>(Vec3(0, 0, 4), Vec3(0, 0, -1), "plate");
    drive(plate, Vec3(0, 0, -1), 1, kPush);
    scene.walls = {flat_floor<3>(), plate};
    scene.num_steps = 50;
    const State<3> end = run_from_start<3>(scene, trial);
    double floor = 0, between = 0;
    for (const ContactOutcome<3>& c : end.contacts) {
      const double force = c.s_n / scene.step;
      if (c.contact.i == 0 && c.contact.j == 1) between = force;
      if (c.contact.i == 0 && c.contact.j == 2) floor = force;
    }
    trial.seen = {
        {floor / (kOnUpper + kLower * kGravity)}, {between / kOnUpper}, {end.bodies[1].x[2]}};
  };
}

/// The speed falls at the same rate in all steps but one. There the place is off by μ g h²/8 at most.
void slipping_ball(Experiment& e) {
  constexpr double kMu = 0.2, kSpeed = 1, kRadius = 0.5, kStep = 1e-3, kEnd = 0.3;
  constexpr double kTime = 2 * kSpeed / (7 * kMu * kGravity);
  constexpr double kPlace =
      12 * kSpeed * kSpeed / (49 * kMu * kGravity) + 5.0 / 7 * kSpeed * (kEnd - kTime);
  const std::string exact = "the scheme is exact here; a hundred times the tightest tolerance";
  e.rows = {
      ValidationRow("dem04_time", "time until a ball that slides on a rough floor rolls [s]", kGarg,
                    "2 v_0/(7 μ g)", Expectation::equal(kTime), {1e-5, exact, kOneRun}),
      ValidationRow("dem04_spin", "its spin from then on, a ω/v_0", kGarg, "5/7",
                    Expectation::equal(5.0 / 7), {1e-6, exact, kOneRun}),
      ValidationRow("dem04_place", "its way after 0.3 s [m]", kGarg,
                    "12 v_0²/(49 μ g) + 5/7 v_0 (t − 2 v_0/(7 μ g))", Expectation::equal(kPlace),
                    {1e-5, "the step in which it begins to roll: μ g h²/8", kOneRun})};
  e.run = [=](Experiment::Trial& trial) {
    Scene<3> scene = experiment_scene<3>({.mu = kMu}, kStep, trial);
    scene.gravity = Vec3(0, 0, -kGravity);
    scene.bodies = {round_body<3>(Vec3(0, 0, kRadius), kRadius, 1, Vec3(kSpeed, 0, 0))};
    scene.walls = {flat_floor<3>()};
    scene.num_steps = static_cast<int>(std::lround(kEnd / kStep));
    double slip = kSpeed, rolls = kNaN;
    const State<3> end = run_from_start<3>(scene, trial, [&](const SceneStep<3>& step) {
      const Sphere& s = step.state.bodies[0];
      const double now = s.v[0] - kRadius * s.spin[1];
      const bool slides = slip > 1e-3 * kSpeed;
      if (slides && now <= 1e-3 * kSpeed) {
        rolls = step.state.time - kStep + slip / (3.5 * kMu * kGravity);
      }
      slip = now;
      return true;
    });
    trial.seen = {{rolls}, {end.bodies[0].spin[1] * kRadius / kSpeed}, {end.bodies[0].x[0]}};
  };
}

/// 60° from the normal, e = 0.98, μ = 0.092: as Kharaz, Gorham and Salman, Powder Technol. 120
/// (2001) 281, measured for aluminium oxide on glass. It slips, as tan 60° > 7/2 μ (1 + e).
void oblique_ball(Experiment& e) {
  constexpr double kMu = 0.092, kRestitution = 0.98, kStep = 1e-3;
  constexpr double kIncidence = std::numbers::sqrt3, kLoss = kMu * (1 + kRestitution);
  const std::string why = "an impact is exact; a hundred times the tightest tolerance";
  e.rows = {
      ValidationRow("dem05_angle", "tangent of the angle at which a ball leaves that came at 60°",
                    kGarg, "(tan 60° − μ (1 + e))/e",
                    Expectation::equal((kIncidence - kLoss) / kRestitution), {1e-6, why, kOneRun}),
      ValidationRow("dem05_tangential", "its speed along the wall, over that before", kGarg,
                    "1 − μ (1 + e)/tan 60°", Expectation::equal(1 - kLoss / kIncidence),
                    {1e-6, why, kOneRun}),
      ValidationRow("dem05_spin", "its spin a ω over the normal speed before", kGarg,
                    "5/2 μ (1 + e)", Expectation::equal(2.5 * kLoss), {1e-6, why, kOneRun})};
  e.run = [=](Experiment::Trial& trial) {
    Scene<3> scene = experiment_scene<3>({.mu = kMu, .e_n = kRestitution}, kStep, trial);
    const Vec3 v(kIncidence, 0, -1);
    scene.bodies = {round_body<3>(Vec3(0, 0, 1) - 0.5 * kStep * v, 1, 1, v)};
    scene.walls = {flat_floor<3>()};
    scene.num_steps = 1;
    const Sphere ball = run_from_start<3>(scene, trial).bodies[0];
    trial.seen = {{ball.v[0] / ball.v[2]}, {ball.v[0] / kIncidence}, {ball.spin[1]}};
  };
}

}  // namespace

std::vector<Experiment> mfix_experiments() {
  return made_by({&falling_ball, &bouncing_ball, &stacked, &slipping_ball, &oblique_ball});
}

}  // namespace bipot
