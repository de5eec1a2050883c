#pragma once

#include <string>

#include "core/base/types.h"
#include "core/problem/contact_problem.h"

namespace bipot {

/// A problem for tests of solvers, with data that the problem itself does not contain.
struct TestProblem {
  std::string origin;  ///< one sentence: file, or scene, step and seed
  ContactProblem problem;
  Vector start;            ///< impulse from which a run starts its solver; empty: unknown  [N s]
  double step = kNaN;      ///< h, NaN if unknown      [s]
  std::size_t bodies = 0;  ///< 0 if unknown
  double smallest_radius = kNaN;  ///< of the disks, NaN likewise                   [m]
};

}  // namespace bipot
