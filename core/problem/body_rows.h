#pragma once

#include <algorithm>
#include <optional>

#include "core/problem/contact_problem.h"

namespace bipot {

/// Rows of H that are forces on bodies. First come `bodies` rigid bodies, each with its
/// translations first; then single translations (driven walls).
struct BodyRows {
  int bodies = 0, per_body = 0, translations = 0, walls = 0;
};

/// The body or wall that owns a row: `bodies` of kPerBody rows each, then walls of one.
template <int kPerBody>
struct RowOwners {
  int bodies = 0;

  int of(int row) const {
    return row < kPerBody * bodies ? row / kPerBody : row - (kPerBody - 1) * bodies;
  }
  /// Among the rows of its owner.
  int place(int row) const { return row < kPerBody * bodies ? row % kPerBody : 0; }
  int first_row(int owner) const {
    return owner < bodies ? kPerBody * owner : owner + (kPerBody - 1) * bodies;
  }
};

/// The first read(walls) that is not empty, else its empty value. The walls are as many as leave
/// whole bodies of `per_body` rows, the fewest first: some walls could also be a body.
template <class Read>
auto read_with_walls(int dofs, int per_body, const Read& read) {
  constexpr int kMostWalls = 24;
  int walls = dofs % per_body;
  auto made = read(walls);
  while (!made && (walls += per_body) <= std::min(kMostWalls, dofs)) made = read(walls);
  return made;
}

/// Rows for each body, by plain_dim(): 2 for d = 1 (x, y; 3 with clusters), 3 for d = 2 (x, y,
/// spin), 6 for d = 3. Empty if the columns of the normals do not have unit forces in these places:
/// H is then of another kind.
std::optional<BodyRows> find_body_rows(const ContactProblem& problem);

}  // namespace bipot
