#pragma once

#include <type_traits>

#include "core/problem/disk_structure.h"
#include "core/problem/sphere_structure.h"

namespace bipot {

/// The packed bodies of a problem with dim = D; 6 is that of rolling spheres.
template <int D>
using BodiesOf = std::conditional_t<D == 3 || D == 6, SphereStructure, DiskStructure>;

}  // namespace bipot
