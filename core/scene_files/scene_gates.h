#pragma once

#include "core/scene/scene.h"
#include "core/scene_files/scene_table.h"

namespace bipot {

/// The tables [[outlets]] and [[inlets]] of a scene, whose materials are known. `turned`: the scene is turned as a
/// whole, which boxes along the axes cannot be. Throws SceneFileError.
template <int D>
void read_gates(const SceneTable& root, bool turned, Scene<D>& scene);

}  // namespace bipot
