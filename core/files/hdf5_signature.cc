#include <array>
#include <fstream>

#include "core/files/hdf5_file.h"

namespace bipot {

bool Hdf5File::is_hdf5(const std::filesystem::path& path) {
  constexpr std::array<char, 8> kSignature = {'\x89', 'H', 'D', 'F', '\r', '\n', '\x1a', '\n'};
  std::array<char, 8> head{};
  std::ifstream in(path, std::ios::binary);
  in.read(head.data(), head.size());
  return in.gcount() == static_cast<std::streamsize>(head.size()) && head == kSignature;
}

}  // namespace bipot
