#include "bench/report/csv_text.h"

#include "core/base/file_error.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

using Fields = std::vector<std::string>;

TEST(CsvText, FieldsComeBackAsTheyWere) {
  const Fields fields = {"plain", "a, b", "the \"best\"", "", "\""};
  std::string line;
  for (const std::string& field : fields) line += (line.empty() ? "" : ",") + csv_text(field);
  EXPECT_EQ(split_csv_line(line), fields);
  EXPECT_EQ(split_csv_line("1,,x y"), (Fields{"1", "", "x y"}));
}

TEST(CsvText, ALineOfTheFileStaysARowOfTheTable) {
  EXPECT_EQ(csv_text("two\nlines\r"), "\"two lines \"");
}

TEST(CsvText, ARowThatWasBeingWrittenIsLeftOut) {
  const TemporaryFolder folder;
  std::ofstream(folder / "t.csv") << "a,b\n1,\"x\"\n2,\"y";
  EXPECT_EQ(read_csv_table(folder / "t.csv", "a,b", 2), (std::vector<Fields>{{"1", "x"}}));
}

TEST(CsvText, OtherTablesAreRefusedWithTheLine) {
  const TemporaryFolder folder;
  std::ofstream(folder / "t.csv") << "a,b\n1,2\n1,2,3\n";
  const auto message = [&](const char* header, std::size_t columns) -> std::string {
    return refusal_of<FileError>([&] { read_csv_table(folder / "t.csv", header, columns); });
  };
  EXPECT_TRUE(says(message("a,c", 2), "line 1"));
  EXPECT_TRUE(says(message("a,b", 2), "line 3: 3 fields, expected 2"));
  EXPECT_THROW(read_csv_table(folder / "missing.csv", "a,b", 2), FileError);
}

}  // namespace
}  // namespace bipot
