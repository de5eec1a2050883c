#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/measure/statistics.h"
#include "bench/study/study.h"

namespace bipot {

Study::Part thresholds_part();  ///< from which ε on is an observable right?
Study::Part depth_part();       ///< does the number of sweeps saturate with the depth?
Study::Part answers_part();     ///< how many steps have several exact answers?
Study::Part ensembles_part();   ///< do statistics depend on the answer that is taken?
Study::Part plane_part();       ///< error over step and tolerance
Study::Part paths_part();       ///< the same of paths, and rigid contacts against springs

/// Values of a quantity by seed, over the cases that agree with `of` in all but the seed.
std::map<int, double> by_seed(const Study::Measured& measured, Study::Case of,
                              const std::string& quantity);
/// Mean and 95 % bar over seeds.
MeanValue over_seeds(const std::map<int, double>& values);
/// The geometric mean over seeds; seeds with a value that is not finite and positive are left out.
Study::Geometric geometric_mean(const std::map<int, double>& values);
/// Mean and bar of the differences a - b of the seeds that both have.
MeanValue paired_difference(const std::map<int, double>& a, const std::map<int, double>& b);
/// Differences of a quantity from a reference, by means over the seeds.
Study::PairedError paired_error(const Study::Measured& measured, const Study::Case& of,
                                const Study::Case& reference, const std::string& quantity);
/// Distinct values of a member over the cases of a part, increasing.
template <class Member>
std::vector<Member> distinct(const Study::Measured& measured, const std::string& part,
                             Member Study::Case::*member,
                             const std::function<bool(const Study::Case&)>& holds = {}) {
  std::vector<Member> all;
  for (const auto& [of, values] : measured) {
    if (of.part == part && (!holds || holds(of))) all.push_back(of.*member);
  }
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}
/// Quantities with a class that the cases of the part have.
std::vector<std::string> classed_quantities(const Study::Measured& measured,
                                            const std::string& part, const std::string& scene);
inline const std::vector<std::string> kStudyClasses = {"geometry", "stress", "forces",
                                                       "kinematics"};

}  // namespace bipot
