#pragma once

#include <span>
#include <vector>

#include "core/problem/contact_problem.h"
#include "core/scene/contact.h"

namespace bipot {

/// The impulses of the step before at the contacts of the same pairs, 0 at new ones, in the
/// problem's variables (row_scale). `contacts` are those of `problem`; both lists are sorted by
/// (i, j), as detection leaves them.
Vector warm_start(const std::vector<ContactOutcome>& before, std::span<const Contact> contacts,
                  const ContactProblem& problem);

}  // namespace bipot
