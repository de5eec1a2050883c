#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "core/motion/push_apart.h"
#include "core/motion/state.h"
#include "core/scene/scene.h"

namespace bipot {

/// What was found at the start of a run, and what was done about it.
struct StartReport {
  int overlapping = 0;            ///< bodies
  std::string pair;               ///< the worst
  double depth = 0, radii = 0;    ///< of its overlap [m], over the smaller radius
  std::optional<PushApart> push;  ///< where bodies were pushed apart
  std::string text;               ///< all this in one line; empty: nothing overlapped
};

/// Checks the start of a scene (core/scene/start_check.h) and does what [start] says; bodies may
/// be pushed apart. Throws std::invalid_argument if bodies overlap and may not, after `picture` has
/// been drawn with these bodies in colour; an empty path draws none. A picture that cannot be
/// drawn is said in the message. `time_limit` ends both, the pushing as a refusal.          [s]
template <int D>
StartReport check_start(Scene<D>& scene, const std::filesystem::path& picture, int threads,
                        double time_limit = kInfinity);

/// The same for callers that do not report the start: `warn`, which may be empty, is told what the
/// scene leaves out and what overlaps.
template <int D>
void check_start(Scene<D>& scene, const std::function<void(const std::string&)>& warn);

/// Steps from the state to the end of the scene, which is a time or a number of steps, or of this
/// duration [s]. Throws std::invalid_argument for one that is shorter than a step.
template <int D>
int remaining_steps(const Scene<D>& scene, const State<D>& state,
                    std::optional<double> duration = std::nullopt);

}  // namespace bipot
