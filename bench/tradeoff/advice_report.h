#pragma once

#include "bench/report/document.h"
#include "bench/tradeoff/advice.h"
#include "core/scene/scene.h"

namespace bipot {

/// The whole advice, with its scene and program. Keys: data/manual/reference/files.md. Undefined
/// numbers are null.
Json to_json(const Scene<2>& scene, const Advice& advice, const Provenance& made);

/// The advice, its cost, the errors of time steps and solvers, and their evidence.
Document advice_document(const Scene<2>& scene, const Advice& advice);

/// The errors, each with its name, of the quantities with a goal: "force error 1.2e-03, energy
/// error not measured". Of a goal itself as well.
std::string error_text(const Accuracy& error, const Accuracy& goal);

}  // namespace bipot
