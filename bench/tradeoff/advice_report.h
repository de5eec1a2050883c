#pragma once

#include <string>

#include "bench/report/document.h"
#include "bench/tradeoff/advice.h"

namespace bipot {

/// The whole advice, with its scene and program. Keys: data/manual/reference/files.md. Undefined
/// numbers are null.
Json to_json(const Advice& advice, const Provenance& made);

/// Five lines: choice, expected error, cost, verdict with what limits, and the command that runs it.
std::string advice_summary(const Advice& advice);
/// The same, and the errors of time steps and solvers with their evidence. A page, with the plane of
/// step and tolerance, if `made` is given.
Document advice_document(const Advice& advice, const Provenance* made = nullptr);

/// The solvers that were tried, with their errors.
std::string advice_csv(const Advice& advice);

/// The command that runs the scene as advised, with this plan for `auto` instead of the solver if one
/// is named; empty without a choice.
std::string run_command_of(const Advice& advice, const std::string& plan = {});

/// The errors, each with its name, of the quantities with a goal: "force error 1.2e-03, energy
/// error not measured". Of a goal itself as well.
std::string error_text(const Accuracy& error, const Accuracy& goal);

}  // namespace bipot
