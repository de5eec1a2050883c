#include "solvers/disks/wavefront.h"

#include "tests/support/test.h"

namespace bipot {
namespace {

/// Bodies 0 ... tiles; tile t works on the bodies t and t + 1, whose values depend on the order of
/// all that came before.
class Bodies {
 public:
  explicit Bodies(int tiles) : value_(static_cast<std::size_t>(tiles) + 1, 1.0) {}
  void operator()(int k, int t) {
    double &a = value_[static_cast<std::size_t>(t)], &b = value_[static_cast<std::size_t>(t) + 1];
    const double sum = 0.7 * a + 0.4 * b + 1e-3 * (k + 1) * (t + 1);
    b = 1.01 * b - 0.3 * sum;
    a = 0.5 * sum - 0.2 * a;
  }
  const std::vector<double>& value() const { return value_; }

 private:
  std::vector<double> value_;
};

std::vector<double> values_after(int threads, int tiles, int iterations, Pipeline pipeline) {
  Bodies bodies(tiles);
  run_wavefront(threads, tiles, iterations, pipeline, [&](int k, int t) { bodies(k, t); });
  return bodies.value();
}

/// From both ends to the middle, iteration after iteration.
std::vector<double> values_of_plain_loops(int tiles, int iterations) {
  Bodies bodies(tiles);
  for (int k = 0; k < iterations; ++k) {
    for (int t = 0; t < first_upper_tile(tiles); ++t) bodies(k, t);
    for (int t = tiles - 1; t >= first_upper_tile(tiles); --t) bodies(k, t);
  }
  return bodies.value();
}

TEST(Wavefront, GivesTheBitsOfThePlainLoops) {
  for (const int tiles : {1, 2, 3, 4, 5, 6, 9, 10, 11, 40, 41}) {
    for (const int iterations : {1, 2, 7, 30}) {
      const std::vector<double> plain = values_of_plain_loops(tiles, iterations);
      for (const int threads : {1, 2, 3, 4, 5}) {
        for (const int depth : {1, 2, 3, 8, 64}) {
          for (const int places : {1, 2, 3, 6}) {
            EXPECT_EQ(values_after(threads, tiles, iterations, {depth, places}), plain)
                << tiles << ' ' << iterations << ' ' << threads << ' ' << depth << ' ' << places;
          }
        }
      }
    }
  }
}

TEST(Wavefront, NoIterationsAndNoTilesAreNothing) {
  EXPECT_EQ(values_after(2, 5, 0, {3}), std::vector<double>(6, 1.0));
  EXPECT_EQ(values_after(2, 0, 4, {3}), std::vector<double>(1, 1.0));
}

}  // namespace
}  // namespace bipot
