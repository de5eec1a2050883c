#pragma once

#include <string>
#include <vector>

namespace bipot {

/// A factor that depends on time: 1, linear between given times and constant outside them, or a
/// sine.
struct Course {
  std::vector<double> times;    ///< increasing [s]; empty: no table
  std::vector<double> factors;  ///< one for each
  double frequency = 0;         ///< of sin(2 π frequency t + phase), if > 0 [Hz]
  double phase = 0;             ///< [rad]

  bool constant() const { return times.empty() && frequency == 0; }
  double at(double time) const;
};

/// Empty for a sound course, else one sentence.
std::string check_course(const Course& course);

}  // namespace bipot
