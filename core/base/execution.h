#pragma once

namespace bipot {

/// Instructions that vector kernels use. All give the same bits.
enum class SimdPath {
  kAuto,      ///< the widest that this machine has
  kPortable,  ///< two lanes, what the compiler's base architecture offers
  kAvx2,      ///< four lanes
  kAvx512     ///< eight lanes
};
const char* to_string(SimdPath path);

/// Whether this build and this machine can run it.
bool has_path(SimdPath path);
/// `path` itself, or the widest available one for kAuto.
SimdPath resolved(SimdPath path);

/// How work is laid on the machine. Neither choice changes a bit of any result.
struct Execution {
  int threads = 1;  ///< at most, >= 1
  SimdPath path = SimdPath::kAuto;
};

/// Contacts are packed in batches of this many lanes, whatever the machine's registers hold: the
/// order of the arithmetic, hence every bit of a result, is the same on all of them.
inline constexpr int kLanes = 8;

}  // namespace bipot
