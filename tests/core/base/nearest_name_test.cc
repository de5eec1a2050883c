#include "core/base/nearest_name.h"

#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(NearestName, CountsEditsAndSwaps) {
  const std::vector<std::string> names = {"time", "title", "gravity", "walls"};
  EXPECT_EQ(nearest_name("titel", names), "title");  // one swap; "time" is two edits away
  EXPECT_EQ(nearest_name("wall", names), "walls");
  EXPECT_EQ(nearest_name("gravitty", names), "gravity");
  EXPECT_EQ(nearest_name("tine", names), "time");
  EXPECT_EQ(nearest_name("walls", names), "walls");
  EXPECT_EQ(nearest_name("foo", names), "");  // nothing is near
  EXPECT_EQ(nearest_name("", names), "");
  EXPECT_EQ(nearest_name("x", {}), "");
}

TEST(NearestName, MessageListsTheValidNames) {
  EXPECT_EQ(unknown_name_message("solver", "pgz", {"pgs", "uzawa"}),
            "unknown solver 'pgz'; did you mean 'pgs'? Valid: pgs, uzawa");
  EXPECT_EQ(unknown_name_message("key", "x", {}), "unknown key 'x'; none is allowed here");
}

}  // namespace
}  // namespace bipot
