#pragma once

#include <span>
#include <vector>

#include "core/scene/cell.h"
#include "core/scene/scene.h"

namespace bipot {

/// Pairs of bodies that may come near each other, kept while the bodies stay near their places. In
/// a periodic cell body i is near an image of body j. Pairs are those of detection: not of one
/// cluster, not of two glued bodies.
template <int D>
class NearPairs {
 public:
  struct Pair {
    int i, j;
    int image_x, image_y;  ///< as of Contact
  };

  /// All pairs whose gap is at most ways[i] + ways[j] + image_way, and others; sorted by (i, j).
  /// `ways`: of the bodies, relative to any motion that all have. `image_way`: of images against
  /// the bodies of their cells; 0 without a cell. [m] Throws as detection does.
  const std::vector<Pair>& within(std::span<const Body<D>> bodies, const PeriodicCell& cell,
                                  std::span<const double> ways, double image_way, int threads);
  /// To be called where bodies came or went.
  void forget() { places_.clear(); }

  /// Beyond this way of a body two of its images might be near another one; infinite without a
  /// cell. `longest_body`: two diameters, or the length of a cluster.                       [m]
  static double longest_way(const PeriodicCell& cell, double longest_body);
  /// Images are at most that many widths of the cell away from a body in it.
  static int most_widths(const PeriodicCell& cell);

 private:
  bool hold(std::span<const Body<D>> bodies, const PeriodicCell& cell, std::span<const double> ways,
            double image_way) const;

  struct Place {
    Vec<D> x;  // in the cell of that number
    CellNumber number;
    double radius, room;
  };
  std::vector<Pair> pairs_;
  std::vector<Place> places_;  // at the search
  PeriodicCell cell_;
  double image_room_ = 0;
};

}  // namespace bipot
