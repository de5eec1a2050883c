// Items of `bipot paper` whose checks hold at every size, small. Label "long".

#include "bench/experiments/paper_item.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

class PaperItemsQuick : public ::testing::TestWithParam<std::string_view> {};

TEST_P(PaperItemsQuick, ChecksHold) {
  const TemporaryFolder folder;
  PaperItem::Context context{.out = folder.path(), .quick = true};
  const auto& items = paper_items();
  const auto item = std::find_if(items.begin(), items.end(),
                                 [](const PaperItem& i) { return i.name == GetParam(); });
  ASSERT_NE(item, items.end());
  Findings result = item->run(context);
  complete(result, "bipot paper");
  EXPECT_FALSE(result.paper.empty());
  EXPECT_FALSE(result.ours.empty());
  EXPECT_FALSE(result.claims.empty());
  for (const Claim& n : result.claims) {
    EXPECT_NE(n.holds, std::optional<bool>(false)) << n.quantity << ": " << n.measured;
  }
}

INSTANTIATE_TEST_SUITE_P(All, PaperItemsQuick,
                         ::testing::Values("table1", "table2", "fig10", "fig13", "fig14"),
                         [](const auto& tested) { return std::string(tested.param); });

}  // namespace
}  // namespace bipot
