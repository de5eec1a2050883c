#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdlib>
#include <new>
#include <vector>

namespace bipot {

/// Asks the system for pages of 2 MiB where an array is larger: what streams through hundreds of
/// megabytes again and again otherwise waits for the tables of 4 KiB pages (5 to 23 % of the time of
/// sweeps on a virtual machine, data/speed.md). Where the system has no such pages, nothing
/// changes; results never do.
template <class T>
struct LargePageAllocator {
  using value_type = T;
  static constexpr std::size_t kPage = std::size_t{1} << 21;

  LargePageAllocator() = default;
  template <class U>
  LargePageAllocator(const LargePageAllocator<U>&) {}  // NOLINT(google-explicit-constructor)

  T* allocate(std::size_t n) {
    const std::size_t bytes = n * sizeof(T), whole = bytes / kPage * kPage;
    if (n > static_cast<std::size_t>(-1) / sizeof(T)) throw std::bad_array_new_length();
    void* memory = nullptr;
    if (posix_memalign(&memory, whole > 0 ? kPage : kLine, bytes > 0 ? bytes : 1) != 0) {
      throw std::bad_alloc();
    }
#ifdef MADV_HUGEPAGE
    // Advice: whether it is taken is the system's affair. The rest of the array keeps small pages.
    if (whole > 0) madvise(memory, whole, MADV_HUGEPAGE);
#endif
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t) { std::free(memory); }

  bool operator==(const LargePageAllocator&) const { return true; }

 private:
  static constexpr std::size_t kLine = 64;
  static_assert(alignof(T) <= kLine);
};

template <class T>
using LargeVector = std::vector<T, LargePageAllocator<T>>;

}  // namespace bipot
