#pragma once

#include <span>
#include <type_traits>
#include <vector>

#include "core/problem/contact_problem.h"
#include "core/scene/contact.h"
#include "core/scene/scene.h"

namespace bipot {

/// Start of a solver: the impulses of the previous step at the contacts of the same pairs, 0 at new
/// ones, in the problem's variables (row_scale). `contacts` are those of `problem`, `walls` the wall
/// that each touches or null. Both lists are sorted by (i, j), as detection returns them.
template <int D>
Vector warm_start(const std::vector<ContactOutcome<D>>& before,
                  std::span<const std::type_identity_t<Contact<D>>> contacts,
                  std::span<const std::type_identity_t<Wall<D>>* const> walls,
                  const ContactProblem& problem);

}  // namespace bipot
