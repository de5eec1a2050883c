#pragma once

#include <filesystem>
#include <variant>

#include "core/motion/state.h"
#include "core/run_files/run_layout.h"

namespace bipot {

/// The state of the frame after `step` (-1: the last frame), bit for bit. `run`: its folder or its
/// run.h5. Throws FileError.
template <int D>
State<D> read_state(const std::filesystem::path& run, int step = -1);
inline State<2> read_state(const std::filesystem::path& run, int step = -1) {
  return read_state<2>(run, step);
}

/// The same for a run of disks or of spheres, as the run has them.
using AnyState = std::variant<State<2>, State<3>>;
AnyState read_any_state(const std::filesystem::path& run, int step = -1);

}  // namespace bipot
