#pragma once

#include <optional>

#include "core/problem/contact_problem.h"

namespace bipot {

/// Which rows of H are the forces on a body: those of `bodies` rigid bodies, each with its
/// translations first, then those of single translations (driven walls).
struct BodyRows {
  int bodies = 0, per_body = 0, translations = 0, walls = 0;
};

/// 2 rows a body for d = 1 (x, y; 3 where there are clusters), 3 for d = 2 (x, y, spin), 6 for
/// d = 3. Nothing where the columns of the normals do not have unit forces in these places, that is
/// where H is of another kind.
std::optional<BodyRows> find_body_rows(const ContactProblem& problem);

}  // namespace bipot
