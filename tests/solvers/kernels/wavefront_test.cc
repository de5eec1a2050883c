#include "solvers/kernels/wavefront.h"

#include <gtest/gtest.h>

#include <vector>

namespace bipot {
namespace {

/// Bodies 0 ... tiles; tile t works on the bodies t and t + 1, whose values depend on the order of
/// all that came before.
std::vector<double> values_after(int threads, int tiles, int iterations, int depth) {
  std::vector<double> body(static_cast<std::size_t>(tiles) + 1, 1.0);
  run_wavefront(threads, tiles, iterations, depth, [&](int k, int t) {
    double &a = body[static_cast<std::size_t>(t)], &b = body[static_cast<std::size_t>(t) + 1];
    const double sum = 0.7 * a + 0.4 * b + 1e-3 * (k + 1) * (t + 1);
    b = 1.01 * b - 0.3 * sum;
    a = 0.5 * sum - 0.2 * a;
  });
  return body;
}

TEST(Wavefront, GivesTheBitsOfThePlainLoops) {
  for (const int tiles : {1, 2, 3, 4, 5, 9, 40}) {
    for (const int iterations : {1, 2, 7, 30}) {
      const std::vector<double> plain = values_after(1, tiles, iterations, 1);
      for (const int threads : {1, 2, 3, 4}) {
        for (const int depth : {1, 2, 3, 8, 64}) {
          EXPECT_EQ(values_after(threads, tiles, iterations, depth), plain)
              << tiles << ' ' << iterations << ' ' << threads << ' ' << depth;
        }
      }
    }
  }
}

TEST(Wavefront, NoIterationsAndNoTilesAreNothing) {
  EXPECT_EQ(values_after(2, 5, 0, 3), std::vector<double>(6, 1.0));
  EXPECT_EQ(values_after(2, 0, 4, 3), std::vector<double>(1, 1.0));
}

}  // namespace
}  // namespace bipot
