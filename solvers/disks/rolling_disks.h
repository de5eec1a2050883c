#pragma once

#include <optional>

#include "core/problem/contact_problem.h"
#include "core/problem/disk_structure.h"

namespace bipot {

/// The structure of rigid disks with rolling friction (kRollingDisks): that of their normal and
/// tangential rows, where a third row has the difference of the spins, times a positive factor.
/// Empty if the problem is another one, or walls are driven: they do not roll.
std::optional<DiskStructure> rolling_disks(const ContactProblem& problem);

}  // namespace bipot
