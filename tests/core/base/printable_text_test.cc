#include "core/base/printable_text.h"

#include "tests/support/test.h"

namespace bipot {
namespace {

constexpr const char* kInstead = "\xEF\xBF\xBD";

TEST(PrintableText, OrdinaryTextStays) {
  for (const char* text :
       {"", "disk 17\n\tand wall", "µ = 0.3, θ", "漢字 🙂", "\xEF\xBF\xBD"}) {
    EXPECT_EQ(printable(text), text);
  }
}

TEST(PrintableText, ControlCharactersAndNoncharactersAreReplaced) {
  EXPECT_EQ(printable("a\x1b[2Jb"), std::string("a") + kInstead + "[2Jb");
  EXPECT_EQ(printable("\x7f"), kInstead);
  EXPECT_EQ(printable("\xC2\x85"), kInstead);          // U+0085, a control character
  EXPECT_EQ(printable("\xEF\xBF\xBE"), kInstead);      // U+FFFE
  EXPECT_EQ(printable("\xF4\x8F\xBF\xBF"), kInstead);  // U+10FFFF
  EXPECT_EQ(printable("\xEF\xB7\x90"), kInstead);      // U+FDD0
}

TEST(PrintableText, EachWrongByteIsReplaced) {
  EXPECT_EQ(printable("\xff"), kInstead);
  EXPECT_EQ(printable("\xC3"), kInstead);                                             // cut off
  EXPECT_EQ(printable("\xC0\xAF"), std::string(kInstead) + kInstead);                 // overlong
  EXPECT_EQ(printable("\xED\xA0\x80"), std::string(kInstead) + kInstead + kInstead);  // surrogate
}

}  // namespace
}  // namespace bipot
