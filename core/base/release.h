#pragma once

#include <malloc.h>

#include <vector>

namespace bipot {

/// Returns freed memory to the system, holes between blocks in use included. malloc keeps it
/// otherwise, all of it once SuperLU_DIST is loaded. Costs a page fault for every page that is used
/// again.
inline void return_freed_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

/// Empties the vector and frees its memory; `values = {}` would keep it.
template <class T>
void release(std::vector<T>& values) {
  std::vector<T>().swap(values);
}

}  // namespace bipot
