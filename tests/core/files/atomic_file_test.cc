#include "core/files/atomic_file.h"

#include "core/base/file_error.h"
#include "tests/support/source_folder.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

TEST(AtomicFile, TheOldFileStaysUntilTheNewOneIsCommitted) {
  const TemporaryFolder folder;
  std::ofstream(folder / "a") << "old";
  {
    AtomicFile file(folder / "a");
    std::ofstream(file.draft()) << "new";
    EXPECT_EQ(file_text(folder / "a"), "old");
    file.commit();
  }
  EXPECT_EQ(file_text(folder / "a"), "new");
}

TEST(AtomicFile, ALinkIsWrittenThrough) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "there");
  for (const auto& [link, target] : {std::pair{"a", "there/b"}, std::pair{"c", "a"}}) {
    std::filesystem::create_symlink(target, folder / link);  // names nothing at first
    write_text_file(folder / link, link);
    EXPECT_TRUE(std::filesystem::is_symlink(folder / link));
    EXPECT_EQ(file_text(folder / "there/b"), link);
  }
}

/// As /dev/stdout: the file that is open is written, not another one of its name.
TEST(AtomicFile, AnOpenFileIsWrittenItself) {
  const TemporaryFolder folder;
  std::FILE* open = std::fopen((folder / "out").c_str(), "w");
  fs::create_symlink(fmt::format("/proc/self/fd/{}", fileno(open)), folder / "stdout");
  fs::create_symlink("stdout", folder / "link");
  write_text_file(folder / "link", "text");
  for (const char* link : {"link", "stdout"}) EXPECT_TRUE(fs::is_symlink(folder / link)) << link;
  EXPECT_EQ(file_text(folder / "out"), "text");
  std::fputs("more", open);
  std::fclose(open);
  EXPECT_EQ(file_text(folder / "out"), "more");
}

TEST(AtomicFile, WithoutCommitNothingIsLeft) {
  const TemporaryFolder folder;
  {
    AtomicFile file(folder / "a");
    std::ofstream(file.draft()) << "new";
  }
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(AtomicFile, NothingToCommitIsAnError) {
  const TemporaryFolder folder;
  AtomicFile file(folder / "a");
  EXPECT_THROW(file.commit(), FileError);
}

}  // namespace
}  // namespace bipot
