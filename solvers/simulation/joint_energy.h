#pragma once

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
  std::string add(const StepReport<D>& step);

 private:
  double made_ = 0, least_ = 0, largest_ = 0;  // [J]
};

}  // namespace bipot
