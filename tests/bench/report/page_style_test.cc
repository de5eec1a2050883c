#include "bench/report/page_style.h"

#include <gtest/gtest.h>

namespace bipot {
namespace {

TEST(PageStyle, OwnRulesStandBetweenTheScreenAndThePrint) {
  const std::string head = page_head("a < b", ".own{color:#123456}");
  EXPECT_NE(head.find("<title>a &lt; b</title>"), std::string::npos);
  const std::size_t own = head.find(".own{"), print = head.find("@media print");
  ASSERT_NE(own, std::string::npos);
  ASSERT_NE(print, std::string::npos);
  EXPECT_LT(head.find("body{margin"), own);
  EXPECT_LT(own, print);
}

TEST(PageStyle, APageNeedsNoOtherFile) {
  const std::string page = page_head("t", "") + page_end();
  for (const char* outside : {"http", "@import", "url(", "<script"}) {
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
  }
  EXPECT_TRUE(page.starts_with("<!DOCTYPE html>"));
  EXPECT_TRUE(page.ends_with("</body></html>\n"));
}

TEST(PageStyle, TheBuildIsEscaped) {
  const BuildInfo build{"1.0", "0123abc", "g++ <12>", "-O3", "Release", "a & b", 2};
  const std::string terms = page_terms(build);
  EXPECT_NE(terms.find("bipot 1.0, commit 0123abc"), std::string::npos);
  EXPECT_NE(terms.find("g++ &lt;12&gt;"), std::string::npos);
  EXPECT_NE(terms.find("a &amp; b, 2 logical cores"), std::string::npos);
}

}  // namespace
}  // namespace bipot
