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

/// The kernels of OpenBLAS for what this processor can do, by name; null: none with AVX2.
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

/// OpenBLAS knows processors by their numbers, and takes kernels of 2004 on one that came after it:
/// Debian 12's on a Xeon of 2023, where `ipm` then takes 1.6 times as long (data/manual/results/performance.md). Starts the
/// program again with those that fit. For the first line of main(): OpenBLAS decides before that. Does
/// nothing where the environment names kernels, or BLAS is another one.
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
