#pragma once

#include <string>

#include "core/base/types.h"
#include "core/problem/contact_problem.h"

namespace bipot {

/// A problem that solvers are tried on, with what the problem itself does not say.
struct TestProblem {
  std::string origin;  ///< one sentence: file, or scene, step and seed
  ContactProblem problem;
  Vector start;        ///< impulse that a run starts its solver from; empty: none is known  [N s]
  double step = kNaN;  ///< h, NaN where the source does not say it      [s]
  double smallest_radius = kNaN;  ///< of the disks, NaN likewise                   [m]
};

}  // namespace bipot
