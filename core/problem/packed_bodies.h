#pragma once

#include <type_traits>

#include "core/problem/disk_structure.h"
#include "core/problem/sphere_structure.h"

namespace bipot {

/// The packed bodies of a problem with dim = D.
template <int D>
using BodiesOf = std::conditional_t<D == 3, SphereStructure, DiskStructure>;

}  // namespace bipot
