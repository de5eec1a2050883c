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
  // Of Fortran.
  EXPECT_EQ(printed_number("+1.5D-03"), 1.5e-3);
  EXPECT_EQ(printed_number("-2d5"), -2e5);
  EXPECT_EQ(printed_number("1.5-100"), 1.5e-100);
  EXPECT_EQ(printed_number("-1.5D+400"), -kInfinity);
}

TEST(NumberText, WhatIsNoNumberInFullIsRefused) {
  for (const char* text : {"", "+", "-", "+-1", "++1", "1 ", "1x", "1e-400x", "1,5", "e", "1D",
                           "D3", "1D3D3", "1e3D3", "1-2", "1.5-99", "2024-100", "1.5-1x0"}) {
    EXPECT_FALSE(printed_number(text)) << text;
  }
}

}  // namespace
}  // namespace bipot
