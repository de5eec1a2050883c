#include "bench/page/page_curves.h"

#include "core/base/file_error.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

void write(const fs::path& path, const std::string& text) { std::ofstream(path) << text; }

struct PageCurves : testing::Test {
  const TemporaryFolder folder;
};

TEST_F(PageCurves, TakesTheColumnsOfAnyFileAndLeavesACutLine) {
  write(folder / "ledger.csv", "step,time [s],new thing [W]\n1,0.5,7\n2,1,nan\n3,1.");
  const auto tables = read_curves(folder.path());
  ASSERT_EQ(tables.size(), 1u);
  EXPECT_EQ(tables[0].file, "ledger");
  const std::vector<double>* column = tables[0].column("new thing");
  ASSERT_NE(column, nullptr);
  ASSERT_EQ(column->size(), 2u);
  EXPECT_EQ((*column)[0], 7);
  EXPECT_TRUE(std::isnan((*column)[1]));
  EXPECT_EQ(tables[0].column("thing"), nullptr);
}

TEST_F(PageCurves, AColumnOfWordsMakesATableForEach) {
  write(folder / "walls.csv",
        "step,time [s],wall,force_x [N]\n1,0.5,left,3\n1,0.5,right,-3\n2,1,left,4\n");
  const auto tables = read_curves(folder.path());
  ASSERT_EQ(tables.size(), 2u);
  EXPECT_EQ(tables[0].part, "left");
  EXPECT_EQ(*tables[0].column("force_x"), (std::vector<double>{3, 4}));
  EXPECT_EQ(tables[1].part, "right");
  EXPECT_EQ(*tables[1].column("force_x"), (std::vector<double>{-3}));
}

TEST_F(PageCurves, UnitsComeFromTheirFileAndNamesMayHaveCommas) {
  write(folder / "units.csv", "file,column,unit\nwalls.csv,reaction_x,N\n");
  write(folder / "walls.csv", "step,time,wall,reaction_x\n1,0.5,\"left, \"\"low\"\"\",3\n");
  const auto tables = read_curves(folder.path());
  ASSERT_EQ(tables.size(), 1u);
  EXPECT_EQ(tables[0].part, "left, \"low\"");
  EXPECT_EQ(tables[0].names, (std::vector<std::string>{"step", "time", "reaction_x [N]"}));
  EXPECT_NE(tables[0].column("reaction_x"), nullptr);
}

TEST_F(PageCurves, AFileWithoutTimeIsRefused) {
  write(folder / "ledger.csv", "step,x\n1,2\n");
  EXPECT_THROW(read_curves(folder.path()), FileError);
}

TEST_F(PageCurves, ThinningKeepsEveryExtreme) {
  CurveTable table{.file = "ledger", .part = "", .names = {"time [s]", "x"}, .columns = {{}, {}}};
  for (int k = 0; k < 1000; ++k) {
    table.columns[0].push_back(k);
    table.columns[1].push_back(k == 777 ? 50 : k == 333 ? -50 : k == 334 ? std::nan("") : 0);
  }
  const CurveTable thin = thinned_curves(table, 20);
  ASSERT_EQ(thin.columns[1].size(), 20u);
  EXPECT_EQ(thin.columns[0].front(), 0);
  EXPECT_EQ(thin.columns[0].back(), 999);
  double low = 0, high = 0;
  for (const double x : thin.columns[1]) {
    EXPECT_FALSE(std::isnan(x));
    low = std::min(low, x);
    high = std::max(high, x);
  }
  EXPECT_EQ(low, -50);
  EXPECT_EQ(high, 50);
}

}  // namespace
}  // namespace bipot
