#pragma once

#include <filesystem>
#include <vector>

namespace bipot {

/// Image of width × height opaque pixels: three bytes each (red, green, blue), row by row from the
/// top.
struct RgbImage {
  int width = 0, height = 0;
  std::vector<unsigned char> bytes;
};

/// Writes `image` as a PNG. Rows are compressed as they are: drawings of few colours lose size and
/// time by the filters that suit photographs. Throws FileError.
void write_png(const std::filesystem::path& path, const RgbImage& image);

}  // namespace bipot
