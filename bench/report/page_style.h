#pragma once

#include <string>
#include <string_view>

namespace bipot {

/// A page from its first byte to <body>: the title and one style sheet. The sheet dresses all that
/// a Document is made of, and its looks (document.h); small screens and print.
std::string page_head(std::string_view title);

}  // namespace bipot
