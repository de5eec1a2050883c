#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "core/scene/scene.h"
#include "core/scene_files/scene_table.h"

namespace bipot {

/// The seed of random numbers. Throws SceneFileError.
std::uint64_t read_seed(const SceneTable& table);

/// The bodies of a random filling, called `kind` in messages: all of this radius [m], or with the
/// radii of read_radii(). Where they go: `corner`, `width`, `depth`, `height` and `inside`; walls
/// are those of the scene so far. Throws SceneFileError.
template <int D>
std::vector<Body<D>> read_filling(const SceneTable& table, const Scene<D>& scene,
                                  std::string_view kind, std::optional<double> radius = {});

}  // namespace bipot
