#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <vector>

#include "core/base/types.h"

namespace bipot {

/// Asks the system for pages of 2 MiB for larger arrays. Sweeps over hundreds of megabytes are else
/// slowed down by the page tables of 4 KiB pages (data/manual/results/performance.md). Without such
/// pages nothing changes; results never do.
inline void ask_for_large_pages(void* memory, std::size_t bytes) {
#ifdef MADV_HUGEPAGE
  constexpr std::uintptr_t kPage = std::uintptr_t{1} << 21;
  const auto start = reinterpret_cast<std::uintptr_t>(memory);
  const std::uintptr_t first = (start + kPage - 1) / kPage * kPage,
                       end = (start + bytes) / kPage * kPage;
  if (first >= end) return;  // the ends of the array keep small pages
  // Advice that the system may ignore. Pages that are in use stay small: joining them
  // (MADV_COLLAPSE) takes longer than it saves.
  madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE);
#endif
}

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
    ask_for_large_pages(memory, bytes);
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

/// A vector of n numbers, not initialised, with large pages.
inline Vector large_vector(Eigen::Index n) {
  Vector v(n);
  ask_for_large_pages(v.data(), to_size(n) * sizeof(double));
  return v;
}
inline Vector large_copy(const Vector& of) {
  Vector v = large_vector(of.size());
  v = of;
  return v;
}

}  // namespace bipot
