#pragma once

#include <malloc.h>

#include <vector>

namespace bipot {

/// Gives memory that was freed back to the system, holes between what is in use included: malloc keeps
/// them, all of them where a library has switched off its ways of not doing so, as SuperLU_DIST does when
/// it is loaded. Costs a fault for every page that is used again.
inline void return_freed_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

/// Empties the vector and gives its memory back; `values = {}` keeps it.
template <class T>
void release(std::vector<T>& values) {
  std::vector<T>().swap(values);
}

}  // namespace bipot
