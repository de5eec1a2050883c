#pragma once

namespace bipot {

/// How many times longer than on the machine of the bounds (in seconds) this one takes for a sparse
/// factorisation, the longest thing that a solver does without a question to its caller; at least
/// 1. The least of several attempts, so that other processes add nothing. Measured once a process.
double machine_slowness();

}  // namespace bipot
