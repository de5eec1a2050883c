#pragma once

#include <cstddef>
#include <string>

namespace bipot {

/// Words of `text` in lines of at most `width` characters, each but the first after `indent`
/// spaces, which count. The first line starts at column `indent`.
std::string wrapped(const std::string& text, std::size_t indent, std::size_t width = 100);

}  // namespace bipot
