#include "core/pictures/png_image.h"

#include <png.h>

#include <stdexcept>

namespace bipot {

std::string encode_png(const RgbImage& image) {
  png_image header = {};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_RGB;
  header.flags = PNG_IMAGE_FLAG_FAST;  // no filters
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::string file(size, '\0');
  if (png_image_write_to_memory(&header, file.data(), &size, 0, image.bytes.data(), 0, nullptr) ==
      0) {
    throw std::runtime_error(std::string("cannot draw: ") + header.message);
  }
  file.resize(size);
  return file;
}

}  // namespace bipot
