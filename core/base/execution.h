#pragma once

namespace bipot {

/// Instruction set of the vector kernels. All give the same bits.
enum class SimdPath {
  kAuto,      ///< the widest that this machine has
  kPortable,  ///< two lanes, the base architecture of the compiler
  kAvx2,      ///< four lanes
  kAvx512     ///< eight lanes
};
const char* to_string(SimdPath path);

/// True if this build and this machine can run it.
bool has_path(SimdPath path);
/// `path` itself, or the widest available one for kAuto.
SimdPath resolved(SimdPath path);

/// Threads and instruction set of a solver. Neither changes a bit of any result.
struct Execution {
  int threads = 1;  ///< at most, >= 1
  SimdPath path = SimdPath::kAuto;
};

/// Number of lanes of a batch of contacts, whatever the width of the machine's registers. The order
/// of the arithmetic, hence every bit of a result, is the same on all machines.
inline constexpr int kLanes = 8;

}  // namespace bipot
