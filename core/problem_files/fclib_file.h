#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "core/problem_files/problem_file.h"

namespace bipot {

/// FCLIB's HDF5 layout (Acary, Brémond, Koziara, Pérignon, FCLIB: a collection of discrete 3D
/// frictional contact problems, 2014). It holds one problem, local (W, q, mu) or global (M, H, f,
/// w, mu), of spacedim 2 or 3, with an optional /solution and optional /guesses. Sparse matrices
/// are stored by rows (nz = -2), by columns (-1) or as nz triplets, where `i` is the row and `p`
/// the column. Duplicates are summed. Order and explicit zeros do not matter. Arrays may be longer
/// than used.
///
/// Data that FCLIB cannot express are in a group of its own, which other readers ignore:
///   /bipot/row_scale  r = sqrt(1 + e) of each row, if ContactProblem has one. W, q and mu of the
///                     file are those of the scaled problem, which is itself a problem of FCLIB's
///                     kind;
///   /bipot/dim        1 for a frictionless problem. FCLIB has no such form: it is written with
///                     spacedim 2, mu = 0 and tangential rows that nothing else depends on, with
///                     W_tt = W_nn. In a global problem, an extra degree of freedom of mass
///                     1/W_nn for each contact, after the others, has this effect;
///   /bipot/dofs       number of degrees of freedom of a global problem with dim = 1, without
///                     these;
///   /bipot/lenient    there where equality rows may block contacts along their normal.
///
/// Equality rows of a global problem, M v = H r + G λ + f with Gᵀ v + b = 0 in the file's signs, are
/// eliminated (with_equality_rows()). /solution/l holds λ. Those of a local problem (V, R, s) are
/// eliminated for good (problem_form.h): it is then one of W and q alone.
///
/// A problem with rolling friction is not of FCLIB's kind. It stands in /bipot_local or
/// /bipot_global, which other readers refuse, with spacedim 3 (plane) or 6 (space) as the rows of a
/// contact, and with vectors/mu_r, and vectors/mu_spin in space.
///
/// Refused, with the reason: inconsistent sizes, missing data, values that are not finite, and
/// whatever validate() refuses. Throws FileError.
ProblemFile read_fclib(const std::filesystem::path& path);

/// Writes a new file, in global form if A and H are given (W is then not stored), else in local
/// form; with equality rows the problem as it was given, G and b. The information becomes
/// /fclib_*/info. The problem must be sound. Each guess (an impulse r to start from) is written into
/// /guesses with its u (and v).
void write_fclib(const std::filesystem::path& path, const ContactProblem& problem,
                 const ProblemInfo& info, const std::vector<Vector>& guesses = {});

/// Writes /solution of an existing problem file and replaces an earlier one. r and u are in the
/// problem's variables. v: velocities of a global problem, by default computed from r. l is computed
/// too.
void write_fclib_solution(const std::filesystem::path& path, const Vector& r, const Vector& u,
                          const std::optional<Vector>& v = std::nullopt);

}  // namespace bipot
