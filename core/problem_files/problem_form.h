#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/problem/contact_problem.h"

namespace bipot {

/// Description of a problem in its file.
struct ProblemInfo {
  std::string title;
  std::string description;  ///< provenance: scene, step, program version
  std::string math_info;    ///< known properties: existence, uniqueness, rank
};

/// A problem from a file, with the reference solution if the file has one.
struct ProblemFile {
  ContactProblem problem;
  bool global = false;          ///< given as (M, H, f, w), else as (W, q)
  std::optional<Vector> r, u;   ///< reference solution, the problem's variables      [N s], [m/s]
  std::optional<Vector> v;      ///< body velocities of the reference, global problems only
  std::vector<Vector> guesses;  ///< impulses to start from, the problem's variables     [N s]
  ProblemInfo info;
};

/// The local form W r + q of other codes. Explicit zeros are dropped. W remains as it is, even if
/// rounding has made it unsymmetric. Throws std::invalid_argument for an unsound problem.
ContactProblem from_local_form(int dim, const SparseRows& W, Vector q, Vector mu);

/// The global form M v = H r + f, u = Hᵀ v + w. Hence A = M, v_free = M⁻¹ f, u_free = Hᵀ v_free +
/// w. For a diagonal M, W stays empty (two passes through H are cheaper); else it is assembled.
/// Throws std::invalid_argument for an unsound problem.
ContactProblem from_global_form(int dim, const SparseMatrix& M, const SparseMatrix& H,
                                const Vector& f, const Vector& w, Vector mu);

}  // namespace bipot
