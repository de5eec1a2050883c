#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/types.h"
#include "core/problem/contact_problem.h"

namespace bipot {

/// A Problem in Python: sound and constant, so that arrays can refer to it and solves can run on it
/// beside Python code.
struct PythonProblem {
  std::shared_ptr<const ContactProblem> problem;
  std::string name;             ///< for readers; empty: none
  std::string caution;          ///< why W is no Delassus operator, if that was accepted
  Vector solution;              ///< reference of the file that it was read from; empty: none
  std::vector<Vector> guesses;  ///< likewise, impulses to start from
  Vector restitution;           ///< of each row, where it was given with physical data; else empty

  PythonProblem() = default;  ///< the problem is to be set
  explicit PythonProblem(std::shared_ptr<const ContactProblem> p) : problem(std::move(p)) {}
  explicit PythonProblem(ContactProblem p, std::string called = {})
      : problem(std::make_shared<const ContactProblem>(std::move(p))), name(std::move(called)) {}
};

}  // namespace bipot
