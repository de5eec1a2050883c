#pragma once

#include <string>

#include "bench/report/document.h"
#include "bench/report/json_output.h"
#include "solvers/analysis/several_answers.h"

namespace bipot {

/// A page: what follows, the answers, the starts, and the contacts that differ. `picture`: the file
/// answers.svg stands beside it.
Document several_page(const SeveralAnswers& found, const std::string& problem, Provenance made,
                      bool picture);
/// Its table of the answers as CSV.
std::string to_csv(const SeveralAnswers& found);
/// The result as tables of at most 100 columns and sentences.
std::string to_text(const SeveralAnswers& found);
/// The same with every number; undefined ones are null.
Json to_json(const SeveralAnswers& found);

}  // namespace bipot
