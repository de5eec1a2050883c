#pragma once

#include <string>
#include <vector>

namespace bipot {

/// Image of width × height opaque pixels: three bytes each (red, green, blue), row by row from the
/// top.
struct RgbImage {
  int width = 0, height = 0;
  std::vector<unsigned char> bytes;
};

/// The bytes of a PNG file. Rows are compressed as they are: filters, which suit photographs, cost
/// drawings of few colours time and size. Throws std::runtime_error.
std::string encode_png(const RgbImage& image);

}  // namespace bipot
