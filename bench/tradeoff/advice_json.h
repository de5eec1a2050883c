#pragma once

#include "bench/report/json_output.h"
#include "bench/tradeoff/advice.h"
#include "core/scene/scene.h"

namespace bipot {

/// The whole advice, with its scene and program. Keys: data/manual/reference/files.md. Undefined
/// numbers are null.
Json to_json(const Scene<2>& scene, const Advice& advice);

}  // namespace bipot
