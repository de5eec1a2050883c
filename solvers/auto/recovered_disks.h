#pragma once

#include <optional>

#include "core/problem/contact_problem.h"

namespace bipot {

/// The problem of W alone with bodies, A and H, so that the kernels for disks serve it; empty where
/// W is not that of disks in the plane to rounding.
///
/// [ours] Contacts c, d that share a disk of mass m and inertia I at the arm a have the block
///
///     W_cd = ± R(θ_d - θ_c) / m + e_t e_tᵀ a²/I,    R a rotation, θ the angle of the normal,
///
/// so that a block gives 1/m, a²/I and an angle ρ, with ± as a turn by π. Blocks of one disk have
/// the same numbers, and their angles add up around every three contacts; around three disks that
/// touch each other they miss by π. So the disks are the cliques of consistent blocks. What the
/// diagonal block has beyond its disks is a disk with this contact alone. Positions are not known;
/// a disk may be turned together with all that hangs on it. Cost: linear in the blocks of W.
///
/// Of the result W is empty and v_free = 0, which no solver reads; s and u are those of `problem`.
std::optional<ContactProblem> recovered_disks(const ContactProblem& problem);

}  // namespace bipot
