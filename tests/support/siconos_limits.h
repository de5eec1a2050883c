#pragma once

#include <set>
#include <string>
#include <string_view>
#include <utility>

namespace bipot {

/// What Siconos' solvers do by themselves, whoever calls them.

/// They iterate in calls that cannot be cut without another path, and ask nobody for an end there.
inline const std::set<std::string> kDeafInACall = {"siconos:nsn_ac", "siconos:admm", "siconos:prox",
                                                   "siconos:lemke"};

/// Rounding decides on their line searches and pivots: data that differ by 1e-15 take a different
/// number of iterations.
inline const std::set<std::string> kDecidedByRounding = {"siconos:nsn_ac", "siconos:lemke"};

/// Problems of tests that end as stalled. Degenerate vertices lead lemke's pivots to no solution; the
/// others divide by the mobility along the tangent, which is 0 on a guide.
inline bool is_beyond_siconos(std::string_view solver, std::string_view problem) {
  static const std::set<std::pair<std::string_view, std::string_view>> beyond = {
      {"siconos:lemke", "pyramid"},
      {"siconos:lemke", "four bars"},
      {"siconos:lemke", "impacts"},
      {"siconos:nsgs", "guide"},
      {"siconos:nsn_ac", "guide"}};
  return beyond.contains({solver, problem});
}

}  // namespace bipot
