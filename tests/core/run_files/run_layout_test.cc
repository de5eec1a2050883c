#include "core/run_files/run_layout.h"

#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

TEST(RunLayout, ARunIsNamedByItsFolderOrItsFile) {
  const TemporaryFolder folder;
  EXPECT_EQ(run_folder(folder.path()), folder.path());
  // The file need not exist: what cannot be read is said by who reads it.
  EXPECT_EQ(run_folder(folder / "run.h5"), folder.path());
  EXPECT_EQ(run_folder("run.h5"), fs::path("."));
}

TEST(RunLayout, RefusesOtherNames) {
  const TemporaryFolder folder;
  std::ofstream(folder / "ledger.csv") << "step\n";
  EXPECT_THROW(run_folder(folder / "ledger.csv"), FileError);
  EXPECT_THROW(run_folder(folder / "frames/00000000.h5"), FileError);
  EXPECT_TRUE(says(refusal_of([&] { run_folder(folder / "nothing"); }), "no such folder or file"));
  EXPECT_THROW(run_folder(""), FileError);
}

TEST(RunLayout, FramesAreFoundByTheirNames) {
  const TemporaryFolder folder;
  EXPECT_TRUE(steps_in_folder(folder.path()).empty());
  fs::create_directories(folder / "frames");
  for (const int step : {100, 7, 123456789}) std::ofstream(frame_path(folder.path(), step)) << "";
  for (const char* other : {"00000008.h5.part", "last.h5", "12x.h5", "00000009.csv"}) {
    std::ofstream(folder / "frames" / other) << "";
  }
  EXPECT_EQ(frame_path("a", 7), fs::path("a/frames/00000007.h5"));
  EXPECT_EQ(steps_in_folder(folder.path()), (std::vector<int>{7, 100, 123456789}));
}

}  // namespace
}  // namespace bipot
