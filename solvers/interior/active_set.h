#pragma once

#include <vector>

#include "solvers/interior/interior_run.h"
#include "solvers/interior/interior_state.h"

namespace bipot {

/// Newton's method on the status of the contacts (Alart and Curnier 1991), the last step of a path,
/// from an accurate impulse. Open contacts get s = 0, sticking ones u = 0, sliding ones u_n = 0 and
/// s_t = mu s_n e, with e the direction of the impulse that is cut off. Every equation has a
/// proximal term, 1e-8 in units of W_cc, anchored at the previous impulse. Redundant contacts then
/// do not make the system singular. For d = 2 the equations of a status are linear: with the status
/// of a solution one factorisation is exact to rounding.
///
/// Limits: it jumps away if contacts are undecided. Therefore the number of steps is limited, and a
/// worse result is discarded.
template <ContactRows D>
class ActiveSet {
 public:
  explicit ActiveSet(InteriorSystem<D>& system);

  /// Status from the pairs of an interior state: open if s_n W_nn < w, sliding if the edge distance
  /// times W_tt is below its multiplier.
  void start(const InteriorState<D>& z);
  /// Status from an impulse (m) and its velocity: cases of s - u / W_cc.
  void start(const Vector& s);

  /// At most `cap` factorisations. The run judges the impulses.
  StageEnd operator()(int cap, InteriorRun& run);

 private:
  using Jordan = ContactJordan<D>;
  static constexpr unsigned kOpen = 255;

  bool step();

  InteriorSystem<D>& system_;
  std::vector<unsigned> status_;  // kOpen, or a bit for each part that slides or rolls
  Vector s_, u_;
  Vector direction_;       // m, of the friction of sliding parts
  std::vector<double> R_;  // blocks of s = g - R u
  Vector g_, residual_, correction_, next_;
};

}  // namespace bipot
