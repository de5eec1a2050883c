#include "solvers/disks/quicker_team.h"

#include "tests/support/test.h"

namespace bipot {
namespace {

/// Runs of so many, and how many of these were alone.
int alone(QuickerTeam& team, int runs, double alone_takes, double team_takes) {
  int count = 0;
  for (int k = 0; k < runs; ++k) {
    const bool one = team.threads() == 1;
    count += one ? 1 : 0;
    team.took(one ? alone_takes : team_takes);
  }
  return count;
}

TEST(QuickerTeam, TakesTheQuickerAndTriesTheOtherEverLessOften) {
  QuickerTeam team(2);
  EXPECT_LE(alone(team, 1000, 1.0, 0.6), 8);
  QuickerTeam busy(2);
  EXPECT_GE(alone(busy, 1000, 1.0, 100.0), 992);
  EXPECT_GE(alone(busy, 10000, 1.0, 100.0), 9995);
}

TEST(QuickerTeam, FollowsAMachineThatBecomesQuiet) {
  QuickerTeam team(2);
  alone(team, 100, 1.0, 50.0);
  EXPECT_LE(alone(team, 1000, 1.0, 0.6), 300);
  EXPECT_GE(alone(team, 1000, 1.0, 50.0), 990);
}

TEST(QuickerTeam, OfOneIsAlwaysAlone) {
  QuickerTeam team(1);
  EXPECT_EQ(alone(team, 100, 1.0, 0.1), 100);
}

}  // namespace
}  // namespace bipot
