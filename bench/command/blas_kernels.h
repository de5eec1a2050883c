#pragma once

#include <dlfcn.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace bipot {

/// True if OpenBLAS's kernels of this name do not use AVX2.
inline bool kernels_without_avx2(std::string_view core) {
  constexpr std::array<std::string_view, 18> kOld{
      "Generic", "Katmai",  "Coppermine",   "Northwood", "Banias",      "Prescott",
      "Core2",   "Penryn",  "Dunnington",   "Nehalem",   "Sandybridge", "Atom",
      "Athlon",  "Opteron", "Opteron_SSE3", "Barcelona", "Bobcat",      "Nano"};
  return std::ranges::find(kOld, core) != kOld.end();
}

/// Name of the kernels of OpenBLAS for this processor; null: none with AVX2.
inline const char* fitting_kernels() {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl")) {
    return "SkylakeX";
  }
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return "Haswell";
#endif
  return nullptr;
}

/// Restarts the program with the OpenBLAS kernels for this processor. OpenBLAS knows processors by
/// their numbers, and chooses slow kernels for newer ones (data/manual/results/performance.md).
/// Call it first in main(), since OpenBLAS decides before. No effect if the environment names
/// kernels, or for another BLAS.
inline void take_kernels_of_this_processor(char** argv) {
  constexpr const char* kVariable = "OPENBLAS_CORETYPE";
  const char* const fitting = fitting_kernels();
  if (fitting == nullptr || getenv(kVariable) != nullptr) return;
  const auto core_name =
      reinterpret_cast<const char* (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_corename"));
  if (core_name == nullptr || !kernels_without_avx2(core_name())) return;
  setenv(kVariable, fitting, 1);
  execv("/proc/self/exe", argv);
  unsetenv(kVariable);  // it cannot be started again: slower, but right
}

}  // namespace bipot
