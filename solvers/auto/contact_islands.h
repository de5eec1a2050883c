#pragma once

#include "core/base/lists.h"
#include "core/problem/contact_problem.h"

namespace bipot {

/// The contacts of a problem, island by island, ascending within each. Islands do not couple: no
/// block of W between them acts on an impulse of the law.
using ContactIslands = Lists<>;

/// Splits the contact graph into its connected components, smaller ones first, equal ones by their
/// first contact. Two contacts are connected if nonzero entries of H act on the same degree of
/// freedom, or on two that A couples; without H, if W has a nonzero entry between them. Fixed
/// bodies have no degree of freedom and connect nothing; a driven wall has one. The tangential rows
/// of a contact without friction connect nothing, as they have no impulse. One pass over the
/// entries.
ContactIslands contact_islands(const ContactProblem& problem);

}  // namespace bipot
