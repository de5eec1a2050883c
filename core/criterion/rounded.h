#pragma once

#include <algorithm>
#include <cmath>

#include "core/criterion/contact_terms.h"

namespace bipot {

/// A number in double precision with a bound on its error: a number type for the templates of
/// contact_terms.h. Every operation propagates the errors of its arguments and adds its own
/// rounding (running error analysis: Higham, Accuracy and Stability of Numerical Algorithms, §3.3).
/// Exact numbers convert. A comparison is true if it is certain.
struct Rounded {
  static constexpr double kUnit = 0x1p-53;  ///< unit roundoff

  double value = 0;
  double error = 0;  ///< |value - exact| at most

  Rounded(double exact = 0) : value(exact) {}  // NOLINT(google-explicit-constructor)
  Rounded(double computed, double bound) : value(computed), error(bound) {}

  explicit operator double() const { return value; }

  /// Adds to a sum over contacts. rounding_bound() accounts for the rounding of these sums, which
  /// depends on the number of contacts.
  Rounded& operator+=(const Rounded& x) {
    value += x.value;
    error += x.error;
    return *this;
  }
  Rounded operator-() const { return {-value, error}; }
  friend Rounded operator+(const Rounded& a, const Rounded& b) {
    return rounded(a.value + b.value, a.error + b.error);
  }
  friend Rounded operator-(const Rounded& a, const Rounded& b) { return a + -b; }
  friend Rounded operator*(const Rounded& a, const Rounded& b) {
    return rounded(a.value * b.value,
                   std::abs(a.value) * b.error + a.error * std::abs(b.value) + a.error * b.error);
  }
  /// To first order in the error of b.
  friend Rounded operator/(const Rounded& a, const Rounded& b) {
    const double quotient = a.value / b.value;
    return rounded(quotient, (a.error + std::abs(quotient) * b.error) / std::abs(b.value));
  }
  friend bool operator==(const Rounded& a, double b) { return a.error == 0 && a.value == b; }

 private:
  static Rounded rounded(double value, double error) {
    return {value, error + kUnit * std::abs(value)};
  }
};

inline Rounded absolute(const Rounded& x) { return {std::abs(x.value), x.error}; }

/// Exactly 0 if x is certainly negative.
inline Rounded positive_part(const Rounded& x) {
  return {std::max(x.value, 0.0), std::clamp(x.value + x.error, 0.0, x.error)};
}

/// The norm of the components `begin` to D - 1 of the values, with that of their errors, which
/// bounds the error of the norm.
template <int D>
Rounded norm_of(const FrameVector<Rounded, D>& x, int begin) {
  double value2 = 0, error2 = 0;
  for (int k = begin; k < D; ++k) {
    value2 += x[k].value * x[k].value;
    error2 += x[k].error * x[k].error;
  }
  const double norm = std::sqrt(value2);
  return {norm, std::sqrt(error2) + 2 * Rounded::kUnit * norm};
}

template <int D>
Rounded tangential_norm(const FrameVector<Rounded, D>& x) {
  return norm_of(x, 1);
}

/// A projection lengthens no difference. The error of each component of the natural map's point is
/// at most the norm of the errors of tau, plus some roundings of tau and of s, those of mu
/// included. (They count the rounding of rho |u_t| too, which is more than there is: where that
/// matters, wider precision decides.)
template <int D, class Friction, class Values>
FrameVector<Rounded, D> rounded_point(const PhysicalContact<Rounded, D, Friction>& c,
                                      const Rounded& rho, const Values& friction,
                                      double roundings) {
  PhysicalContact<double, D, Values> values{{}, {}, c.slip.value, friction, 0, 0, 0};
  for (int k = 0; k < D; ++k) {
    values.s[k] = c.s[k].value;
    values.u[k] = c.u[k].value;
  }
  const FrameVector<double, D> point = natural_point(values, rho.value);
  const Rounded norm = norm_of(natural_step(c, rho), 0);
  const double size = norm.value + norm_of(c.s, 0).value;
  const double error = norm.error + roundings * Rounded::kUnit * size;
  FrameVector<Rounded, D> s;
  for (int k = 0; k < D; ++k) s[k] = {point[k], error};
  return s;
}
template <int D>
FrameVector<Rounded, D> natural_point(const PhysicalContact<Rounded, D, Rounded>& c,
                                      const Rounded& rho) {
  return rounded_point(c, rho, c.mu.value, 24);
}
template <int D>
FrameVector<Rounded, D> natural_point(
    const PhysicalContact<Rounded, D, RollingFriction<Rounded>>& c, const Rounded& rho) {
  return rounded_point(
      c, rho, RollingFriction<double>{c.mu.slide.value, c.mu.roll.value, c.mu.spin.value}, 80);
}
template <int kFirst, int kCount, int D>
Rounded part_norm(const FrameVector<Rounded, D>& x) {
  if constexpr (kCount == 1) return absolute(x[kFirst]);
  FrameVector<Rounded, kCount> part;
  for (int k = 0; k < kCount; ++k) part[k] = x[kFirst + k];
  return norm_of(part, 0);
}

/// The square of a norm; therefore the error is stored as that of the norm of the errors.
template <int D>
Rounded natural_energy(const Rounded& w_nn, const FrameVector<Rounded, D>& N) {
  FrameVector<double, D> value, error;
  for (int k = 0; k < D; ++k) {
    value[k] = N[k].value;
    error[k] = N[k].error + 0.5 * w_nn.error / w_nn.value * std::abs(N[k].value);
  }
  return {natural_energy(w_nn.value, value), natural_energy(w_nn.value, error)};
}

}  // namespace bipot
