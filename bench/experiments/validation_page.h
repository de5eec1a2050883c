#pragma once

#include <string>

#include "bench/experiments/validation_run.h"

namespace bipot {

/// The index page. Charts are files beside it; nothing else is needed: no script, no network.
std::string to_html(const ValidationPage& page);

}  // namespace bipot
