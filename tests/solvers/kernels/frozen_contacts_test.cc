#include "solvers/kernels/frozen_contacts.h"

#include <gtest/gtest.h>

#include <vector>

namespace bipot {
namespace {

/// Sweeps at which contact 0 is visited when the value it stands at is value(sweep).
template <class Value>
std::vector<int> visits(int freeze, int sweeps, const Value& value) {
  FrozenContacts frozen(1, freeze);
  Local<1> s(value(-1));
  std::vector<int> at;
  for (int k = 0; k < sweeps; ++k) {
    const auto impulse = [&](int) { return s; };
    const auto visit = [&](int) { s[0] = value(k); };
    if (frozen.operator()<1>(0, 0.1, impulse, visit)) at.push_back(k);
  }
  return at;
}

TEST(FrozenContacts, OneThatRestsIsLookedAtNowAndThen) {
  // Visits 0, 1, 2 settle it; then it is left out of 4 sweeps, looked at, and so on.
  EXPECT_EQ(visits(4, 20, [](int) { return 1.0; }), (std::vector<int>{0, 1, 2, 7, 12, 17}));
}

TEST(FrozenContacts, OneThatMovesIsNeverLeftOut) {
  EXPECT_EQ(visits(4, 10, [](int k) { return 0.2 * k; }).size(), 10u);
  EXPECT_EQ(visits(4, 10, [](int) { return kNaN; }).size(), 10u);
}

TEST(FrozenContacts, OneThatMovesAgainWakesUp) {
  // At rest up to sweep 7, where it is looked at and has moved: three more visits before it rests.
  EXPECT_EQ(visits(4, 16, [](int k) { return k < 7 ? 1.0 : 2.0; }),
            (std::vector<int>{0, 1, 2, 7, 8, 9, 10, 15}));
}

}  // namespace
}  // namespace bipot
