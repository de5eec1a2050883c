#pragma once

#include <cstddef>
#include <string>

namespace bipot {

/// The first so many characters of UTF-8.
std::string first_characters(const std::string& text, std::size_t count);

/// The reason of a solver in one line: of a list of stages their number and the last one.
std::string short_reason(const std::string& message);

/// Words of `text` in lines of at most `width` characters, each but the first after `indent`
/// spaces, which count. The first line starts at column `indent`.
std::string wrapped(const std::string& text, std::size_t indent, std::size_t width = 100);

}  // namespace bipot
