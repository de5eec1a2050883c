#include "core/files/folder_lock.h"

#include "core/base/file_error.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

TEST(FolderLock, HoldsAFolderOnceAndFreesItAtItsEnd) {
  const TemporaryFolder folder;
  std::optional<FolderLock> first(folder.path());
  EXPECT_THROW(FolderLock(folder.path()), std::invalid_argument);
  first.reset();
  const FolderLock second(folder.path());
}

TEST(FolderLock, NeedsAFolder) {
  const TemporaryFolder folder;
  EXPECT_THROW(FolderLock(folder.path() / "missing"), FileError);
}

}  // namespace
}  // namespace bipot
