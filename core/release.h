#pragma once

#include <vector>

namespace bipot {

/// Empties the vector and gives its memory back; `values = {}` keeps it.
template <class T>
void release(std::vector<T>& values) {
  std::vector<T>().swap(values);
}

}  // namespace bipot
