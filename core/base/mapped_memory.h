#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdlib>
#include <new>
#include <vector>

namespace bipot {

/// Allocates arrays of a megabyte and more from the system, and returns them as soon as they are
/// freed. Purpose: arrays of changing size in every step of a run, which would fragment the heap.
/// SuperLU_DIST, once loaded, switches off malloc's own way of doing this.
template <class T>
struct MappedAllocator {
  using value_type = T;
  static constexpr std::size_t kMapped = std::size_t{1} << 20;

  MappedAllocator() = default;
  template <class U>
  MappedAllocator(const MappedAllocator<U>&) {}  // NOLINT(google-explicit-constructor)

  T* allocate(std::size_t n) {
    if (n > static_cast<std::size_t>(-1) / sizeof(T)) throw std::bad_array_new_length();
    const std::size_t bytes = n * sizeof(T);
    void* memory = nullptr;
    if (bytes >= kMapped) {
      memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
      if (memory == MAP_FAILED) memory = nullptr;
    } else {
      memory = std::malloc(bytes > 0 ? bytes : 1);
    }
    if (memory == nullptr) throw std::bad_alloc();
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t n) {
    if (n * sizeof(T) >= kMapped) {
      munmap(memory, n * sizeof(T));
    } else {
      std::free(memory);
    }
  }

  bool operator==(const MappedAllocator&) const { return true; }
};

template <class T>
using MappedVector = std::vector<T, MappedAllocator<T>>;

}  // namespace bipot
