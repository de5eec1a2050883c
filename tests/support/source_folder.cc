#include "tests/support/source_folder.h"

#include <fstream>
#include <iterator>

namespace bipot {

std::filesystem::path source_folder() { return BIPOT_SOURCE_DIR; }

std::string file_text(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace bipot
