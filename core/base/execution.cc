#include "core/base/execution.h"

namespace bipot {

const char* to_string(SimdPath path) {
  switch (path) {
    case SimdPath::kAuto:
      return "auto";
    case SimdPath::kPortable:
      return "portable";
    case SimdPath::kAvx2:
      return "avx2";
    case SimdPath::kAvx512:
      return "avx512";
  }
  return "?";
}

bool has_path(SimdPath path) {
#ifdef BIPOT_X86_PATHS
  if (path == SimdPath::kAvx2) return __builtin_cpu_supports("avx2");
  if (path == SimdPath::kAvx512) {
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl");
  }
#endif
  return path == SimdPath::kAuto || path == SimdPath::kPortable;
}

SimdPath resolved(SimdPath path) {
  if (path != SimdPath::kAuto) return path;
  if (has_path(SimdPath::kAvx512)) return SimdPath::kAvx512;
  return has_path(SimdPath::kAvx2) ? SimdPath::kAvx2 : SimdPath::kPortable;
}

}  // namespace bipot
