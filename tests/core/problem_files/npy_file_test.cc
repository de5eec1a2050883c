#include "core/problem_files/npy_file.h"

#include <cstring>

#include "core/base/file_error.h"
#include "core/problem_files/impulse_file.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

template <class Number>
std::string bytes(std::initializer_list<Number> values) {
  std::string out;
  for (const Number x : values) {
    char raw[sizeof x];
    std::memcpy(raw, &x, sizeof x);
    out.append(raw, sizeof x);
  }
  return out;
}

/// A file as numpy writes it: header padded with spaces and ended by a line feed.
std::string npy(const std::string& descr, const std::string& order, const std::string& shape,
                const std::string& data, char version = 1) {
  std::string header =
      "{'descr': '" + descr + "', 'fortran_order': " + order + ", 'shape': " + shape + ", }";
  while ((10 + header.size() + 1) % 64 != 0) header += ' ';
  header += '\n';
  std::string out = "\x93NUMPY";
  out += version;
  out += '\0';
  out += static_cast<char>(header.size() % 256);
  out += static_cast<char>(header.size() / 256);
  if (version > 1) out += std::string(2, '\0');
  return out + header + data;
}

class NpyFile : public testing::Test {
 protected:
  NpyArray read(const std::string& content) {
    std::ofstream(path(), std::ios::binary) << content;
    return read_npy(path());
  }
  std::string refusal(const std::string& content) {
    return refusal_of<FileError>([&] { read(content); });
  }
  fs::path path() const { return folder_ / "x.npy"; }

  TemporaryFolder folder_;
};

using Shape = std::vector<std::size_t>;
using Values = std::vector<double>;

TEST_F(NpyFile, ReadsEveryWidthAndVersion) {
  for (const char version : {1, 2, 3}) {
    const NpyArray a = read(npy("<f8", "False", "(3,)", bytes({1.5, -2.0, 1e-300}), version));
    EXPECT_EQ(a.shape, Shape{3});
    EXPECT_EQ(a.values, (Values{1.5, -2, 1e-300}));
  }
  EXPECT_EQ(read(npy("<f4", "False", "(2,)", bytes({1.5f, -0.25f}))).values, (Values{1.5, -0.25}));
  EXPECT_EQ(read(npy("<i8", "False", "(2,)", bytes<std::int64_t>({7, -8}))).values,
            (Values{7, -8}));
  EXPECT_EQ(read(npy("<i4", "False", "(1,)", bytes<std::int32_t>({-9}))).values, Values{-9});
  EXPECT_EQ(read(npy("<f8", "False", "(0, 2)", "")).values, Values{});
  EXPECT_EQ(read(npy("<f8", "False", "()", bytes({4.0}))).values, Values{4});
  EXPECT_TRUE(is_npy(path()));
  EXPECT_FALSE(is_npy(folder_ / "nothing"));
}

TEST_F(NpyFile, FortranOrderIsTurned) {
  // [[1, 2, 3], [4, 5, 6]] column by column.
  const NpyArray a = read(npy("<f8", "True", "(2, 3)", bytes({1.0, 4.0, 2.0, 5.0, 3.0, 6.0})));
  EXPECT_EQ(a.shape, (Shape{2, 3}));
  EXPECT_EQ(a.values, (Values{1, 2, 3, 4, 5, 6}));
}

TEST_F(NpyFile, RefusesWhatItCannotRead) {
  const std::string two = bytes({1.0, 2.0});
  EXPECT_TRUE(says(refusal(npy(">f8", "False", "(2,)", two)), "elements of type '>f8': expected"));
  EXPECT_TRUE(
      says(refusal(npy("<c16", "False", "(1,)", two)), "elements of type '<c16': expected"));
  EXPECT_TRUE(says(refusal(npy("<f8", "False", "(3,)", two)),
                   "16 bytes of elements, the shape asks for 3"));
  EXPECT_TRUE(says(refusal(npy("<f8", "False", "(1,)", two)), "16 bytes of elements"));
  EXPECT_TRUE(says(refusal(npy("<f8", "False", "(4294967296, 4294967296)", two)), "more elements"));
  EXPECT_TRUE(says(refusal(npy("<f8", "False", "[2]", two)), "not a tuple"));
  EXPECT_TRUE(says(refusal(npy("<f8", "False", "(2,)", two, 4)), "version 4"));
  EXPECT_TRUE(says(refusal(npy("<f8", "False", "(2,)", two).substr(0, 40)), "ends within"));
  EXPECT_TRUE(says(refusal("1 2 3"), "not a .npy file"));
}

TEST_F(NpyFile, ATableOfImpulsesHasARowOrAColumnForEachContact) {
  const ContactProblem p{.dim = 2, .u_free = Vector::Zero(12), .mu = Vector::Constant(6, 0.5)};
  const std::string zeros(12 * sizeof(double), '\0');
  for (const char* shape : {"(12,)", "(12, 1)", "(1, 12)", "(6, 2)", "(2, 6)"}) {
    read(npy("<f8", "False", shape, zeros));
    EXPECT_EQ(read_impulses(path(), p), p.u_free) << shape;
  }
  read(npy("<f8", "False", "(3, 4)", zeros));
  EXPECT_TRUE(says(refusal_of<FileError>([&] { read_impulses(path(), p); }),
                   "the shape 3 x 4, expected 12, 6 x 2 or 2 x 6"));
}

}  // namespace
}  // namespace bipot
