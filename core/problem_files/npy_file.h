#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

namespace bipot {

/// An array as numpy.save writes it.
struct NpyArray {
  std::vector<std::size_t> shape;  ///< empty: a scalar
  std::vector<double> values;      ///< last index fastest, whatever the order in the file
};

/// Reads a .npy file of format version 1, 2 or 3 with little-endian real numbers of 4 or 8 bytes
/// (float, or signed integers), in C or Fortran order. Throws FileError for any other content.
NpyArray read_npy(const std::filesystem::path& path);

/// True when the file begins as .npy files do, whatever its name. False for no file.
bool is_npy(const std::filesystem::path& path);

}  // namespace bipot
