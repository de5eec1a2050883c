#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "core/base/types.h"
#include "core/scene/contact_frame.h"

namespace bipot {

/// Region where bodies leave the scene: a half-plane (in 3D a half-space), or a box along the axes.
/// A body whose centre lies in it at the end of a step is removed before the next one; likewise one
/// whose way from mid-step to mid-step goes through a box that is thinner.
template <int D>
struct Outlet {
  std::string name;
  bool box = false;
  Vec<D> point = Vec<D>::Zero();        ///< half-planes: on the edge                 [m]
  Vec<D> normal = Vec<D>::Unit(D - 1);  ///< half-planes: unit, out of the outlet
  Vec<D> lower = Vec<D>::Zero(),
         upper = Vec<D>::Zero();  ///< boxes, edges included                    [m]

  bool takes(const Vec<D>& x) const {
    if (!box) return normal.dot(x - point) <= 0;
    return (x.array() >= lower.array()).all() && (x.array() <= upper.array()).all();
  }
  /// The same for a centre that moves from x - way to x + way.                      [m]
  bool takes(const Vec<D>& x, const Vec<D>& way) const {
    if (takes(x)) return true;
    if (!box || (2 * way.cwiseAbs().array() <= (upper - lower).array()).all()) return false;
    double enters = -1, leaves = 1;  // x + t way
    for (int k = 0; k < D; ++k) {
      if (way[k] == 0 && (x[k] < lower[k] || x[k] > upper[k])) return false;
      if (way[k] == 0) continue;
      const double a = (lower[k] - x[k]) / way[k], b = (upper[k] - x[k]) / way[k];
      enters = std::max(enters, std::min(a, b));
      leaves = std::min(leaves, std::max(a, b));
    }
    return enters <= leaves;
  }
};

/// Source of bodies: the k-th (k = 0, 1, ...) is due at starts + k / rate. It appears, with the
/// given velocity, at a random place of the box that is free. If none is found it waits for the
/// next step, and so do all bodies after it. Random numbers depend on the seed, k and the step
/// alone.
template <int D>
struct Inlet {
  std::string name;
  Vec<D> lower = Vec<D>::Zero(),
         upper = Vec<D>::Zero();  ///< bodies appear wholly inside              [m]
  double rate = 0;                ///< > 0                                     [1/s]
  std::vector<double> radii;      ///< one of each class, > 0                   [m]
  std::vector<double> shares;     ///< probability of each class, relative
  double mass = 0;                ///< of each body; 0: by density             [kg]
  double density = 0;             ///< where no mass is given     [kg/m³]
  double inertia = 0;             ///< of each body; 0: homogeneous         [kg m²]
  Vec<D> v = Vec<D>::Zero();      ///< [m/s]
  Spin<D> spin = no_turn<D>();    ///< [rad/s]
  int material = 0;
  int seed = 1;
  int count = -1;            ///< largest number; -1: no limit
  double starts = 0;         ///< [s]
  double stops = kInfinity;  ///< from then on nothing comes, not even bodies that wait [s]
};

/// Empty for sound gates, else one sentence that names the entry and its value.
template <int D>
std::string check_outlet(const Outlet<D>& outlet);
template <int D>
std::string check_inlet(const Inlet<D>& inlet, int materials);

}  // namespace bipot
