#include "core/pictures/png_file.h"

#include <png.h>

#include <string>

#include "core/base/file_error.h"

namespace bipot {

void write_png(const std::filesystem::path& path, const RgbImage& image) {
  png_image header = {};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_RGB;
  header.flags = PNG_IMAGE_FLAG_FAST;  // no filters
  if (png_image_write_to_file(&header, path.c_str(), 0, image.bytes.data(), 0, nullptr) == 0) {
    throw FileError(path, "", std::string("cannot write the picture: ") + header.message);
  }
}

}  // namespace bipot
