#include "bench/command/blas_kernels.h"

#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(BlasKernels, OldOnesAreKnownByName) {
  for (const char* core : {"Prescott", "Barcelona", "Sandybridge", "Generic"}) {
    EXPECT_TRUE(kernels_without_avx2(core)) << core;
  }
  for (const char* core : {"Haswell", "SkylakeX", "Zen", "Cooperlake", ""}) {
    EXPECT_FALSE(kernels_without_avx2(core)) << core;
  }
}

}  // namespace
}  // namespace bipot
