#pragma once

#include <string>

#include "bench/report/json_output.h"
#include "solvers/analysis/several_answers.h"

namespace bipot {

/// The result as tables of at most 100 columns and sentences.
std::string to_text(const SeveralAnswers& found);
/// The same with every number; undefined ones are null.
Json to_json(const SeveralAnswers& found);

}  // namespace bipot
