#include "solvers/simulation/joint_energy.h"

#include <fmt/format.h>

#include <algorithm>

namespace bipot {

template <int D>
std::string JointEnergy::add(const StepReport<D>& step) {
  constexpr double kMost = 0.1;
  // From rest, kinetic energy is of the order of what the step misses until some steps are done.
  constexpr double kFirstSteps = 10;
  made_ -= step.joint_loss;
  least_ = std::min(least_, made_);
  largest_ = std::max({largest_, step.energy.kinetic, kFirstSteps * kFirstSteps * step.from_rest});
  if (made_ - least_ <= kMost * largest_) return {};
  return fmt::format(
      "pins and ropes made {:.3g} J, with a kinetic energy of {:.3g} J at most: bodies turn too far "
      "in a step, shorten it",
      made_ - least_, largest_);
}

template std::string JointEnergy::add(const StepReport<2>&);
template std::string JointEnergy::add(const StepReport<3>&);

}  // namespace bipot
