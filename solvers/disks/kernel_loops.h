#pragma once

// What the kernels of disks and those of spheres have in common. Both define
// sweep_symmetric() and project() for their bodies; DiskKernels are made of these.

#include "solvers/disks/lanes.h"

namespace bipot {
namespace {

/// kOuter: starts from y in the forward sweep, computes sums at the end of the backward sweep.
/// kRelaxed: omega is not 1.
template <int D, bool kBack, bool kOuter, bool kRelaxed>
void sweep_symmetric(const SymmetricTask<D>& task, Lanes* turn);
template <int D, GradientMap kMap>
void project(const GradientTask<D>& task, GradientSums& sums);

/// Runs solve(batch, part, motion) -> wrench over all parts of the batches from `first` to before
/// `last`, downwards with kBack. In program order the bodies of a part are read before the previous
/// part writes to its own. The processor can then work on both at once. They share no body: neither
/// do the lanes of a batch nor two consecutive batches.
template <bool kBack, class Bodies, class Batch, class Solve>
[[gnu::always_inline]] inline void for_parts(const Bodies& bodies, const Batch* contact, int first,
                                             int last, const Solve& solve) {
  typename Bodies::Motion wrench{};
  const unsigned *i_before = nullptr, *j_before = nullptr;
  const int batches = last - first, step = kBack ? -1 : 1;
  int k = kBack ? last - 1 : first;
  for (int n = 0; n < batches; ++n, k += step) {
#pragma GCC unroll 4
    for (int part = 0; part < kParts; ++part) {
      const unsigned* const i = contact[k].i + part * kWidth;
      const unsigned* const j = contact[k].j + part * kWidth;
      const typename Bodies::Motion motion = bodies.gathered(i, j);
      if (part > 0 || n > 0) bodies.add(wrench, i_before, j_before);
      wrench = solve(k, part, motion);
      i_before = i;
      j_before = j;
    }
  }
  if (batches > 0) bodies.add(wrench, i_before, j_before);
}

/// Prefetching of a symmetric sweep. Lists from memory are prefetched. Hardware does not predict
/// the bodies of batches in descending order: rows are prefetched as the task lists them.
template <bool kBack, bool kOuter, int D>
struct SymmetricPrefetch {
  int share, coming = 0;

  explicit SymmetricPrefetch(const SymmetricTask<D>& a) {
    const int batches = a.last_batch - a.first_batch;
    share = batches > 0 ? (a.num_coming + batches - 1) / batches : 0;
  }
  [[gnu::always_inline]] void operator()(const SymmetricTask<D>& a, int k, int part) {
    if (part != 0 || !a.ask_ahead) return;
    const int ahead = kBack ? k - kAhead : k + kAhead;
    prefetch_item(a.contact, ahead);
    prefetch_item(a.next, ahead);
    if constexpr (kOuter) {
      prefetch_item(a.now, ahead);
      prefetch_item(a.before, ahead);
    }
    if constexpr (kBack) {
      const int end = coming + share < a.num_coming ? coming + share : a.num_coming;
      for (; coming < end; ++coming) {
        prefetch(at(a.velocity, a.coming[coming]));
        if constexpr (!kOfSpheres<D>) prefetch(at(a.inverse, a.coming[coming]));
      }
    }
  }
};

/// Calls visit(window, end) for the windows of a step of the gradient.
template <int D, class Visit>
[[gnu::always_inline]] inline void for_windows(const GradientTask<D>& a, const Visit& visit) {
  for (const BodyBlock* window = a.begin; window != a.end;) {
    const auto left = a.end - window;
    const BodyBlock* const end = window + (left < kWindowBlocks ? left : kWindowBlocks);
    visit(window, end);
    window = end;
  }
}

template <int D>
void sweep_forth(const SymmetricTask<D>& task) {
  if (task.outer) return sweep_symmetric<D, false, true, true>(task, nullptr);
  if (task.omega == 1 && !kOfSpheres<D>)
    return sweep_symmetric<D, false, false, false>(task, nullptr);
  sweep_symmetric<D, false, false, true>(task, nullptr);
}
template <int D>
void sweep_back(const SymmetricTask<D>& task, TurnSums& sums) {
  if (!task.outer) return sweep_symmetric<D, true, false, true>(task, nullptr);
  Lanes turn[kParts];
  for (int part = 0; part < kParts; ++part) turn[part] = load(sums.turn, part);
  sweep_symmetric<D, true, true, true>(task, turn);
  for (int part = 0; part < kParts; ++part) store(sums.turn, part, turn[part]);
}

template <int D>
void gradient(const GradientTask<D>& task, GradientSums& sums) {
  if (task.map == GradientMap::kFollowed) {
    project<D, GradientMap::kFollowed>(task, sums);
  } else {
    project<D, GradientMap::kSplit>(task, sums);
  }
}

template <int D>
constexpr DiskKernels<D> kKernels = {&gradient<D>, &extrapolate_velocity, &sweep_forth<D>,
                                     &sweep_back<D>};

}  // namespace
}  // namespace bipot
