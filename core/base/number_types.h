#pragma once

#include <Eigen/Core>
#include <cmath>
#include <type_traits>

namespace bipot {

// Functions for formulas that are written once for several number types: double, long double,
// Quadruple, and lanes (GNU vectors of doubles, where every lane is a number of its own). A class
// that is used as a number type brings its own overloads. They are always inlined, because vectors
// wider than the default registers must not be passed between functions.

/// A number with a significand of 113 bits, in software where long double is shorter.
#if __LDBL_MANT_DIG__ >= 113
using Quadruple = long double;
#else
__extension__ typedef __float128 Quadruple;
#endif

/// mask ? a : b, in every lane.
template <class Mask, class Real>
[[gnu::always_inline]] inline Real select(const Mask& mask, const Real& a, const Real& b) {
  return mask ? a : b;
}

/// Whether select() certainly returns `a`. Lanes are not asked.
template <class Mask>
[[gnu::always_inline]] inline bool surely(const Mask&) {
  return false;
}
[[gnu::always_inline]] inline bool surely(bool mask) { return mask; }

/// |x|, without a branch where the machine has the number type.
template <class Real>
[[gnu::always_inline]] inline Real absolute(const Real& x) {
  if constexpr (std::is_floating_point_v<Real>) {
    return std::abs(x);
  } else if constexpr (requires { x[0]; }) {
    using Bits = decltype(x < x);
    return reinterpret_cast<Real>(reinterpret_cast<Bits>(x) & 0x7fffffffffffffffLL);
  } else {
    return x < 0 ? -x : x;
  }
}

/// Square root.
template <class Real>
[[gnu::always_inline]] inline Real root(const Real& x) {
  if constexpr (std::is_floating_point_v<Real>) {
    return Eigen::numext::sqrt(x);  // Eigen's has no test for errno
  } else if constexpr (requires { x[0]; }) {
    Real y = x;
#ifdef __x86_64__
    // g++ has no operation for lanes, and makes slow code of a loop over them.
    if constexpr (sizeof(Real) == 16) {
      asm("sqrtpd %1, %0" : "=x"(y) : "x"(x));
    } else {
      asm("vsqrtpd %1, %0" : "=v"(y) : "v"(x));
    }
#else
    for (std::size_t k = 0; k < sizeof(Real) / sizeof(double); ++k) y[k] = std::sqrt(x[k]);
#endif
    return y;
  } else {
    // A step of Newton's method doubles the digits of the root in long double.
    const Real near = std::sqrt(static_cast<long double>(x));
    return near > 0 ? (near + x / near) / 2 : near;
  }
}

/// max(x, 0), exactly, without a branch; NaN stays NaN.
template <class Real>
[[gnu::always_inline]] inline Real positive_part(const Real& x) {
  return 0.5 * (x + absolute(x));
}

/// x limited to [-radius, radius] without a branch; NaN stays NaN.
template <class Real>
[[gnu::always_inline]] inline Real cut_off(const Real& x, const Real& radius) {
  const Real above = select(x < -radius, Real(-radius), x);
  return select(above > radius, radius, above);
}

}  // namespace bipot
