// Packings under isotropic pressure: number of contacts that hold them, and density.
//
// N' bodies take part (no rattlers), with M loaded contacts. Without friction a contact is one
// force, a body D equations. Generic packings at rest have no more forces than equations (else
// radii would have to fit by chance) and no fewer (else they move): M = D N' + driven sides - free
// rigid shifts. With friction a contact is D forces, a body D (D + 1)/2 equations: D M >= D(D+1)/2
// N' + ..., and sliding contacts have one force less.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/experiments/experiment_scene.h"
#include "bench/experiments/validation_row.h"
#include "bench/measure/statistics.h"
#include "core/observables/observables.h"
#include "core/scene/generators.h"

namespace bipot {
namespace {

constexpr const char* kOverPackings = "95 % over packings (seeds)";
constexpr double kPressure = 1000, kDensity = 1000;
/// In equal shares: no skewness; their ratio is above 0.743.
const std::vector<RadiusClass> kSizes = {{0.044, 1}, {0.05, 1}, {0.056, 1}};

/// Disks of three radii about 0.05 m in a cell that is pressed from both sides.
Scene<2> pressed_cell(int count, double mu, std::uint64_t seed, const Experiment::Trial& trial) {
  Scene<2> scene = experiment_scene<2>({.mu = mu}, 2e-3, trial);
  const double width = 0.12 * std::sqrt(count);
  scene.bodies = random_filling(count, kSizes, width, 0.02, seed, Vec2::Zero());
  double top = 0;
  for (Disk& d : scene.bodies) {
    give_density(d, kDensity);
    top = std::max(top, d.x[1] + d.radius);
  }
  scene.cell.in_x = scene.cell.in_y = true;
  scene.cell.width.length = width;
  scene.cell.height.length = top * 1.01;
  for (CellSide* side : {&scene.cell.width, &scene.cell.height}) {
    side->motion = CellSide::Motion::kDriven;
    side->stress = kPressure;
    side->mass = 2.0 * count;
  }
  scene.contact_distance = 1e-7;
  scene.num_steps = trial.context.quick ? 900 : 1500;
  return scene;
}

/// A packing at rest, counted.
struct Counted {
  int bodies = 0, contacts = 0, sliding = 0;  ///< without rattlers
};

template <int D>
Counted count_packing(const Scene<D>& scene, const State<D>& state) {
  const std::vector<bool> rattler = find_rattlers(scene, state);
  Counted counted;
  const int bodies = static_cast<int>(state.bodies.size());
  counted.bodies = bodies - static_cast<int>(std::ranges::count(rattler, true));
  for (const ContactOutcome<D>& o : state.contacts) {
    if (!(o.s_n > 0) || rattler[to_size(o.contact.i)]) continue;
    if (o.contact.j < bodies && rattler[to_size(o.contact.j)]) continue;
    ++counted.contacts;
    if (o.status == ContactStatus::kSlip) ++counted.sliding;
  }
  return counted;
}

Observation over_packings(const std::vector<double>& values) {
  const MeanValue mean = mean_value(values);
  return {mean.mean, mean.confidence};
}

void plane_packings(Experiment& e) {
  const std::string counting =
      "counting of forces and equations, derived in packing_experiments.cc";
  e.rows = {
      ValidationRow(
          "disks_frictionless",
          "coordination of disks without friction, without rattlers, periodic cell pressed "
          "from two sides",
          counting, "4: M = 2N' + 2 sides − 2 shifts", Expectation::equal(4),
          {1e-2, "contacts at the edge of being loaded", kOverPackings}),
      ValidationRow("disks_rough", "the same with μ = 10", counting,
                    "at least 3 (2M ≥ 3N' + 2 − 2), below 4; 3 for μ → ∞",
                    Expectation::between(3, 4, 3), {0, "none", kOverPackings}),
      ValidationRow(
          "sliding_contacts",
          "sliding contacts less 2M − 3N', over N': packings of μ = 0.3 at rest",
          "McNamara and Herrmann 2004 (read in an abstract), and counting: each sliding contact "
          "has one force less",
          "at most 0", Expectation::at_most(0, 1), {1e-9, "a count", kOverPackings}),
      ValidationRow(
          "fraction_falls", "solid fraction without friction less that with μ = 10",
          "friction holds looser packings (trend; the figures .76 to .80 are from memory, not "
          "tested)",
          "at least 0", Expectation::at_least(0, 1), {0, "none", kOverPackings}),
      ValidationRow(
          "fraction_close", "solid fraction without friction, three radii in equal shares",
          "Meer, Galoustian, de Falco Manuel and Weeks 2024 (abstract of arXiv 2404.02316): "
          "0.840 for size distributions without skewness, whatever their width",
          "0.840", Expectation::equal(0.840),
          {1.5e-2, "64 disks (--quick: 25); overlaps count twice", kOverPackings}),
      ValidationRow("fraction_bound", "the same, as a bound",
                    "Blind 1969 (read in the abstract of arXiv 1907.03652): disks of radii within "
                    "0.743 of each other pack no denser than equal ones",
                    "at most π/√12 = 0.9069",
                    Expectation::at_most(std::numbers::pi / std::sqrt(12.0), 1),
                    {0, "none", kOverPackings})};
  e.tols = {10, 1, 1e-1, 1e-2, 1e-3};
  e.quick_tols = {1, 1e-1, 1e-3};
  e.run = [](Experiment::Trial& trial) {
    const int count = trial.context.quick ? 25 : 64, seeds = trial.context.quick ? 3 : 5;
    std::vector<double> smooth, rough, excess, falls, fractions;
    for (int seed = 1; seed <= seeds; ++seed) {
      double fraction[2] = {0, 0};
      for (const double mu : {0.0, 0.3, 10.0}) {
        const Scene<2> scene = pressed_cell(count, mu, to_size(seed), trial);
        const auto end = run_from_start<2>(scene, trial);
        const Counted counted = count_packing(scene, end);
        const Observables<2> seen = observe(scene, end, {});
        if (mu == 0) {
          smooth.push_back(seen.coordination_without);
          fraction[0] = seen.solid_fraction;
        } else if (mu == 10) {
          rough.push_back(seen.coordination_without);
          fraction[1] = seen.solid_fraction;
        } else {
          excess.push_back(
              static_cast<double>(counted.sliding - 2 * counted.contacts + 3 * counted.bodies) /
              std::max(1, counted.bodies));
        }
      }
      falls.push_back(fraction[0] - fraction[1]);
      fractions.push_back(fraction[0]);
    }
    Observation worst = over_packings(excess);
    worst.value = *std::ranges::max_element(excess);
    worst.bar = 0;
    trial.seen = {over_packings(smooth), over_packings(rough),     worst,
                  over_packings(falls),  over_packings(fractions), over_packings(fractions)};
  };
}

/// Spheres in a box whose three upper planes press.
Scene<3> pressed_box(int count, double mu, std::uint64_t seed, const Experiment::Trial& trial) {
  Scene<3> scene = experiment_scene<3>({.mu = mu}, 2e-3, trial);
  const double side = 0.12 * std::cbrt(count);
  scene.bodies = random_spheres(count, kSizes, Vec2(side, side), 0.02, seed, Vec3::Zero());
  Vec3 top = Vec3::Zero();
  for (Sphere& s : scene.bodies) {
    give_density(s, kDensity);
    top = top.cwiseMax(s.x + Vec3::Constant(s.radius));
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      Wall<3> wall{.name = fmt::format("{}{}", sign > 0 ? "low" : "high", axis),
                   .normal = sign * Vec3::Unit(axis)};
      if (sign < 0) {
        wall.a = top[axis] * Vec3::Unit(axis);
        drive(wall, wall.normal, 0.2 * count, kPressure * side * side);
      }
      scene.walls.push_back(wall);
    }
  }
  scene.contact_distance = 1e-7;
  scene.num_steps = 1500;
  return scene;
}

void space_packings(Experiment& e) {
  e.rows = {
      ValidationRow("spheres_frictionless",
                    "twice the loaded contacts of spheres without friction, over the number that "
                    "hold each other; walls count as bodies do, three of them driven",
                    "counting of forces and equations, derived in packing_experiments.cc",
                    "6: M = 3N' + 3 walls, so 2(M − 3)/N'", Expectation::equal(6),
                    {1e-2, "contacts at the edge of being loaded", kOverPackings}),
      ValidationRow("spheres_rough", "the same with μ = 10",
                    "counting; Silbert 2010 (abstract of arXiv 1108.0012): → 4 for μ → ∞",
                    "at least 4 (3M ≥ 6N' + 3), below 6", Expectation::between(4, 6, 4),
                    {0, "none", kOverPackings})};
  e.tols = {10, 1, 1e-1, 1e-2, 1e-3};
  e.quick_tols = {1, 1e-1, 1e-3};
  e.run = [](Experiment::Trial& trial) {
    const int count = trial.context.quick ? 27 : 100, seeds = trial.context.quick ? 3 : 4;
    std::vector<double> smooth, rough;
    for (int seed = 1; seed <= seeds; ++seed) {
      for (const double mu : {0.0, 10.0}) {
        const Scene<3> scene = pressed_box(count, mu, to_size(seed), trial);
        const auto end = run_from_start<3>(scene, trial);
        const Counted counted = count_packing(scene, end);
        const double walls = mu == 0 ? 3 : 1;
        (mu == 0 ? smooth : rough)
            .push_back(2 * (counted.contacts - walls) / std::max(1, counted.bodies));
      }
    }
    trial.seen = {over_packings(smooth), over_packings(rough)};
  };
}

}  // namespace

std::vector<Experiment> packing_experiments() {
  return made_by({&plane_packings, &space_packings});
}

}  // namespace bipot
