// Every item of `bipot paper`, small. Label "long".

#include "bench/paper_items.h"

#include <gtest/gtest.h>

#include "bench/paper_report.h"
#include "tests/temporary_folder.h"

namespace bipot {
namespace {

class PaperItemsQuick : public ::testing::TestWithParam<PaperItem> {};

TEST_P(PaperItemsQuick, ChecksHold) {
  const TemporaryFolder folder;
  PaperContext context;
  context.out = folder.path();
  context.quick = true;
  PaperResult result = GetParam().run(context);
  complete(result, "bipot paper");
  EXPECT_FALSE(result.paper.empty());
  EXPECT_FALSE(result.ours.empty());
  EXPECT_FALSE(result.numbers.empty());
  for (const PaperNumber& n : result.numbers) {
    EXPECT_NE(n.holds, std::optional<bool>(false)) << n.meaning << ": " << n.value;
  }
}

INSTANTIATE_TEST_SUITE_P(All, PaperItemsQuick, ::testing::ValuesIn(paper_items()),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace bipot
