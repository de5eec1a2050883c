// Scenes of the study and what is measured in them.

#include <algorithm>
#include <cmath>

#include "bench/experiments/packing.h"
#include "bench/measure/statistics.h"
#include "bench/problems/moving_scene.h"
#include "bench/problems/scene_catalogue.h"
#include "bench/study/study.h"
#include "core/motion/force_balance.h"
#include "core/observables/observables.h"
#include "core/scene/generators.h"
#include "core/scene/scene_parts.h"
#include "core/scene_files/scene_file.h"

namespace bipot {
namespace {

constexpr double kRunLimit = 120;  // CPU seconds of one run
constexpr int kStepsBetween = 4;   // of the sample's own, between two measurements

/// A third each of three radii about the middle one; `spread` 1: by 12.5 % (shear), 20 % (drum).
std::vector<RadiusClass> three_radii(double middle, double width, double spread) {
  return {{middle - spread * width, 1}, {middle, 1}, {middle + spread * width, 1}};
}

/// The shipped plane_shear with other disks. Sides and masses grow with the number.
Scene<2> shear_sample(const Study::Sample& sample) {
  Scene<2> scene = read_scene(find_scene("plane_shear"));
  const double scale = std::sqrt(sample.size / 120.0), height = 0.9 * scale;
  scene.laws[0].mu = sample.mu;
  scene.cell.width.length = scale;
  scene.bodies = random_filling(sample.size, three_radii(0.04, 0.005, sample.spread), scale, 0.02,
                                to_size(sample.seed), Vec2::Zero());
  double top = 0;
  for (Disk& d : scene.bodies) {
    give_density(d, 1000);
    top = std::max(top, d.x[1] + d.radius);
  }
  scene.cell.height.length = 1.01 * top;
  scene.cell.height.mass = 40 * scale * scale;
  scene.cell.offset.speed = sample.drive * height;
  scene.step = 4e-3 / std::max(1.0, std::sqrt(sample.drive));
  const double strain = sample.drive < 1 ? 1 : 2;
  scene.num_steps =
      static_cast<int>((sample.averages_from(scene) + strain / sample.drive) / scene.step);
  return scene;
}

/// The shipped drum, half full, with other disks.
Scene<2> drum_sample(const Study::Sample& sample) {
  Scene<2> scene = read_scene(find_scene("drum"));
  const double scale = std::sqrt(sample.size / 220.0), radius = 0.7 * scale;
  scene.laws[0].mu = sample.mu;
  FillingBounds<2> inside;
  inside.holds = [&](const Vec2& x, double r) { return x.norm() + r < radius; };
  scene.bodies =
      random_filling(sample.size, three_radii(0.025, 0.005, sample.spread), 1.4 * scale, 0.02,
                     to_size(sample.seed), Vec2(-0.7 * scale, -0.7 * scale), inside);
  for (Disk& d : scene.bodies) give_density(d, 1000);
  scene.walls[0].radius = radius;
  scene.walls[0].spin *= sample.drive;
  scene.num_steps = static_cast<int>((1 + 2.4 / scene.walls[0].spin) / scene.step);
  return scene;
}

double mean_height(const State<2>& state) {
  double sum = 0, mass = 0;
  for (const Disk& d : state.bodies) {
    sum += d.mass * d.x[1];
    mass += d.mass;
  }
  return sum / mass;
}

/// Width within which 97 % of the mass lies.
double spread_width(const State<2>& state) {
  std::vector<double> x;
  for (const Disk& d : state.bodies) x.push_back(d.x[0]);
  std::ranges::sort(x);
  return quantile(x, 0.985) - quantile(x, 0.015);
}

}  // namespace

double Study::Sample::averages_from(const Scene<2>& made) const {
  if (scene == "shear") return 0.4 + 0.6 * std::sqrt(size / 120.0) + 0.5 / drive;
  return (scene == "drum" ? 0.4 : 0.85) * made.num_steps * made.step;
}

Scene<2> Study::Sample::make() const {
  Scene<2> made;
  if (scene == "shear") {
    made = shear_sample(*this);
  } else if (scene == "drum") {
    made = drum_sample(*this);
  } else {
    made = make_moving_scene(scene, static_cast<int>(std::lround(std::sqrt(size))),
                             {.mu = mu, .seed = to_size(seed)});
    made.num_steps = made.num_steps * 7 / 5;  // at rest in the end
  }
  made.observables.reset();
  return made;
}

std::string Study::class_of(const std::string& quantity) {
  static const std::map<std::string, std::string> classes = {
      {"coordination", "geometry"}, {"fabric", "geometry"},         {"height", "geometry"},
      {"runout", "geometry"},       {"solid_fraction", "geometry"}, {"angle", "geometry"},
      {"wall_share", "stress"},     {"side_ratio", "stress"},       {"pressure", "stress"},
      {"stress_ratio", "stress"},   {"force_tail", "forces"},       {"force_variation", "forces"},
      {"weak_share", "forces"},     {"sliding_share", "forces"},    {"rotation", "kinematics"},
      {"sideways", "kinematics"},   {"peak_energy", "kinematics"},  {"fluctuation", "kinematics"},
      {"spin", "kinematics"},       {"dissipation", "kinematics"}};
  const auto at = classes.find(quantity);
  return at == classes.end() ? "" : at->second;
}

Study::Observer::Observer(const Sample& sample, const Scene<2>& made, double step_factor)
    : sample_(sample),
      scene_(made),
      from_(sample.averages_from(made)),
      start_energy_(potential_energy(initial_state(made), made.gravity)),
      every_(std::max(1, static_cast<int>(std::lround(kStepsBetween / step_factor)))) {}

void Study::Observer::see(const State<2>& state) {
  if (state.step % every_ != 0) return;
  peak_ = std::max(peak_, kinetic_energy(state));
  if (state.time < from_) return;
  const auto add = [&](const char* quantity, double value) {
    if (!std::isfinite(value)) return;
    auto& [sum, count] = sums_[quantity];
    sum += value;
    ++count;
  };
  const std::string& name = sample_.scene;
  const bool shear = name == "shear", drum = name == "drum";
  const Observables<2> seen = observe(scene_, state, {});
  const Mat2 stress = seen.stress.total();
  add("coordination", seen.coordination_without);
  add("sliding_share", seen.sliding_share());
  add("fabric", anisotropy(seen.fabric));
  const int layers = shear || drum ? 1 : std::max(1, static_cast<int>(std::sqrt(sample_.size) / 3));
  double mean = 0;
  std::vector<double> forces = relative_forces(state, layers);
  for (const double f : forces) mean += f / static_cast<double>(forces.size());
  for (double& f : forces) f /= mean;
  forces_.insert(forces_.end(), forces.begin(), forces.end());
  const double lost = state.friction_loss + state.shock_loss;
  if (loss_time_ < 0) {
    loss_ = lost;
    loss_time_ = state.time;
  }
  const double elapsed = state.time - loss_time_;
  if (shear) {
    const double pressure = scene_.cell.height.stress, rate = sample_.drive;
    add("stress_ratio", std::abs(stress(0, 1)) / stress(1, 1));
    add("pressure", stress(1, 1) / pressure);
    add("solid_fraction", seen.solid_fraction);
    add("inertial_number", seen.inertial_number());
    add("fluctuation", std::sqrt(seen.stress.kinetic.trace() / pressure));
    double spin = 0;
    for (const Disk& d : state.bodies) spin += d.spin * d.spin;
    add("spin", std::sqrt(spin / static_cast<double>(state.bodies.size())) / rate);
    const double area = state.cell.width.length * state.cell.height.length;
    if (elapsed > 0)
      sums_["dissipation"] = {(lost - loss_) / (elapsed * area * pressure * rate), 1};
  } else if (drum) {
    Vec2 centre = Vec2::Zero();
    double mass = 0, energy = 0;
    for (const Disk& d : state.bodies) {
      centre += d.mass * d.x;
      mass += d.mass;
      energy += d.mass * d.v.squaredNorm();
    }
    const double radius = scene_.walls[0].radius, speed = scene_.walls[0].spin * radius;
    add("angle", std::abs(std::atan2(centre[0], -centre[1])));
    add("fluctuation", std::sqrt(energy / mass) / speed);
    add("inertial_number", seen.inertial_number());
    if (elapsed > 0)
      sums_["dissipation"] = {(lost - loss_) / (elapsed * mass * kGravity * speed), 1};
  } else {
    add("height", mean_height(state));
    add("side_ratio", stress(0, 0) / stress(1, 1));
    if (name == "pour") {
      double weight = 0;
      for (const Disk& d : state.bodies) weight += kGravity * d.mass;
      const std::vector<Vec2> walls = wall_reactions(state, scene_.step);
      add("wall_share", -(walls[1][1] + walls[2][1]) / weight);
    } else {
      add("runout", spread_width(state));
    }
  }
}

Study::Values Study::Observer::values(const State<2>& end) const {
  Values values;
  for (const auto& [quantity, sum] : sums_) {
    values[quantity] = sum.first / static_cast<double>(sum.second);
  }
  double squares = 0, weak = 0;
  for (const double f : forces_) {
    squares += (f - 1) * (f - 1);
    weak += f < 1 ? 1 : 0;
  }
  const double count = static_cast<double>(forces_.size());
  if (count > 1) {
    values["force_tail"] = fit_exponential_tail(forces_, kForceTail).rate;
    values["force_variation"] = std::sqrt(squares / count);
    values["weak_share"] = weak / count;
  }
  if (sample_.scene == "pour" || sample_.scene == "collapse") {
    double turned = 0, sideways = 0;
    for (std::size_t k = 0; k < end.bodies.size(); ++k) {
      turned += std::abs(end.bodies[k].angle);
      sideways += std::abs(end.bodies[k].x[0] - scene_.bodies[k].x[0]);
    }
    values["rotation"] = turned / static_cast<double>(end.bodies.size());
    values["sideways"] = sideways / static_cast<double>(end.bodies.size());
    values["peak_energy"] = peak_ / start_energy_;
  }
  std::erase_if(values, [](const auto& entry) { return !std::isfinite(entry.second); });
  return values;
}

Study::Values Study::run(const Sample& sample, const RunSetting& setting, const Stopped& stopped) {
  const Scene<2> made = sample.make(), taken = with_setting(made, setting);
  Observer observer(sample, taken, setting.step_factor);
  State<2> state = initial_state(made);
  const RunRecord record =
      run_setting<2>(made, state, setting, {.cpu_seconds = kRunLimit, .cancelled = stopped},
                     {.before_step = {}, .on_step = [&](const SceneStep<2>& step) {
                        observer.see(step.state);
                        return true;
                      }});
  if (!record.whole) return {{"failed", 1}, {"cpu", std::isnan(record.cpu) ? 0 : record.cpu}};
  Values values = observer.values(state);
  values["cpu"] = record.cpu;
  values["steps"] = record.steps;
  values["unsolved"] = record.steps - record.steps_converged;
  values["iterations"] = record.iterations;
  values["overlap"] = record.penetration;
  return values;
}

}  // namespace bipot
