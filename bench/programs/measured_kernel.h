#pragma once

#include <fmt/format.h>

#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "bench/measure/kernel_work.h"
#include "core/motion/time_stepping.h"
#include "core/problem/delassus.h"
#include "core/scene/scene_family.h"
#include "solvers/disks/tiled_gradient.h"
#include "solvers/disks/tiled_sweep.h"
#include "solvers/kernels/contact_sweep.h"
#include "solvers/kernels/spectral_estimate.h"

namespace bipot {

/// One packing and the data that the kernels need.
struct Packing {
  Scene<2> scene;
  State<2> state;
  ContactProblem problem;
  DelassusOperator delassus;
  ContactScaling scaling;
  double lambda;

  explicit Packing(Scene<2> given)
      : scene(std::move(given)),
        state(initial_state(scene)),
        problem(step_problem(scene, state, false)),
        delassus(problem),
        scaling(equilibrated_scaling(problem, delassus.diagonal())),
        lambda(kSpectralMargin * largest_eigenvalue()) {
    if (!delassus.disks() || problem.dim != 2) {
      throw std::invalid_argument("not disks with friction");
    }
  }
  Vector start() const { return Vector::Zero(problem.num_rows()); }
  double largest_eigenvalue() const {
    WholeSpace space(problem);
    return spectral_estimate(space, scaling.velocity);
  }
  double bodies_per_contact() const {
    return static_cast<double>(delassus.disks()->surroundings()) / problem.num_contacts();
  }
};

/// A family at a side, tilted by 10°; shared while in use.
inline std::shared_ptr<const Packing> tilted_packing(const std::string& family, int side) {
  static std::map<std::pair<std::string, int>, std::weak_ptr<const Packing>> cache;
  auto& slot = cache[{family, side}];
  std::shared_ptr<const Packing> made = slot.lock();
  if (!made) {
    FamilyOptions options{.tilt_degrees = 10};
    made = std::make_shared<const Packing>(make_family_scene(family, side, options));
    slot = made;
  }
  return made;
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

inline MeasuredKernel tiled_sweep(const Packing& p, const Execution& execution) {
  auto sweep =
      std::make_shared<TiledSweep<2>>(p.problem, *p.delassus.disks(), p.scaling, 1, execution);
  sweep->reset(p.start());
  return {static_cast<double>(p.problem.num_contacts()), kTogether,
          tiled_sweep_work(p.bodies_per_contact()), [sweep] { sweep->advance(kTogether); }};
}

inline MeasuredKernel tiled_gradient(const Packing& p, const Execution& execution) {
  auto gradient =
      std::make_shared<TiledGradient<2>>(p.problem, *p.delassus.disks(), p.scaling, execution);
  gradient->reset(p.start());
  GradientControl control{.lambda = p.lambda};
  return {static_cast<double>(p.problem.num_contacts()), kTogether,
          gradient_work(p.bodies_per_contact()),
          [gradient, control]() mutable { gradient->advance(kTogether, control); }};
}

}  // namespace bipot
