#include "bench/page/deflate.h"

#include <zlib.h>

#include <new>
#include <stdexcept>

namespace bipot {
namespace {

constexpr int kLevel = 4;  // half the time of zlib's default level, a few per cent more bytes

}  // namespace

std::string deflated(std::string_view bytes) {
  uLongf size = compressBound(bytes.size());
  std::string packed(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), kLevel) != Z_OK) {
    throw std::bad_alloc();  // the buffer is large enough, the level exists
  }
  packed.resize(size);
  return packed;
}

std::string inflated(std::string_view packed, std::size_t size) {
  uLongf found = size;
  std::string bytes(size, '\0');
  if (uncompress(reinterpret_cast<Bytef*>(bytes.data()), &found,
                 reinterpret_cast<const Bytef*>(packed.data()), packed.size()) != Z_OK ||
      found != size) {
    throw std::invalid_argument("not the deflated form of so many bytes");
  }
  return bytes;
}

}  // namespace bipot
