#include "core/base/large_pages.h"

#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(LargePages, LargeArraysBeginOnAPageAndAllOnALine) {
  const auto address = [](const LargeVector<double>& v) {
    return reinterpret_cast<std::uintptr_t>(v.data());
  };
  constexpr std::size_t kPage = std::size_t{1} << 21;
  for (const std::size_t bytes : {std::size_t{8}, kPage - 8, kPage, 3 * kPage + 4096}) {
    LargeVector<double> v(bytes / 8, 1.0);
    EXPECT_EQ(address(v) % (bytes >= kPage ? kPage : 64), 0U) << bytes;
    EXPECT_EQ(std::accumulate(v.begin(), v.end(), 0.0), static_cast<double>(v.size()));
    const LargeVector<double> copy = v;
    v.back() = 2;
    EXPECT_EQ(copy.back(), 1);
  }
}

TEST(LargePages, WhatCannotBeHadIsSaid) {
  LargePageAllocator<double> memory;
  EXPECT_THROW(static_cast<void>(memory.allocate(static_cast<std::size_t>(-1) / 4)),
               std::bad_array_new_length);
}

}  // namespace
}  // namespace bipot
