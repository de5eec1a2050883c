#include "core/files/hdf5_file.h"

#include <sys/resource.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <future>
#include <thread>

#include "tests/support/source_folder.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

using Mode = Hdf5File::Mode;

/// The message of the FileError that f throws.
template <class F>
std::string refusal(F&& f) {
  return refusal_of<FileError>([&] { f(); });
}

TEST(Hdf5File, WhatIsWrittenIsReadBackBitForBit) {
  const TemporaryFolder folder;
  const std::vector<double> x = {
      1.0 / 3, -0.0, 5e-324, std::numeric_limits<double>::infinity(), std::nextafter(1.0, 2.0),
      -1.7e308};
  const std::vector<int> i = {0, -1, std::numeric_limits<int>::max()};
  const std::vector<std::string> names = {"steel", "", "café au lait"};
  {
    Hdf5File file(folder / "a.h5", Mode::kCreate);
    file.write("/x", x);
    file.write("/deep/in/groups/i", i);
    file.write("/number", 0.1);
    file.write("/count", 7);
    file.write("/text", "two\nlines");
    file.write("/empty text", "");
    file.write("/names", names);
    file.write("/nothing", std::span<const double>());
    file.write_rows("/table", x, 2);
    file.write_attribute("/x", "unit", "m/s");
    file.close();
  }
  const Hdf5File file(folder / "a.h5", Mode::kRead);
  const std::vector<double> y = file.read_doubles("/x");
  ASSERT_EQ(y.size(), x.size());
  for (std::size_t k = 0; k < x.size(); ++k) {
    EXPECT_EQ(std::memcmp(&x[k], &y[k], sizeof(double)), 0) << k;
  }
  EXPECT_EQ(file.read_ints("/deep/in/groups/i"), i);
  EXPECT_EQ(file.read_double("/number"), 0.1);
  EXPECT_EQ(file.read_int("/count"), 7);
  EXPECT_EQ(file.read_string("/text"), "two\nlines");
  EXPECT_EQ(file.read_string("/empty text"), "");
  EXPECT_EQ(file.read_strings("/names"), names);
  EXPECT_TRUE(file.read_doubles("/nothing").empty());
  EXPECT_EQ(file.shape("/table"), (std::vector<std::size_t>{3, 2}));
  const std::string bytes = file_text(folder / "a.h5");
  EXPECT_TRUE(says(bytes, "unit"));
  EXPECT_TRUE(says(bytes, "m/s"));
  EXPECT_TRUE(file.exists("/deep/in"));
  EXPECT_FALSE(file.exists("/deep/out/of/reach"));
  EXPECT_EQ(file.list("/deep"), std::vector<std::string>{"in"});
}

TEST(Hdf5File, AppendReplacesAndKeepsTheRest) {
  const TemporaryFolder folder;
  const std::vector<double> two = {1, 2}, three = {3, 4, 5};
  Hdf5File(folder / "a.h5", Mode::kCreate).write("/a/x", two);
  {
    Hdf5File file(folder / "a.h5", Mode::kAppend);
    file.write("/a/y", two);
    file.write("/a/x", three);
  }
  Hdf5File file(folder / "a.h5", Mode::kAppend);
  EXPECT_EQ(file.read_doubles("/a/x"), three);
  EXPECT_EQ(file.read_doubles("/a/y"), two);
  file.remove("/a");
  EXPECT_FALSE(file.exists("/a"));
}

TEST(Hdf5File, ALinkLeadsIntoAFileBesideIt) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "parts");
  Hdf5File(folder / "parts/1.h5", Mode::kCreate).write("/x", 4.5);
  {
    Hdf5File file(folder / "all.h5", Mode::kCreate);
    file.link("/parts/one", "parts/1.h5", "/");
    file.link("/parts/two", "parts/2.h5", "/");
  }
  const Hdf5File file(folder / "all.h5", Mode::kRead);
  EXPECT_EQ(file.read_double("/parts/one/x"), 4.5);
  EXPECT_FALSE(file.exists("/parts/two"));  // its file is missing
  EXPECT_EQ(file.list("/parts"), (std::vector<std::string>{"one", "two"}));
}

TEST(Hdf5File, TheSameContentGivesTheSameBytes) {
  const TemporaryFolder folder;
  for (const char* name : {"a.h5", "b.h5"}) {
    Hdf5File file(folder / name, Mode::kCreate);
    file.write("/group/x", 1.5);
    file.write("/group/text", "same");
  }
  EXPECT_EQ(file_text(folder / "a.h5"), file_text(folder / "b.h5"));
}

TEST(Hdf5File, FailuresNameTheFileAndTheObject) {
  const TemporaryFolder folder;
  {
    Hdf5File file(folder / "a.h5", Mode::kCreate);
    file.write("/text", "words");
    file.write("/x", std::vector<double>{1.5, 2.5});
  }
  testing::internal::CaptureStderr();
  const Hdf5File file(folder / "a.h5", Mode::kRead);
  const auto expect = [&](const std::string& message, const std::string& part) {
    EXPECT_TRUE(says(message, "a.h5"));
    EXPECT_TRUE(says(message, part));
  };
  expect(refusal([&] { file.read_double("/y/z"); }), "/y/z: missing");
  expect(refusal([&] { file.read_double("/x"); }), "/x: has 2 elements, expected one");
  expect(refusal([&] { file.read_doubles("/text"); }), "/text: not numbers");
  expect(refusal([&] { file.read_ints("/x"); }), "/x: not integers");
  expect(refusal([&] { file.read_string("/x"); }), "/x: not text");
  expect(refusal([&] { file.read_doubles("/"); }), "/: not a dataset");
  expect(refusal([&] { file.list("/x"); }), "/x: not a group");
  EXPECT_TRUE(says(refusal([&] { Hdf5File(folder / "b.h5", Mode::kRead); }), "no such file"));
  EXPECT_TRUE(says(refusal([&] { Hdf5File(folder / "no/b.h5", Mode::kCreate); }), "cannot open"));
  std::ofstream(folder / "c.h5") << "plain text";
  EXPECT_TRUE(says(refusal([&] { Hdf5File(folder / "c.h5", Mode::kRead); }), "not an HDF5 file"));
  std::ofstream(folder / "d.h5", std::ios::binary) << file_text(folder / "a.h5").substr(0, 700);
  EXPECT_TRUE(says(refusal([&] { Hdf5File(folder / "d.h5", Mode::kRead); }), "cannot open"));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");  // HDF5 itself says nothing
}

TEST(ThreadedHdf5File, SeveralThreadsWriteTheirFilesAsOneWould) {
  const TemporaryFolder folder;
  const auto write_all = [&](const std::string& name) {
    for (int k = 0; k < 200; ++k) {
      Hdf5File file(folder / name, Hdf5File::Mode::kCreate);
      for (const char* entry : {"/a/b/c", "/a/b/d", "/e"}) {
        file.write(entry, std::vector<double>(50, 1.0 / 3));
        file.write_attribute(entry, "unit", "m");
      }
      EXPECT_THROW(file.read_doubles("/a/missing"), FileError);
      file.close();
    }
  };
  write_all("alone");
  std::vector<std::thread> threads;
  for (const char* name : {"first", "second", "third"}) threads.emplace_back(write_all, name);
  for (std::thread& thread : threads) thread.join();
  for (const char* name : {"first", "second", "third"}) {
    EXPECT_EQ(file_text(folder / name), file_text(folder / "alone")) << name;
  }
}

/// A file that may not grow is a full disk without one. The program ends as it wants to.
TEST(Hdf5File, AFullDiskIsReportedAndTheProgramEndsInOrder) {
  const TemporaryFolder folder;
  const auto fill = [&] {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{4000, 4000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    const std::string said = refusal([&] {
      Hdf5File file(folder / "a", Mode::kCreate);
      for (int k = 0; k < 100; ++k) file.write("/entry" + std::to_string(k), 1.0);
      file.close();
    });
    std::fputs(said.c_str(), stderr);
    std::exit(4);
  };
  EXPECT_EXIT(fill(), testing::ExitedWithCode(4), "a: cannot write: File too large");
}

/// Whether `use` waits for the file that another thread has open.
void expect_to_wait(const fs::path& path, const std::function<void()>& use) {
  std::promise<void> opened, go_on;
  std::thread writer([&] {
    Hdf5File file(path, Hdf5File::Mode::kCreate);
    opened.set_value();
    go_on.get_future().wait();
    file.write("/x", 1.0);
  });
  opened.get_future().wait();
  std::atomic<bool> done = false;
  std::thread user([&] {
    use();
    done = true;
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_FALSE(done);
  go_on.set_value();
  writer.join();
  user.join();
  EXPECT_TRUE(done);
  EXPECT_EQ(Hdf5File(path, Hdf5File::Mode::kRead).read_double("/x"), 1.0);
}

TEST(ThreadedHdf5File, OneThreadAtATimeHasFilesOpen) {
  const TemporaryFolder folder;
  expect_to_wait(folder / "a", [&] {
    Hdf5File first(folder / "b", Mode::kCreate);
    const Hdf5File second(folder / "c", Mode::kCreate);  // the same thread: as many as it likes
    Hdf5File moved(std::move(first));
    moved.write("/y", 2.0);
  });
}

/// Replaces a number of eight bytes wherever a file has it.
void replace_number(const fs::path& path, std::uint64_t from, std::uint64_t to) {
  std::string bytes = file_text(path);
  const std::string old(reinterpret_cast<const char*>(&from), sizeof from);
  std::size_t at = bytes.find(old);
  ASSERT_NE(at, std::string::npos);
  for (; at != std::string::npos; at = bytes.find(old, at + 1)) {
    bytes.replace(at, sizeof to, reinterpret_cast<const char*>(&to), sizeof to);
  }
  std::ofstream(path, std::ios::binary) << bytes;
}

TEST(Hdf5File, TheStructureOfUntrustedFilesIsChecked) {
  const TemporaryFolder folder;
  const auto make = [&] {
    Hdf5File file(folder / "a.h5", Mode::kCreate);
    file.write("/deep/x", std::vector<double>(1237, 0.5));
    file.write("/deep/empty", std::span<const double>());
    file.write("/text", "words");
  };
  const auto said = [&] { return refusal([&] { Hdf5File::check_structure(folder / "a.h5"); }); };
  make();
  EXPECT_EQ(said(), "nothing was thrown");
  replace_number(folder / "a.h5", 1237, 1238);  // more numbers than are stored
  EXPECT_TRUE(says(said(), "/deep/x: claims 9904 bytes and stores 9896"));
  make();
  replace_number(folder / "a.h5", 1237, std::uint64_t{1} << 50);
  EXPECT_TRUE(says(said(), "more than a file of"));
  make();
  Hdf5File(folder / "a.h5", Mode::kAppend).link("/deep/other", "b.h5", "/x");
  EXPECT_TRUE(says(said(), "/deep/other: a link"));
  make();
  const std::string whole = file_text(folder / "a.h5");
  std::ofstream(folder / "a.h5", std::ios::binary) << whole.substr(0, whole.size() / 2);
  EXPECT_NE(said(), "nothing was thrown");
  std::ofstream(folder / "a.h5") << "plain text";
  EXPECT_EQ(said(), "nothing was thrown");
}

}  // namespace
}  // namespace bipot
