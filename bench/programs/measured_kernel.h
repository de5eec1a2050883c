#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "bench/measure/kernel_work.h"
#include "bench/problems/sphere_problems.h"
#include "core/motion/time_stepping.h"
#include "core/problem/delassus.h"
#include "core/scene/scene_family.h"
#include "solvers/disks/rolling_bodies.h"
#include "solvers/disks/symmetric_sweep.h"
#include "solvers/disks/tiled_gradient.h"
#include "solvers/disks/tiled_sweep.h"
#include "solvers/kernels/contact_sweep.h"
#include "solvers/kernels/spectral_estimate.h"

namespace bipot {

/// A problem of disks (also kRollingDisks) or spheres with friction, and the data that the kernels
/// need.
template <int D>
struct PackedProblem {
  ContactProblem problem;
  DelassusOperator delassus;
  ContactScaling scaling;
  double lambda;
  std::optional<DiskStructure> rolling;

  explicit PackedProblem(ContactProblem given)
      : problem(std::move(given)),
        delassus(problem),
        scaling(equilibrated_scaling(problem, delassus.diagonal())),
        lambda(kSpectralMargin * largest_eigenvalue()),
        rolling(rolling_bodies<kRollingDisks>(problem)) {
    if (D == kRollingDisks ? !rolling : !delassus.is_packed() || problem.dim != D) {
      throw std::invalid_argument("not disks or spheres with friction");
    }
  }
  const BodiesOf<D>& bodies() const {
    if constexpr (D == kRollingDisks) {
      return *rolling;
    } else {
      return *delassus.template bodies<D>();
    }
  }
  Vector start() const { return Vector::Zero(problem.num_rows()); }
  double largest_eigenvalue() const {
    WholeSpace space(problem);
    return spectral_estimate(space, scaling.velocity);
  }
  double bodies_per_contact() const {
    return static_cast<double>(bodies().surroundings()) / problem.num_contacts();
  }
};

/// Disks of a scene.
struct Packing : PackedProblem<2> {
  Scene<2> scene;
  State<2> state;

  explicit Packing(const Scene<2>& given)
      : PackedProblem(step_problem(given, initial_state(given), false)),
        scene(given),
        state(initial_state(scene)) {}
};

/// What `make` makes for a family at a side; shared while in use.
template <class Packed, class Make>
std::shared_ptr<const Packed> shared_packing(const std::string& family, int side,
                                             const Make& make) {
  static std::map<std::pair<std::string, int>, std::weak_ptr<const Packed>> cache;
  auto& slot = cache[{family, side}];
  std::shared_ptr<const Packed> made = slot.lock();
  if (!made) slot = made = std::make_shared<const Packed>(make());
  return made;
}

/// A family, tilted by 10°.
inline std::shared_ptr<const Packing> tilted_packing(const std::string& family, int side) {
  return shared_packing<Packing>(
      family, side, [&] { return make_family_scene(family, side, {.tilt_degrees = 10}); });
}

/// The same with rolling friction of a twentieth of a radius.
inline std::shared_ptr<const PackedProblem<kRollingDisks>> tilted_rolling_packing(
    const std::string& family, int side) {
  return shared_packing<PackedProblem<kRollingDisks>>(family, side, [&] {
    Scene<2> scene = make_family_scene(family, side, {.tilt_degrees = 10});
    for (ContactLaw& law : scene.laws) law.mu_r = 0.025;
    return step_problem(scene, initial_state(scene), false);
  });
}

/// A family of sphere_problems.h, tilted by 10°.
inline std::shared_ptr<const PackedProblem<3>> tilted_spheres(const std::string& family, int side) {
  return shared_packing<PackedProblem<3>>(family, side,
                                          [&] { return sphere_family(family, side, 0.3, 10); });
}

/// Iterations of a kernel over all contacts, for measurements. Refers to its packing.
struct MeasuredKernel {
  double contacts = 0;
  int iterations = 0;  ///< of one call
  KernelWork work;     ///< a contact and iteration
  std::function<void()> call;
};

/// Iterations of one call, as many as solvers do between two judgements.
inline constexpr int kTogether = 32;

inline MeasuredKernel given_order_sweep(const Packing& p) {
  auto sweep = std::make_shared<DiskSweep<2>>(p.problem, *p.delassus.disks());
  const Vector diagonal = p.delassus.diagonal();
  sweep->reset(p.start());
  for (int c = 0; c < p.problem.num_contacts(); ++c) {
    const Local<2> w = diagonal.segment<2>(2 * c);
    sweep->set_steps(c, w.cwiseInverse(), p.problem.mu[c]);
  }
  const int contacts = p.problem.num_contacts();
  return {static_cast<double>(contacts), kTogether, given_order_sweep_work(p.bodies_per_contact()),
          [sweep, contacts] {
            for (int k = 0; k < kTogether; ++k) {
              for (int c = 0; c < contacts; ++c) sweep->relax(c);
            }
          }};
}

template <int D>
MeasuredKernel tiled_sweep(const PackedProblem<D>& p, const Execution& execution) {
  auto sweep = std::make_shared<TiledSweep<D>>(p.problem, p.bodies(), p.scaling, 1, execution);
  sweep->reset(p.start());
  return {static_cast<double>(p.problem.num_contacts()), kTogether,
          D == kRollingDisks ? KernelWork{} : tiled_sweep_work<D>(p.bodies_per_contact()),
          [sweep] { sweep->advance(kTogether); }};
}

template <int D>
MeasuredKernel tiled_gradient(const PackedProblem<D>& p, const Execution& execution) {
  auto gradient = std::make_shared<TiledGradient<D>>(p.problem, p.bodies(), p.scaling, execution);
  gradient->reset(p.start());
  GradientKernel::Control control{.lambda = p.lambda};
  return {static_cast<double>(p.problem.num_contacts()), kTogether,
          D == kRollingDisks ? KernelWork{} : gradient_work<D>(p.bodies_per_contact()),
          [gradient, control]() mutable { gradient->advance(kTogether, control); }};
}

/// An iteration of `assor` with two sweeps each way, momentum left out.
template <int D>
MeasuredKernel symmetric_sweep(const PackedProblem<D>& p, const Execution& execution) {
  auto sweep =
      std::make_shared<SymmetricSweep<D>>(p.problem, p.bodies(), p.scaling, 1, 2, execution);
  sweep->reset(p.start());
  return {static_cast<double>(p.problem.num_contacts()), kTogether, {}, [sweep] {
            for (int k = 0; k < kTogether; ++k) sweep->iterate(0);
          }};
}

}  // namespace bipot
