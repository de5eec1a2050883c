#pragma once

#include <filesystem>

#include "core/motion/state.h"
#include "core/motion/stress_tensor.h"
#include "core/scene/scene.h"

namespace bipot {

/// Mean stress of the sample and its area; NaN without disks.
template <int D>
MeanStress<D> stress_of_sample(const State<D>& state, double step);

/// Writes frames/<step>.h5 of a run: a state, and the stresses that follow from it; `stress` is that
/// of the sample. data/manual/reference/files.md describes each entry. Throws FileError.
template <int D>
void write_frame_file(const std::filesystem::path& path, const Scene<D>& scene,
                      const State<D>& state, const MeanStress<D>& stress);

}  // namespace bipot
