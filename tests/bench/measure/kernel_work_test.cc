#include "bench/measure/kernel_work.h"

#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(KernelWork, OfAContactOnASquareLattice) {
  // Half a body a contact: 48.5 + 32 + 48, 96 + 32 + 32, 48.5 + 48 + 80; 51 + 10.5.
  EXPECT_DOUBLE_EQ(tiled_sweep_work<2>(0.5).bytes, 128.5);
  EXPECT_DOUBLE_EQ(tiled_sweep_work<2>(0.5).flops, 39);
  EXPECT_DOUBLE_EQ(given_order_sweep_work(0.5).bytes, 160);
  EXPECT_DOUBLE_EQ(gradient_work<2>(0.5).bytes, 176.5);
  EXPECT_DOUBLE_EQ(gradient_work<2>(0.5).flops, 61);
  // Spheres on a cubic lattice, a third of a body a contact: 112.5 + 42.67, 136.5 + 106.67.
  EXPECT_DOUBLE_EQ(tiled_sweep_work<3>(1.0 / 3).bytes, 112.5 + 128.0 / 3);
  EXPECT_DOUBLE_EQ(gradient_work<3>(1.0 / 3).bytes, 136.5 + 320.0 / 3);
}

TEST(KernelWork, OfAnExplicitRowIsThatOfTheTable) {
  // 44 entries a contact on a triangular lattice: 528 + 136 = 664 bytes and 100 flops.
  EXPECT_DOUBLE_EQ(explicit_sweep_work(44).bytes, 532);
  EXPECT_DOUBLE_EQ(explicit_sweep_work(44).flops, 100);
}

TEST(KernelWork, TheRooflineIsTheLowerOfItsTwoRoofs) {
  // The triad has 1/12 flop a byte: 2 Gflop/s at 24 GB/s, the peak where that is less.
  EXPECT_DOUBLE_EQ(roofline(triad_work(), 24e9, 10e9), 2e9);
  EXPECT_DOUBLE_EQ(roofline(triad_work(), 24e9, 1e9), 1e9);
}

}  // namespace
}  // namespace bipot
