#pragma once

#include "bench/tradeoff/advice.h"

namespace bipot {

/// Sets costs, status and message of an advice from its results.
void conclude(const Advice::Options& options, Advice& advice);
/// The same where no contact was seen in the sampled run.
void conclude_without_contacts(const Advice::Options& options, Advice& advice);

}  // namespace bipot
