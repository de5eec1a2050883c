#include "core/scene/gates.h"

#include <fmt/format.h>

#include <cmath>

namespace bipot {
namespace {

bool is_positive(double x) { return std::isfinite(x) && x > 0; }

}  // namespace

template <int D>
std::string check_outlet(const Outlet<D>& outlet) {
  if (outlet.box) {
    const bool sound = outlet.lower.allFinite() && outlet.upper.allFinite() &&
                       (outlet.lower.array() < outlet.upper.array()).all();
    return sound ? "" : fmt::format("outlet '{}': its box has no inside", outlet.name);
  }
  const bool sound = outlet.point.allFinite() && std::abs(outlet.normal.norm() - 1) < 1e-12;
  return sound ? "" : fmt::format("outlet '{}': its normal is not a unit vector", outlet.name);
}

template <int D>
std::string check_inlet(const Inlet<D>& inlet, int materials) {
  const auto defect = [&](const std::string& what) {
    return fmt::format("inlet '{}': {}", inlet.name, what);
  };
  if (!is_positive(inlet.rate)) return defect(fmt::format("rate = {} is not > 0", inlet.rate));
  if (inlet.radii.empty() || inlet.shares.size() != inlet.radii.size()) {
    return defect("every class needs a radius and a share");
  }
  double sum = 0;
  for (std::size_t k = 0; k < inlet.radii.size(); ++k) {
    if (!is_positive(inlet.radii[k])) return defect("a radius is not a positive finite number");
    if (!(inlet.shares[k] >= 0)) return defect("a share is negative");
    sum += inlet.shares[k];
  }
  if (!is_positive(sum)) return defect("the shares are all zero");
  if (!is_positive(inlet.mass) && !is_positive(inlet.density)) return defect("it has no mass");
  if (!(inlet.inertia >= 0)) return defect("its inertia is negative");
  const double largest = *std::max_element(inlet.radii.begin(), inlet.radii.end());
  const bool finite = inlet.lower.allFinite() && inlet.upper.allFinite() && inlet.v.allFinite();
  if (!finite || !((inlet.upper - inlet.lower).minCoeff() >= 2 * largest)) {
    return defect(fmt::format("its box has no room for a body of radius {} m", largest));
  }
  if (inlet.material < 0 || inlet.material >= materials) {
    return defect(fmt::format("material index {} is not in [0, {})", inlet.material, materials));
  }
  if (!(inlet.starts >= 0) || !(inlet.stops > inlet.starts)) {
    return defect(
        fmt::format("starts = {} s (>= 0), stops = {} s (> starts)", inlet.starts, inlet.stops));
  }
  return {};
}

template std::string check_outlet(const Outlet<2>&);
template std::string check_outlet(const Outlet<3>&);
template std::string check_inlet(const Inlet<2>&, int);
template std::string check_inlet(const Inlet<3>&, int);

}  // namespace bipot
