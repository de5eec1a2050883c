#pragma once

namespace bipot {

/// The angle of a pendulum after a time, by Runge and Kutta's rule: a'' = pull(a, a').
template <class Pull>
double pendulum_angle(double angle, double time, const Pull& pull) {
  const int steps = 20000;
  const double h = time / steps;
  double rate = 0;
  for (int k = 0; k < steps; ++k) {
    const double a1 = rate, r1 = pull(angle, rate), a2 = rate + 0.5 * h * r1,
                 r2 = pull(angle + 0.5 * h * a1, a2), a3 = rate + 0.5 * h * r2,
                 r3 = pull(angle + 0.5 * h * a2, a3), a4 = rate + h * r3,
                 r4 = pull(angle + h * a3, a4);
    angle += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    rate += h / 6 * (r1 + 2 * r2 + 2 * r3 + r4);
  }
  return angle;
}

}  // namespace bipot
