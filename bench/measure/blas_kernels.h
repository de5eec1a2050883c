#pragma once

#include <dlfcn.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace bipot {

/// Whether OpenBLAS's kernels of this name do without AVX2.
inline bool kernels_without_avx2(std::string_view core) {
  constexpr std::array<std::string_view, 18> kOld{
      "Generic", "Katmai",  "Coppermine",   "Northwood", "Banias",      "Prescott",
      "Core2",   "Penryn",  "Dunnington",   "Nehalem",   "Sandybridge", "Atom",
      "Athlon",  "Opteron", "Opteron_SSE3", "Barcelona", "Bobcat",      "Nano"};
  return std::find(kOld.begin(), kOld.end(), core) != kOld.end();
}

/// OpenBLAS knows processors by their numbers, and takes kernels of 2004 on one that came after it:
/// Debian 12's on a Xeon of 2023, where `ipm` then takes 1.35 times as long (data/speed.md). Starts the
/// program again with those of any processor that has AVX2, whose digits are the same on all. For the
/// first line of main(): OpenBLAS decides before that. Does nothing where the environment names
/// kernels, or BLAS is another one.
inline void take_kernels_of_this_processor(char** argv) {
#ifdef __x86_64__
  constexpr const char* kVariable = "OPENBLAS_CORETYPE";
  if (getenv(kVariable) != nullptr || !__builtin_cpu_supports("avx2") ||
      !__builtin_cpu_supports("fma")) {
    return;
  }
  const auto core_name =
      reinterpret_cast<const char* (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_corename"));
  if (core_name == nullptr || !kernels_without_avx2(core_name())) return;
  setenv(kVariable, "Haswell", 1);
  execv("/proc/self/exe", argv);
  unsetenv(kVariable);  // it cannot be started again: slower, but right
#else
  (void)argv;
#endif
}

}  // namespace bipot
