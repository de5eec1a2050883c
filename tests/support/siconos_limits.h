#pragma once

#include <set>
#include <string>

namespace bipot {

/// What Siconos' solvers do by themselves, whoever calls them.

/// They iterate in calls that cannot be cut without another path, and ask nobody for an end there.
inline const std::set<std::string> kDeafInACall = {"siconos:nsn_ac", "siconos:admm", "siconos:prox",
                                                   "siconos:lemke"};

/// Rounding decides on their line searches and pivots: data that differ by 1e-15 take a different
/// number of iterations.
inline const std::set<std::string> kDecidedByRounding = {"siconos:nsn_ac", "siconos:lemke"};

}  // namespace bipot
