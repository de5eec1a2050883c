#include "core/problem/body_rows.h"

#include <cmath>
#include <vector>

namespace bipot {
namespace {

/// True if each normal pushes one body or two with unit forces, for bodies laid out as `rows` says.
bool has_unit_normals(const ContactProblem& p, const BodyRows& rows) {
  for (int c = 0; c < p.num_contacts(); ++c) {
    const double scale = p.row_scale.size() != 0 ? p.row_scale[c * p.dim] : 1.0;
    int body = -1;
    double squared = 0;
    const auto is_unit = [&] { return body < 0 || std::abs(std::sqrt(squared) - 1) < 1e-6; };
    for (SparseMatrix::InnerIterator it(p.H, c * p.dim); it; ++it) {
      const int row = static_cast<int>(it.row());
      if (row >= rows.bodies * rows.per_body) break;
      if (row / rows.per_body != body) {
        if (!is_unit()) return false;
        body = row / rows.per_body;
        squared = 0;
      }
      if (row % rows.per_body < rows.translations) squared += std::pow(scale * it.value(), 2);
    }
    if (body < 0 || !is_unit()) return false;
  }
  return true;
}

}  // namespace

std::optional<BodyRows> find_body_rows(const ContactProblem& p) {
  if (!p.has_velocities()) return std::nullopt;
  const int d = p.plain_dim();
  // Clusters turn even without friction, unlike single disks.
  for (const int per_body : d == 1 ? std::vector{2, 3} : std::vector{d == 2 ? 3 : 6}) {
    const auto found = read_with_walls(p.num_dofs(), per_body, [&](int walls) {
      const BodyRows rows{.bodies = (p.num_dofs() - walls) / per_body,
                          .per_body = per_body,
                          .translations = d == 1 ? 2 : d,
                          .walls = walls};
      return has_unit_normals(p, rows) ? std::optional(rows) : std::nullopt;
    });
    if (found) return found;
  }
  return std::nullopt;
}

}  // namespace bipot
