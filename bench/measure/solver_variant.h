#pragma once

#include <map>
#include <string>

namespace bipot {

/// A solver with its parameters, under a name for readers.
struct SolverVariant {
  std::string label, solver;
  std::map<std::string, std::string> parameters = {};
};

}  // namespace bipot
