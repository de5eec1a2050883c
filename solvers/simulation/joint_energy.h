#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "core/motion/time_stepping.h"

namespace bipot {

/// Watches the energy that pins and ropes make in a run. It goes back and forth, to the second order
/// in the step, unless bodies turn too far in it (core/motion/joint_rows.h).
class JointEnergy {
 public:
  /// Takes a step. Empty, or a sentence for a run that cannot be trusted: since its least value,
  /// what the joints made has grown by a tenth of the largest kinetic energy.
  template <int D>
  std::string add(const StepReport<D>& step) {
    constexpr double kMost = 0.1;
    // From rest, kinetic energy is of the order of what the step misses until some steps are done.
    constexpr double kFirstSteps = 10;
    made_ -= step.joint_loss;
    least_ = std::min(least_, made_);
    largest_ =
        std::max({largest_, step.energy.kinetic, kFirstSteps * kFirstSteps * step.from_rest});
    if (made_ - least_ <= kMost * largest_) return {};
    return fmt::format(
        "pins and ropes made {:.3g} J, with a kinetic energy of {:.3g} J at most: bodies turn too "
        "far in a step, shorten it; or fixed points hold joints taut in one line",
        made_ - least_, largest_);
  }

 private:
  double made_ = 0, least_ = 0, largest_ = 0;  // [J]
};

}  // namespace bipot
