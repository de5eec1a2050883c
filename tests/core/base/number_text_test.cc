#include "core/base/number_text.h"

#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(NumberText, APrintedNumberHasASignAndAnyExponent) {
  EXPECT_EQ(printed_number("+1.5e+00"), 1.5);
  EXPECT_EQ(printed_number("-2"), -2);
  EXPECT_EQ(printed_number("1e-400"), 0);
  EXPECT_EQ(printed_number("-1E-400"), 0);
  EXPECT_EQ(printed_number("1e400"), kInfinity);
  EXPECT_EQ(printed_number("-1e+400"), -kInfinity);
}

TEST(NumberText, WhatIsNoNumberInFullIsRefused) {
  for (const char* text : {"", "+", "-", "+-1", "++1", "1 ", "1x", "1e-400x", "1,5", "e"}) {
    EXPECT_FALSE(printed_number(text)) << text;
  }
}

}  // namespace
}  // namespace bipot
