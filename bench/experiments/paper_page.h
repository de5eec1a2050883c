#pragma once

#include <string>

#include "bench/experiments/paper_report.h"

namespace bipot {

/// The index page of a report. Pictures are files beside it; nothing else is needed: no script, no
/// network.
std::string to_html(const PaperReport& report);

}  // namespace bipot
