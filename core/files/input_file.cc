#include "core/files/input_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "core/base/file_error.h"

namespace bipot {

void require_regular_file(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (std::filesystem::is_regular_file(status)) return;
  throw FileError(path, "",
                  status.type() == std::filesystem::file_type::not_found   ? "no such file"
                  : status.type() == std::filesystem::file_type::directory ? "is a folder"
                  : error                                                  ? error.message()
                          : "is a pipe or a device, not a regular file");
}

std::string read_text_file(const std::filesystem::path& path) {
  require_regular_file(path);
  std::ifstream in(path, std::ios::binary);
  if (!in) throw FileError(path, "", std::string("cannot be opened: ") + std::strerror(errno));
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (text.starts_with("\x1F\x8B")) throw FileError(path, "", "is compressed: gunzip it first");
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  return text;
}

}  // namespace bipot
