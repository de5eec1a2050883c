#pragma once

#include "bench/compare/comparison.h"

namespace bipot {

/// Solves that are measured once, with time enough; a folder keeps the rows.
inline Comparison::Options quick(std::vector<std::string> solvers, std::vector<double> tols,
                                 const std::filesystem::path& out = {}) {
  return Comparison::Options{.solvers = std::move(solvers),
                             .tols = std::move(tols),
                             .time_limit = 20,
                             .reference_time_limit = 20,
                             .min_time = 0,
                             .out = out};
}

}  // namespace bipot
