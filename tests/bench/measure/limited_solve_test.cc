#include "bench/measure/limited_solve.h"

#include <unistd.h>

#include "bench/measure/stopwatch.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(CpuLimit, EndsABusyLoop) {
  CpuLimit limit(0.05);
  EXPECT_FALSE(limit());
  const double start = cpu_seconds();
  double x = 1;
  while (!limit()) x = std::sqrt(x + 1);
  const double spent = cpu_seconds() - start;
  EXPECT_GT(spent, 0.045);
  EXPECT_LT(spent, 0.1);  // the clock is read every few milliseconds at the latest
  EXPECT_TRUE(limit.reached());
  EXPECT_TRUE(limit());  // for good
  EXPECT_GT(x, 0);
}

TEST(CpuLimit, DoesNotCountWaiting) {
  CpuLimit limit(0.05);
  for (int k = 0; k < 8; ++k) {
    usleep(10000);
    EXPECT_FALSE(limit());
  }
  EXPECT_FALSE(limit.reached());
}

TEST(CpuLimit, FollowsALoopThatBecomesSlow) {
  // Asked quickly at first, then in steps of 5 ms, of which it may miss eight.
  CpuLimit limit(0.1);
  const double start = cpu_seconds();
  for (int k = 0; k < 20000; ++k) limit();
  while (!limit()) {
    const double pause = cpu_seconds();
    while (cpu_seconds() < pause + 0.005) continue;
  }
  EXPECT_LT(cpu_seconds() - start, 0.1 + 10 * 0.005);
}

}  // namespace
}  // namespace bipot
