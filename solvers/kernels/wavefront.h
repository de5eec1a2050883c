#pragma once

#include <algorithm>
#include <vector>

#include "core/parallel.h"

namespace bipot {

/// Calls task(k, t) for all iterations k < `iterations` and tiles t < `tiles`, in an order in which
/// every (k, t) comes after (k, t - 1) and (k - 1, t + 1): in wave w the pairs with t + 2 k = w, at
/// the same time on several threads. With ContactTiles (contact_tiles.h) the pairs of a wave share
/// no body, and the result is that of the plain loops over k and t, bit for bit. What an iteration
/// has in the cache serves the next ones too.
template <class Task>
void run_wavefront(int threads, int tiles, int iterations, const Task& task) {
  const int waves = tiles > 0 ? tiles + 2 * (iterations - 1) : 0;
  std::vector<int> first(static_cast<std::size_t>(waves)), last(first);
  for (int w = 0; w < waves; ++w) {
    first[static_cast<std::size_t>(w)] = w < tiles ? 0 : (w - tiles) / 2 + 1;
    last[static_cast<std::size_t>(w)] = std::min(iterations - 1, w / 2) + 1;
  }
  const auto call = [&](int w, int k) { task(k, w - 2 * k); };
  run_phases(threads, waves, first.data(), last.data(), call);
}

}  // namespace bipot
