#pragma once

#include <string>

#include "core/problem/contact_problem.h"

namespace bipot {

/// Empty if W can be a Delassus operator Hᵀ A⁻¹ H, else one sentence that names the entries and
/// the size of the defect. W must be symmetric and positive semidefinite, and it must agree with A
/// and H where these are given too. Problems without W pass. The problem must pass validate().
///
/// Rounded data of other codes pass. With the diagonal scaled to 1, W and Wᵀ may differ by 1e-2 of
/// W in the Frobenius norm and by 0.1 in an entry. The smallest eigenvalue may be -1e-2 times the
/// largest sum of a row. Up to 300 rows a dense Cholesky factorisation of the shifted matrix decides. Beyond, 60 products with
/// W bound the smallest eigenvalue from above (Lanczos): what is refused is indefinite, but a weak
/// indefiniteness may pass.
std::string delassus_defect(const ContactProblem& problem);

}  // namespace bipot
