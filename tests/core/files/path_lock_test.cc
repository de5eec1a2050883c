#include "core/files/path_lock.h"

#include "core/base/file_error.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

TEST(PathLock, HoldsAFolderOnceAndFreesItAtItsEnd) {
  const TemporaryFolder folder;
  std::optional<PathLock> first(folder.path());
  EXPECT_THROW(PathLock(folder.path()), std::invalid_argument);
  first.reset();
  const PathLock second(folder.path());
}

TEST(PathLock, HoldsAFileToo) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "rows.csv";
  std::ofstream(file) << "a\n";
  const PathLock first(file);
  EXPECT_THROW(PathLock{file}, std::invalid_argument);
}

TEST(PathLock, NeedsAFolder) {
  const TemporaryFolder folder;
  EXPECT_THROW(PathLock(folder.path() / "missing"), FileError);
}

}  // namespace
}  // namespace bipot
