#pragma once

#include "bench/report/json_output.h"
#include "bench/tradeoff/advice.h"
#include "core/scene/scene.h"

namespace bipot {

/// All that an advice holds, with the scene and the program that it goes for. Keys:
/// data/manual/reference/files.md. Undefined numbers are null.
Json to_json(const Scene<2>& scene, const Advice& advice);

}  // namespace bipot
