#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/types.h"

namespace bipot {

/// A line that mass may cross. Flux is positive to its left, seen from a to b.
struct FluxLine {
  std::string name;
  Vec2 a = Vec2::Zero(), b = Vec2::Zero();  ///< different                              [m]
};

/// Bins across one axis, equal in width.
struct ProfileChoice {
  int axis = 1;              ///< 0: bins along x, 1: along y
  int bins = 20;             ///< > 0
  double low = 0, high = 0;  ///< ends, low < high                                      [m]
};

/// What a run measures besides its ledger (core/observables); nothing where it is not asked for.
struct ObservableChoice {
  int every = 10;     ///< steps between measurements, > 0
  double starts = 0;  ///< averages begin here                                          [s]
  /// Rectangle that everything but flux is measured in; else the whole sample.         [m]
  std::optional<std::pair<Vec2, Vec2>> window;
  std::optional<ProfileChoice> profile;
  std::vector<FluxLine> lines;
  int force_bins = 30;  ///< of the distribution of normal forces, > 0
  double force_limit =
      6;  ///< its end, in mean forces, > 0; what is beyond is counted in the last bin
};

}  // namespace bipot
