#pragma once

#include <cstdint>
#include <string>

#include "core/problem/contact_problem.h"

namespace bipot {

/// A random contact problem, for statistics of solvers.
struct RandomProblem {
  ContactProblem problem;
  /// An impulse that obeys the law but for rounding, for every second problem; else empty.
  Vector planted;
  std::string description;  ///< one line: size, friction, masses, units
};

/// Problem `index` of the set `seed`: the same bits on all machines with IEEE arithmetic.
///
/// 1 to 50 contacts (uniform in the logarithm) between rigid bodies, or bodies and the ground, in
/// one, two or three dimensions. A third of the problems repeat contacts, so that W is singular.
/// Masses of one problem differ by up to 10^8. Units of mass and velocity lie between 10^-10 and
/// 10^10, those of length between 10^-5 and 10^5. Friction: none, 1e-12, up to 1, up to 10, 1e6, or
/// all of these in one problem. A third has restitution (row_scale), half are given by W alone.
///
/// Even indices plant a solution: contacts open, stick or slip, and u_free = u - W s, summed in
/// extended precision. Odd ones draw u_free: any, or that of a motion.
RandomProblem random_problem(std::uint64_t seed, int index);

}  // namespace bipot
