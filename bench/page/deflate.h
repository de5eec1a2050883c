#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace bipot {

/// The bytes in the zlib format (RFC 1950), which browsers call "deflate". The same bytes give the
/// same result with one version of zlib. Only this file's source uses the library. Throws
/// std::bad_alloc.
std::string deflated(std::string_view bytes);

/// The bytes again; `size`: their number. Throws std::invalid_argument for anything else than the
/// result of deflated() on so many bytes.
std::string inflated(std::string_view packed, std::size_t size);

}  // namespace bipot
