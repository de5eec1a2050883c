#pragma once

#include "core/problem/contact_problem.h"

namespace bipot {

/// The problem with compliant contacts, u = (W + R) s + u_free: a contact gives way by R s, as a
/// spring κ with a dashpot c does at R = 1 / (h (hκ + c)). With bodies this is exact by more of
/// them, R = Lᵀ L: degrees of freedom of mass 1 at the end, at rest without impulses, with the wrench
/// map L. So nothing else knows of it.
///
/// R: m x m, blocks of the contacts alone, symmetric and positive semidefinite [1/kg]. Throws
/// std::invalid_argument with the contact or the entry for any other, and for a problem with
/// equality rows.
ContactProblem with_compliance(ContactProblem problem, const SparseRows& R);

}  // namespace bipot
