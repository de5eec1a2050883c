#pragma once

#include <initializer_list>

#include "core/base/portable_random.h"
#include "core/base/types.h"

namespace bipot {

/// The numbers as a vector.
inline Vector vec(std::initializer_list<double> x) {
  return Eigen::Map<const Vector>(x.begin(), static_cast<Eigen::Index>(x.size()));
}

/// Numbers in [-1, 1).
inline Vector random_vector(Eigen::Index size, std::uint64_t seed) {
  PortableRandom random(seed);
  Vector x(size);
  for (double& value : x) value = random.symmetric();
  return x;
}

}  // namespace bipot
