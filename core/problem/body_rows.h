#pragma once

#include <optional>

#include "core/problem/contact_problem.h"

namespace bipot {

/// Rows of H that are forces on bodies. First come `bodies` rigid bodies, each with its
/// translations first; then single translations (driven walls).
struct BodyRows {
  int bodies = 0, per_body = 0, translations = 0, walls = 0;
};

/// Rows for each body, by plain_dim(): 2 for d = 1 (x, y; 3 with clusters), 3 for d = 2 (x, y, spin), 6 for d = 3.
/// Empty if the columns of the normals do not have unit forces in these places: H is then of
/// another kind.
std::optional<BodyRows> find_body_rows(const ContactProblem& problem);

}  // namespace bipot
