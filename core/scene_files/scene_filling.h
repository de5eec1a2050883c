#pragma once

#include "core/scene/generators.h"
#include "core/scene_files/scene_table.h"

namespace bipot {

/// Where a random filling goes.
template <int D>
struct FillingPlace {
  Vec<D> corner;    ///< lower left one                                                       [m]
  Vec<D - 1> base;  ///< width, in 3D also depth                                              [m]
  FillingBounds<D> bounds;
};

/// `corner`, `width`, `depth`, `height` and `inside` of a random filling; walls are those of the
/// scene so far. Throws SceneFileError.
template <int D>
FillingPlace<D> read_filling_place(const SceneTable& table, const Scene<D>& scene);

}  // namespace bipot
