// Cost of one step's detection and assembly (A, H, W) in a dense packing, against the number of
// disks. Rows: time, contacts, bytes of W; the complexity line fits the growth.

#include <benchmark/benchmark.h>

#include <cmath>

#include "core/motion/assembly.h"
#include "core/scene/contact_detection.h"
#include "core/scene/generators.h"
#include "core/scene/scene.h"
#include "core/scene/scene_parts.h"

namespace bipot {
namespace {

/// About `count` disks in a triangular lattice (six contacts each) in a box, with friction.
Scene<2> dense_packing(int count) {
  const int side = static_cast<int>(std::lround(std::sqrt(count)));
  Scene<2> scene{.gravity = Vec2(0, -9.81),
                 .bodies = triangular_lattice(side, side, 0.01, Vec2::Zero())};
  for (Disk& d : scene.bodies) give_mass(d, 1);
  const auto wall = [](const Vec2& a, const Vec2& normal) {
    return Wall<2>{.a = a, .normal = normal};
  };
  scene.walls = {wall(Vec2::Zero(), Vec2(0, 1)), wall(Vec2::Zero(), Vec2(1, 0)),
                 wall(Vec2(0.02 * side, 0), Vec2(-1, 0))};
  scene.materials = {"default"};
  scene.laws = {{.mu = 0.3, .e_n = 0.1, .e_t = 1.0}};
  scene.step = 1e-3;
  scene.contact_distance = 1e-8;
  return scene;
}

void detection(benchmark::State& state) {
  const Scene<2> scene = dense_packing(static_cast<int>(state.range(0)));
  std::size_t contacts = 0;
  for ([[maybe_unused]] auto _ : state) {
    contacts = detect_contacts(scene.bodies, scene.walls, scene.contact_distance).size();
  }
  state.counters["disks"] = static_cast<double>(scene.bodies.size());
  state.counters["contacts"] = static_cast<double>(contacts);
  state.SetComplexityN(static_cast<long>(scene.bodies.size()));
}

void assembly(benchmark::State& state) {
  const Scene<2> scene = dense_packing(static_cast<int>(state.range(0)));
  const auto contacts = detect_contacts(scene.bodies, scene.walls, scene.contact_distance);
  const std::vector<Vec2> v_free(scene.bodies.size(), scene.step * scene.gravity);
  const std::vector<double> wall_v_free(scene.walls.size(), 0.0);
  double nonzeros = 0, bytes = 0;
  for ([[maybe_unused]] auto _ : state) {
    const AssembledStep step =
        assemble_step(scene, scene.bodies, scene.walls, contacts, v_free, wall_v_free, true);
    const ContactProblem& p = step.problem;
    nonzeros = static_cast<double>(p.W.nonZeros());
    bytes = static_cast<double>(
        (p.A.nonZeros() + p.H.nonZeros() + p.W.nonZeros()) * (sizeof(double) + sizeof(int)) +
        (p.A.outerSize() + p.H.outerSize() + p.W.outerSize()) * sizeof(int));
  }
  state.counters["disks"] = static_cast<double>(scene.bodies.size());
  state.counters["contacts"] = static_cast<double>(contacts.size());
  state.counters["W_nonzeros"] = nonzeros;
  state.counters["bytes"] = bytes;
  state.counters["bytes_per_contact"] = bytes / static_cast<double>(contacts.size());
  state.SetComplexityN(static_cast<long>(scene.bodies.size()));
}

/// About `count` spheres in a face-centred packing (six contacts each) on a floor, with friction.
Scene<3> dense_spheres(int count) {
  const int side = static_cast<int>(std::lround(std::cbrt(count)));
  Scene<3> scene{.gravity = Vec3(0, 0, -9.81)};
  // Square layers, each sphere in the hollow of four below.
  const double radius = 0.01;
  for (int k = 0; k < side; ++k) {
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i) {
        Sphere s;
        s.x = radius * Vec3(2 * i + k % 2, 2 * j + k % 2, 1 + k * std::sqrt(2.0));
        s.radius = radius;
        give_mass(s, 1);
        scene.bodies.push_back(s);
      }
    }
  }
  scene.walls.resize(1);
  scene.materials = {"default"};
  scene.laws = {{.mu = 0.3, .e_n = 0.1, .e_t = 1.0}};
  scene.step = 1e-3;
  scene.contact_distance = 1e-8;
  return scene;
}

/// Detection and assembly (A, H) of a step, on one thread.
void sphere_step(benchmark::State& state) {
  const Scene<3> scene = dense_spheres(static_cast<int>(state.range(0)));
  const std::vector<Vec3> v_free(scene.bodies.size(), scene.step * scene.gravity);
  const std::vector<double> wall_v_free(scene.walls.size(), 0.0);
  std::size_t contacts = 0;
  for ([[maybe_unused]] auto _ : state) {
    const auto found = detect_contacts<3>(scene.bodies, scene.walls, scene.contact_distance);
    contacts = found.size();
    benchmark::DoNotOptimize(assemble_step(scene, scene.bodies, scene.walls, found, v_free,
                                           wall_v_free, state.range(1) != 0));
  }
  state.counters["spheres"] = static_cast<double>(scene.bodies.size());
  state.counters["contacts"] = static_cast<double>(contacts);
}

BENCHMARK(sphere_step)->Args({100000, 0})->Args({100000, 1})->Unit(benchmark::kMillisecond);
BENCHMARK(detection)
    ->Arg(1000)
    ->Arg(10000)
    ->Arg(100000)
    ->Unit(benchmark::kMillisecond)
    ->Complexity();
BENCHMARK(assembly)
    ->Arg(1000)
    ->Arg(10000)
    ->Arg(100000)
    ->Unit(benchmark::kMillisecond)
    ->Complexity();

}  // namespace
}  // namespace bipot

BENCHMARK_MAIN();
