// What bodies sink into each other by in steps that a popular setting ends.

#include <algorithm>

#include "bench/compare/popular_settings.h"
#include "bench/problems/moving_scene.h"
#include "core/motion/push_apart.h"
#include "core/scene/generators.h"
#include "core/scene/scene_parts.h"
#include "core/scene/start_check.h"
#include "solvers/registry.h"
#include "solvers/simulation/scene_run.h"
#include "solvers/simulation/step_solver.h"

namespace bipot {
namespace {

constexpr double kBeforeTol = 1e-3, kExactTol = 1e-8;

/// A scene that is left after a share of its steps, with its overlaps taken out.
template <int D>
Scene<D> flow_of(Scene<D> scene, double share, const std::function<bool()>& interrupted) {
  scene.solver = {.name = "auto", .tol = kBeforeTol};
  State<D> state = initial_state(scene);
  const int steps = static_cast<int>(share * scene.num_steps);
  run_scene<D>(scene, state, {.steps = steps, .cancelled = interrupted});
  scene.bodies = state.bodies;
  push_apart(scene, make_step_solver(require_solver("auto"), {.tol = 1e-10}));
  return scene;
}

/// A triangular lattice between walls, where nothing has to move.
Scene<2> column_at_rest() {
  constexpr int kWidth = 6, kRows = 30;
  Scene<2> scene;
  scene.materials = {"default"};
  scene.laws = {{.mu = 0.3}};
  scene.gravity = Vec2(0, -kGravity);
  scene.step = 0.005;
  scene.contact_distance = 1e-6;
  scene.bodies = triangular_lattice(kWidth, kRows, 0.5, Vec2::Zero());
  for (Disk& d : scene.bodies) give_mass(d, 1);
  scene.walls = {flat_floor<2>(), half_space<2>(Vec2(0, 0), Vec2(1, 0), "left"),
                 half_space<2>(Vec2(kWidth, 0), Vec2(-1, 0), "right")};
  return scene;
}

template <int D>
SettingStudy::Overlap overlap_after(const Scene<D>& start, const StepSolver& solver,
                                    const std::function<bool()>& interrupted) {
  SettingStudy::Overlap overlap;
  State<D> state = initial_state(start);
  const SceneRun<D> run = run_scene<D>(start, state,
                                       {.steps = SettingStudy::Overlap::kSteps,
                                        .solver = solver,
                                        .on_tunnel = OnTunnel::kWarn,
                                        .cancelled = interrupted});
  if (run.end != SceneRun<D>::End::kCompleted) {
    overlap.end = run.failure ? run.failure->what() : "interrupted";
    return overlap;
  }
  Scene<D> end = start;
  end.bodies = state.bodies;
  const auto pairs = start_overlaps(end);
  overlap.largest = overlap.mean = 0;
  for (const StartOverlap<D>& pair : pairs) {
    const double depth = -pair.contact.gap / smallest_radius(start);
    overlap.largest = std::max(overlap.largest, depth);
    overlap.mean += depth / static_cast<double>(pairs.size());
  }
  return overlap;
}

template <int D>
void add_overlaps(const std::string& name, const Scene<D>& start,
                  const SettingStudy::Options& options, std::vector<SettingStudy::Overlap>& all) {
  const auto add = [&](const std::string& code, const StepSolver& solver) {
    all.push_back(overlap_after<D>(start, solver, options.watch.interrupted));
    all.back().code = code;
    all.back().scene = name;
  };
  add(SettingStudy::Overlap::kExact,
      make_step_solver(require_solver("auto"),
                       {.tol = kExactTol, .time_limit = options.time_limit}));
  for (const PopularSetting& setting : popular_settings()) {
    add(setting.code, popular_step_solver(setting, options));
  }
}

}  // namespace

std::vector<SettingStudy::Overlap> popular_overlaps(const SettingStudy::Options& options) {
  std::vector<SettingStudy::Overlap> all;
  const auto& stop = options.watch.interrupted;
  const Scene<2> disks = make_moving_scene("pour", 10, {.mu = 0.3});
  add_overlaps<2>("100 disks fall", flow_of(disks, 0.5, stop), options, all);
  add_overlaps<2>(SettingStudy::Overlap::kColumn, column_at_rest(), options, all);
  const Scene<3> spheres = make_moving_spheres("pour3d", 4, {.mu = 0.3});
  add_overlaps<3>("64 spheres fall", flow_of(spheres, 0.5, stop), options, all);
  return all;
}

}  // namespace bipot
