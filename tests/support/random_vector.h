#pragma once

#include "core/base/portable_random.h"
#include "core/base/types.h"

namespace bipot {

/// Numbers in [-1, 1).
inline Vector random_vector(Eigen::Index size, std::uint64_t seed) {
  PortableRandom random(seed);
  Vector x(size);
  for (double& value : x) value = random.symmetric();
  return x;
}

}  // namespace bipot
