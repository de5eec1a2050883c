#pragma once

#include <span>
#include <vector>

#include "core/problem/contact_problem.h"

namespace bipot {

/// A part of a problem as a problem of its own.
struct IslandProblem {
  ContactProblem problem;
  std::vector<int> rows;  ///< for each row of `problem`: the row of the whole

  /// Values of the whole in the rows of the part. Empty stays empty.
  Vector gather(const Vector& whole) const;
  /// The inverse. Rows of contacts that the part does not have (tangents if nothing has friction)
  /// are set to 0.
  void scatter(const Vector& part, int whole_dim, Vector& whole) const;
};

/// Cuts parts out of one problem.
class IslandCutter {
 public:
  /// Keeps a reference to the problem.
  explicit IslandCutter(const ContactProblem& whole);
  explicit IslandCutter(ContactProblem&&) = delete;  // would dangle

  /// The problem of these contacts (ascending), which must be an island of contact_islands(). Its
  /// degrees of freedom are those in which its columns of H have stored entries, zeros included, so
  /// that rows of a body stay together, and those that A couples with them; order as in the whole.
  /// Without friction d = 1. W is cut if the whole has it. Cost: linear in the part.
  IslandProblem operator()(std::span<const int> contacts);

 private:
  std::vector<int> number_dofs(const std::vector<int>& rows);
  void cut_delassus(std::span<const int> contacts, IslandProblem& island);

  const ContactProblem& whole_;
  bool diagonal_ = true;
  std::vector<int> dof_;      // number in the island being cut, else -1
  std::vector<int> contact_;  // the same for contacts
};

}  // namespace bipot
