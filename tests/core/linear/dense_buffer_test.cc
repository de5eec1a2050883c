#include "core/linear/dense_buffer.h"

#include <sys/resource.h>
#include <unistd.h>

#include <new>
#include <thread>

#include "tests/support/test.h"

namespace bipot {
namespace {

/// Bytes of address space that this process has.
rlim_t address_space() {
  rlim_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
}

// OpenBLAS would ask for its buffer for ever.
TEST(DenseBuffer, SaysSoWhereItCannotBeHad) {
  std::string said;
  bool later = false;
  std::thread([&] {
    rlimit before{};
    ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
    rlimit tight = before;
    tight.rlim_cur = address_space() + (rlim_t{64} << 20);
    ASSERT_EQ(setrlimit(RLIMIT_AS, &tight), 0);
    try {
      take_dense_buffer();
    } catch (const std::bad_alloc& e) {
      said = e.what();
    }
    ASSERT_EQ(setrlimit(RLIMIT_AS, &before), 0);
    take_dense_buffer();  // there is room again
    later = true;
  }).join();
  EXPECT_TRUE(says(said, "128 MB of address space"));
  EXPECT_TRUE(later);
}

}  // namespace
}  // namespace bipot
