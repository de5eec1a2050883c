#pragma once

#include <filesystem>
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
  bool global = false;          ///< given as (M, H, f, w, G, b), else as (W, q)
  std::optional<Vector> r, u;   ///< reference solution, the problem's variables      [N s], [m/s]
  std::optional<Vector> v;      ///< body velocities of the reference, global problems only
  std::vector<Vector> guesses;  ///< impulses to start from, the problem's variables     [N s]
  ProblemInfo info;
  std::string caution;  ///< why W is no Delassus operator, if that was accepted
};

/// Reads an FCLIB HDF5 file or a Siconos text file; the content decides, not the name. Throws
/// FileError with the reason if the file cannot be read, fails Hdf5File::check_structure(), or if the
/// problem is not sound. Likewise if W is no Delassus operator (delassus_defect()), unless
/// `accept_indefinite`: then `caution` says why.
ProblemFile read_problem(const std::filesystem::path& path, bool accept_indefinite = false);

}  // namespace bipot
