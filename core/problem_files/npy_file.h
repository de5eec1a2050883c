#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

namespace bipot {

/// An array as written by numpy.save.
struct NpyArray {
  std::vector<std::size_t> shape;  ///< empty: a scalar
  std::vector<double> values;      ///< last index fastest, whatever the order in the file
};

/// Reads a .npy file of format version 1, 2 or 3 with little-endian real numbers of 4 or 8 bytes
/// (float, or signed integers), in C or Fortran order. Throws FileError for any other content.
NpyArray read_npy(const std::filesystem::path& path);

/// True if the file begins like a .npy file, whatever its name. False if there is no file.
bool is_npy(const std::filesystem::path& path);

}  // namespace bipot
